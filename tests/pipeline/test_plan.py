from __future__ import annotations

import math
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import tamp
from tamp.checking import check
from tamp.planning import Report
from tamp.streams.grasping.sampler import sample_grasp
from tamp.task import Grip
from tamp.task.files.plan_file import plan_sha256
from tests.pipeline.samplers import FROM_ABOVE, NO_HANDS, SIDEWAYS

SCENARIOS = Path(__file__).parents[2] / "scenarios"
MINE = "tests.pipeline.samplers:from_above"


@pytest.fixture(scope="module")
def task():
    return tamp.load_task(SCENARIOS / "one_object.yaml")


@pytest.fixture(scope="module")
def plan(task):
    return tamp.plan(task, seed=3)


def grasps_in(plan):
    return [step.attachment.T_tool_object.inverse() for step in plan.steps if isinstance(step, Grip)]


def one_of_mine(pose):
    return any(np.allclose(pose.matrix, mine.matrix, atol=1e-9) for mine in (FROM_ABOVE, SIDEWAYS))


def test_a_plan_brings_the_object_from_its_start_to_its_goal(task, plan):
    assert [action.name for action in plan.actions] == ["move", "pick", "move", "place"]
    assert plan.start.keys() == plan.goals.keys() == {"red"}
    assert plan.seed == 3
    assert math.dist(plan.goals["red"].xyz, task.object("red").goal.pose.xyz) < 0.002
    assert check(task, plan, start=plan.start, goals=plan.goals).accepted


def test_the_same_seed_gives_the_same_plan_whatever_was_planned_before_and_another_seed_another(task, plan):
    assert plan_sha256(tamp.plan(task, seed=4)) != plan_sha256(plan)
    assert plan_sha256(tamp.plan(task, seed=3)) == plan_sha256(plan)


@pytest.mark.skipif(sys.platform != "linux", reason="more threads need Linux")
@pytest.mark.parametrize("clock", ["wall", "processor"])
def test_more_threads_find_the_same_plan(clock):
    task = tamp.load_task(SCENARIOS / "swap.yaml")
    one, two = (tamp.plan(task, seed=1, threads=threads, clock=clock) for threads in (1, 2))
    assert plan_sha256(one) == plan_sha256(two)


@pytest.mark.parametrize("threads", [0, -1, 1.5, "2"])
def test_what_is_no_number_of_threads_is_refused(task, threads):
    with pytest.raises(tamp.TampError, match=r"threads is .*valid are 1, 2, 3"):
        tamp.plan(task, threads=threads)


@pytest.mark.skipif(sys.platform != "linux", reason="more threads need Linux")
def test_more_threads_say_why_there_is_no_plan(task):
    with pytest.raises(tamp.PlanningFailure, match="no plan") as caught:
        tamp.plan(task, threads=2, timeout=0.05)
    assert caught.value.status == "timeout"


def test_another_process_finds_the_same_plan(plan):
    program = (
        "import sys, tamp\n"
        "from tamp.task.files.plan_file import plan_sha256\n"
        "print(plan_sha256(tamp.plan(tamp.load_task(sys.argv[1]), seed=3)))\n"
    )
    command = [sys.executable, "-c", program, str(SCENARIOS / "one_object.yaml")]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.split()[-1] == plan_sha256(plan)


def test_a_samplers_function_is_used(task, plan):
    asked = []

    def mine(context, obj):
        asked.append(obj)
        yield from sample_grasp(context, obj)

    # Nothing else differs: the plan is the one that the domain's own sampler gives.
    assert plan_sha256(tamp.plan(task, seed=3, samplers={"sample-grasp": mine})) == plan_sha256(plan)
    assert "red" in asked


def test_a_samplers_address_is_used_as_argument_and_in_the_task(task, plan):
    assert not any(one_of_mine(grasp) for grasp in grasps_in(plan))
    by_argument = tamp.plan(task, samplers={"sample-grasp": MINE})
    by_task = tamp.plan(replace(task, samplers={"sample-grasp": MINE}), trust_task_code=True)
    for found in (by_argument, by_task):
        assert grasps_in(found)
        assert all(one_of_mine(grasp) for grasp in grasps_in(found))
    assert plan_sha256(by_argument) == plan_sha256(by_task)


def test_an_argument_is_nearer_than_the_tasks_own_sampler(task):
    stubborn = replace(task, samplers={"sample-grasp": "tests.pipeline.samplers:no_grasp"})
    assert all(
        one_of_mine(grasp)
        for grasp in grasps_in(tamp.plan(stubborn, samplers={"sample-grasp": MINE}, trust_task_code=True))
    )


@pytest.mark.parametrize("samplers", [{"sample-grasps": MINE}, {"sample-grasp": "tests.pipeline.samplers:from_abov"}])
def test_a_sampler_that_is_not_there_is_refused(task, samplers):
    with pytest.raises(tamp.SamplerError, match=r"did you mean '(sample-grasp|from_above)'"):
        tamp.plan(task, samplers=samplers)


def test_an_exception_in_a_sampler_comes_out_with_its_stream(task):
    def broken(context, obj):
        raise ZeroDivisionError("mine")
        yield

    with pytest.raises(Exception, match="sample-grasp") as failed:
        tamp.plan(task, samplers={"sample-grasp": broken})
    assert isinstance(failed.value.__cause__, ZeroDivisionError)


def test_a_failure_says_for_each_stream_how_it_did_and_why(task):
    with pytest.raises(tamp.PlanningFailure) as failed:
        tamp.plan(task, samplers=NO_HANDS)
    report = failed.value.report
    assert isinstance(report, Report)
    assert failed.value.status == report.status
    grasping = next(stream for stream in report.streams if stream.name == "sample-grasp")
    assert grasping.calls > 0
    assert grasping.successes == 0
    assert grasping.failures[0][0] == "nobody grasps red"
    assert "nobody grasps red" in failed.value.left["red"]
    assert str(failed.value).startswith("no plan (failed); red: ")
