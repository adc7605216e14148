"""Searches behind the protocol agree; Fast Downward's process ends when it must."""

from __future__ import annotations

import gc
import math
import sys
import warnings

import pytest

from tamp.errors import DomainError, TampError
from tamp.planning import Problem, SearchResult, solve
from tamp.planning.grounding.ground_task import GroundTask, TaskAxiom, TaskEffect, TaskOperator, axiom_layers
from tamp.planning.grounding.operators import GroundOperator
from tamp.planning.search.best_first import BuiltinSearch
from tamp.planning.search.fast_downward import CONFIGURATIONS, FastDownward
from tests.planning.oracles.validator import validate
from tests.planning.problems import blocksworld, continuous, negation, quantified, recursive, unsolvable

SOURCE = GroundOperator(None, {}, (), (), (), ())


def operator(positive, negative, *effects, cost=1):
    return TaskOperator(SOURCE, tuple(positive), tuple(negative), tuple(effects), cost)


def task(atoms, initial, goal, operators, axioms=(), absent=(), groups=()):
    names = tuple(("atom", i) for i in range(atoms))
    return GroundTask(names, frozenset(initial), tuple(goal), tuple(absent), tuple(operators), tuple(axioms), groups)


@pytest.fixture(params=["builtin", *CONFIGURATIONS])
def search(request):
    return BuiltinSearch() if request.param == "builtin" else FastDownward(request.param)


def test_negative_conditions_and_conditional_effects(search):
    # Atom 0 must go before 1 can come, and 2 only follows where 1 held.
    problem = task(
        3,
        [0],
        [2],
        [
            operator([], [0], TaskEffect(1, adds=True)),
            operator([0], [], TaskEffect(0, adds=False)),
            operator([], [], TaskEffect(2, adds=True, positive=(1,))),
        ],
    )
    plan = search(problem, 10.0).plan
    assert [problem.operators.index(op) for op in plan] == [1, 0, 2]


def test_an_addition_wins_over_a_deletion(search):
    problem = task(
        2,
        [0],
        [0, 1],
        [operator([], [], TaskEffect(0, adds=False), TaskEffect(0, adds=True), TaskEffect(1, adds=True))],
    )
    assert len(search(problem, 10.0).plan) == 1


def test_groups_share_a_variable(search):
    steps = [operator([i], [], TaskEffect(i, adds=False), TaskEffect(i + 1, adds=True)) for i in range(3)] + [
        operator([], [1], TaskEffect(4, adds=True))
    ]
    problem = task(5, [0], [3, 4], steps, absent=[0], groups=((0, 1, 2, 3),))
    assert len(search(problem, 10.0).plan) == 4


def test_axioms_by_strata(search):
    # 2 holds where 0 does, 3 where 2 does not: the goal needs 0 to go.
    problem = task(
        4,
        [0],
        [3],
        [operator([0], [], TaskEffect(0, adds=False), TaskEffect(1, adds=True))],
        [TaskAxiom(2, (0,), ()), TaskAxiom(3, (), (2,))],
    )
    assert len(search(problem, 10.0).plan) == 1
    assert axiom_layers(problem.axioms) == {2: 0, 3: 1}


def test_a_task_without_plan_is_proven(search):
    result = search(
        task(2, [0], [0, 1], [operator([0], [], TaskEffect(0, adds=False), TaskEffect(1, adds=True))]), 10.0
    )
    assert (result.plan, result.proven) == (None, True)


def test_a_bound_is_kept(search):
    problem = task(1, [], [0], [operator([], [], TaskEffect(0, adds=True), cost=7)])
    assert search(problem, 10.0, bound=8).plan is not None
    assert search(problem, 10.0, bound=7).plan is None


def test_axioms_that_negate_themselves_are_refused():
    with pytest.raises(ValueError, match="its own negation"):
        axiom_layers([TaskAxiom(0, (), (0,))])


@pytest.mark.parametrize(
    "make",
    [
        lambda: blocksworld.inversion(3),
        lambda: continuous.line(2),
        lambda: negation.parking(2),
        lambda: quantified.trays(1),
        lambda: recursive.rooms(3),
    ],
)
def test_the_builtin_search_solves_small_problems(make):
    problem = make()
    solution = solve(problem, search="builtin", timeout=20.0)
    plan = [(action.name, action.args) for action in solution.plan]
    facts = [*problem.init, *solution.certified]
    validate(problem.parsed_domain, facts, plan, problem.goal, problem.parsed_streams, problem.samplers)


def test_the_builtin_search_proves_infeasibility():
    assert solve(unsolvable.exhausted(), search="builtin", timeout=10.0).status == "infeasible"


def counter(bits, goal):
    """A counter in binary: as many states as numbers."""
    flips = [
        operator(range(i), [i], *(TaskEffect(j, adds=False) for j in range(i)), TaskEffect(i, adds=True))
        for i in range(bits)
    ]
    return task(bits + 1, [], goal, [*flips, operator([bits], [], TaskEffect(0, True))])


def test_fast_downward_is_stopped_in_time():
    result = FastDownward("astar")(counter(24, [24]), 0.3)
    assert result.plan is None and result.timed_out and not result.proven


def test_fast_downward_ends_after_its_processor_time():
    result = FastDownward("astar")(counter(24, [24]), 600.0, effort=1.0)
    assert result.plan is None and result.timed_out and not result.proven


def test_fast_downward_leaves_nothing_open_where_it_is_ended():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.MonkeyPatch.context() as patch:
            seen = []
            patch.setattr(sys, "unraisablehook", seen.append)
            assert FastDownward("astar")(counter(24, [24]), 0.2).timed_out
            gc.collect()
    assert not seen


@pytest.mark.parametrize("found", [None, ((), True)])
def test_a_search_that_returns_something_else_is_refused(found):
    def broken(*args):
        return found

    with pytest.raises(TampError, match=r"^search .*broken: expected a SearchResult, found "):
        solve(blocksworld.inversion(2), search=broken)


def test_the_builtin_search_ends_after_its_processor_time():
    result = BuiltinSearch()(counter(16, range(16)), 600.0, effort=0.01)
    assert result.plan is None and result.timed_out and not result.proven


@pytest.mark.parametrize("algorithm", ["adaptive", "focused"])
def test_placeholders_of_ended_streams_are_not_searched_any_more(algorithm):
    domain = """(define (domain d) (:predicates (Thing ?x) (Made ?x ?y) (Seen ?x) (Painted ?x) (Done ?x))
      (:action look :parameters () :effect (forall (?x) (Seen ?x)))
      (:action paint :parameters (?x) :precondition (Seen ?x) :effect (Painted ?x))
      (:action use :parameters (?x ?y) :precondition (and (Made ?x ?y) (Painted ?y)) :effect (Done ?x)))"""
    streams = "(define (stream s) (:stream make :inputs (?x) :domain (Thing ?x) :outputs (?y) :certified (Made ?x ?y)))"
    problem = Problem(
        domain=domain,
        streams=streams,
        samplers={"make": lambda context, x: iter(["b"])},
        init=[("Thing", "a")],
        goal=("and", ("Done", "a"), ("not", ("Painted", "b"))),
    )
    solution = solve(problem, algorithm=algorithm, timeout=20.0)
    assert solution.status == "infeasible", str(solution.report)
    assert solution.report.counts["operators"] == 4  # look, paint a, paint b, use a b


@pytest.mark.parametrize(
    ("plan", "said"),
    [
        (lambda task: (), "its plan does not lead from what is initial in the task to the task's goal"),
        (lambda task: task.operators, "its plan does not lead"),
        (lambda task: ("pick",), "its plan does not lead"),
        (lambda task: sys.exit(3), r"raised SystemExit: 3 at .*test_best_first.py:"),
        (lambda task: 1 / 0, r"raised ZeroDivisionError: division by zero at .*test_best_first.py:"),
    ],
)
def test_a_search_from_outside_is_not_believed(plan, said):
    def lies(task, timeout, bound=None, effort=math.inf):
        return SearchResult(plan(task))

    with pytest.raises(TampError, match=rf"^search .*lies:? {said}"):
        solve(blocksworld.inversion(2), search=lies)


@pytest.mark.parametrize(
    ("search", "said"),
    [
        (5, "5 cannot be called; a search is called with"),
        (BuiltinSearch, "is the class BuiltinSearch; give an instance, such as BuiltinSearch"),
        (lambda task: None, r"must take \(task, timeout, bound=None, effort=math.inf\): too many"),
    ],
)
def test_what_is_no_search_is_refused_before_anything_runs(search, said):
    with pytest.raises(DomainError, match=f"^search: .*{said}"):
        solve(blocksworld.inversion(2), search=search)
