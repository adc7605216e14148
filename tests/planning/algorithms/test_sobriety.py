"""Turns of real values alone: several plans among the same values, and what is asked of their like."""

import pytest

from benchmarks.pddlstream.small import packing
from tamp.planning import solve
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
