"""Values of plans that fail are left open again, so that fresh draws compete with them."""

import pytest

from benchmarks.pddlstream.shapes import shelf
from tamp.planning import solve
from tests.planning.test_problems import ALGORITHMS, check

REGIONS = {"floor": (-10.0, 10.0), "stove": (5.0, 10.0), "middle": (-2.0, 2.0)}


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_a_value_that_several_streams_gave_bars_no_other_from_being_left_open(algorithm):
    """Both blocks are gripped by the same value; what was drawn for one of them was then kept, and failed for ever."""
    problem = shelf([-7.0, 0.3], {"A": ["stove", "middle"]}, REGIONS)
    solution = solve(problem, algorithm=algorithm, timeout=20.0)
    check(problem, solution)
    assert solution.report.counts["iterations"] < 20
