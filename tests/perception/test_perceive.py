"""From a task to a file of poses, and how far they are off."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tamp.errors import TampError
from tamp.perception.cameras.setup import OCRTOC_2021
from tamp.perception.estimate import Estimate
from tamp.perception.estimation.models.object_model import object_model
from tamp.perception.evaluation import pose_error, pose_errors
from tamp.perception.overlay import overlay
from tamp.perception.perceive import perceive_task, save_sight
from tamp.perception.poses_file import details_path
from tamp.perception.rendering.surface import Surface, plain
from tamp.task import Box, Cylinder, Object, Pose, Task
from tamp.task.files.poses_file import load_poses

pytest.importorskip("embreex", reason="the extra perception is not installed")

BRICK, CAN = Box((0.16, 0.09, 0.05)), Cylinder(0.035, 0.12)
TASK = Task(
    "two",
    (Object("brick", BRICK, Pose((-0.05, 0.12, 0.026))), Object("can", CAN, Pose((-0.1, -0.15, 0.061)))),
)


def _colored(shape: Box) -> Surface:
    surface = plain(shape)
    ends = np.where(surface.vertices[:, :1] > 0, (220, 30, 30), (30, 30, 220)).astype(np.uint8)
    return Surface(surface.vertices.copy(), surface.faces.copy(), ends)


def test_perceived_poses_are_a_poses_file(tmp_path: Path) -> None:
    sight = perceive_task(TASK)
    paths = save_sight(sight, tmp_path / "poses.json", tmp_path / "pictures")
    assert len(paths) == 2 + 7
    poses = load_poses(tmp_path / "poses.json")
    for name, pose in poses.items():
        assert pose is not None
        assert math.dist(pose.xyz, sight.truth[name].xyz) < 0.006
    details = json.loads(details_path(tmp_path / "poses.json").read_text(encoding="utf-8"))
    assert details["can"]["confidence"] > 0.3
    drawn = overlay(sight.frames[0], sight.objects, sight.estimates)
    assert (drawn != sight.frames[0].color).any()


def test_what_was_not_seen_is_null(tmp_path: Path) -> None:
    small = tmp_path / "small.yaml"
    small.write_text(OCRTOC_2021.read_text(encoding="utf-8").replace("[1280, 720]", "[320, 180]"), encoding="utf-8")
    sight = perceive_task(TASK, perceiver=f"{__name__}:nobody", setup=small)
    save_sight(sight, tmp_path / "poses.json")
    assert load_poses(tmp_path / "poses.json") == {"brick": None, "can": None}
    drawn = overlay(sight.frames[0], sight.objects, sight.estimates)
    changed = np.argwhere((drawn != sight.frames[0].color).any(axis=2))
    assert len(changed), "what was not seen is named"
    assert changed.max(axis=0) == pytest.approx((50, 60), abs=30), "in the corner alone"


def nobody(frames: object, objects: dict[str, Surface], *, table: object, seed: int) -> dict[str, Estimate]:
    return {name: Estimate(None, 0.0) for name in objects}


def test_a_perceiver_that_is_not_there_is_refused() -> None:
    with pytest.raises(TampError, match="unknown perceiver"):
        perceive_task(TASK, perceiver="eyes")


def test_a_boxs_own_turns_are_forgiven_but_not_in_the_raw_error() -> None:
    model = object_model(plain(BRICK))
    true = Pose((0.1, 0.2, 0.025))
    turned = true @ Pose.from_rpy((0, 0, 0), (0, 0, math.pi))
    symmetric, raw = pose_error(model, turned, true)
    assert symmetric < 0.002
    assert raw > 0.05
    quarter = true @ Pose.from_rpy((0, 0, 0), (0, 0, math.pi / 2))
    assert pose_error(model, quarter, true)[0] > 0.03


def test_a_shift_is_its_own_error() -> None:
    model = object_model(plain(BRICK))
    symmetric, raw = pose_error(model, Pose((0.103, 0.2, 0.025)), Pose((0.1, 0.2, 0.025)))
    assert raw == pytest.approx(0.003)
    assert symmetric <= raw + 1e-12


def test_two_of_a_mesh_may_stand_for_each_other() -> None:
    brick = plain(BRICK)
    truth = {"a": Pose((0, 0.2, 0)), "b": Pose((0, -0.2, 0))}
    swapped = {"a": Estimate(truth["b"], 0.9), "b": Estimate(truth["a"], 0.8)}
    errors = pose_errors(swapped, truth, {"a": brick, "b": brick})
    assert [e.raw for e in errors.values()] == [0.0, 0.0]
    assert (errors["a"].said, errors["a"].confidence) == ("b", 0.8)
    missing = pose_errors({"a": Estimate(truth["b"], 0.9)}, truth, {"a": brick, "b": brick})
    assert (missing["a"].raw, missing["b"].raw) == (None, 0.0)


def test_colour_tells_which_end_is_which() -> None:
    from tamp.perception.cameras.capture import shoot, views
    from tamp.perception.cameras.setup import load_setup
    from tamp.perception.estimation.estimator import estimate_poses
    from tamp.task import load_robot

    panda = load_robot("panda")
    cameras = [replace(c, intrinsics=c.intrinsics.scaled(0.5)) for c in load_setup()]
    looks = {"brick": _colored(BRICK)}
    for yaw in (0.4, 0.4 + math.pi):
        true = Pose.from_rpy((-0.05, 0.12, 0.025), (0, 0, yaw))
        shots = shoot(looks, {"brick": true}, views(cameras, panda), panda)
        found = estimate_poses([shot.frame for shot in shots], looks)["brick"].pose
        assert found is not None
        assert found.matrix[:3, 0] @ true.matrix[:3, 0] > 0.99
