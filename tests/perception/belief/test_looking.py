"""What contradicts a belief, where it comes to rest, and where to look next."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tamp.perception.belief import next_view, rest
from tamp.perception.belief.absence import absent
from tamp.perception.belief.next_view import Unseen, next_views, seen_into, unseen
from tamp.perception.belief.rest import at_rest, lifted_apart
from tamp.perception.cameras.camera import Camera, Frame, Intrinsics, looking_at
from tamp.perception.cameras.capture import shoot, views
from tamp.perception.cameras.setup import load_setup
from tamp.perception.estimate import Estimate
from tamp.perception.rendering.backends import open_renderer
from tamp.perception.rendering.robot import camera_pose
from tamp.perception.rendering.scene import objects_at, robot_body, table_body
from tamp.perception.rendering.surface import Surface, plain
from tamp.task import Box, Object, Pose, Table, Task, load_robot
from tamp.world.geometry.object_geometry import geometry_of_object
from tamp.world.robot.model import robot_model
from tamp.world.world import World

pytest.importorskip("embreex", reason="the extra perception is not installed")

K = Intrinsics.from_field_of_view(320, 240, math.radians(50))
LOOKS = {"wall": plain(Box((0.02, 0.3, 0.25))), "brick": plain(Box((0.08, 0.08, 0.06)))}
POSES = {"wall": Pose((-0.05, 0.0, 0.125)), "brick": Pose((0.1, 0.25, 0.03))}
CAMERA = Camera("wrist", K, "panda_link8", Pose((0.0, 0.0, 0.06)))


def _world(task: Task) -> World:
    return World(robot_model(load_robot("panda")), {o.name: geometry_of_object(o) for o in task.objects}, task.table)


def _frame(eye: tuple[float, float, float], poses: dict[str, Pose], looks: Mapping[str, Surface] = LOOKS) -> Frame:
    T = looking_at(np.array(eye), np.array([-0.05, 0.05, 0.05]))
    with open_renderer("raycast")([*objects_at(looks, poses), table_body(Table())]) as scene:
        picture = scene.picture(K, T)
    return Frame("c", K, T, picture.color, picture.depth, np.zeros(picture.depth.shape, dtype=bool))


def test_what_is_where_it_is_thought_to_be_is_not_absent() -> None:
    assert absent([_frame((0.8, 0.1, 0.7), POSES)], LOOKS, POSES, Table()) == set()


def test_what_is_gone_is_absent_and_what_cannot_be_seen_is_not() -> None:
    frame = _frame((0.8, 0.1, 0.7), {"wall": POSES["wall"]})
    assert absent([frame], LOOKS, POSES, Table()) == {"brick"}
    hidden = {**POSES, "brick": Pose((-0.15, 0.0, 0.03))}
    assert absent([_frame((0.9, 0.0, 0.1), {"wall": POSES["wall"]})], LOOKS, hidden, Table()) == set()


@pytest.mark.parametrize("beside", [-0.005, 0.005])
def test_what_a_camera_looks_along_is_there_though_it_is_a_little_beside(beside: float) -> None:
    """A wall whose side shows at a grazing angle: along the rays 5 mm are 5 cm."""
    looks = {"wall": plain(Box((0.3, 0.02, 0.25)))}
    thought = {"wall": Pose((-0.05, 0.0, 0.125))}
    truly = {"wall": Pose((-0.05, beside, 0.125))}
    frame = _frame((0.6, 0.07, 0.45), truly, looks)
    assert absent([frame], looks, thought, Table()) == set()
    assert absent([_frame((0.6, 0.07, 0.45), {}, looks)], looks, thought, Table()) == {"wall"}


def test_what_is_flat_is_absent_where_the_table_shows_and_not_where_sensors_err() -> None:
    """Through the contest's cameras, with all of their noise."""
    robot = load_robot("panda")
    looks = {name: plain(Box((0.18, 0.18, 0.01))) for name in ("near", "far")}
    poses = {"near": Pose((-0.05, 0.15, 0.005)), "far": Pose((0.1, -0.2, 0.005))}
    for there in (poses, {"near": poses["near"]}):
        shots = shoot(looks, there, views(load_setup(), robot), robot, table=Table(), seed=0)
        assert absent([shot.frame for shot in shots], looks, poses, Table()) == poses.keys() - there.keys()
        standing = [shot.frame for shot in shots if shot.frame.camera == "kinect"]
        assert absent(standing, looks, there, Table()) == set()


def test_a_floating_estimate_comes_to_rest() -> None:
    task = Task("one", (Object("brick", Box((0.08, 0.08, 0.06)), Pose()),))
    found = at_rest(task, _world(task), {"brick": Estimate(Pose((0.0, 0.1, 0.035)), 0.4)})["brick"]
    assert found.pose is not None
    assert found.pose.xyz == pytest.approx((0.0, 0.1, 0.03), abs=1e-3)
    assert found.confidence == 0.4


def test_an_unsure_estimate_that_cannot_be_is_given_up_and_a_sure_one_is_not() -> None:
    shape = Box((0.08, 0.08, 0.06))
    task = Task("two", (Object("a", shape, Pose()), Object("b", shape, Pose())))
    said = {"a": Estimate(Pose((0.0, 0.1, 0.03)), 0.9), "b": Estimate(Pose((0.0, 0.1, 0.2)), 0.2)}
    found = at_rest(task, _world(task), said)
    assert found["b"] == Estimate(None, 0.0)
    assert found["a"].pose is not None
    assert found["a"].pose.xyz == pytest.approx((0.0, 0.1, 0.03), abs=1e-3)


def test_what_is_a_little_inside_what_it_stands_on_is_not_thrown_off_it() -> None:
    shape = Box((0.08, 0.02, 0.06))
    task = Task("pile", (Object("low", shape, Pose()), Object("high", shape, Pose())))
    said = {"low": Pose((0.0, 0.1, 0.03)), "high": Pose((0.0, 0.1, 0.07))}
    found = at_rest(task, _world(task), {name: Estimate(pose, 0.9) for name, pose in said.items()})
    assert found["high"].pose is not None
    assert found["high"].pose.xyz == pytest.approx((0.0, 0.1, 0.09), abs=2e-3)


def test_things_are_lifted_out_of_what_is_below_them_and_not_out_of_what_is_beside_them() -> None:
    shape = Box((0.06, 0.06, 0.08))
    world = _world(Task("three", tuple(Object(name, shape, Pose()) for name in "abc")))
    said = {"a": Pose((0.0, 0.0, 0.04)), "b": Pose((0.0, 0.01, 0.11)), "c": Pose((0.055, 0.0, 0.04))}
    apart = lifted_apart(world, said)
    assert (apart["a"], apart["c"]) == (said["a"], said["c"])
    assert 0.118 < apart["b"].xyz[2] < 0.122


def test_what_physics_throws_apart_stands_as_it_was_expected_near_by(monkeypatch: pytest.MonkeyPatch) -> None:
    """Stacked things that are seen a little inside each other, however they are lifted."""
    task = Task("stack", tuple(Object(name, Box((0.1, 0.1, 0.1)), Pose()) for name in ("low", "high")))
    expected = {"low": Pose((0.0, 0.1, 0.05)), "high": Pose((0.0, 0.1, 0.15))}
    seen = {name: Pose((0.005, 0.1, pose.xyz[2] - 0.004)) for name, pose in expected.items()}
    thrown = {name: Pose((0.3, 0.1, 0.05)) for name in expected}

    def explosive(_: Task, poses: Mapping[str, Pose], **__: Any) -> Any:
        return SimpleNamespace(poses=expected if poses == expected else thrown)

    monkeypatch.setattr(rest, "settle", explosive)
    estimates = {name: Estimate(pose, 0.9) for name, pose in seen.items()}
    found = at_rest(task, _world(task), estimates, expected=expected)
    assert {name: e.pose for name, e in found.items()} == expected
    far = {name: Pose((0.4, 0.1, pose.xyz[2])) for name, pose in expected.items()}
    found = at_rest(task, _world(task), estimates, expected=far)
    assert {name: e.pose for name, e in found.items()} == thrown, "what was expected elsewhere says nothing"


def test_behind_a_wall_is_unseen_and_the_next_view_looks_there() -> None:
    hidden = unseen([_frame((0.6, 0.0, 0.25), POSES)], Table())
    behind = (hidden.cells[:, 0] < -0.1) & (np.abs(hidden.cells[:, 1]) < 0.05) & (hidden.cells[:, 2] < 0.1)
    assert behind.sum() > 50
    world = World(robot_model(load_robot("panda")), {}, Table())
    # Only what is behind the wall is asked for, so that the test says where it must look.
    wanted = Unseen(hidden.cells[behind], hidden.surface)
    q = next(next_views(wanted, CAMERA, world, {}, np.random.default_rng(0)))
    T = camera_pose(CAMERA, load_robot("panda"), q)
    ahead = (wanted.cells - T[:3, 3]) @ T[:3, :3]
    pixels, depth = K.project(ahead)
    inside = (depth > 0) & (pixels >= 0).all(axis=1) & (pixels < (K.width, K.height)).all(axis=1)
    assert inside.mean() > 0.5
    assert world.robot.forward(np.array(q))[2, 3] > 0.0


@pytest.mark.parametrize("place", [(0.05, 0.3, 0.03), (-0.25, -0.25, 0.03), (0.2, 0.0, 0.03)])
def test_the_next_view_is_of_where_something_is_thought_to_be(place: tuple[float, ...]) -> None:
    narrow = replace(CAMERA, intrinsics=Intrinsics.from_field_of_view(320, 240, math.radians(22)))
    grid = np.stack(np.meshgrid(np.arange(-0.4, 0.4, 0.02), np.arange(-0.5, 0.5, 0.02), [0.02, 0.05], indexing="ij"))
    nothing_seen = Unseen(grid.reshape(3, -1).T, np.empty((0, 3)))
    world = World(robot_model(load_robot("panda")), {}, Table())
    q = next(next_views(nothing_seen, narrow, world, {}, np.random.default_rng(0), sought=[np.array(place)]))
    T = camera_pose(narrow, load_robot("panda"), q)
    near = nothing_seen.cells[np.linalg.norm(nothing_seen.cells - place, axis=1) < 0.04]
    empty = np.full((240, 320), np.inf)
    assert seen_into(narrow.intrinsics, T, empty, near, 0.0).mean() > 0.8


def test_a_view_shows_nothing_behind_the_arm() -> None:
    """A camera on the wrist that looks back at the arm."""
    robot = load_robot("panda")
    back = Camera("back", K, "panda_link8", Pose.from_rpy((0.15, 0.0, 0.1), (math.pi, 0.0, 0.0)))
    world, T = World(robot_model(robot), {}, Table()), camera_pose(back, robot, robot.home)
    with open_renderer("raycast")([robot_body(robot, robot.home)]) as scene:
        depth = scene.picture(K.scaled(1 / 8), T).depth
    rows, columns = np.nonzero(np.ones_like(depth))
    rays = K.scaled(1 / 8).rays().reshape(-1, 3)
    arm = depth[rows, columns] > 0
    assert 0.05 < arm.mean() < 0.95
    cells = (rays * 1.2) @ T[:3, :3].T + T[:3, 3]
    shown = next_view._look_from(back, world, robot.home, Unseen(cells, np.empty((0, 3)))).shown
    assert shown[~arm].mean() > 0.9 and shown[arm].mean() < 0.1


def test_where_nothing_is_hidden_there_is_no_next_view() -> None:
    world = World(robot_model(load_robot("panda")), {}, Table())
    nothing = Unseen(np.empty((0, 3)), np.zeros((1, 3)))
    assert list(next_views(nothing, CAMERA, world, {}, np.random.default_rng(0))) == []
