from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tamp.streams.affordances.stable_poses import (
    BALANCE,
    STEADY,
    inside_by,
    midtable,
    moved,
    outline,
    righted,
    rolls,
    rolls_down,
    stands,
    stays,
    steady_faces,
    tips_at,
)
from tamp.streams.affordances.tilts import tilts
from tamp.streams.values import Placement
from tamp.task import Box, Cylinder, Object, Pose
from tamp.task.mesh.parts import convex_hull
from tamp.world.geometry.object_geometry import geometry_of, load_geometry, stable_poses
from tests.streams.tables import workspace_of


@given(points=arrays(np.float64, (12, 2), elements=st.floats(-1.0, 1.0, width=32)))
def test_an_outline_turns_left_all_around_and_leaves_no_point_outside(points):
    corners = outline(points)
    if len(corners) < 3:
        return
    edges = np.roll(corners, -1, axis=0) - corners
    for corner, edge in zip(corners, edges, strict=True):
        offsets = points - corner
        assert (edge[0] * offsets[:, 1] - edge[1] * offsets[:, 0] > -1e-9).all()


def test_points_in_line_have_no_outline():
    assert len(outline(np.array([[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]))) < 3


@given(size=st.tuples(*[st.floats(0.02, 0.2)] * 3))
def test_a_box_stands_on_each_of_its_faces(size):
    geometry = load_geometry(Box(size))
    assert all(stands(geometry, pose.R) for pose in stable_poses(geometry))


@given(size=st.tuples(*[st.floats(0.05, 0.2)] * 3), angle=st.floats(0.1, 1.4))
def test_a_box_does_not_stand_on_an_edge(size, angle):
    c, s = np.cos(angle), np.sin(angle)
    assert not stands(load_geometry(Box(size)), np.array([[1, 0, 0], [0, c, -s], [0, s, c]]))


def test_a_disc_stands_flat_and_not_on_its_rim():
    disc = load_geometry(Cylinder(0.1, 0.01))
    assert stands(disc, np.eye(3))
    leaning = np.array([[1.0, 0, 0], [0, np.cos(1.4), -np.sin(1.4)], [0, np.sin(1.4), np.cos(1.4)]])
    assert not stands(disc, leaning)


@given(height=st.floats(0.1, 0.3), slope=st.floats(0.02, 0.3))
def test_a_board_on_its_edge_stands_only_where_it_is_not_easily_tipped(height, slope):
    assume(abs(slope - STEADY) > 1e-3 and slope * height / 2 > 2 * BALANCE)
    board = load_geometry(Box((slope * height, 0.2, height)))
    assert stands(board, np.eye(3)) == (slope > STEADY)


@given(
    radius=st.floats(0.005, 0.015), length=st.floats(0.05, 0.2), yaw=st.sampled_from(np.radians(np.arange(0, 360, 10)))
)
def test_what_is_round_rolls_where_it_lies_and_comes_no_lower(radius, length, yaw):
    can, (c, s) = load_geometry(Cylinder(radius, length)), (np.cos(yaw), np.sin(yaw))
    lying = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
    assert rolls(can, lying) and not rolls_down(can, lying)
    assert not rolls(can, np.eye(3)) and not rolls(load_geometry(Box((radius, radius, length))), lying)


def test_a_face_that_nearly_every_throw_ends_on_is_steady_though_it_rocks():
    # A plate whose underside bends up by three degrees, a millimetre beside its centre of mass.
    half, bend = 0.05, -0.002
    rise = (half - bend) * np.tan(np.radians(3.0))
    under = [(-half, 0.0), (bend, 0.0), (half, rise)]
    corners = [(x, y, z) for y in (-half, half) for x, z in (*under, (half, 0.01), (-half, 0.01))]
    plate = geometry_of([convex_hull(np.array(corners))])
    flat = np.eye(3)
    assert not stands(plate, flat)
    assert any(np.allclose(R, flat, atol=1e-6) for R in steady_faces(plate))


@given(size=st.tuples(*[st.floats(0.02, 0.2)] * 3))
def test_a_box_stays_on_the_broadest_of_its_faces(size):
    assert stays(load_geometry(Box(tuple(sorted(size, reverse=True)))), np.eye(3))


def test_what_falls_onto_a_narrow_end_or_a_round_side_does_not_stay():
    pillar, rod = load_geometry(Box((0.02, 0.02, 0.2))), load_geometry(Cylinder(0.02, 0.2))
    lying = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    assert not stays(pillar, np.eye(3))
    assert stays(pillar, lying)
    assert not stays(rod, lying)
    assert not stays(rod, np.eye(3))
    assert stays(load_geometry(Cylinder(0.08, 0.03)), np.eye(3))


BOOK = Object("book", Box((0.15, 0.20, 0.03)), Pose.from_rpy((0.1, 0.25, 0.016), (0.0, 0.0, 0.0)))
FLAT = Placement(BOOK.pose, ("table",))


@pytest.fixture(scope="module")
def workspace():
    return workspace_of(BOOK)


def elsewhere(placement, x, y, angle):
    moved = Pose.from_rpy((x, y, 0.0), (0.0, 0.0, angle)) @ placement.pose
    return Placement(moved, placement.on)


@given(
    st.floats(-0.3, 0.3),
    st.floats(-0.3, 0.3),
    st.floats(-3.0, 3.0),
    st.sampled_from([0.0, np.pi / 2, np.pi]),
)
def test_all_places_on_the_table_have_one_in_its_middle(workspace, x, y, angle, roll):
    placement = Placement(Pose.from_rpy((0.0, 0.0, 0.05), (roll, 0.0, 0.0)), ("table",))
    middle = midtable(workspace, placement)
    other = midtable(workspace, elsewhere(placement, x, y, angle))
    np.testing.assert_allclose(other.pose.matrix, middle.pose.matrix, atol=1e-8)
    np.testing.assert_allclose(middle.pose.matrix[2], placement.pose.matrix[2], atol=1e-8)
    assert middle.pose.xyz[:2] == workspace.task.table.center


def test_a_fall_is_moved_as_a_whole_and_ends_at_the_placement(workspace):
    there = elsewhere(FLAT, 0.2, -0.1, 1.0)
    fall = tilts(workspace, "book", midtable(workspace, FLAT))[0].fall
    found = moved(fall, there)
    assert found[-1] == there.pose
    for pose, before in zip(found, fall, strict=True):
        step, meant = found[-1].inverse() @ pose, fall[-1].inverse() @ before
        np.testing.assert_allclose(step.matrix, meant.matrix, atol=1e-8)


def _rotations():
    return arrays(np.float64, 4, elements=st.floats(-1.0, 1.0)).filter(lambda q: np.linalg.norm(q) > 0.1)


def test_what_is_put_down_in_balance_on_its_edge_is_over_that():
    s = np.sqrt(0.5)
    balanced = np.array([[1.0, 0.0, 0.0], [0.0, s, -s], [0.0, s, s]])
    assert righted(load_geometry(Box((0.1, 0.1, 0.1))), balanced) is balanced


def _turn(quaternion):
    return Pose((0.0, 0.0, 0.0), tuple(quaternion / np.linalg.norm(quaternion))).matrix[:3, :3]


def _distance(corners):
    """How far beside a polygon, corners (n, 2), or an edge on which something is balanced, the origin is."""
    if len(corners) > 2:
        return max(0.0, -inside_by(corners, np.zeros(2)))
    ways = corners[[0]] + np.linspace(0.0, 1.0, 2001)[:, None] * (corners[-1] - corners[0])
    return np.linalg.norm(ways, axis=1).min()


@given(points=arrays(np.float64, (12, 3), elements=st.floats(-0.1, 0.1)), quaternion=_rotations())
def test_what_rights_itself_comes_down_to_where_its_centre_of_mass_is_over_what_touches(points, quaternion):
    assume(np.linalg.svd(points - points.mean(axis=0))[1].min() > 0.05)
    geometry, R = geometry_of((convex_hull(points),)), _turn(quaternion)
    found = righted(geometry, R)
    height = [-((geometry.hull.vertices - geometry.center_of_mass) @ at[2]).min() for at in (R, found)]
    assert height[1] <= height[0] + 1e-4
    assert righted(geometry, found)[2] @ found[2] > np.cos(0.03)
    if found is not R:
        around = (geometry.hull.vertices - geometry.center_of_mass) @ found.T
        low = around[around[:, 2] < around[:, 2].min() + 2e-4, :2]
        assert _distance(outline(low) if len(low) > 1 else low) < 1e-3


@given(size=st.tuples(*[st.floats(0.05, 0.2)] * 3), angle=st.floats(0.05, 0.6))
def test_a_box_that_is_put_down_on_an_edge_falls_to_the_face_that_its_middle_is_over(size, angle):
    _, depth, height = size
    falls_on = np.arctan2(depth, height)  # from there on the other face is below
    assume(abs(angle - falls_on) > 0.05)
    c, s = np.cos(angle), np.sin(angle)
    up = righted(load_geometry(Box(size)), np.array([[1, 0, 0], [0, c, -s], [0, s, c]]))[2]
    assert abs(up[2 if angle < falls_on else 1]) > 0.999


def test_what_rests_in_a_simulator_is_taken_for_upright():
    c, s = np.cos(0.01), np.sin(0.01)
    R = np.array([[1.0, 0, 0], [0, c, -s], [0, s, c]])
    assert righted(load_geometry(Box((0.1, 0.1, 0.05))), R) is R


def test_what_is_round_rolls_until_its_heavy_side_is_below():
    angles = np.linspace(0.0, 2 * np.pi, 72, endpoint=False)
    rim = np.stack([0.05 * np.cos(angles), 0.05 * np.sin(angles)], axis=1)
    ends = np.concatenate([np.column_stack([np.full(72, x), rim]) for x in (-0.05, 0.05)])
    round_one = convex_hull(ends)
    weight = convex_hull(np.array([[x, y, z] for x in (-0.04, 0.04) for y in (-0.02, 0.02) for z in (-0.04, -0.02)]))
    roller = geometry_of((round_one, weight))
    assert roller.center_of_mass[2] < -0.002
    assert not rolls_down(roller, np.eye(3))
    aside = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
    assert rolls_down(roller, aside)
    assert not rolls_down(geometry_of((round_one,)), aside)  # it rolls, but not down
    assert not rolls_down(load_geometry(Box((0.1, 0.1, 0.1))), np.eye(3))


@given(width=st.floats(0.02, 0.1), height=st.floats(0.02, 0.2), yaw=st.floats(-3.0, 3.0))
def test_a_box_tips_over_when_its_centre_is_over_its_edge(width, height, yaw):
    box = load_geometry(Box((width, 0.2, height)))
    R = Pose.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, yaw)).matrix[:3, :3]
    assert tips_at(box, R) == pytest.approx(np.arctan2(width, height), abs=1e-6)
