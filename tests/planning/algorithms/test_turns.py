"""Which skeletons have turns beside those that the search finds."""

from benchmarks.pddlstream.belief import hidden
from tamp.planning import solve


def test_what_leaves_nothing_open_has_no_further_turn():
    """Each turn of a plan that could not come to anything else was followed by a round of sampling: 3222 calls."""
    solution = solve(hidden(), algorithm="binding", timeout=20.0)
    assert solution.status == "solved"
    assert sum(stream.calls for stream in solution.report.streams) < 2000
