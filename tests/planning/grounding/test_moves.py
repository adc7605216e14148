"""Moves that are left out of the search have their price there all the same."""

from dataclasses import replace

import pytest

from tamp.planning import Problem, StreamInfo, solve
from tamp.planning.algorithms.session import Session
from tamp.planning.grounding import moves
from tamp.planning.options import Options
from tamp.planning.search.fast_downward import FastDownward
from tests.planning.problems import costs
from tests.planning.test_problems import check

ALGORITHMS = ("adaptive", "binding", "focused", "incremental")

ERRANDS = """
(define (domain errands)
  (:requirements :strips)
  (:predicates (Robot ?r) (Conf ?q) (Way ?q1 ?t ?q2) (Reach ?r ?x ?q) (Errand ?x) (AtConf ?r ?q) (Done ?x))
  (:functions (Length ?q1 ?q2))
  (:action move
    :parameters (?r ?q1 ?t ?q2)
    :precondition (and (Robot ?r) (Way ?q1 ?t ?q2) (AtConf ?r ?q1))
    :effect (and (AtConf ?r ?q2) (not (AtConf ?r ?q1)) MOVECOST))
  (:action run
    :parameters (?r ?x ?q)
    :precondition (and (Robot ?r) (Reach ?r ?x ?q) (AtConf ?r ?q))
    :effect (and (Done ?x) RUNCOST)))
"""

ERRANDS_STREAMS = """
(define (stream errands)
  (:stream find-conf
    :inputs (?r ?x) :domain (and (Robot ?r) (Errand ?x)) :outputs (?q) :certified (Conf ?q))
  (:stream find-way :inputs (?q1 ?q2) :domain (and (Conf ?q1) (Conf ?q2)) :outputs (?t) :certified (Way ?q1 ?t ?q2))
  (:stream test-reach
    :inputs (?r ?x ?q) :domain (and (Robot ?r) (Errand ?x) (Conf ?q)) :certified (Reach ?r ?x ?q))
  (:function (Length ?q1 ?q2) (and (Conf ?q1) (Conf ?q2))))
"""


def errands(robots=1, home=False, move_cost="(increase (total-cost) (Length ?q1 ?q2))", run_cost="1", bound=10.0):
    """Errands that can all be run from wherever one of them can; a move costs 10, and robots may have to go home."""
    drawn = iter(range(100))
    domain = ERRANDS.replace("MOVECOST", move_cost).replace(
        "RUNCOST", f"(increase (total-cost) {run_cost})" if run_cost else ""
    )
    init = [("Errand", x) for x in "abc"]
    for r in range(robots):
        init += [("Robot", r), ("Conf", f"home{r}"), ("AtConf", r, f"home{r}")]
    return Problem(
        domain=domain,
        streams=ERRANDS_STREAMS,
        samplers={
            "find-conf": lambda context, robot, errand: iter([f"q{next(drawn)}"]),
            "find-way": lambda context, a, b: iter([f"{a}-{b}"]),
            "test-reach": lambda context, robot, errand, conf: not conf.startswith("home"),
            "length": lambda context, a, b: 10.0,
        },
        init=init,
        goal=("and", *(("Done", x) for x in "abc"), *(("AtConf", r, f"home{r}") for r in range(robots) if home)),
        info={"length": StreamInfo(bound=bound)},
    )


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_one_value_serves_several_actions(algorithm):
    problem = errands()
    solution = solve(problem, algorithm=algorithm, timeout=20.0)
    assert [action.name for action in solution.plan or ()] == ["move", "run", "run", "run"]
    assert solution.cost == 13.0
    check(problem, solution)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_what_has_no_costs_is_planned_with_few_moves(algorithm):
    problem = errands(move_cost="", run_cost="")
    solution = solve(problem, algorithm=algorithm, timeout=20.0)
    assert solution.cost == 4.0


def test_the_way_home_counts():
    problem = errands(robots=2, home=True)
    solution = solve(problem, timeout=20.0)
    assert solution.cost == 23.0
    assert len({action.args[0] for action in solution.plan or ()}) == 1
    check(problem, solution)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_a_dear_move_is_not_taken_for_free(algorithm):
    problem = costs.delivery()
    assert solve(problem, algorithm=algorithm, timeout=20.0).cost == costs.BEST_COST


def test_moves_to_very_many_values_have_no_price(monkeypatch):
    monkeypatch.setattr(moves, "MANY", 2)
    problem = errands(robots=2, home=True)
    solution = solve(problem, timeout=20.0)
    assert solution.status == "solved"
    check(problem, solution)


@pytest.mark.parametrize("search", ["builtin", "ff", "astar"])
def test_every_search_sees_the_price(search):
    assert solve(errands(home=True), search=search, timeout=20.0).cost == 23.0


def test_a_move_that_costs_nothing_has_no_price():
    problem = replace(errands(bound=0.0), goal=("Done", "a"))
    assert solve(problem, timeout=20.0).cost == 11.0


@pytest.mark.parametrize(("move_cost", "hidden"), [("(increase (total-cost) 10)", True), (None, False)])
def test_where_plans_must_be_cheap_moves_are_left_out_that_always_cost_the_same(move_cost, hidden):
    problem = errands(home=True, **({"move_cost": move_cost} if move_cost else {}))
    session = Session(problem, Options(max_cost=30.0), FastDownward("ff"), False, 0.0)
    assert bool(session.connectors.connectors) == hidden
    solution = solve(problem, success_cost=23.0, timeout=20.0)
    assert solution.cost == 23.0
    check(problem, solution)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_the_dearest_allowed_plan_is_found_with_moves_left_out(algorithm):
    problem = errands(home=True, move_cost="(increase (total-cost) 10)")
    assert solve(problem, algorithm=algorithm, max_cost=23.0, timeout=20.0).cost == 23.0
