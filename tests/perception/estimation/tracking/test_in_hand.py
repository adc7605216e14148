"""How what is held lies in the hand, by what two cameras see of it."""

from __future__ import annotations

import numpy as np
import pytest

from tamp.perception.belief.belief import nearest_turn
from tamp.perception.cameras.camera import Frame
from tamp.perception.cameras.capture import View, shoot
from tamp.perception.cameras.setup import load_setup
from tamp.perception.estimate import Estimate
from tamp.perception.estimation.models.object_model import object_model
from tamp.perception.estimation.tracking.in_hand import estimate_held
from tamp.perception.rendering.surface import Surface, plain
from tamp.task import Box, Pose, Table, load_robot
from tamp.world.robot.model import robot_model

pytest.importorskip("embreex", reason="the extra perception is not installed")

ROBOT = load_robot("panda")
TOOL = Pose.from_matrix(robot_model(ROBOT).forward(np.array(ROBOT.home)))
LOOKS: dict[str, Surface] = {"slab": plain(Box((0.16, 0.03, 0.1))), "block": plain(Box((0.1, 0.1, 0.2)))}
HUNG = Pose((0.0, 0.0, 0.06), (0.0, 0.0, 0.0, 1.0))
"""The slab by the middle of a long edge, across the fingers."""
BLOCK = Pose((TOOL.xyz[0] + 0.12, TOOL.xyz[1], 0.1))


def _swung(angle: float) -> Pose:
    return Pose.from_rpy((0.0, 0.0, 0.0), (0.0, angle, 0.0)) @ HUNG


def _pictures(poses: dict[str, Pose]) -> list[Frame]:
    views = [View(camera, tuple(ROBOT.home), 0.03) for camera in load_setup()]
    return [shot.frame for shot in shoot(LOOKS, poses, views, ROBOT, table=Table(), seed=3)]


def _estimate(frames: list[Frame]) -> Estimate:
    models = {name: object_model(surface) for name, surface in LOOKS.items()}
    return estimate_held(
        frames, models, {"slab": TOOL @ HUNG, "block": BLOCK}, "slab", TOOL, ROBOT.gripper.axis, Table()
    )


@pytest.mark.parametrize("angle", [0.0, 0.4, -0.8])
def test_an_object_that_swings_between_the_fingers_is_found_as_it_hangs(angle: float) -> None:
    assert ROBOT.gripper.axis == (0.0, 1.0, 0.0)
    true, model = TOOL @ _swung(angle), object_model(LOOKS["slab"])
    found = _estimate(_pictures({"slab": true, "block": BLOCK}))
    assert found.pose is not None
    assert model.apart(found.pose.matrix, true.matrix) < 0.008
    assert found.confidence > 0.5
    near = nearest_turn(model, found.pose, TOOL @ HUNG)
    assert np.allclose((TOOL.inverse() @ near).xyz, _swung(angle).xyz, atol=0.008), "not turned over"


def test_what_is_not_in_the_pictures_is_not_seen_in_the_hand() -> None:
    assert _estimate(_pictures({"block": BLOCK})).pose is None


def test_points_of_others_say_nothing_of_what_is_held() -> None:
    """What stands where the object would hang if it had swung is known to be something else."""
    models = {name: object_model(surface) for name, surface in LOOKS.items()}
    beside = Pose((TOOL.xyz[0] + 0.05, TOOL.xyz[1] - 0.02, TOOL.xyz[2] - 0.14))
    frames = _pictures({"slab": TOOL @ HUNG, "block": beside})
    poses = {"slab": TOOL @ HUNG, "block": beside}
    found = estimate_held(frames, models, poses, "slab", TOOL, ROBOT.gripper.axis, Table())
    assert found.pose is not None
    assert models["slab"].apart(found.pose.matrix, (TOOL @ HUNG).matrix) < 0.01


def test_without_pictures_nothing_is_told() -> None:
    assert _estimate([]) == Estimate(None, 0.0)
