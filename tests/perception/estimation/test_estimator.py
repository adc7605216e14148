"""Objects are found where they are, and not where they are not."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tamp.perception.cameras.capture import shoot, views
from tamp.perception.cameras.setup import load_setup
from tamp.perception.estimate import Estimate
from tamp.perception.estimation import estimator
from tamp.perception.estimation.candidates import Candidate
from tamp.perception.estimation.estimator import estimate_poses
from tamp.perception.estimation.models.object_model import object_model
from tamp.perception.estimation.turns.rendered import Shown
from tamp.perception.estimation.verification import APART, Verified, verify
from tamp.perception.rendering.surface import Surface, plain
from tamp.task import Box, Cylinder, Pose, Table, load_robot

pytest.importorskip("embreex", reason="the extra perception is not installed")

PANDA = load_robot("panda")
CAMERAS = tuple(replace(c, intrinsics=c.intrinsics.scaled(0.5)) for c in load_setup())
LOOKS = {
    "brick": plain(Box((0.16, 0.09, 0.05)), (190, 60, 50)),
    "can": plain(Cylinder(0.035, 0.12), (60, 90, 190)),
    "slab": plain(Box((0.2, 0.14, 0.03)), (190, 190, 60)),
}
POSES = {
    "brick": Pose.from_rpy((-0.05, 0.12, 0.025), (0, 0, 0.5)),
    "can": Pose.from_rpy((-0.1, -0.15, 0.035), (math.pi / 2, 0, 0.9)),
}


def _estimates(looks: dict[str, Surface], poses: dict[str, Pose], *, masks: bool = False) -> dict[str, Estimate]:
    shots = shoot(looks, poses, views(CAMERAS, PANDA), PANDA, masks=masks)
    return estimate_poses([shot.frame for shot in shots], looks)


@pytest.fixture(scope="module")
def estimates() -> dict[str, Estimate]:
    return _estimates(LOOKS, POSES)


@pytest.mark.parametrize(("name", "extent"), [("brick", (0.08, 0.045, 0.025)), ("can", (0.0, 0.0, 0.06))])
def test_what_is_there_is_found(estimates: dict[str, Estimate], name: str, extent: tuple[float, ...]) -> None:
    found, true = estimates[name].pose, POSES[name]
    assert found is not None
    assert math.dist(found.xyz, true.xyz) < 0.005
    # Both bodies look the same upside down: axes agree up to their sign.
    for axis in range(3):
        if extent[axis]:
            off = 1 - abs(found.matrix[:3, axis] @ true.matrix[:3, axis])
            assert off < 1 - math.cos(math.radians(4))
    assert estimates[name].confidence > 0.5


def test_what_is_not_there_is_not_seen(estimates: dict[str, Estimate]) -> None:
    assert estimates["slab"] == Estimate(None, 0.0)


def test_masks_keep_objects_apart() -> None:
    found = _estimates(LOOKS, POSES, masks=True)
    assert {name for name, estimate in found.items() if estimate.pose is not None} == {"brick", "can"}
    for name, true in POSES.items():
        pose = found[name].pose
        assert pose is not None
        assert math.dist(pose.xyz, true.xyz) < 0.005


def test_with_masks_every_candidate_explains_an_objects_own_points_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    verified = []

    def watched(scene: Any, surfaces: Any, models: Any, found: Any, selection: Any) -> Any:
        labels = scene.cloud.instances
        verified.extend((labels[candidate.points] == i).all() for i, of in enumerate(found) for candidate in of)
        return verify(scene, surfaces, models, found, selection)

    monkeypatch.setattr(estimator, "verify", watched)
    _estimates(LOOKS, {"brick": POSES["brick"], "can": Pose((-0.05, 0.19, 0.06))}, masks=True)
    assert len(verified) > 40 and all(verified)


def test_an_empty_table() -> None:
    assert _estimates(LOOKS, {}) == dict.fromkeys(LOOKS, Estimate(None, 0.0))


def test_the_same_seed_gives_the_same_poses(estimates: dict[str, Estimate]) -> None:
    assert _estimates(LOOKS, POSES) == estimates


def test_two_of_a_kind_take_different_places() -> None:
    brick = LOOKS["brick"]
    looks = {"one": brick, "other": brick}
    poses = {"one": POSES["brick"], "other": Pose.from_rpy((-0.05, -0.15, 0.045), (math.pi / 2, 0, 0.2))}
    found = _estimates(looks, poses)
    places = sorted(np.array([e.pose.xyz for e in found.values() if e.pose is not None]).tolist())
    expected = sorted([list(pose.xyz) for pose in poses.values()])
    assert np.allclose(sorted(p[1] for p in places), sorted(p[1] for p in expected), atol=0.006)


@pytest.mark.parametrize("swapped", [False, True])
def test_twins_are_told_apart_by_what_is_printed_on_them(swapped: bool) -> None:
    """Two boxes of one shape, each with a label on half of it, side by side."""
    looks = {"red": _labelled((190, 50, 40)), "blue": _labelled((50, 70, 190))}
    places = [Pose.from_rpy((-0.05, 0.07, 0.03), (0, 0, 0.4)), Pose.from_rpy((-0.06, -0.07, 0.03), (0, 0, -0.3))]
    poses = dict(zip(looks, reversed(places) if swapped else places, strict=True))
    for name, estimate in _estimates(looks, poses).items():
        assert estimate.pose is not None and estimate.confidence > 0.5
        assert math.dist(estimate.pose.xyz, poses[name].xyz) < 0.006
        assert estimate.pose.matrix[:3, 0] @ poses[name].matrix[:3, 0] > 0.99, "the label is at the other end"


def _labelled(label: tuple[int, int, int]) -> Surface:
    """A white box, half of which has a colour."""
    halves = [plain(Box((0.06, 0.08, 0.06)), color) for color in ((220, 220, 210), label)]
    vertices = np.concatenate(
        [half.vertices + np.array((x, 0.0, 0.0)) for half, x in zip(halves, (-0.03, 0.03), strict=True)]
    )
    faces = np.concatenate([halves[0].faces, halves[1].faces + len(halves[0].vertices)])
    return Surface(vertices, faces, np.concatenate([half.colors for half in halves]))


def test_what_is_alike_is_sought_in_each_others_place(monkeypatch: pytest.MonkeyPatch) -> None:
    looks = {"short": plain(Box((0.12, 0.08, 0.06))), "long": plain(Box((0.132, 0.08, 0.06)))}
    poses = {"short": Pose((-0.05, 0.12, 0.03)), "long": Pose((-0.1, -0.15, 0.03))}
    sought = estimator._sought

    def misled(*given: Any) -> list[list[Candidate]]:
        """Each has candidates where the other one is."""
        short, long = sought(*given)
        return [[c for c in short if c.pose[1, 3] < 0], [c for c in long if c.pose[1, 3] > 0]]

    monkeypatch.setattr(estimator, "_sought", misled)
    for name, estimate in _estimates(looks, poses).items():
        assert estimate.pose is not None
        assert math.dist(estimate.pose.xyz, poses[name].xyz) < 0.01


def test_of_two_ways_round_in_one_place_whole_pictures_show_one() -> None:
    """A rack of which one bar is higher: most points are explained the other way round, too."""
    bars = [_bar(x, height) for x, height in ((-0.07, 0.03), (-0.035, 0.03), (0.035, 0.037), (0.07, 0.03))]
    offsets = np.cumsum([0, *(len(bar.vertices) for bar in bars)])
    rack = Surface(
        np.concatenate([bar.vertices for bar in bars]),
        np.concatenate([bar.faces + first for bar, first in zip(bars, offsets, strict=False)]),
        np.concatenate([bar.colors for bar in bars]),
    )
    true = Pose.from_rpy((-0.05, 0.1, 0.0), (0.0, 0.0, 0.6)).matrix
    around = Pose.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, math.pi)).matrix
    shots = shoot({"rack": rack}, {"rack": Pose.from_matrix(true)}, views(CAMERAS, PANDA), PANDA)
    scene = estimator.see([shot.frame for shot in shots], Table())
    assert scene is not None
    model, own = object_model(rack), np.arange(len(scene.cloud.points))
    for poses in ([true, true @ around], [true @ around, true]):
        found, told = estimator._shown(scene, rack, model, poses, own)
        assert (told > 0) == (poses[0] is true), "that it is the first is told, too"
        assert np.allclose(found[:3, :3], true[:3, :3], atol=0.03)


def _bar(x: float, height: float) -> Surface:
    bar = plain(Box((0.016, 0.12, height)))
    return Surface(bar.vertices + np.array((x, 0.0, height / 2)), bar.faces, bar.colors)


@pytest.mark.parametrize(("by", "kept", "share"), [(5.0, True, 0.0), (500.0, False, 0.0), (-300.0, True, 3.0)])
def test_pictures_that_hardly_tell_two_ways_round_leave_it_to_the_points(
    by: float, kept: bool, share: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = estimator.see([shot.frame for shot in shoot(LOOKS, POSES, views(CAMERAS, PANDA), PANDA)], Table())
    assert scene is not None
    model, upright = object_model(LOOKS["brick"]), POSES["brick"].matrix
    rolled = upright @ Pose.from_rpy((0.0, 0.0, 0.0), (math.pi / 2, 0.0, 0.0)).matrix
    monkeypatch.setattr(estimator, "all_shown", lambda *_: [Shown(0, 400.0 + by), Shown(0, 400.0)])
    found, told = estimator._shown(scene, LOOKS["brick"], model, [upright, rolled], np.arange(0))
    assert (model.error(found, upright) < 0.001) == kept
    assert told == pytest.approx(share)


def test_a_guess_that_is_the_chosen_pose_once_it_fits_the_points_is_no_other_answer() -> None:
    shots = shoot({"brick": LOOKS["brick"]}, {"brick": POSES["brick"]}, views(CAMERAS, PANDA), PANDA)
    scene = estimator.see([shot.frame for shot in shots], Table())
    assert scene is not None
    model, true = object_model(LOOKS["brick"]), POSES["brick"].matrix
    beside = true @ Pose.from_rpy((0.015, 0.012, 0.0), (0.0, 0.0, 0.2)).matrix
    rolled = true @ Pose.from_rpy((0.0, 0.0, 0.0), (math.pi / 2, 0.0, 0.0)).matrix
    assert model.error(true, beside) > APART
    chosen = Verified(0, true, np.arange(len(scene.cloud.points)), math.inf)
    assert estimator._fitted_alike(scene, model, beside, chosen)
    assert not estimator._fitted_alike(scene, model, rolled, chosen)
