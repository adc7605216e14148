"""A program imports tamp: what it gets can be compared, copied and sent to other processes; Ctrl-C stops it."""

from __future__ import annotations

import copy
import dataclasses
import pickle
import signal
from typing import Any

import pytest

import tamp
from tests.docs.manual import ROOT

SCENARIO = ROOT / "scenarios" / "one_object.yaml"


@pytest.fixture(scope="module")
def given() -> dict[str, Any]:
    task = tamp.load_task(SCENARIO)
    plan = tamp.plan(task, seed=0)
    run = tamp.execute(task, plan)
    result = tamp.solve(task, execute=False)
    return {"task": task, "plan": plan, "execution": run, "result": result, "score": tamp.score(task, run.final_poses)}


@pytest.mark.parametrize("name", ["task", "plan", "execution", "result", "score"])
@pytest.mark.parametrize("copied", [copy.deepcopy, lambda it: pickle.loads(pickle.dumps(it)), dataclasses.replace])
def test_what_it_gets_can_be_copied_and_sent(given, name, copied):
    assert copied(given[name]) == given[name]


@pytest.mark.parametrize("name", ["task", "plan", "result"])
def test_what_it_gets_becomes_plain_data(given, name):
    assert dataclasses.asdict(given[name])


@pytest.mark.parametrize("name", ["task", "plan", "execution", "score"])
def test_equal_things_have_equal_hashes(given, name):
    assert hash(copy.deepcopy(given[name])) == hash(given[name])


def test_the_same_plan_is_equal_and_another_is_not(given):
    again, other = tamp.plan(given["task"], seed=0), tamp.plan(given["task"], seed=1)
    assert again == given["plan"]
    assert dataclasses.replace(other, seed=0) != given["plan"]
    (first, *_) = (step for step in pickle.loads(pickle.dumps(again)).steps if isinstance(step, tamp.Move))
    assert not first.trajectory.positions.flags.writeable


def test_what_is_written_reads_back_equal(given, tmp_path):
    tamp.save_task(given["task"], tmp_path / "task.yaml")
    tamp.save_plan(given["plan"], tmp_path / "plan.json")
    assert tamp.load_task(tmp_path / "task.yaml") == given["task"]
    assert tamp.load_plan(tmp_path / "plan.json") == given["plan"]


def test_a_failure_comes_back_from_another_process():
    failure = tamp.PlanningFailure("timeout", "no time", {"red": "out of reach"})
    again = pickle.loads(pickle.dumps(failure))
    assert (again.status, again.report, again.left, str(again)) == (*vars(failure).values(), str(failure))


@pytest.mark.parametrize("strategy", ["serialized", "all-at-once", "net-benefit"])
def test_ctrl_c_inside_a_sampler_ends_everything(strategy):
    calls = []

    def interrupted(context, obj):
        calls.append(obj)
        signal.raise_signal(signal.SIGINT)
        yield

    with pytest.raises(KeyboardInterrupt):
        tamp.plan(tamp.load_task(SCENARIO), samplers={"sample-grasp": interrupted}, strategy=strategy)
    with pytest.raises(KeyboardInterrupt):
        tamp.solve(tamp.load_task(SCENARIO), samplers={"sample-grasp": interrupted}, strategy=strategy)
    assert calls == ["red", "red"]


def test_it_has_a_version():
    assert tamp.__version__.count(".") == 2
