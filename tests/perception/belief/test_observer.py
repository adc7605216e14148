"""One look is one piece of evidence, however many times its frames are looked at."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tamp.perception.belief import observer
from tamp.perception.belief.belief import Belief
from tamp.perception.belief.observer import Observer
from tamp.perception.cameras.camera import Frame, Intrinsics
from tamp.perception.cameras.capture import View, shoot, views
from tamp.perception.cameras.setup import load_setup
from tamp.perception.estimate import Estimate
from tamp.perception.rendering.surface import Surface, plain
from tamp.task import Box, Object, Pose, Task, Trajectory, load_robot
from tamp.task.robot import RobotSpec
from tamp.world.geometry.object_geometry import geometry_of_object
from tamp.world.robot.model import robot_model
from tamp.world.scene import Scene
from tamp.world.world import World

pytest.importorskip("embreex", reason="the extra perception is not installed")

SHAPE = Box((0.05, 0.05, 0.05))
HERE = Pose((0.0, 0.1, 0.025))
TASK = Task("one", (Object("a", SHAPE, Pose()),))
LOOKS = {"a": plain(SHAPE)}
WORLD = World(robot_model(load_robot("panda")), {o.name: geometry_of_object(o) for o in TASK.objects}, TASK.table)
K = Intrinsics(1.0, 1.0, 0.5, 0.5, 1, 1)
BLACK = Frame("c", K, np.eye(4), np.zeros((1, 1, 3), np.uint8), np.zeros((1, 1), np.float32), np.zeros((1, 1), bool))


class Still:
    """A cell whose two cameras show nothing, with an arm that goes where it is told."""

    cameras = load_setup()

    def __init__(self) -> None:
        self.q = WORLD.robot.spec.home

    def frame(self, camera: str) -> Frame:
        return BLACK

    def configuration(self) -> tuple[float, ...]:
        return self.q

    def follow(self, trajectory: Trajectory) -> None:
        self.q = tuple(trajectory.positions[-1])


class Dim(Observer):
    """Sees nothing at first, and nothing from two further views either."""

    def _frames(self, poses: Mapping[str, Pose]) -> Iterator[Frame]:
        yield BLACK

    def _further(self, belief: Belief, frames: list[Frame], missing: Collection[str], most: int) -> Iterator[Frame]:
        yield from [BLACK] * most


def _look(expected: Belief | None, said: Sequence[Estimate], monkeypatch: pytest.MonkeyPatch) -> Estimate:
    answers = iter(said)

    def perceiver(*_: Any, **__: Any) -> dict[str, Estimate]:
        return {"a": next(answers)}

    monkeypatch.setattr(observer, "absent", lambda *_: set())
    dim = Dim(Still(), TASK, LOOKS, WORLD, perceiver, 0, 100.0)  # type: ignore[arg-type]
    return dim.look(expected, {"a"}).estimates["a"]


def test_after_a_look_the_arm_is_clear_of_what_was_found(monkeypatch: pytest.MonkeyPatch) -> None:
    cell = Still()
    hand = WORLD.robot.forward(np.array(cell.q))
    found = Estimate(Pose((*hand[:2, 3].tolist(), 0.025)), 0.9)
    tall = Box((0.05, 0.05, 2 * float(hand[2, 3])))
    task = Task("tall", (Object("a", tall, Pose()),))
    world = World(WORLD.robot, {"a": geometry_of_object(task.object("a"))}, task.table)
    at = replace(found, pose=Pose((*hand[:2, 3].tolist(), float(hand[2, 3]))))
    assert not world.checker(Scene({"a": at.pose.matrix})).free(np.array(cell.q))  # type: ignore[union-attr]
    monkeypatch.setattr(observer, "absent", lambda *_: set())
    dim = Dim(cell, task, {"a": plain(tall)}, world, lambda *_, **__: {"a": at}, 0, 100.0)  # type: ignore[arg-type]
    pose = dim.look(None, {"a"}).poses["a"]
    assert world.checker(Scene({"a": pose.matrix})).free(np.array(cell.q))


def test_what_was_not_found_is_doubted_once_a_look(monkeypatch: pytest.MonkeyPatch) -> None:
    nothing = Estimate(None, 0.0)
    found = _look(Belief({"a": Estimate(HERE, 0.4)}), [nothing] * 3, monkeypatch)
    assert found.confidence == pytest.approx(0.2)


def test_what_a_part_of_the_frames_has_shown_of_the_unknown_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    found = _look(None, [Estimate(HERE, 0.2), Estimate(None, 0.0), Estimate(None, 0.0)], monkeypatch)
    assert found.pose is not None


@pytest.mark.parametrize(("beside", "again"), [(0.0, 1), (0.1, 3)])
def test_what_further_views_left_in_doubt_is_not_viewed_again_where_it_is(
    beside: float, again: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[Pose] = []

    def perceiver(*_: Any, **__: Any) -> dict[str, Estimate]:
        asked.append(HERE)
        x = 0.0 if len(asked) <= 3 else beside
        return {"a": Estimate(Pose((HERE.xyz[0] + x, *HERE.xyz[1:])), 0.4)}

    monkeypatch.setattr(observer, "absent", lambda *_: set())
    dim = Dim(Still(), TASK, LOOKS, WORLD, perceiver, 0, 100.0)  # type: ignore[arg-type]
    dim.look(dim.look(None, {"a"}), {"a"})
    assert len(asked) == 3 + again


@pytest.mark.parametrize(("beside", "kind"), [(0.005, None), (0.016, "misplaced")])
def test_what_was_let_go_and_is_seen_beside_its_place_ends_the_plan(
    beside: float, kind: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = Estimate(Pose((HERE.xyz[0] + beside, *HERE.xyz[1:])), 0.9)
    monkeypatch.setattr(observer, "absent", lambda *_: set())
    monkeypatch.setattr(observer, "estimate_nearby", lambda *_: seen)
    eyes = Observer(Still(), TASK, LOOKS, WORLD, None, 0, 100.0)  # type: ignore[arg-type]
    assert eyes.watch({"a": HERE}) is None, "nothing was moved"
    found = eyes.watch({"a": HERE}, ("a",))
    assert (None if found is None else found.kind) == kind


class Watched(Still):
    """A cell in which something unknown stands; the standing camera sees it, and each way of the arm is kept."""

    def __init__(self, standing: Frame) -> None:
        super().__init__()
        self.standing, self.ways = standing, [np.array([self.q])]
        self.time = 0.0

    @property
    def robot(self) -> RobotSpec:
        return WORLD.robot.spec

    def frame(self, camera: str) -> Frame:
        return self.standing if camera == self.standing.camera else BLACK

    def follow(self, trajectory: Trajectory) -> None:
        self.ways.append(np.array(trajectory.positions))
        super().follow(trajectory)


@pytest.mark.parametrize("x", [-0.06, 0.05])
def test_the_arm_is_not_driven_into_what_is_seen_and_not_known(x: float) -> None:
    shape, pose = Box((0.1, 0.25, 0.32)), Pose((x, 0.3, 0.16))
    task = Task("tall", (Object("a", shape, Pose()),))
    world = World(WORLD.robot, {"a": geometry_of_object(task.object("a"))}, task.table)
    scene = Scene({"a": pose.matrix}, opening=WORLD.robot.spec.gripper.stroke)
    free = world.checker(scene).free
    assert not all(free(np.array(q)) for camera in Still.cameras for q in camera.viewpoints)
    fixed = tuple(camera for camera in Still.cameras if not camera.viewpoints)
    spec = WORLD.robot.spec
    (shot,) = shoot({"a": plain(shape)}, {"a": pose}, views(fixed, spec), spec, table=task.table, seed=0)
    cell = Watched(shot.frame)
    eyes = Observer(cell, task, {"a": plain(shape)}, world, None, 0, 100.0)  # type: ignore[arg-type]
    seen = list(eyes._frames({}))
    assert len(seen) >= 5
    assert all(free(q) for way in cell.ways for q in way)


class OnTheArm(Watched):
    """The same cell without the standing camera: the one on the arm sees what is before it."""

    cameras = tuple(camera for camera in Still.cameras if camera.viewpoints)

    def __init__(self, looks: Mapping[str, Surface], poses: Mapping[str, Pose]) -> None:
        super().__init__(BLACK)
        self.looks, self.poses = looks, poses

    def frame(self, camera: str) -> Frame:
        view = View(self.cameras[0], self.q, WORLD.robot.spec.gripper.stroke)
        (shot,) = shoot(self.looks, self.poses, (view,), WORLD.robot.spec, table=TASK.table, seed=len(self.ways))
        return shot.frame


@pytest.mark.parametrize("x", [-0.06, 0.05])
def test_where_no_camera_stands_what_the_arm_has_seen_is_not_driven_into(x: float) -> None:
    shape, pose = Box((0.1, 0.25, 0.32)), Pose((x, 0.3, 0.16))
    task = Task("tall", (Object("a", shape, Pose()),))
    world = World(WORLD.robot, {"a": geometry_of_object(task.object("a"))}, task.table)
    free = world.checker(Scene({"a": pose.matrix}, opening=WORLD.robot.spec.gripper.stroke)).free
    cell = OnTheArm({"a": plain(shape)}, {"a": pose})
    eyes = Observer(cell, task, {"a": plain(shape)}, world, None, 0, 100.0)  # type: ignore[arg-type]
    assert len(list(eyes._frames({}))) >= 5
    assert all(free(q) for way in cell.ways for q in way)
