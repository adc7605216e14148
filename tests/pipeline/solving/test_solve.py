from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import ClassVar

import numpy as np
import pytest

import tamp
from tamp.checking import Problem, Verdict
from tamp.errors import PlanningFailure
from tamp.execution.executor import Executor
from tamp.pipeline.options.settings import DEFAULT_SETTINGS, Settings
from tamp.pipeline.options.tuning import DEFAULT_TUNING
from tamp.pipeline.plan import Planning, plan
from tamp.pipeline.prepare import prepare
from tamp.pipeline.solving.job import Job
from tamp.pipeline.solving.solve import carry_out
from tamp.pipeline.strategies.known import Known
from tamp.scoring import score
from tamp.task import At, Box, Object, Plan, Pose, Task
from tamp.task.files.plan_file import plan_sha256
from tests.pipeline.samplers import NO_HANDS

RED = Object("red", Box((0.05, 0.05, 0.08)), Pose((0.05, 0.2, 0.04)), At(Pose((0.1, -0.2, 0.04))))


def shifted(pose, distance):
    return Pose(tuple(np.add(pose.xyz, (distance, 0.0, 0.0))), pose.quat)


@pytest.mark.parametrize(
    ("off", "astray", "missed"), [(0.0, 0, 0), (1.5 * DEFAULT_TUNING.astray_m, 1, 0), (0.05, 1, 1)]
)
def test_what_is_a_little_off_is_astray_and_what_is_far_off_is_missed(off, astray, missed):
    task = Task("near", (RED,))
    setup = prepare(task)
    job = Job(task, 0, 60.0, Settings())
    job.final_poses = {"red": shifted(setup.goals["red"].pose, off)}
    assert (len(job.astray(setup)), len(job.missed)) == (astray, missed)


def test_what_a_plan_leaves_is_not_astray():
    task = Task("left", (RED,))
    setup = prepare(task)
    job = Job(task, 0, 60.0, Settings())
    job.final_poses = dict(setup.start)
    job.plans.append(Plan("left", "panda", 0, setup.start, (0.0,) * 7, {}, (), {"left": {"red": "no grasp"}}))
    assert job.astray(setup) == set()


@pytest.mark.parametrize(("off", "times"), [(0.015, 1), (0.04, DEFAULT_TUNING.max_corrections + 1)])
def test_what_ends_a_little_off_is_corrected_and_what_misses_its_goal_however_often(monkeypatch, off, times):
    """The first plans are made to end beside the goal, as if a gripper had been off."""
    true, calls = Executor.carry_out, []

    def nudged(self, plan):
        execution = true(self, plan)
        calls.append(plan)
        if len(calls) <= times:
            self._simulator.place("red", Pose((off, 0.0, 0.0)) @ self._simulator.pose("red"))
            self._simulator.step(60)
            execution = replace(execution, final_poses=self.poses())
        return execution

    monkeypatch.setattr(Executor, "carry_out", nudged)
    run = carry_out(Task("nudged", (RED,)), seed=0, timeout=300.0)
    assert len(calls) == times + 1
    assert run.result.status == "solved"
    assert run.result.ede_m < 0.5 * DEFAULT_TUNING.astray_m
    assert run.result.n_replans == times


@pytest.mark.parametrize("plans", [(), (Plan("vain", "panda", 0, {}, (), {}, ()),)])
def test_a_search_that_time_cut_short_is_followed_by_another_with_all_that_is_left(monkeypatch, plans):
    begun = []

    class InVain:
        cut_short, rejections, left, hopeless, unturned = True, (), {"red": "no time was left"}, {}, {}
        report = SimpleNamespace(status="timeout")

        def __init__(self, *_, seed, deadline, **__):
            begun.append((seed, deadline))

        def run(self):
            return None

    monkeypatch.setattr("tamp.pipeline.solving.job.Planning", InVain)
    job = Job(Task("vain", (RED,)), 3, 100.0, Settings(), plans=[*plans])
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

    monkeypatch.setattr("tamp.pipeline.solving.job.Planning", Hurried)
    run = carry_out(Task("hurried", (RED,)), seed=0, timeout=300.0)
    assert len(searches) == 2
    assert run.result.status == "solved"


def test_a_search_knows_who_is_hopeless_as_long_as_it_stands_where_it_stood(monkeypatch):
    told = []

    class InVain:
        cut_short, rejections, left = False, (), {"red": "no grasp"}
        report, hopeless = SimpleNamespace(status="failed"), {"red": (RED.pose, "no grasp")}
        unturned: ClassVar = {"red": RED.pose}

        def __init__(self, *_, known: Known, **__):
            told.append((dict(known.hopeless), list(known.unturned)))

        def run(self):
            return None

    monkeypatch.setattr("tamp.pipeline.solving.job.Planning", InVain)
    job = Job(Task("vain", (RED,)), 0, 100.0, Settings())
    for off in (0.0, 0.001, 0.05):
        assert not job.plan(None, {"red": shifted(RED.pose, off)}, ())
    assert told == [({}, []), ({"red": "no grasp"}, ["red"]), ({}, [])]


def test_what_is_known_of_an_object_does_not_outlive_the_sight_of_it(monkeypatch):
    """Where poses are perceived, an object that was found once may not be found again: the task is without it then."""
    told = []

    class Asked:
        report, left, cut_short, rejections = SimpleNamespace(status="failed"), {}, False, []
        hopeless, unturned = {"red": (RED.pose, "no grasp")}, {"red": RED.pose}

        def __init__(self, *_, known: Known, **__):
            told.append((dict(known.hopeless), list(known.unturned)))

        def run(self):
            return None

    monkeypatch.setattr("tamp.pipeline.solving.job.Planning", Asked)
    job = Job(Task("lost", (RED,)), 0, 100.0, Settings())
    for objects, poses in (((RED,), {"red": RED.pose}), ((), {}), ((RED,), {"red": RED.pose})):
        job.task = Task("lost", objects)
        assert not job.plan(None, poses, ())
    assert told == [({}, []), ({}, []), ({"red": "no grasp"}, ["red"])]


def test_whatever_executions_have_stopped_at_twice_is_unsteady():
    stopped = [SimpleNamespace(deviation=name and SimpleNamespace(object=name)) for name in ("a", "b", None, "a", None)]
    assert Job(Task("vain", (RED,)), 0, 100.0, Settings(), executions=stopped).unsteady == ["a"]


SCENARIOS = Path(__file__).parents[3] / "scenarios"


def test_one_object_is_solved(run):
    result = run.result
    assert result.status == "solved"
    assert result.plan_checked
    assert dict(result.goals_met) == {"red": True}
    assert result.ede_m < 0.03
    assert result.message == ""
    assert result.grasps_succeeded == result.grasps_attempted == 1
    assert result.n_actions == 4


def test_the_record_agrees_with_what_happened(run, one_object):
    assert run.result.plan_sha256 == plan_sha256(run.plans[0])
    assert run.result.n_replans == len(run.plans) - 1
    assert run.result.ede_m == score(one_object, run.final_poses).ede_m
    assert run.result.execution_sim_s == sum(e.sim_s for e in run.executions)


def test_without_execution_a_task_is_planned_and_has_no_score(run, one_object):
    result = tamp.solve(one_object, seed=0, execute=False)
    assert result.status == "planned"
    assert result.plan_checked
    assert result.plan_sha256 == run.result.plan_sha256
    assert result.ede_m is None
    assert result.improvement is None
    assert result.improvement_ueb is None
    assert result.objects == ()
    assert result.execution_sim_s == 0.0
    assert result.n_actions == 4


def test_solve_and_plan_find_the_same_plan(run, one_object):
    assert plan_sha256(plan(one_object, seed=0)) == run.result.plan_sha256


def test_a_rejected_plan_sends_the_planner_back_and_is_counted(run, one_object, monkeypatch):
    """The checker is made to find something in the first plan: another is made, and the record says so."""
    refusal = Verdict((Problem(0, "move()", 0.5, "collision", ("red", "hand"), 0.002, "red and hand touch"),))
    verdicts = iter([refusal])
    monkeypatch.setattr("tamp.pipeline.prepare.check", lambda *args, **options: next(verdicts, Verdict()))
    second = carry_out(one_object, seed=0, execute=False)
    assert second.result.status == "planned"
    assert second.result.plans_rejected == 1
    assert second.result.plan_sha256 != run.result.plan_sha256
    assert second.plans[0].report["rejected"] == [str(refusal)]
    assert second.rejections == (str(refusal),)
    assert run.result.plans_rejected == 0


def test_two_things_change_places():
    result = tamp.solve(tamp.load_task(SCENARIOS / "swap.yaml"), seed=0)
    assert result.status == "solved"
    assert dict(result.goals_met) == {"cup": True, "jar": True}
    assert result.n_actions >= 12  # one of them moves twice


def test_a_task_that_is_done_already_needs_no_action():
    there = Pose((0.05, 0.2, 0.04))
    result = tamp.solve(Task("done", (Object("red", Box((0.05, 0.05, 0.08)), there, At(there)),)))
    assert result.status == "solved"
    assert result.n_actions == 0


def test_what_is_where_its_goal_settles_and_not_where_that_is_asked_for_is_told_so():
    in_the_air = At(Pose((0.05, 0.2, 0.08)))
    result = tamp.solve(Task("air", (Object("red", Box((0.05, 0.05, 0.08)), Pose((0.05, 0.2, 0.04)), in_the_air),)))
    assert result.status == "failed"
    there = "red is where its goal comes to rest, 4.0 cm (EDE) from the pose that is asked for"
    assert result.message == f"goals not reached: red; {there}"


def test_without_a_plan_the_objects_stay_and_the_message_says_why(one_object):
    settings = Settings(samplers=NO_HANDS, tuning={"max_vain_plans": 1})
    given_up = carry_out(one_object, seed=0, timeout=60.0, settings=settings)
    assert given_up.result.status in ("timeout", "failed", "infeasible")
    assert given_up.result.plan_sha256 == ""
    assert not given_up.result.plan_checked
    assert given_up.result.message.startswith("no plan (")
    assert "red: " in given_up.result.message
    assert given_up.failure is not None
    assert given_up.executions == ()
    assert given_up.result.ede_m == given_up.result.do_nothing_ede_m


def test_time_that_is_up_before_anything_has_settled_is_a_timeout(one_object):
    run = carry_out(one_object, seed=0, timeout=1e-9)
    assert run.result.status == "timeout"
    assert run.final_poses == {thing.name: thing.pose for thing in one_object.objects}


@pytest.mark.parametrize(
    ("spent", "proven", "searches"),
    [(0.0, False, DEFAULT_TUNING.max_vain_plans), (58.0, False, 0), (0.0, True, 0)],
)
def test_a_search_in_vain_is_followed_by_others_while_time_is_left(monkeypatch, one_object, spent, proven, searches):
    asked = []
    monkeypatch.setattr(Job, "plan", lambda job, *scene: bool(asked.append(scene)))
    job = Job(one_object, 0, 60.0, DEFAULT_SETTINGS, planning_s=spent)
    job.failure = PlanningFailure("infeasible", "proven") if proven else None
    assert not job.insist(None, {}, ())
    assert len(asked) == searches


@pytest.mark.parametrize("timeout", [1e7, 1e15, math.inf])
def test_a_limit_may_be_as_long_as_anybody_likes(one_object, timeout):
    assert tamp.solve(one_object, seed=0, timeout=timeout, execute=False).status == "planned"
