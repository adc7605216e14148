from __future__ import annotations

from itertools import islice

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.streams.affordances.tilts import (
    LEAST,
    MOST,
    ROLL,
    TIPS,
    layable,
    never_too_wide,
    rolls,
    tilts,
    tips_on,
    upside_down,
)
from tamp.streams.values import Placement
from tamp.task import At, Box, Cylinder, Object, Pose
from tamp.world.transforms import rotation, turned_about
from tests.streams.tables import RED, corners, workspace_of

CUBE = np.array([[x, y, z] for x in (0.0, 0.1) for y in (0.0, 0.1) for z in (0.0, 0.1)])


@given(angle=st.floats(-np.pi, np.pi), count=st.integers(1, 100))
@settings(max_examples=30, deadline=None)
def test_what_rolls_stays_on_the_plane_and_turns_evenly(angle, count):
    outward = np.array([np.cos(angle), np.sin(angle)])
    *_, (T, touching) = islice(rolls(CUBE, np.eye(4), outward), count)
    world = CUBE @ T[:3, :3].T + T[:3, 3]
    assert abs(world[:, 2].min()) < 1e-9
    turn = rotation(np.array([-outward[1], outward[0], 0.0]), count * ROLL)
    np.testing.assert_allclose(T[:3, :3], turn, atol=1e-9)
    assert (world[:, :2] @ outward).min() - 1e-9 <= touching.min() <= touching.max()


def test_after_a_quarter_turn_a_cube_lies_beside_where_it_lay():
    *_, (T, touching) = islice(rolls(CUBE, np.eye(4), np.array([1.0, 0.0])), round(np.pi / 2 / ROLL))
    world = CUBE @ T[:3, :3].T + T[:3, 3]
    np.testing.assert_allclose(world.min(axis=0), (0.1, 0.0, 0.0), atol=1e-9)
    np.testing.assert_allclose(sorted(set(touching.round(6))), (0.1, 0.2), atol=1e-9)


def test_the_point_that_something_turns_about_stays():
    pivot, T = np.array([0.3, 0.2, 0.1]), np.eye(4)
    turned = turned_about(pivot, rotation(np.array([0.0, 0.0, 1.0]), 0.7), T)
    np.testing.assert_allclose(turned[:3, :3] @ pivot + turned[:3, 3], pivot)


@given(half=st.floats(0.01, 0.1), height=st.floats(0.02, 0.3), share=st.floats(0.1, 0.95))
@settings(max_examples=60, deadline=None)
def test_a_block_tips_on_as_it_rocks(half, height, share):
    """Housner, The behavior of inverted pendulum structures during earthquakes, BSSA 53, 1963, eq. 8."""
    workspace = workspace_of(Object("block", Box((2 * half, 0.08, height)), Pose((0.0, 0.2, height / 2))))
    up, radius, slender = height / 2, float(np.hypot(half, height / 2)), float(np.arctan2(half, height / 2))
    upright, angle = np.eye(4), share * slender
    upright[2, 3] = up
    tilted = turned_about(np.array([half, 0.0, 0.0]), rotation(np.array([0.0, 1.0, 0.0]), angle), upright)
    left = (1.0 - 1.5 * np.sin(slender) ** 2).clip(0.0) ** 2 * (radius * np.cos(slender - angle) - up)
    needed = TIPS * (radius - up)
    if abs(left - needed) > 1e-3 * needed:
        geometry = workspace.world.geometries["block"]
        told = tips_on(geometry, Pose.from_matrix(tilted), Pose.from_matrix(upright))
        assert told == (left > needed)


def test_what_is_narrow_and_high_is_not_stood_up_by_a_fall_on_the_table():
    for width, some in ((0.03, False), (0.2, True)):
        start, goal = Pose.from_rpy((0.0, 0.2, width / 2), (0.0, np.pi / 2, 0.0)), Pose((0.0, 0.2, 0.06))
        workspace = workspace_of(Object("block", Box((width, width, 0.12)), start, At(goal)))
        assert bool(tilts(workspace, "block", workspace.goals["block"])) == some


def lying(size, yaw=0.0):
    """A box that stands on its narrow side and shall lie flat."""
    _, y, z = size
    start = Pose.from_rpy((0.1, 0.25, y / 2), (np.pi / 2, 0.0, 0.0))
    goal = Pose.from_rpy((0.05, -0.15, z / 2), (0.0, 0.0, yaw))
    return workspace_of(Object("book", Box(size), start, At(goal)))


@given(size=st.tuples(st.floats(0.1, 0.2), st.floats(0.1, 0.2), st.floats(0.01, 0.06)), yaw=st.floats(-3.0, 3.0))
@settings(max_examples=15, deadline=None)
def test_a_fall_ends_at_the_placement_and_turns_over_an_edge_that_stays(size, yaw):
    workspace = lying(size, yaw)
    goal = workspace.goals["book"]
    found = tilts(workspace, "book", goal)
    assert {round(tilt.angle, 6) for tilt in found} >= {round(float(np.radians(a)), 6) for a in (10, 30)}
    for tilt in found:
        assert tilt.fall[-1].xyz == pytest.approx(goal.pose.xyz)
        assert LEAST - 1e-9 <= tilt.angle <= MOST + 1e-9
        assert len(tilt.fall) == 1 + round(tilt.angle / ROLL)
        before, after = (corners(workspace, "book", pose) for pose in (tilt.fall[0], tilt.fall[-1]))
        assert before[:, 2].min() == pytest.approx(0.0, abs=1e-6)
        # The two corners of the edge it turns about stay where they are, and the base's two others come down.
        still = np.linalg.norm(before - after, axis=1) < 1e-6
        assert still.sum() == 2
        landing = ~still & (after[:, 2] < 1e-6)
        assert landing.sum() == 2
        assert (before[landing, 2] > 0.01).all()


def test_the_least_tilt_comes_first():
    workspace = lying((0.15, 0.2, 0.03))
    angles = [tilt.angle for tilt in tilts(workspace, "book", workspace.goals["book"])]
    assert angles == sorted(angles)


def test_a_disc_that_rolls_over_its_rim_stays_on_the_ground():
    disc = Object("disc", Cylinder(0.1, 0.02), Pose((0.0, 0.0, 0.01)))
    workspace = workspace_of(disc)
    found = tilts(workspace, "disc", workspace.start["disc"])
    assert found
    for tilt in found:
        for pose in tilt.fall:
            assert corners(workspace, "disc", pose)[:, 2].min() == pytest.approx(0.0, abs=1e-6)


def test_nothing_falls_onto_a_base_that_is_a_line():
    bar = Object("bar", Box((0.2, 0.008, 0.03)), Pose((0.0, 0.0, 0.015)))
    workspace = workspace_of(bar)
    assert not tilts(workspace, "bar", workspace.start["bar"])


def test_what_is_wide_or_turned_over_is_layable_and_a_small_box_is_not():
    book = lying((0.15, 0.2, 0.03))
    assert layable(book, "book", book.goals["book"])
    red = workspace_of(RED)
    assert not layable(red, "red", red.goals["red"])
    over = Placement(Pose.from_rpy((0.05, -0.2, 0.04), (np.pi, 0.0, 0.0)), ("table",))
    assert layable(red, "red", over)


@given(
    a=st.floats(0.01, 0.08), b=st.floats(0.01, 0.08), c=st.floats(0.01, 0.3), turn=st.tuples(*[st.floats(-3, 3)] * 3)
)
@settings(max_examples=60, deadline=None)
def test_what_is_never_too_wide_is_not_too_wide_however_it_lies(a, b, c, turn):
    item = Object("bar", Box((a, b, c)), Pose((0.0, 0.0, c / 2)))
    workspace = workspace_of(item)
    points = corners(workspace, "bar", Pose.from_rpy((0.0, 0.0, 0.2), turn))[:, :2]
    angles = np.linspace(0.0, np.pi, 1800)
    narrowest = np.ptp(points @ np.stack([np.cos(angles), np.sin(angles)]), axis=0).min()
    assert not never_too_wide(workspace, "bar") or narrowest < workspace.world.robot.spec.gripper.stroke + 5e-4


@pytest.mark.parametrize(("roll", "over"), [(0.0, False), (np.pi / 2, False), (0.9 * np.pi, True), (np.pi, True)])
def test_what_is_upside_down_has_to_be_turned_over(roll, over):
    workspace = workspace_of(RED)
    placement = Placement(Pose.from_rpy((0.05, -0.2, 0.04), (roll, 0.0, 0.7)), ("table",))
    assert upside_down(workspace, "red", placement) == over
