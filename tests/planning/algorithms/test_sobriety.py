"""Turns of real values alone: several plans among the same values, and what is asked of their like."""

import pytest

from benchmarks.pddlstream.small import packing
from tamp.planning import Problem, solve
from tamp.planning.algorithms.session import Session
from tamp.planning.options import Options
from tamp.planning.search.fast_downward import FastDownward
from tests.planning.test_problems import check

ARMS = {"left": (-1.0, 5.5), "right": (2.5, 30.0)}


@pytest.mark.parametrize(("algorithm", "seed"), [("adaptive", 0), ("binding", 1), ("focused", 0)])
def test_blocks_that_are_handed_over_where_there_is_hardly_room(algorithm, seed):
    problem = packing(3, (5.0, 1.0), ARMS)
    solution = solve(problem, algorithm=algorithm, timeout=20.0, seed=seed)
    check(problem, solution)
    assert solution.report.counts["iterations"] < 60


def test_types_of_a_value_and_its_robot_are_no_reason_to_search_among_moves():
    """(Conf ?arm ?q) was taken for what decides about moves; each pair of configurations was grounded."""
    session = Session(packing(2, (4.0, 1.0), ARMS), Options(), FastDownward(), eager=False, started=0.0)
    assert [c.schema.name for c in session.connectors.connectors] == ["move"]


FRAME = """
(define (domain frame)
  (:predicates (Bar ?b) (Way ?b ?t) (Stands ?b) (Gone ?b) (Stiff))
  (:action take :parameters (?b ?t)
    :precondition (and (Way ?b ?t) (Stands ?b) (Stiff))
    :effect (and (Gone ?b) (not (Stands ?b)))))
"""
FRAME_STREAMS = """
(define (stream frame)
  (:stream sample-way :inputs (?b) :domain (Bar ?b) :outputs (?t) :certified (Way ?b ?t))
  (:stream test-stiff :fluents (Stands) :certified (Stiff)))
"""


@pytest.mark.parametrize("algorithm", ["adaptive", "focused"])
def test_real_values_have_their_turns_where_a_test_is_told_the_state(algorithm):
    """No set of bars is why a frame falls, as it stands with more: each state is barred by itself, or seen as real."""
    bars = [(i, i + 1) for i in range(10)] + [(i, i + 2) for i in range(9)]

    def stiff(context):
        standing = {fact[1] for fact in context.fluents}
        held = {0}
        while more := [bar for bar in standing if len(held & set(bar)) == 1]:
            held.update(*more)
        return all(bar[0] in held for bar in standing)

    problem = Problem(
        domain=FRAME,
        streams=FRAME_STREAMS,
        samplers={"sample-way": lambda context, bar: ((bar, i) for i in range(100)), "test-stiff": stiff},
        init=[fact for bar in bars for fact in (("Bar", bar), ("Stands", bar))],
        goal=("and", *(("Gone", bar) for bar in bars)),
    )
    solution = solve(problem, algorithm=algorithm, timeout=20.0)
    assert solution.status == "solved" and solution.cost == len(bars)
