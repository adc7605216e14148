from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.task import Box, Capsule, Cylinder, Mesh, Sphere
from tamp.task.mesh.concave import is_convex
from tamp.task.mesh.parts import bounds, convex_hull, parts, watertight

OCRTOC = Path(__file__).parents[3].parent / "shared" / "ocrtoc" / "2021" / "models"

CUBE = """v 0 0 0
v 0.1 0 0
v 0.1 0.1 0
v 0 0.1 0
v 0 0 0.1
v 0.1 0 0.1
v 0.1 0.1 0.1
v 0 0.1 0.1
f 4 3 2 1
f 5 6 7 8
f 1/1/1 2/2/1 6/3/1 5/4/1
f -7 -6 -2 -3
f 3 4 8 7
f 4 1 5 8
"""


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("TAMP_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def volume(part):
    corners = part.vertices[part.faces]
    return np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6


@pytest.mark.parametrize(
    ("shape", "exact"),
    [
        (Box((0.1, 0.2, 0.3)), 0.006),
        (Cylinder(0.03, 0.1), np.pi * 0.03**2 * 0.1),
        (Sphere(0.05), 4 / 3 * np.pi * 0.05**3),
        (Capsule(0.02, 0.1), np.pi * 0.02**2 * 0.1 + 4 / 3 * np.pi * 0.02**3),
    ],
)
def test_a_primitive_is_one_polytope_inscribed_in_it(shape, exact):
    (part,) = parts(shape)
    assert 0.97 * exact <= volume(part) <= exact * (1 + 1e-9)
    lower, upper = bounds(shape)
    assert (part.vertices >= lower - 1e-12).all()
    assert (part.vertices <= upper + 1e-12).all()
    np.testing.assert_allclose(part.vertices.max(axis=0), upper, rtol=0.02)
    assert watertight(shape)
    with pytest.raises(ValueError, match="read-only"):
        part.vertices[0] = 0


def test_polygons_texture_indices_and_negative_indices_are_read(tmp_path):
    path = tmp_path / "cube.obj"
    path.write_text(CUBE)
    (part,) = parts(Mesh(path))
    assert volume(part) == pytest.approx(0.001)
    (half,) = parts(Mesh(path, scale=0.5))
    np.testing.assert_allclose(bounds(Mesh(path, scale=0.5))[1], 0.05)
    assert volume(half) == pytest.approx(0.001 / 8)
    assert watertight(Mesh(path))


def test_a_file_edited_is_read_anew(tmp_path):
    import os

    path = tmp_path / "cube.obj"
    path.write_text(CUBE)
    parts(Mesh(path))
    path.write_text(CUBE.replace("0.1", "0.2"))
    os.utime(path, (1, 1))
    assert volume(parts(Mesh(path))[0]) == pytest.approx(0.008)


def test_an_angle_of_one_piece_keeps_its_notch(tmp_path, cache):
    path = tmp_path / "angle.obj"
    corners = [(0, 0), (0.1, 0), (0.1, 0.02), (0.02, 0.02), (0.02, 0.1), (0, 0.1)]
    lines = [f"v {x} {y} {z}" for z in (0, 0.03) for x, y in corners]
    lines += [f"f {k + 1} {(k + 1) % 6 + 1} {(k + 1) % 6 + 7} {k + 7}" for k in range(6)]
    lines += ["f 4 3 2 1", "f 6 5 4 1", "f 7 8 9 10", "f 7 10 11 12"]
    path.write_text("\n".join(lines))
    assert watertight(Mesh(path))
    pieces = parts(Mesh(path))
    assert len(pieces) >= 2
    assert sum(volume(part) for part in pieces) == pytest.approx((0.1 * 0.02 + 0.02 * 0.08) * 0.03, rel=0.05)
    inside = np.array([0.04, 0.04, 0.015])
    for part in pieces:
        a, b, c = (part.vertices[part.faces[:, i]] for i in range(3))
        normals = np.cross(b - a, c - a)
        assert (np.einsum("ij,ij->i", normals, inside - a) > 0).any(), "the notch is filled"
    assert list(cache.glob("parts/*.npz"))


def test_groups_are_the_convex_parts():
    if not OCRTOC.is_dir():
        pytest.skip("the OCRTOC models are not beside this checkout")
    path = OCRTOC / "bowl" / "collision.obj"
    groups = sum(line.startswith("o ") for line in path.read_text().splitlines())
    assert len(parts(Mesh(path))) == groups > 50


def test_an_inside_out_surface_is_as_convex_as_any():
    (part,) = parts(Box((0.1, 0.1, 0.1)))
    assert is_convex(part.vertices, part.faces[:, ::-1])


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6), st.integers(8, 60))
def test_a_hull_contains_its_points_and_faces_outwards(seed, count):
    points = np.random.default_rng(seed).normal(size=(count, 3))
    hull = convex_hull(points)
    a, b, c = (hull.vertices[hull.faces[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    heights = normals @ points.T - np.einsum("ij,ij->i", normals, a)[:, None]
    assert heights.max() < 1e-9
    assert is_convex(hull.vertices, hull.faces)


def test_flat_points_have_no_hull():
    with pytest.raises(ValueError, match="no volume"):
        convex_hull(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.0]]))
