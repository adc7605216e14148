"""Random problems for all algorithms: each problem with one of them or, with EXPLORE set, with all."""

import os

import pytest

from tests.planning.test_problems import ALGORITHMS


def in_turn(count: int) -> pytest.MarkDecorator:
    """Parameters `seed`, below a count, and `algorithm`, which takes turns."""
    turns = [(seed, ALGORITHMS[seed % len(ALGORITHMS)]) for seed in range(count)]
    every = [(seed, algorithm) for seed in range(count) for algorithm in ALGORITHMS]
    return pytest.mark.parametrize(("seed", "algorithm"), every if os.environ.get("EXPLORE") else turns)
