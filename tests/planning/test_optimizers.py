"""Optimizers: what their procedures are asked, one by one and for a whole plan, and what comes of the answers."""

import numpy as np
import pytest

from benchmarks.pddlstream.shapes import SHELF
from benchmarks.pddlstream.shelf import OPTIMIZER, fit, optimised
from tamp.errors import SamplerError
from tamp.planning import Problem, solve
from tamp.planning.pddlstream import OptimizerOutput, from_fn, from_gen_fn, from_stream_map
from tests.planning.test_problems import ALGORITHMS, check

LINE = {"floor": (-10.0, 10.0), "goal": (5.0, 10.0)}


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize(("starts", "goals"), [([0.0, -3.0], {"A": "goal", "B": "goal"}), ([0.0, 7.5], {"A": "goal"})])
def test_one_answer_for_all_that_constraints_tie_together(algorithm, starts, goals):
    """Alone, each block would be put at the same place: only together there is room for both."""
    problem = optimised(starts, goals, LINE)
    solution = solve(problem, algorithm=algorithm, timeout=20.0)
    assert solution.status == "solved", str(solution.report)
    check(problem, solution)


def recorded(procedure, asked):
    def solve(outputs, facts, hint=None):
        asked.append((tuple(outputs), tuple(facts)))
        yield procedure(outputs, facts)

    return from_gen_fn(solve)


POINTS = """
(define (domain points)
  (:predicates (Thing ?x) (At ?x ?p) (Apart ?p ?q) (Placed ?x ?p) (Done))
  (:functions (Far ?p))
  (:action place :parameters (?x ?p) :precondition (At ?x ?p)
    :effect (and (Placed ?x ?p) (increase (total-cost) (Far ?p))))
  (:action finish
    :parameters (?p ?q) :precondition (and (Placed a ?p) (Placed b ?q) (Apart ?p ?q)) :effect (Done)))
"""

POINTS_STREAMS = """
(define (stream points)
  (:function (Far ?p) (Point ?p))
  (:optimizer choose
    (:variables (?p) :inputs (?x) :domain (Thing ?x) :graph (and (At ?x ?p) (Point ?p)))
    (:constraint (Apart ?p ?q) :necessary (and (Point ?p) (Point ?q)))
    (:objective Far)))
"""


def points(procedure):
    domain = POINTS.replace("(:predicates", "(:constants a b) (:predicates")
    stream_map = {"choose": procedure, "Far": lambda p: float(p)}
    init = [("Thing", "a"), ("Thing", "b")]
    return Problem(domain, POINTS_STREAMS, from_stream_map(stream_map), init, ("Done",))


def test_it_is_told_names_facts_of_them_and_what_shall_be_small():
    asked = []
    problem = points(recorded(lambda outputs, facts: tuple(range(1, len(outputs) + 1)), asked))
    solution = solve(problem, timeout=10.0)
    check(problem, solution)
    outputs, facts = next(question for question in asked if len(question[0]) == 2)
    p, q = outputs
    assert set(facts) == {
        ("at", "a", p), ("point", p), ("at", "b", q), ("point", q), ("apart", p, q), ("minimize", ("far", p)),
        ("minimize", ("far", q)),
    } or set(facts) == {
        ("at", "a", q), ("point", q), ("at", "b", p), ("point", p), ("apart", q, p), ("minimize", ("far", p)),
        ("minimize", ("far", q)),
    }  # fmt: skip


@pytest.mark.parametrize("give", [lambda o: OptimizerOutput([o]), lambda o: o])
def test_answers_in_either_form(give):
    problem = points(from_fn(lambda outputs, facts, hint: give(tuple(range(len(outputs))))))
    solution = solve(problem, timeout=10.0)
    check(problem, solution)


def test_that_it_has_no_answer_proves_nothing():
    problem = points(from_fn(lambda outputs, facts, hint: OptimizerOutput(infeasible=[facts])))
    solution = solve(problem, timeout=10.0)
    assert (solution.plan, solution.status) == (None, "failed")


def test_answers_of_another_number():
    problem = points(from_fn(lambda outputs, facts, hint: (1, 2, 3) if len(outputs) == 2 else (1,)))
    with pytest.raises(SamplerError, match=r"optimizer 'choose': expected one value for each of \?o0, \?o1"):
        solve(problem, timeout=10.0)


ONE = r"expected several assignments, found one OptimizerOutput; "


def one_always(outputs, facts, hint=None):
    return OptimizerOutput([tuple(range(len(outputs)))])


def one_of_two(outputs, facts, hint=None):
    return OptimizerOutput([(0, 1)]) if len(outputs) == 2 else [0]


def ours(context, outputs, facts, hint):
    return one_always(outputs, facts)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize(
    ("procedure", "mend"),
    [(one_always, "wrap the optimizer's procedure in from_list_fn"), (ours, "yield each assignment")],
)
def test_one_output_in_place_of_several_is_refused_in_a_sentence(procedure, mend, algorithm):
    problem = points(procedure)
    if procedure is ours:
        samplers = {"choose": ours, "Far": lambda context, p: 1.0}
        problem = Problem(problem.domain, POINTS_STREAMS, samplers, problem.init, ("Done",))
    who = rf"{__name__}:{procedure.__name__} at \S*test_optimizers.py:\d+$"
    with pytest.raises(SamplerError, match=rf"^stream '[^']+': {ONE}{mend}: {who}"):
        solve(problem, algorithm=algorithm, timeout=10.0)


def test_so_it_is_where_a_whole_plan_is_asked_about():
    with pytest.raises(SamplerError, match=rf"^stream '[^']+': {ONE}wrap .*:one_of_two at \S*test_optimizers.py:\d+$"):
        solve(points(one_of_two), timeout=10.0)


def test_what_a_message_shows_is_short():
    problem = points(from_fn(lambda outputs, facts, hint: tuple(range(1000))))
    with pytest.raises(SamplerError, match=r"found \(0, 1, 2, .*\.\.\.\)") as said:
        solve(problem, timeout=10.0)
    assert len(str(said.value)) < 300


def test_an_optimizer_without_procedure():
    with pytest.raises(SamplerError, match="optimizer 'fit' has no procedure; given are: plan-path"):
        Problem(SHELF, OPTIMIZER, from_stream_map({"plan-path": from_fn(lambda a, b: (1,))}), [], ("Empty", 0))


def test_debug_samplers_stand_for_its_streams():
    problem = points(from_fn(lambda outputs, facts, hint: None))
    problem = Problem(problem.domain, POINTS_STREAMS, "debug", problem.init, ("Done",))
    assert solve(problem, timeout=10.0).solved


def test_the_procedure_of_the_benchmark_says_no():
    regions = {"narrow": (0.0, 1.5)}
    facts = (("pose", "A", "?p"), ("within", "A", "?p", "narrow"))
    assert list(fit(regions).sampler(("?p",), facts, hint={})) == [None]
    wide = list(fit({"wide": (0.0, 5.0)}).sampler(("?p",), (("within", "A", "?p", "wide"),), hint={}))
    assert np.allclose(wide[0], [1.0, 0.0])
