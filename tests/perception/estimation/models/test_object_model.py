"""What is known of an object before it is looked for: its outside, its own turns, its ways to rest."""

from __future__ import annotations

import numpy as np
import pytest

from tamp.perception.estimation.models.object_model import object_model
from tamp.perception.evaluation import pose_error
from tamp.perception.rendering.surface import Surface, plain
from tamp.task import Box, Cylinder, Pose, Sphere

pytest.importorskip("embreex", reason="the extra perception is not installed")


def _joined(*surfaces: Surface) -> Surface:
    first = np.cumsum([0, *(len(s.vertices) for s in surfaces)])
    return Surface(
        np.concatenate([s.vertices for s in surfaces]),
        np.concatenate([s.faces + start for s, start in zip(surfaces, first, strict=False)]),
        np.concatenate([s.colors for s in surfaces]),
    )


def _moved(surface: Surface, shift: tuple[float, float, float]) -> Surface:
    return Surface(surface.vertices + shift, surface.faces.copy(), surface.colors.copy())


@pytest.mark.parametrize(
    ("shape", "least", "most"),
    [
        (Box((0.16, 0.09, 0.05)), 4, 4),
        (Box((0.1, 0.1, 0.04)), 8, 8),
        (Cylinder(0.03, 0.12), 72, 72),
        (Sphere(0.04), 500, 5000),
        # Large ones, whose points lie farther apart.
        (Box((0.3, 0.2, 0.05)), 4, 4),
        (Cylinder(0.15, 0.02), 72, 72),
    ],
)
def test_a_shapes_own_turns(shape: Box | Cylinder | Sphere, least: int, most: int) -> None:
    model = object_model(plain(shape))
    assert np.allclose(model.symmetries[0], np.eye(4))
    assert least <= len(model.symmetries) <= most
    R = model.symmetries[:, :3, :3]
    assert np.allclose(R @ R.transpose(0, 2, 1), np.eye(3), atol=1e-9)


def test_a_lopsided_shape_has_none() -> None:
    hook = _joined(plain(Box((0.12, 0.03, 0.03))), _moved(plain(Box((0.03, 0.08, 0.02))), (0.05, 0.05, 0.01)))
    assert len(object_model(hook).symmetries) == 1


def test_a_large_lopsided_shape_has_none() -> None:
    step = _joined(plain(Box((0.3, 0.2, 0.04))), _moved(plain(Box((0.1, 0.2, 0.02))), (0.1, 0.0, 0.03)))
    assert len(object_model(step).symmetries) == 1


def _book(width: float, height: float, thickness: float) -> Surface:
    """Two covers, pages that stand back between them on three sides, and a spine on the fourth."""
    cover = plain(Box((width, 0.003, height)))
    covers = [_moved(cover, (0.0, side * (thickness - 0.003) / 2, 0.0)) for side in (1, -1)]
    pages = _moved(plain(Box((width - 0.016, thickness - 0.006, height - 0.008))), (0.0, 0.0, 0.004))
    spine = _moved(plain(Box((width, thickness, 0.003))), (0.0, 0.0, height / 2 - 0.0015))
    return _joined(*covers, pages, spine)


@pytest.mark.parametrize("size", [(0.272, 0.17, 0.042), (0.16, 0.27, 0.037), (0.3, 0.22, 0.05), (0.12, 0.17, 0.03)])
def test_a_book_has_one_turn_however_large_and_it_is_exact(size: tuple[float, float, float]) -> None:
    turns = object_model(_book(*size)).symmetries
    assert len(turns) == 2
    corner = np.array([size[0] / 2, size[2] / 2, size[1] / 2])
    assert np.allclose(turns[1][:3, :3] @ corner + turns[1][:3, 3], corner * (-1, -1, 1), atol=0.002)


def test_walls_inside_are_left_out_and_faces_turned_over_are_turned_back() -> None:
    outer, inner = plain(Box((0.1, 0.1, 0.1))), plain(Box((0.05, 0.05, 0.05)))
    turned = Surface(outer.vertices.copy(), outer.faces[:, ::-1].copy(), outer.colors.copy())
    model = object_model(_joined(turned, inner))
    assert (np.abs(model.points).max(axis=1) > 0.049).all()
    assert (np.einsum("ij,ij->i", model.points, model.normals) > 0).all()
    assert model.solid.all()
    assert model.area == pytest.approx(0.06, rel=0.02)
    assert np.allclose(model.center, 0, atol=1e-3)


def test_a_sheet_has_two_sides_and_no_inside() -> None:
    square = np.array([[0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0], [0, 0.1, 0.001]], dtype=np.float64)
    sheet = Surface(square, np.array([[0, 1, 2], [0, 2, 3]]), np.full((4, 3), 200, np.uint8))
    model = object_model(sheet)
    assert not model.solid.any()
    assert 0.4 < (model.normals[:, 2] > 0).mean() < 0.6
    assert model.area == pytest.approx(0.02, rel=0.02)


def test_a_box_rests_on_its_six_sides() -> None:
    model = object_model(plain(Box((0.16, 0.09, 0.05))))
    heights = sorted(round(pose.height, 4) for pose in model.stable)
    assert heights == [0.025, 0.025, 0.045, 0.045, 0.08, 0.08]


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("shape", [Box((0.16, 0.09, 0.05)), Cylinder(0.03, 0.12)])
def test_what_a_mistake_costs_is_what_scores_say(shape: Box | Cylinder, seed: int) -> None:
    model, rng = object_model(plain(shape)), np.random.default_rng(seed)
    one, other = (
        Pose.from_rpy(rng.uniform(-0.1, 0.1, 3).tolist(), rng.uniform(-np.pi, np.pi, 3).tolist()) for _ in range(2)
    )
    assert model.error(one.matrix, other.matrix) == pytest.approx(pose_error(model, one, other)[0])
    turn = model.symmetries[seed % len(model.symmetries)]
    assert model.error(one.matrix, one.matrix @ turn) == pytest.approx(0.0, abs=1e-9)
