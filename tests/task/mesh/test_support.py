"""The support function of many points is that of looking at each; what is convex by it is what always was."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.task.mesh import support
from tamp.task.mesh.concave import CONVEX_TOLERANCE, is_convex
from tamp.task.mesh.support import FEW, Support


def looked_at(vertices: Any, faces: Any) -> bool:
    """`is_convex` by its definition: each vertex against each face."""
    points = vertices[np.unique(faces)]
    size = np.linalg.norm(np.ptp(points, axis=0))
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    area = np.linalg.norm(normal, axis=1)
    solid = area > 1e-6 * size * size
    normal, a = normal[solid] / area[solid, None], a[solid]
    heights = normal @ points.T - np.einsum("ij,ij->i", normal, a)[:, None]
    return bool((np.minimum(heights.max(axis=1), -heights.min(axis=1)) <= CONVEX_TOLERANCE * size).all())


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.integers(4, 400), st.floats(0.0, 0.05), st.booleans())
def test_what_is_convex_is_what_it_is_by_looking_at_each_vertex(seed: int, count: int, dent: float, cube: bool) -> None:
    rng = np.random.default_rng(seed)
    points = rng.uniform(-1.0, 1.0, (count, 3)) if cube else rng.normal(size=(count, 3))
    if not cube:
        points /= np.linalg.norm(points, axis=1)[:, None]
    hull = trimesh.convex.convex_hull(points * rng.uniform(0.2, 1.0, 3))
    vertices, faces = np.array(hull.vertices), np.array(hull.faces)
    vertices *= 1.0 - dent * rng.integers(0, 2, len(vertices))[:, None]
    turned = rng.integers(0, 2, len(faces)).astype(bool)
    faces[turned] = faces[turned][:, ::-1]
    assert is_convex(vertices, faces) == looked_at(vertices, faces)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 500), st.sampled_from(["ball", "sphere", "grid", "flat", "line"]))
def test_the_farthest_of_many_points_is_found(seed: int, count: int, kind: str) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(count, 3))
    if kind == "sphere":
        points /= np.linalg.norm(points, axis=1)[:, None]
    elif kind == "grid":
        points = np.round(points)
    elif kind in ("flat", "line"):
        points[:, 1 if kind == "line" else 2 :] = 0.0
    directions = rng.normal(size=(50, 3))
    found, least = Support(points).exactly(directions), Support(points).at_least(directions)
    assert np.allclose(found, (directions @ points.T).max(axis=1), rtol=0.0, atol=1e-9)
    assert (least <= found + 1e-9).all() and (count > FEW or np.allclose(least, found))


def test_faces_without_a_direction_are_not_asked() -> None:
    line = np.arange(300.0).reshape(100, 3)
    assert is_convex(line, np.array([[0, 1, 2], [3, 4, 5]]))


def test_a_vertex_with_very_many_neighbours_is_one_among_others() -> None:
    cone = trimesh.creation.cone(0.1, 0.2, sections=3000)
    vertices, faces = np.array(cone.vertices), np.array(cone.faces)
    assert is_convex(vertices, faces)
    directions = np.random.default_rng(0).normal(size=(100, 3))
    assert np.allclose(Support(vertices).exactly(directions), (directions @ vertices.T).max(axis=1))


def test_a_dense_convex_mesh_is_not_looked_at_face_by_vertex(monkeypatch: pytest.MonkeyPatch) -> None:
    ball = trimesh.creation.icosphere(subdivisions=5)
    looked = []
    farthest = support._farthest
    monkeypatch.setattr(support, "_farthest", lambda p, d: looked.append(len(p) * len(d)) or farthest(p, d))
    assert is_convex(np.array(ball.vertices), np.array(ball.faces))
    assert sum(looked) <= 2 * FEW * len(ball.faces)
