"""Grasps from a cloud: antipodal on the true shape, clear of table and neighbours, and a sampler like any other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tamp.perception.cameras.capture import shoot, views
from tamp.perception.cameras.setup import load_setup
from tamp.perception.estimation.estimator import see
from tamp.perception.estimation.volume import Volume
from tamp.perception.grasps import CloudGrasps, Pinch, hand_points, pinches
from tamp.perception.rendering.surface import plain
from tamp.streams.values import Grasp, Placement
from tamp.task import Box, Pose, Table, load_robot
from tamp.world.robot.model import robot_model

pytest.importorskip("embreex", reason="the extra perception is not installed")

PANDA = load_robot("panda")
SIZE = np.array([0.05, 0.12, 0.1])
POSE = Pose.from_rpy((-0.05, 0.05, 0.05), (0, 0, 0.5))


@pytest.fixture(scope="module")
def scene() -> Volume:
    cameras = [replace(c, intrinsics=c.intrinsics.scaled(0.5)) for c in load_setup()]
    looks = {"block": plain(Box((0.05, 0.12, 0.1)))}
    found = see([s.frame for s in shoot(looks, {"block": POSE}, views(cameras, PANDA), PANDA)], Table())
    assert found is not None
    return found


@pytest.fixture(scope="module")
def found(scene: Volume) -> list[Pinch]:
    return pinches(scene, np.arange(len(scene.cloud.points)), PANDA, np.random.default_rng(0))


def test_grasps_are_antipodal_on_the_true_box(found: list[Pinch]) -> None:
    assert len(found) > 20
    good = 0
    for pinch in found:
        T = np.linalg.inv(POSE.matrix) @ pinch.T_world_tool
        across = np.abs(T[:3, 1])
        side = int(across.argmax())
        good += bool(across[side] > 0.95 and abs(pinch.width - SIZE[side]) < 0.008)
    assert good / len(found) > 0.9


def test_the_hand_is_clear_of_table_and_box(found: list[Pinch]) -> None:
    for pinch in found:
        points = hand_points(PANDA, round(pinch.width + 2 * pinch.clearance, 3))
        world = points @ pinch.T_world_tool[:3, :3].T + pinch.T_world_tool[:3, 3]
        assert world[:, 2].min() > 0
        local = (world - POSE.xyz) @ POSE.matrix[:3, :3]
        assert not (np.abs(local) < SIZE / 2 - 0.001).all(axis=1).any()


def test_what_is_too_wide_or_hardly_seen_has_no_grasp(scene: Volume) -> None:
    own = np.arange(len(scene.cloud.points))
    narrow = replace(PANDA, gripper=replace(PANDA.gripper, stroke=0.03))
    assert not pinches(scene, own, narrow, np.random.default_rng(0))
    assert not pinches(scene, own[:5], PANDA, np.random.default_rng(0))


class _Workspace:
    """As much of a workspace as the sampler looks at."""

    def __init__(self) -> None:
        self.start = {"block": Placement(POSE, ("table",)), "gone": Placement(Pose((0.2, -0.5, 0.05)), ("table",))}
        self.world = self
        self.robot = robot_model(PANDA)

    def bounds(self, name: str, pose: Pose) -> tuple[np.ndarray, np.ndarray]:
        reach = np.abs(pose.matrix[:3, :3]) @ (SIZE / 2)
        return np.array(pose.xyz) - reach, np.array(pose.xyz) + reach


class _Context:
    seed, deadline, fluents, bound = 0, float("inf"), (), ()

    def __init__(self) -> None:
        self.scene, self.rng = _Workspace(), np.random.default_rng(0)
        self.reasons: list[str] = []

    def fail(self, reason: str, because: object = (), proven: bool = True) -> None:
        self.reasons.append(reason)


def test_it_serves_as_a_sampler(scene: Volume) -> None:
    context = _Context()
    grasps = list(CloudGrasps(scene)(context, "block"))
    assert grasps
    assert all(isinstance(grasp, Grasp) for grasp in grasps)
    first = POSE @ grasps[0].T_object_tool
    assert first.matrix[2, 2] < -0.8, "the first comes from above"
    assert not list(CloudGrasps(scene)(context, "gone"))
    assert context.reasons == ["no two opposite surfaces of gone were seen with room for the hand"]
