"""What was let go beside its place is found beside it, by what cameras see of it from where they are."""

from __future__ import annotations

import pytest

from tamp.perception.cameras.camera import Frame
from tamp.perception.cameras.capture import View, shoot
from tamp.perception.cameras.setup import load_setup
from tamp.perception.estimate import Estimate
from tamp.perception.estimation.models.object_model import object_model
from tamp.perception.estimation.tracking.nearby import estimate_nearby
from tamp.perception.rendering.surface import Surface, plain
from tamp.task import Box, Pose, Table, load_robot

pytest.importorskip("embreex", reason="the extra perception is not installed")

ROBOT = load_robot("panda")
LOOKS: dict[str, Surface] = {"lid": plain(Box((0.12, 0.09, 0.04))), "crate": plain(Box((0.16, 0.12, 0.1)))}
MODELS = {name: object_model(surface) for name, surface in LOOKS.items()}
CRATE = Pose((0.15, 0.05, 0.05))
MEANT = {"crate": CRATE, "lid": Pose((0.15, 0.05, 0.12))}


def _pictures(poses: dict[str, Pose]) -> list[Frame]:
    views = [View(camera, tuple(ROBOT.home), 0.08) for camera in load_setup()]
    return [shot.frame for shot in shoot(LOOKS, poses, views, ROBOT, table=Table(), seed=3)]


@pytest.mark.parametrize("beside", [(0.0, 0.0, 0.0), (0.0, 0.02, 0.0), (-0.04, 0.0, 0.0)])
def test_what_was_put_on_another_is_found_where_it_lies_on_it(beside: tuple[float, float, float]) -> None:
    true = Pose(beside) @ MEANT["lid"]
    found = estimate_nearby(_pictures({"crate": CRATE, "lid": true}), MODELS, MEANT, "lid", Table())
    assert found.pose is not None
    assert found.confidence > 0.5
    assert MODELS["lid"].apart(found.pose.matrix, true.matrix) < 0.009


def test_what_others_explain_says_nothing_of_what_is_sought() -> None:
    found = estimate_nearby(_pictures({"crate": CRATE}), MODELS, MEANT, "lid", Table())
    assert found.pose is None or found.confidence < 0.5


def test_without_pictures_nothing_is_told() -> None:
    assert estimate_nearby([], MODELS, MEANT, "lid", Table()) == Estimate(None, 0.0)
