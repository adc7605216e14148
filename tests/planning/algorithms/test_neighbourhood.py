"""Another order of actions is looked for among the best plan's values, and what streams give first for these."""

import pytest

from benchmarks.pddlstream.known import jugs
from tamp import clock
from tamp.planning import Problem, solve
from tamp.planning.algorithms import neighbourhood
from tamp.planning.algorithms.neighbourhood import Neighbourhood
from tamp.planning.algorithms.session import Session
from tamp.planning.grounding.moves import MANY
from tamp.planning.options import Options
from tamp.planning.search.fast_downward import FastDownward
from tests.planning.test_problems import ALGORITHMS, check

HAULING = """
(define (domain hauling)
  (:predicates (Hand ?h) (Thing ?x) (Conf ?q) (Way ?q1 ?t ?q2) (Start ?h ?x ?q) (End ?h ?x ?q)
               (AtConf ?q) (Free ?h) (Waits ?x) (Held ?h ?x) (Done ?x))
  (:functions (Length ?q1 ?q2))
  (:action move
    :parameters (?q1 ?t ?q2)
    :precondition (and (Way ?q1 ?t ?q2) (AtConf ?q1))
    :effect (and (AtConf ?q2) (not (AtConf ?q1)) (increase (total-cost) (Length ?q1 ?q2))))
  (:action take
    :parameters (?h ?x ?q)
    :precondition (and (Start ?h ?x ?q) (AtConf ?q) (Free ?h) (Waits ?x))
    :effect (and (Held ?h ?x) (not (Waits ?x)) (not (Free ?h)) (increase (total-cost) 1)))
  (:action put
    :parameters (?h ?x ?q)
    :precondition (and (End ?h ?x ?q) (AtConf ?q) (Held ?h ?x))
    :effect (and (Done ?x) (Free ?h) (not (Held ?h ?x)) (increase (total-cost) 1))))
"""

HAULING_STREAMS = """
(define (stream hauling)
  (:stream find-start
    :inputs (?h ?x) :domain (and (Hand ?h) (Thing ?x)) :outputs (?q) :certified (and (Conf ?q) (Start ?h ?x ?q)))
  (:stream find-end
    :inputs (?h ?x) :domain (and (Hand ?h) (Thing ?x)) :outputs (?q) :certified (and (Conf ?q) (End ?h ?x ?q)))
  (:stream find-way :inputs (?q1 ?q2) :domain (and (Conf ?q1) (Conf ?q2)) :outputs (?t) :certified (Way ?q1 ?t ?q2))
  (:function (Length ?q1 ?q2) (and (Conf ?q1) (Conf ?q2))))
"""


def hauling(things, away=20.0):
    """Two hands take things from about 0 to about `away`, so that a way with both of them full is half of all ways."""

    def near(place):
        def draw(context, hand, thing):
            while True:
                yield place + round(context.rng.uniform(-0.5, 0.5), 3)

        return draw

    return Problem(
        domain=HAULING,
        streams=HAULING_STREAMS,
        samplers={
            "find-start": near(0.0),
            "find-end": near(away),
            "find-way": lambda context, a, b: iter([(f"{a}-{b}",)]),
            "length": lambda context, a, b: abs(a - b),
        },
        init=[("Conf", 0.0), ("AtConf", 0.0), *((p, x) for x in things for p in ("Thing", "Waits"))]
        + [(p, h) for h in ("left", "right") for p in ("Hand", "Free")],
        goal=("and", *(("Done", x) for x in things)),
    )


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_what_lies_on_one_way_is_done_on_one_way(algorithm):
    """The search sees what each move costs between two values: one hand after the other goes three times as far."""
    problem = hauling("ab")
    solution = solve(problem, algorithm=algorithm, timeout=20.0)
    check(problem, solution)
    assert solution.cost < 26.0, solution.cost


def test_one_value_of_each_stream_stands_for_its_like_where_moves_are_priced():
    """Among real values alone there are far more than the search may see moves between."""
    problem = hauling("ab")
    session = Session(problem, Options(), FastDownward(), True, clock.now())
    session.begin()
    for _ in range(8):
        session.rounds.expand()
    operators = Neighbourhood(session).operators()
    values = {op.binding["?q"] for op in operators}
    assert len({op.binding["?q"] for op in session.grounder.operators}) > MANY >= len(values) == 8
    assert {op.schema.name for op in operators} == {"take", "put"}


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize(
    ("things", "seed", "most"),
    [
        pytest.param("abcd", 2, 70.0, id="first values that fit each other"),  # few did, and none gave a plan: 103.8
        pytest.param("abcdef", 0, 150.0, id="part by part"),  # below the cost of the whole are too many states: 184
        pytest.param("abcdef", 4, 150.0, id="parts of the best plan"),  # where nothing cheaper was seen at all: 185
    ],
)
def test_a_better_order_is_found_of_a_plan(things, seed, most, algorithm):
    problem = hauling(things)
    solution = solve(problem, algorithm=algorithm, timeout=20.0, seed=seed)
    check(problem, solution)
    assert solution.cost < most, solution.cost


@pytest.mark.parametrize(("most", "grounded"), [(5, range(5, 7)), (100, [16])])
def test_what_is_grounded_for_a_neighbourhood_has_an_end(most, grounded, monkeypatch):
    """There are 16 actions, two hands' with four things at two places, of which each stream's call brings up to two."""
    monkeypatch.setattr(neighbourhood, "MOST", most)
    session = Session(hauling("abcd"), Options(optimistic=False), FastDownward(), True, clock.now())
    session.begin()
    before = len(session.grounder.operators)
    Neighbourhood(session).ask(10_000)
    assert len(session.grounder.operators) - before in grounded


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_values_that_streams_give_of_each_other_are_no_trap(algorithm):
    """One litre with jugs of five and three: what is poured one way may be poured back."""
    problem, best = jugs((5.0, 3.0), 1.0)
    solution = solve(problem, algorithm=algorithm, timeout=20.0)
    check(problem, solution)
    assert solution.cost == best
