"""Residuals tell apart what the joint choice cannot: shapes that differ by millimetres, and ways round."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from tamp.perception.estimation.candidates import Candidate
from tamp.perception.estimation.fit import explained, polished
from tamp.perception.estimation.fusion import Cloud
from tamp.perception.estimation.models.object_model import ObjectModel, object_model
from tamp.perception.estimation.selection import Selection
from tamp.perception.estimation.turns.likeness import misfit
from tamp.perception.estimation.verification import Verified, verify
from tamp.perception.estimation.volume import Volume
from tamp.perception.rendering.surface import Surface, plain
from tamp.task import Box, Cylinder, Pose, Sphere

pytest.importorskip("embreex", reason="the extra perception is not installed")

HERE, THERE = (Pose((x, 0.0, 0.03)).matrix for x in (-0.15, 0.15))
LOW, TALL = (object_model(plain(Box((0.12, 0.08, height)))) for height in (0.06, 0.064))
NOWHERE = plain(Box((0.1, 0.1, 0.1)))
"""Stands for meshes: without frames none is rendered."""
TURN = Pose.from_rpy((0, 0, 0), (0, 0, np.pi)).matrix


@cache
def _wedge() -> ObjectModel:
    """A box whose top rises from one end to the other."""
    box = plain(Box((0.12, 0.08, 0.06)))
    vertices = box.vertices.copy()
    vertices[:, 2] += np.where(vertices[:, 2] > 0, 0.2 * vertices[:, 0], 0.0)
    return object_model(Surface(vertices, box.faces.copy(), box.colors.copy()))


def _seen(*bodies: tuple[ObjectModel, np.ndarray]) -> Volume:
    """Points of bodies, with the noise of fused depth."""
    rng = np.random.default_rng(0)
    points = np.concatenate([model.points @ T[:3, :3].T + T[:3, 3] for model, T in bodies])
    normals = np.concatenate([model.normals @ T[:3, :3].T for model, T in bodies])
    colors = np.concatenate([model.colors for model, _ in bodies])
    points += 0.0008 * rng.normal(size=(len(points), 1)) * normals
    kept = normals[:, 2] > -0.5
    shape = (120, 60, 30)
    nothing, nowhere = np.full(shape, -1, np.int32), np.zeros(shape, np.bool_)
    return Volume(Cloud(points[kept], normals[kept], colors[kept]), np.array([-0.24, -0.12, 0.0]), nothing, nowhere)


def _verified(
    scene: Volume, models: list[ObjectModel], poses: list[list[np.ndarray]], chosen: list[int]
) -> dict[int, Verified]:
    found = [
        [Candidate(T, *explained(scene.cloud, model, T), 0.5, 0.0, 0.0) for T in some]
        for model, some in zip(models, poses, strict=True)
    ]
    selection = Selection(scene.cloud, models, found)
    selection.chosen = chosen
    return verify(scene, [NOWHERE] * len(models), models, found, selection)


@pytest.mark.parametrize("swapped", [False, True])
def test_boxes_that_differ_by_millimetres_are_told_apart(swapped: bool) -> None:
    lifted = Pose((0.0, 0.0, 0.002)).matrix
    scene = _seen((LOW, HERE), (TALL, lifted @ THERE))
    found = _verified(scene, [LOW, TALL], [[HERE, THERE], [HERE, THERE]], [int(swapped), int(not swapped)])
    assert [found[i].candidate for i in (0, 1)] == [0, 1]
    assert np.abs(found[0].pose[:3, 3] - HERE[:3, 3]).max() < 0.002
    assert np.abs(found[1].pose[:3, 3] - (lifted @ THERE)[:3, 3]).max() < 0.002
    assert 0 < found[0].lead < np.inf


def test_boxes_of_one_mesh_keep_their_places_and_have_no_rival() -> None:
    scene = _seen((LOW, HERE), (LOW, THERE))
    found = _verified(scene, [LOW, LOW], [[HERE, THERE], [HERE, THERE]], [1, 0])
    assert [found[i].candidate for i in (0, 1)] == [1, 0]
    assert found[0].lead == np.inf


@pytest.mark.parametrize("first", [0, 1])
def test_the_way_round_is_decided_by_residuals(first: int) -> None:
    wedge = _wedge()
    candidates = [HERE, HERE @ TURN]
    found = _verified(_seen((wedge, HERE)), [wedge], [candidates], [first])
    assert found[0].candidate == 0
    assert 0 < found[0].lead < np.inf


def test_what_is_thin_is_another_way_round_when_it_is_rolled() -> None:
    """Its points move by 16 mm, the corners of the cube that scores are told by twice as far."""
    bar = object_model(plain(Box((0.11, 0.022, 0.014))))
    lying = Pose((0.0, 0.0, 0.007)).matrix
    rolled = lying @ Pose.from_rpy((0.0, 0.0, 0.0), (np.pi / 2, 0.0, 0.0)).matrix
    assert bar.apart(lying, rolled) < 0.02 < 0.03 < bar.error(lying, rolled)
    found = _verified(_seen((bar, lying)), [bar], [[lying, rolled]], [0])
    assert found[0].candidate == 0
    assert 0 < found[0].lead < np.inf


def test_candidates_of_one_pose_are_one() -> None:
    near = HERE @ Pose((0.003, 0.0, 0.0)).matrix
    found = _verified(_seen((LOW, HERE)), [LOW], [[near, HERE]], [0])
    assert found[0].candidate == 0
    assert found[0].lead == np.inf
    assert np.abs(found[0].pose[:3, 3] - HERE[:3, 3]).max() < 0.001


def test_what_is_not_chosen_is_not_verified() -> None:
    assert _verified(_seen((LOW, HERE)), [LOW, TALL], [[HERE], []], [0, -1]).keys() == {0}


def test_what_was_fitted_to_all_of_its_points_is_not_fitted_again() -> None:
    marker = object_model(plain(Cylinder(0.009, 0.13)))
    lying = Pose.from_rpy((0.1, -0.05, 0.009), (np.pi / 2, 0.0, 0.4)).matrix
    scene = _seen((marker, lying))
    found = _verified(scene, [marker], [[lying]], [0])[0]
    assert (found.pose == polished(scene.cloud, marker, lying, found.own)).all()


def test_points_that_touch_another_object_are_the_nearers() -> None:
    slab = object_model(plain(Box((0.1, 0.06, 0.012))))
    side, on = Pose((0.0, 0.0, 0.03)).matrix, Pose((0.0, 0.0, 0.066)).matrix
    scene = _seen((LOW, side), (slab, on))
    # A guess that puts the slab into the top of what it lies on claims that one's points too.
    sunk = Pose((0.0, 0.0, 0.057)).matrix
    found = _verified(scene, [LOW, slab], [[side], [on, sunk]], [0, 0])
    x, y, z = scene.cloud.points[found[1].own].T
    assert not ((z < 0.062) & (np.abs(x) < 0.045) & (np.abs(y) < 0.025)).any()
    assert np.abs(found[1].pose[:3, 3] - on[:3, 3]).max() < 0.002


def test_many_guesses_of_one_pose_leave_room_for_another() -> None:
    """A dozen nearly alike ones, turned round, seem to explain more than the one that is right."""
    wedge = _wedge()
    scene = _seen((wedge, HERE))
    wrong = [HERE @ TURN @ Pose((0.0, 0.0002 * n, 0.0)).matrix for n in range(12)]
    points = np.arange(len(scene.cloud.points))
    found = [
        Candidate(T, points, np.full(len(points), weight), 0.5, 0.0, 0.0)
        for T, weight in [*((T, 0.9) for T in wrong), (HERE, 0.8)]
    ]
    selection = Selection(scene.cloud, [wedge], [found])
    selection.chosen = [0]
    verified = verify(scene, [NOWHERE], [wedge], [found], selection)[0]
    assert verified.candidate == len(wrong)
    assert wedge.error(verified.pose, HERE) < 0.003


def _striped_ball() -> ObjectModel:
    ball = plain(Sphere(0.036))
    colors = np.tile(np.array((180, 60, 60), np.uint8), (len(ball.vertices), 1))
    for axis, color in ((0, (80, 160, 60)), (2, (60, 30, 30))):
        colors[ball.vertices[:, axis] > 0.025] = color
    return object_model(Surface(ball.vertices, ball.faces, colors))


def test_what_is_nearly_round_is_told_by_colours_from_a_guess_that_is_a_little_turned() -> None:
    """Of two guesses, one turned by 17 degrees and one by half a turn, colours tell only once both are turned on."""
    model = _striped_ball()
    true = Pose.from_rpy((0.0, 0.0, 0.037), (0.2, 0.1, 0.5)).matrix
    near, far = (true @ Pose.from_rpy((0.0, 0.0, 0.0), turn).matrix for turn in ((0.2, 0.2, 0.1), (0.0, 0.0, np.pi)))
    pose = _verified(_seen((model, true)), [model], [[far, near]], [0])[0].pose
    assert np.trace(pose[:3, :3].T @ true[:3, :3]) > 1 + 2 * np.cos(np.radians(5.0))


def test_what_a_fit_by_shape_turns_away_from_its_colours_is_tried_as_it_was_too() -> None:
    """Few points of a ball, with noise: fitted by shape alone it turns so far that colours do not bring it back."""
    model = _striped_ball()
    true = Pose.from_rpy((0.0, 0.0, 0.037), (0.2, 0.1, 0.5)).matrix
    scene, rng = _seen((model, true)), np.random.default_rng(3)
    few = scene.of_points(rng.permutation(np.flatnonzero(scene.cloud.normals[:, 2] > 0.6))[:60])
    few.cloud.points[:] += 0.002 * np.random.default_rng(3).normal(size=few.cloud.points.shape)
    found = _verified(few, [model], [[true]], [0])[0]
    assert misfit(few.cloud, model, found.pose, found.own) <= misfit(few.cloud, model, true, found.own)
