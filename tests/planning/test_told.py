"""Tests that are told the state and name no cause: what is concluded of their answers."""

import pytest

from tamp.planning import Problem, solve
from tests.planning.test_problems import ALGORITHMS, check

LAMPS = """
(define (domain lamps)
  (:predicates (Lamp ?x) (On ?x) (Bright ?x) (Read))
  (:action switch-on :parameters (?x) :precondition (Lamp ?x) :effect (On ?x))
  (:action switch-off :parameters (?x) :precondition (On ?x) :effect (not (On ?x)))
  (:action read :parameters (?x) :precondition (Bright ?x) :effect (Read)))
"""

LAMPS_STREAMS = """
(define (stream lamps)
  (:stream test-bright :inputs (?x) :domain (Lamp ?x) :fluents (On) :certified (Bright ?x)))
"""


def lamps(on, wanted):
    """Three lamps, some of them on; one can read where as many as wanted are."""
    names = ["a", "b", "c"]
    init = [*(("Lamp", name) for name in names), *(("On", name) for name in names[:on])]
    samplers = {"test-bright": lambda context, lamp: len(context.fluents) == wanted}
    return Problem(LAMPS, LAMPS_STREAMS, samplers, init, ("Read",))


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize(("on", "wanted"), [(1, 2), (3, 1), (0, 3), (2, 0)])
def test_a_state_with_nothing_to_tell_is_one_of_many(on, wanted, algorithm):
    """What a test said where no lamp was on was taken for what it says in any state: "infeasible"."""
    problem = lamps(on, wanted)
    solution = solve(problem, algorithm=algorithm, timeout=20.0)
    assert solution.status == "solved", str(solution.report)
    check(problem, solution)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_that_no_state_will_do_is_proven(algorithm):
    solution = solve(lamps(0, 9), algorithm=algorithm, timeout=20.0)
    assert (solution.plan, solution.status) == (None, "infeasible")
