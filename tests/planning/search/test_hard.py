"""Tasks that are large for their search, and what is brought that nobody promised."""

from benchmarks.pddlstream.roads import logistics, visits
from tamp.planning import solve
from tests.planning.test_problems import check


def test_many_packages_on_many_roads():
    """The last search preferred no actions, and was ended after ten times as long with nothing found."""
    problem = logistics(50, 12, 2)
    solution = solve(problem, algorithm="incremental", timeout=30.0)
    check(problem, solution)
    assert solution.report.counts["iterations"] == 1


def test_a_roadmap_that_a_call_has_brought_is_searched_before_others_are_made():
    """The values of a plan that failed were tried one after the other, and each call brought another roadmap."""
    problem = visits(2)
    solution = solve(problem, timeout=30.0)
    check(problem, solution)
    calls = next(stream.calls for stream in solution.report.streams if stream.name == "connect")
    assert calls < 40
