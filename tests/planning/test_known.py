"""Problems whose cheapest plans are known: what PDDLStream's users have, with no hints and by each algorithm."""

import pytest

from benchmarks.pddlstream_like import KNOWN
from tamp.planning import solve
from tests.planning.test_problems import ALGORITHMS, check


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("name", KNOWN)
def test_the_cheapest_plan_is_found(name, algorithm):
    problem, best = KNOWN[name]()
    solution = solve(problem, algorithm=algorithm, timeout=30.0)
    check(problem, solution)
    assert solution.cost == pytest.approx(best), solution.cost
