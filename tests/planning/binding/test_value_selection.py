"""In which order values are tried."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.pddlstream.small import packing
from tamp.planning import solve
from tamp.planning.binding.value_selection import turned
from tests.planning.problems.handful import handful
from tests.planning.problems.ledge import ledge
from tests.planning.test_problems import check


@given(known=st.integers(0, 30), new=st.integers(0, 10), turn=st.integers(0, 200))
def test_every_value_has_its_turn(known, new, turn):
    order = [turned(number, known, turn) for number in range(known + new)]
    assert sorted(order[:known]) == list(range(known))
    assert order[known:] == list(range(known, known + new))


@given(known=st.integers(0, 30))
def test_the_first_attempt_takes_values_as_they_come(known):
    assert [turned(number, known, 0) for number in range(known)] == list(range(known))


@pytest.mark.parametrize("seed", [0, 2])
def test_tight_shelves_are_filled(seed):
    """Every attempt began at the same values, and each order of the blocks with a small budget again."""
    solution = solve(packing(5, (5.6, 1.0)), algorithm="binding", seed=seed, max_iterations=150, timeout=60.0)
    assert solution.status == "solved"


@pytest.mark.parametrize(("algorithm", "seed"), [("adaptive", 0), ("adaptive", 1), ("binding", 1), ("binding", 4)])
def test_little_is_spent_on_what_does_not_help_a_bad_choice(algorithm, seed):
    """One in 36 pairs of places will do: each was given up after ever more ways to reach it, and to hold the thing."""
    problem = ledge(1.2)
    solution = solve(problem, algorithm=algorithm, seed=seed, max_iterations=4)
    assert solution.status == "solved"
    check(problem, solution)


@pytest.mark.parametrize("algorithm", ["adaptive", "binding"])
def test_values_that_a_test_is_against_are_passed_over_where_no_other_choice_is_to_blame(algorithm):
    """Each few of them ended the attempt: all was searched anew, until no more searches were allowed."""
    solution = solve(handful(60, past=20), algorithm=algorithm, max_iterations=3)
    assert solution.status == "solved"
