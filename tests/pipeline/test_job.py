from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pybullet
import pytest

from tamp.execution.executor import Executor
from tamp.pipeline.job import ASTRAY, Job
from tamp.pipeline.planning import Planning
from tamp.pipeline.setup import prepare
from tamp.pipeline.solving import MAX_CORRECTIONS, carry_out
from tamp.task import At, Box, Object, Plan, Pose, Task

RED = Object("red", Box((0.05, 0.05, 0.08)), Pose((0.05, 0.2, 0.04)), At(Pose((0.1, -0.2, 0.04))))


def shifted(pose, distance):
    return Pose(tuple(np.add(pose.xyz, (distance, 0.0, 0.0))), pose.quat)


@pytest.mark.parametrize(("off", "astray", "missed"), [(0.0, 0, 0), (1.5 * ASTRAY, 1, 0), (0.05, 1, 1)])
def test_what_is_a_little_off_is_astray_and_what_is_far_off_is_missed(off, astray, missed):
    task = Task("near", (RED,))
    setup = prepare(task)
    job = Job(task, 0, 60.0, None, "adaptive")
    job.final_poses = {"red": shifted(setup.goals["red"].pose, off)}
    assert (len(job.astray(setup)), len(job.missed)) == (astray, missed)


def test_what_a_plan_leaves_is_not_astray():
    task = Task("left", (RED,))
    setup = prepare(task)
    job = Job(task, 0, 60.0, None, "adaptive")
    job.final_poses = dict(setup.start)
    job.plans.append(Plan("left", "panda", 0, setup.start, (0.0,) * 7, {}, (), {"left": {"red": "no grasp"}}))
    assert job.astray(setup) == set()


@pytest.mark.parametrize(("off", "times"), [(0.015, 1), (0.04, MAX_CORRECTIONS + 1)])
def test_what_ends_a_little_off_is_corrected_and_what_misses_its_goal_however_often(monkeypatch, off, times):
    """The first plans are made to end beside the goal, as if a gripper had been off."""
    true, calls = Executor.carry_out, []

    def nudged(self, plan):
        execution = true(self, plan)
        calls.append(plan)
        if len(calls) <= times:
            body = self._simulator.bodies["red"]
            position, turn = pybullet.getBasePositionAndOrientation(body.id, physicsClientId=self._simulator._client)
            beside = (position[0] + off, *position[1:])
            pybullet.resetBasePositionAndOrientation(body.id, beside, turn, physicsClientId=self._simulator._client)
            self._simulator.step(60)
            execution = replace(execution, final_poses=self.poses())
        return execution

    monkeypatch.setattr(Executor, "carry_out", nudged)
    run = carry_out(Task("nudged", (RED,)), seed=0, timeout=300.0)
    assert len(calls) == times + 1
    assert run.result.status == "solved"
    assert run.result.ede_m < 0.5 * ASTRAY
    assert run.result.n_replans == times


@pytest.mark.parametrize("plans", [(), (Plan("vain", "panda", 0, {}, (), {}, ()),)])
def test_a_search_that_time_cut_short_is_followed_by_another_with_all_that_is_left(monkeypatch, plans):
    begun = []

    class InVain:
        cut_short, rejections, left, hopeless = True, (), {"red": "no time was left"}, {}
        report = SimpleNamespace(status="timeout")

        def __init__(self, *_, seed, deadline, **__):
            begun.append((seed, deadline))

        def run(self):
            return None

    monkeypatch.setattr("tamp.pipeline.job.Planning", InVain)
    job = Job(Task("vain", (RED,)), 3, 100.0, None, "adaptive", plans=[*plans])
    assert not job.plan(None, {}, ())
    (first, soft), (second, hard) = begun
    assert first == 3 != second
    assert hard - soft > 20.0


def test_what_a_hurried_plan_leaves_is_planned_for_with_the_time_that_was_kept(monkeypatch):
    searches = []

    class Hurried(Planning):
        """The first search finds no time for anything."""

        cut_short = property(lambda self: self is searches[0])

        def run(self, *, persistent=False):
            searches.append(self)
            found = super().run(persistent=persistent)
            return replace(found, actions=(), report={"left": {"red": "no time"}}) if len(searches) == 1 else found

    monkeypatch.setattr("tamp.pipeline.job.Planning", Hurried)
    run = carry_out(Task("hurried", (RED,)), seed=0, timeout=300.0)
    assert len(searches) == 2
    assert run.result.status == "solved"


def test_a_search_knows_who_is_hopeless_as_long_as_it_stands_where_it_stood(monkeypatch):
    known = []

    class InVain:
        cut_short, rejections, left = False, (), {"red": "no grasp"}
        report, hopeless = SimpleNamespace(status="failed"), {"red": (RED.pose, "no grasp")}

        def __init__(self, *_, hopeless, **__):
            known.append(dict(hopeless))

        def run(self):
            return None

    monkeypatch.setattr("tamp.pipeline.job.Planning", InVain)
    job = Job(Task("vain", (RED,)), 0, 100.0, None, "adaptive")
    for off in (0.0, 0.001, 0.05):
        assert not job.plan(None, {"red": shifted(RED.pose, off)}, ())
    assert known == [{}, {"red": "no grasp"}, {}]
