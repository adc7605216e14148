"""A scene that came to rest before is remembered to the last bit, and any other scene is another."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from tamp.errors import PlanningFailure
from tamp.execution.settling import cache as settling_cache
from tamp.execution.settling.cache import settle_once
from tamp.execution.settling.rounding import nearest_rest
from tamp.execution.settling.settle import settle
from tamp.task import Box, Mesh, Object, Pose, Table, Task

OBJECTS = Path(__file__).parents[3] / "scenarios" / "objects"
MUG = OBJECTS / "mug" / "collision.obj"
BLOCK = Object("block", Box((0.05, 0.06, 0.08)), Pose.from_rpy((0.05, 0.2, 0.05), (0.02, 0.0, 0.3)))


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.setenv("TAMP_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(settling_cache, "WORTH_S", 0.0)
    return tmp_path / "cache" / "settled"


@pytest.fixture
def simulated(monkeypatch: pytest.MonkeyPatch) -> list[Task]:
    """The tasks that were simulated."""
    asked: list[Task] = []

    def settled(task: Task, *arguments: object, **options: object) -> object:
        asked.append(task)
        return nearest_rest(task, *arguments, **options)

    monkeypatch.setattr(settling_cache, "nearest_rest", settled)
    return asked


def _task(mesh: Path = MUG) -> Task:
    mug = Object("mug", Mesh(mesh), Pose((-0.1, -0.2, 0.08)), mass=0.2)
    return Task("two", (BLOCK, replace(BLOCK, name="upper", pose=Pose((0.05, 0.2, 0.14))), mug))


def test_it_is_what_settling_gives_to_the_last_bit(cache: Path, simulated: list[Task]) -> None:
    task = _task()
    assert settle_once(task) == settle_once(task) == settle(task)
    goals = {"mug": Pose((0.1, 0.1, 0.08)), "block": Pose((0.1, -0.3, 0.041))}
    assert settle_once(task, goals) == settle_once(task, dict(goals)) == settle(task, goals)
    assert len(simulated) == 2, "once each"
    assert len([*cache.iterdir()]) == 2
    assert settle_once(task, {}) == settle(task, {})
    again, anew = settle_once(task, goals), settle(task, goals)
    assert repr(again) == repr(anew), "order and signs too"


def test_whatever_decides_it_makes_another_scene(cache: Path, simulated: list[Task], tmp_path: Path) -> None:
    mesh = tmp_path / "mug.obj"
    shutil.copy(MUG, mesh)
    task = _task(mesh)
    block, *others = task.objects
    tasks = [
        task,
        replace(task, table=Table(thickness=0.03)),
        *(
            replace(task, objects=(other, *others))
            for other in (
                replace(block, mass=0.3),
                replace(block, friction=0.7),
                replace(block, name="brick"),
                replace(block, shape=Box((0.05, 0.06, 0.079))),
                replace(block, pose=Pose((0.05, 0.2, 0.0500001))),
            )
        ),
    ]
    for one in tasks:
        settle_once(one)
    mesh.write_text(mesh.read_text(encoding="utf-8").replace("v ", "v -", 1), encoding="utf-8")
    settle_once(task)
    assert len(simulated) == len(tasks) + 1
    settle_once(replace(task, name="of another name", path=tmp_path / "task.yaml"))
    assert len(simulated) == len(tasks) + 1, "a task's name moves nothing"


def test_a_folder_that_is_spoilt_or_cannot_be_used_costs_time_only(
    cache: Path, simulated: list[Task], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    task = Task("one", (BLOCK,))
    good = settle_once(task)
    (file,) = cache.iterdir()
    whole = file.read_bytes()
    middle = len(whole) // 2
    spoilt = (b"", b"nonsense", whole[:middle], whole[:middle] + b"\0" * 40 + whole[middle + 40 :])
    for content in spoilt:
        file.write_bytes(content)
        assert settle_once(task) == good
        assert settle_once(task) == good
    assert len(simulated) == 1 + len(spoilt), "each was put right"
    (tmp_path / "file").write_text("", encoding="utf-8")
    monkeypatch.setenv("TAMP_CACHE", str(tmp_path / "file"))
    assert settle_once(task) == good


def test_what_settles_at_once_fills_no_disk(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(settling_cache, "WORTH_S", 60.0)
    assert settle_once(Task("one", (BLOCK,))) == settle(Task("one", (BLOCK,)))
    assert not cache.exists()


def test_past_the_deadline_nothing_is_remembered(cache: Path) -> None:
    task = Task("one", (BLOCK,))
    settle_once(task)
    with pytest.raises(PlanningFailure):
        settle_once(task, deadline=0.0)


def test_what_somebody_elses_simulator_does_is_not_kept(cache: Path, simulated: list[Task]) -> None:
    entry = settling_cache.SIMULATORS[settling_cache.DEFAULT]
    for _ in range(2):
        settle_once(Task("one", (BLOCK,)), simulator=entry.address)
    assert len(simulated) == 2
    assert not cache.exists()
