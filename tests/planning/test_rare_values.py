"""Values from which streams can seldom go on, such as poses that the arm seldom reaches."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tamp.planning import solve
from tests.planning.problems import banks, continuous
from tests.planning.test_problems import check


def counted(problem, algorithm, seeds):
    """How many searches each of some seeds takes to a plan, the fewest first."""
    solutions = [solve(problem, algorithm=algorithm, timeout=20.0, seed=seed) for seed in range(seeds)]
    for solution in solutions:
        check(problem, solution)
    return sorted(solution.report.counts["iterations"] for solution in solutions)


def seldom_reached(problem):
    """The problem with a configuration for the poses of its start, and for one in ten others."""
    starts = [fact[2] for fact in problem.init if fact[0] == "AtPose"]

    def inverse_kinematics(context, block, pose):
        if any(np.array_equal(pose, start) for start in starts) or context.rng.random() < 0.1:
            yield from continuous.inverse_kinematics(context, block, pose)

    return replace(problem, samplers={**problem.samplers, "inverse-kinematics": inverse_kinematics})


@pytest.mark.parametrize("algorithm", ["adaptive", "focused"])
def test_a_plan_is_given_up_only_after_many_values_from_which_nothing_goes_on(algorithm):
    """Six, or two, were tried, and the search asked again and again for the same plan with what had failed."""
    searches = counted(seldom_reached(continuous.line(4)), algorithm, seeds=6)
    assert searches[2] <= 10, searches


def seldom_solved(problem):
    """The problem with a solver of which one call in eighty gives something, whatever it is called for."""

    def inverse_kinematics(context, block, pose):
        while True:
            if context.rng.random() < 0.0125:
                yield from continuous.inverse_kinematics(context, block, pose)
            else:
                yield None

    return replace(problem, samplers={**problem.samplers, "inverse-kinematics": inverse_kinematics})


@pytest.mark.parametrize("algorithm", ["adaptive", "binding"])
def test_a_stream_that_seldom_gives_anything_is_waited_for(algorithm):
    """Each was given up after a few calls, for other plans with ever more values that needed it as well."""
    searches = counted(seldom_solved(continuous.line(4)), algorithm, seeds=3)
    assert searches[1] <= 12, searches


@pytest.mark.parametrize("luck", [1.0, 0.1])
@pytest.mark.parametrize("algorithm", ["adaptive", "binding", "focused"])
def test_a_stream_that_goes_on_in_vain_is_not_waited_for_without_end(algorithm, luck):
    """Each miss made the stream look rarer, and so excused the next one, as soon as it had given anything."""
    problem = banks.garden(2, luck)
    for seed in range(4):
        solution = solve(problem, algorithm=algorithm, timeout=20.0, seed=seed)
        check(problem, solution)
        calls = sum(stream.calls for stream in solution.report.streams)
        assert calls <= 1000 / luck, (seed, calls)
