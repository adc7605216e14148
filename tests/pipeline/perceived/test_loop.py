"""Rearranging by what cameras see, from end to end, and that nothing but what they see gets through."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tamp.errors import TaskError
from tamp.execution.log import ActionLog, Deviation, Execution, Kind
from tamp.execution.simulators import make_simulator
from tamp.perception.cameras.setup import load_setup
from tamp.perception.rendering.surface import Surface, plain
from tamp.perception.workcell.simulated import SimulatedWorkcell
from tamp.perception.workcell.workcell import Workcell
from tamp.pipeline.options.settings import Settings
from tamp.pipeline.perceived import run as perceived
from tamp.pipeline.perceived.loop import _lost
from tamp.pipeline.solving.job import Job
from tamp.pipeline.solving.run import save_run
from tamp.pipeline.solving.solve import carry_out
from tamp.task import At, Box, Object, Pose, Shape, Task, load_robot
from tamp.task.files.plan_file import plan_sha256

pytest.importorskip("embreex", reason="the extra perception is not installed")

EYES = f"{__package__}.eyes"
COLORS = {0.04: (220, 30, 30), 0.05: (30, 60, 220)}
START = {"red": Pose((-0.05, 0.15, 0.03)), "blue": Pose((0.0, -0.2, 0.03))}
TASK = Task(
    "squares",
    (
        Object("red", Box((0.04, 0.04, 0.06)), START["red"], At(Pose((0.05, -0.05, 0.03)))),
        Object("blue", Box((0.05, 0.05, 0.06)), START["blue"]),
    ),
)
SETUP = """cameras:
  - name: above
    parent: world
    pose: {xyz: [0.0, 0.0, 1.0], quat: [1, 0, 0, 0]}
    size: [480, 480]
    intrinsics: [400, 400, 240, 240]
"""


@pytest.fixture(autouse=True)
def _colored(monkeypatch: pytest.MonkeyPatch) -> None:
    """Boxes have colours by their size: tasks in code have no coloured meshes."""
    monkeypatch.setattr(perceived, "surfaces", lambda task: {obj.name: _look(obj.shape) for obj in task.objects})


@cache
def _look(shape: Shape) -> Surface:
    assert isinstance(shape, Box)
    return plain(shape, COLORS[shape.size[0]])


def _settings(tmp_path: Path, perceiver: str = "by_color") -> Settings:
    (tmp_path / "cameras.yaml").write_text(SETUP, encoding="utf-8")
    return Settings(perceive=f"{EYES}:{perceiver}", cameras=str(tmp_path / "cameras.yaml"), clock="processor")


def test_a_run_is_planned_from_what_is_seen_and_scored_in_the_true_world(tmp_path: Path) -> None:
    run = carry_out(TASK, settings=_settings(tmp_path))
    assert (run.result.status, run.result.perceived) == ("solved", True)
    assert {o["name"]: o["fate"] for o in run.result.perception} == {"red": "reached", "blue": "no goal"}
    assert all(o["estimate_m"] < 0.01 for o in run.result.perception)
    assert run.plans[0].start["red"] != START["red"], "planned from an estimate"
    assert len(run.looks) == 2
    save_run(run, TASK, {}, tmp_path / "run")
    names = {path.name for path in (tmp_path / "run").iterdir()}
    assert {"look-0.json", "look-0.details.json", "look-1.json", "look-0-00-above.png"} <= names


def test_what_is_not_seen_is_said_to_be(tmp_path: Path) -> None:
    result = carry_out(TASK, settings=_settings(tmp_path, "nobody")).result
    assert (result.status, result.message) == ("failed", "red was not seen; blue was not seen")
    assert {o["name"]: o["fate"] for o in result.perception} == {"red": "not seen", "blue": "no goal"}
    assert result.ede_m == pytest.approx(result.do_nothing_ede_m, abs=1e-3)


def test_a_turn_that_cameras_cannot_tell_is_said_to_be_all_that_is_wrong(tmp_path: Path) -> None:
    red = replace(TASK.objects[0], pose=replace(START["red"], quat=(0.0, 0.0, 1.0, 0.0)))
    result = carry_out(replace(TASK, objects=(red, TASK.objects[1])), settings=_settings(tmp_path)).result
    turned = "red: reached, but turned in a way that its shape does not show"
    assert (result.status, result.message) == ("failed", f"goals not reached: red; {turned}")


class Wall:
    """Lets through what a workcell is, and nothing else."""

    def __init__(self, cell: Workcell) -> None:
        allowed = [name for name in dir(Workcell) if not name.startswith("_")]
        self.__ask = lambda name: getattr(cell, name) if name in allowed else self._refuse(name)

    def _refuse(self, name: str) -> None:
        raise AssertionError(f"the planning side asked its workcell for {name!r}")

    def __getattr__(self, name: str) -> object:
        return self.__ask(name)


def _worked(task: Task, tmp_path: Path, *, execute: bool) -> tuple[Job, Mapping[str, Pose]]:
    """Run the loop behind a wall; what it planned, and where everything is in the end."""
    settings = _settings(tmp_path).for_task(task)
    job = Job(task, 0, 60.0, settings)
    looks, robot = perceived.surfaces(task), load_robot("panda")
    with make_simulator("pybullet", TASK.objects, START, table=task.table, robot=robot) as world:
        cell = SimulatedWorkcell(world, looks, load_setup(Path(settings.cameras or "")), task.table)
        perceived.loop_for(task, Wall(cell), looks, job, settings, 0).run(execute=execute)  # type: ignore[arg-type]
        return job, world.poses()


def test_the_planning_side_has_no_way_to_the_truth(tmp_path: Path) -> None:
    """It works a cell through its protocol alone, and start poses in the task, right or wrong, change nothing."""
    lies = replace(TASK, objects=tuple(replace(o, pose=Pose((0.3, 0.5, 0.2))) for o in TASK.objects))
    (told, end), (lied_to, _) = _worked(TASK, tmp_path, execute=True), _worked(lies, tmp_path, execute=False)
    assert told.plans[0].start == lied_to.plans[0].start
    assert [str(a) for a in told.plans[0].actions] == [str(a) for a in lied_to.plans[0].actions]
    assert plan_sha256(told.plans[0]) == plan_sha256(lied_to.plans[0])
    assert np.allclose(end["red"].xyz[:2], (0.05, -0.05), atol=0.015)


def test_a_search_in_vain_is_not_the_last_while_there_is_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plan, calls = Job.plan, []

    def unlucky(job: Job, *scene: Any) -> bool:
        calls.append(scene)
        return len(calls) > 1 and plan(job, *scene)

    monkeypatch.setattr(Job, "plan", unlucky)
    assert carry_out(TASK, settings=_settings(tmp_path)).result.status == "solved"
    assert len(calls) > 1


@pytest.mark.parametrize("kind", ["missed", "dropped", "slipped", "misplaced", "disturbed"])
def test_what_ended_a_plan_is_looked_for_anew(kind: Kind) -> None:
    """Whatever it was by which the plan ended, that object is hardly believed to be where the plan has it."""
    log = (ActionLog("pick(blue)", 1.0, 1, 1, {}, (Deviation("blue", "slipped", 0.03, 0.0),), 0.0),)
    stopped = Execution("deviated", dict(START), (), log, 1.0, deviation=Deviation("red", kind, 0.1, 0.0))
    assert _lost(stopped) == ("blue", "red")
    assert _lost(replace(stopped, deviation=None)) == ("blue",)


def test_a_tasks_own_perceiver_is_refused_where_it_is_not_trusted(tmp_path: Path) -> None:
    text = "objects: [{name: a, shape: {box: [0.04, 0.04, 0.04]}, pose: {xyz: [0, 0, 0.02]}}]\nperceive: my.eyes:look\n"
    (tmp_path / "a.yaml").write_text(text, encoding="utf-8")
    from tamp.task.files.load import load_task

    with pytest.raises(TaskError, match=r"a\.yaml.*my\.eyes:look.*--trust-task-code"):
        carry_out(load_task(tmp_path / "a.yaml"))


def test_a_task_may_ask_to_be_perceived() -> None:
    assert Settings().for_task(replace(TASK, perceive="fit")).perceive == "fit"
    assert Settings(perceive="fit").for_task(TASK).perceive == "fit"
