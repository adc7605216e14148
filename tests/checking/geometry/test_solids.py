"""Distances between solids against closed forms and against a slow computation by linear programming."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog
from scipy.spatial import ConvexHull

from tamp.checking.geometry.solids import Piece, Solid, clearance, deeper, parting_normal, penetration
from tamp.checking.geometry.transforms import inverse
from tamp.checking.robot.links import read_links
from tamp.task import Box, Cylinder, Pose, Sphere, load_robot
from tamp.task.mesh.parts import convex_hull, parts

angles = st.floats(-np.pi, np.pi)
offsets = st.floats(-0.12, 0.12)
poses = st.builds(lambda x, y, z, r, p, w: Pose.from_rpy((x, y, z), (r, p, w)).matrix, *[offsets] * 3, *[angles] * 3)
TRAY = [((0.1, 0.08, 0.004), (0.0, 0.0, 0.0)), ((0.004, 0.08, 0.03), (0.05, 0.0, 0.015))]
HALF = Box((0.05, 0.06, 0.05))
shapes = st.sampled_from([Box((0.05, 0.06, 0.1)), Cylinder(0.03, 0.08), Sphere(0.04), Box((0.2, 0.2, 0.004))])


def solid(*shapes: Box | Cylinder | Sphere) -> Solid:
    return Solid.of("body", [part for shape in shapes for part in parts(shape)])


def overlap(a: Piece, b: Piece, T: np.ndarray) -> bool:
    """Whether some point satisfies all half-spaces of both pieces."""
    normals, offsets = a.planes
    others, more = b.planes
    turned = others @ T[:3, :3].T
    A, c = np.vstack([normals, turned]), np.concatenate([offsets, more + turned @ T[:3, 3]])
    return linprog(np.zeros(3), A_ub=A, b_ub=c, bounds=[(None, None)] * 3).status == 0


@given(a=shapes, b=shapes, T=poses)
@settings(max_examples=100, deadline=None)
def test_sign_agrees_with_linear_programming(a: object, b: object, T: np.ndarray) -> None:
    one, two = solid(a), solid(b)
    apart = clearance(one, two, T, 0.001)
    if abs(apart) > 1e-6:
        assert (apart < 0) == overlap(one.hull, two.hull, T)


@given(a=shapes, b=shapes, T=poses)
@settings(max_examples=100, deadline=None)
def test_clearance_is_symmetric_and_deep_values_are_exact(a: object, b: object, T: np.ndarray) -> None:
    one, two = solid(a), solid(b)
    there, back = clearance(one, two, T, 0.0), clearance(two, one, inverse(T), 0.0)
    assert there == pytest.approx(back, abs=1e-5, rel=0.1)  # bounds of distances may be slack, depths may not
    if there < -1e-6:
        assert there == pytest.approx(-penetration(one.hull, two.hull, T), abs=1e-9)


@given(a=shapes, b=shapes, T=poses)
@settings(max_examples=60, deadline=None)
def test_what_goes_deep_into_another_parts_from_it_along_the_normal_and_no_sooner(
    a: object, b: object, T: np.ndarray
) -> None:
    one, two = solid(a).hull, solid(b).hull
    deep = penetration(one, two, T)
    if deep > 1e-4:
        moved, normal = T.copy(), parting_normal(one, two, T)
        assert np.linalg.norm(normal) == pytest.approx(1.0)
        moved[:3, 3] -= deep * normal  # the second gives way, as much as the first would the other way
        assert penetration(one, two, moved) == pytest.approx(0.0, abs=1e-6)


@given(a=shapes, b=shapes, T=poses)
@settings(max_examples=25, deadline=None)
def test_the_plane_that_best_parts_two_is_a_face_of_the_hull_of_their_minkowski_difference(
    a: object, b: object, T: np.ndarray
) -> None:
    one, two = solid(a).hull, solid(b).hull
    moved = two.corners @ T[:3, :3].T + T[:3, 3]
    planes = ConvexHull((one.corners[:, None] - moved).reshape(-1, 3)).equations
    best = planes[:, 3].max()
    assert penetration(one, two, T) == pytest.approx(-best, abs=1e-8)
    alike = planes[planes[:, 3] > best - 1e-7, :3]
    assert (alike @ -parting_normal(one, two, T)).max() == pytest.approx(1.0, abs=1e-5)


@given(gap=st.floats(-0.03, 0.1))
@settings(max_examples=50, deadline=None)
def test_boxes_face_to_face(gap: float) -> None:
    T = np.eye(4)
    T[0, 3] = 0.05 + gap
    box = solid(Box((0.05, 0.05, 0.08)))
    assert clearance(box, box, T, 0.001) == pytest.approx(gap, abs=1e-3 if -0.001 < gap < 0 else 1e-6)


@given(T=poses)
@settings(max_examples=60, deadline=None)
def test_a_hollow_stays_hollow_and_bounds_hold(T: np.ndarray) -> None:
    walls, nearest = [], np.inf
    ball_points = parts(Sphere(0.02))[0].vertices @ T[:3, :3].T + T[:3, 3]
    for axis, sign in ((0, 1), (0, -1), (1, 1), (1, -1)):
        shift = np.zeros(3)
        shift[axis] = sign * 0.05
        size = np.array([0.1, 0.1, 0.1])
        size[axis] = 0.004
        walls.append(convex_hull(parts(Box(tuple(size)))[0].vertices + shift))
        outside = np.maximum(np.abs(ball_points - shift) - size / 2, 0.0)
        nearest = min(nearest, float(np.linalg.norm(outside, axis=1).min()))
    cup, ball = Solid.of("cup", walls), solid(Sphere(0.02))
    assert clearance(cup, ball, T, 0.0) <= nearest + 1e-6  # no corner of the ball is nearer than the bound says
    assert clearance(cup, ball, np.eye(4), 0.0) == pytest.approx(0.028, abs=1e-3)


@given(T=poses, other=shapes)
@settings(max_examples=60, deadline=None)
def test_of_the_pieces_of_two_bodies_none_is_nearer_than_their_clearance(T: np.ndarray, other: object) -> None:
    tray = [convex_hull(parts(Box(size))[0].vertices + shift) for size, shift in TRAY]
    a, b = Solid.of("tray", tray), Solid.of("other", [*tray, *parts(other)])
    least = min(clearance(Solid.of("", [p.part]), Solid.of("", [q.part]), T, 0.0) for p in a.pieces for q in b.pieces)
    told = clearance(a, b, T, 0.0)
    assert told <= least + 1e-6
    if told < 0.0:
        assert told == pytest.approx(least, abs=1e-6)


@given(T=poses, other=shapes, share=st.floats(0.0, 2.0))
@settings(max_examples=100, deadline=None)
def test_deeper_tells_what_the_clearance_tells(T: np.ndarray, other: object, share: float) -> None:
    tray = [convex_hull(parts(Box(size))[0].vertices + shift) for size, shift in TRAY]
    a, b = Solid.of("tray", tray), solid(other)
    told = clearance(a, b, T, 0.0)
    for depth in (0.0, share * max(-told, 0.0)):
        if abs(-told - depth) > 1e-9:
            assert deeper(a, b, T, depth) == (-told > depth)


def test_mass_of_a_box() -> None:
    volume, center = Solid.of("body", parts(Box((0.1, 0.2, 0.3)))).hull.volume_and_centroid
    assert volume == pytest.approx(0.006)
    assert np.allclose(center, 0.0, atol=1e-12)


def test_links_of_the_panda() -> None:
    links = read_links(load_robot("panda"))
    assert len(links.solids) == 11
    assert links.fixed == {"panda_link0"}
    assert links.gripper == {"panda_hand", "panda_leftfinger", "panda_rightfinger"}
    pairs = {frozenset((a.name, b.name)) for a, b in links.pairs}
    assert frozenset(("panda_link0", "panda_hand")) in pairs
    assert frozenset(("panda_link1", "panda_link2")) not in pairs
    assert frozenset(("panda_leftfinger", "panda_rightfinger")) not in pairs


def test_inertia_is_that_of_a_box_a_cylinder_and_of_boxes_put_together() -> None:
    box = np.array([0.05, 0.06, 0.1])
    assert np.allclose(solid(Box(tuple(box))).inertia, np.diag(box @ box - box**2) / 12)
    axial, across = 0.03**2 / 2, (3 * 0.03**2 + 0.08**2) / 12
    assert np.allclose(solid(Cylinder(0.03, 0.08)).inertia, np.diag([across, across, axial]), rtol=0.01)
    halves = [
        convex_hull(part.vertices + np.array([0.0, 0.0, side * 0.025])) for side in (-1, 1) for part in parts(HALF)
    ]
    assert np.allclose(Solid.of("body", halves).inertia, np.diag(box @ box - box**2) / 12)
