from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.streams.hand.antipodal import Contacts
from tamp.streams.hand.candidates import (
    DIRECTIONS,
    WIDTH_RESERVE,
    Pinches,
    in_tool_frames,
    intrinsic_cost,
    levelled,
    sample_pinches,
)
from tamp.streams.hand.clearance import above_table
from tamp.task import Box, Object, Pose
from tests.streams.tables import panda, workspace_of

GRIPPER = panda().spec.gripper


@pytest.fixture(scope="module")
def pinches(table):
    return sample_pinches(table, "red", np.random.default_rng(0))


def test_tools_are_right_handed_frames(pinches):
    R = pinches.T_object_tool[:, :3, :3]
    assert np.allclose(R @ R.transpose(0, 2, 1), np.eye(3))
    assert np.allclose(np.linalg.det(R), 1.0)
    assert np.array_equal(pinches.T_object_tool[:, 3], np.tile([0.0, 0.0, 0.0, 1.0], (len(pinches), 1)))


def test_the_contact_lies_between_the_pads_at_the_depth_that_is_said(pinches, table):
    T = pinches.T_object_tool
    # Back along the approach from the fingertips by the depth: the middle of the two contacts, inside the box.
    tip = T[:, :3, 3] + T[:, :3, 2] * GRIPPER.pad[2] / 2
    middle = tip - pinches.depths[:, None] * T[:, :3, 2]
    half = np.array(table.task.object("red").shape.size) / 2
    assert (np.abs(middle) <= half + 1e-9).all()
    ends = [middle + side * 0.5 * pinches.widths[:, None] * (T[:, :3, :3] @ GRIPPER.axis) for side in (-1, 1)]
    for end in ends:
        assert np.allclose(np.abs(np.abs(end) - half).min(axis=1), 0.0, atol=1e-7)


def test_of_what_hangs_over_the_edge_only_that_is_pinched():
    board = Object("board", Box((0.2, 0.2, 0.02)), Pose((-0.05, 0.3, 0.01)))
    workspace = workspace_of(board)
    edge = workspace.task.table.center[1] + workspace.task.table.size[1] / 2
    hanging = Pose((-0.05, edge + 0.04, 0.01))
    found = sample_pinches(workspace, "board", np.random.default_rng(0), hanging=hanging)
    T = found.T_object_tool
    middle = T[:, :3, 3] + T[:, :3, 2] * (GRIPPER.pad[2] / 2 - found.depths[:, None])
    assert len(found) > 100
    # Between its two faces a ray runs so far aside at most as friction lets it.
    assert (middle[:, 1] + hanging.xyz[1]).min() > edge - 0.02


@settings(max_examples=20, deadline=None)
@given(rise=st.floats(-0.49, 0.49), heading=st.floats(-np.pi, np.pi), width=st.floats(0.005, 0.07))
def test_a_nearly_level_pair_of_contacts_is_made_quite_level_about_its_middle(rise, heading, width):
    level = np.array([np.cos(heading), np.sin(heading), 0.0])
    axis = np.sqrt(1 - rise**2) * level + [0.0, 0.0, rise]
    pair = Contacts(np.array([[0.1, 0.2, 0.3]]), axis[None], np.array([width]), np.array([0.1]))
    found = levelled(pair, np.array([0.0, 0.0, 1.0]))
    assert np.allclose(found.axes, level) and np.array_equal(found.centers, pair.centers)
    assert np.allclose(found.widths, width * np.sqrt(1 - rise**2))
    assert not len(levelled(pair, level * np.sign(axis @ level)).widths)


def test_of_what_lies_low_hands_that_come_straight_down_get_hold():
    blade = Object("blade", Box((0.14, 0.014, 0.008)), Pose((0.05, 0.0, 0.004)))
    workspace = workspace_of(blade)
    place = workspace.start["blade"]
    plain, more = (sample_pinches(workspace, "blade", np.random.default_rng(0), low=low) for low in ([], [place.pose]))
    assert np.array_equal(more.widths[: len(plain)], plain.widths)
    over = [above_table(workspace, pinches, place).sum() for pinches in (plain, more)]
    assert over[1] > 2 * over[0] > 0


def test_every_contact_is_offered_from_all_directions_at_all_depths(pinches):
    assert len(pinches) % (DIRECTIONS * len(GRIPPER.depths)) == 0
    assert set(np.unique(pinches.depths)) == set(GRIPPER.depths)
    assert (pinches.widths <= GRIPPER.stroke - WIDTH_RESERVE).all()


def test_the_same_generator_gives_the_same_pinches(pinches, table):
    again = sample_pinches(table, "red", np.random.default_rng(0))
    assert np.array_equal(pinches.T_object_tool, again.T_object_tool)


def test_choosing_and_joining_keep_rows_together(pinches):
    mask = pinches.depths == GRIPPER.depths[0]
    halves = [pinches.at(mask), pinches.at(~mask)]
    joined = Pinches.joined(halves)
    assert len(joined) == len(pinches)
    order = np.concatenate([np.flatnonzero(mask), np.flatnonzero(~mask)])
    assert np.array_equal(joined.T_object_tool, pinches.T_object_tool[order])
    assert np.array_equal(joined.slants, pinches.slants[order])


def test_a_long_lever_costs_more_than_a_grip_at_the_centre():
    workspace = workspace_of(Object("rod", Box((0.3, 0.03, 0.03)), Pose((0.0, 0.0, 0.015))))
    pinches = sample_pinches(workspace, "rod", np.random.default_rng(0))
    cost = intrinsic_cost(workspace, "rod", pinches)
    far = np.abs(pinches.T_object_tool[:, 0, 3])
    assert np.isfinite(cost).all()
    assert far[cost.argmin()] < 0.05
    assert cost[far < 0.03].mean() < cost[far > 0.12].mean()


@given(seed=st.integers(0, 10_000), grasps=st.integers(1, 4), count=st.integers(1, 5))
@settings(max_examples=30, deadline=None)
def test_points_seen_from_a_tool_go_back_to_where_they_were(seed, grasps, count):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(count, 3))
    T = np.array([Pose(tuple(rng.normal(size=3)), tuple(rng.normal(size=4))).matrix for _ in range(grasps)])
    local = in_tool_frames(points, T)
    assert local.shape == (grasps, count, 3)
    for tool, seen in zip(T, local, strict=True):
        assert np.allclose(seen @ tool[:3, :3].T + tool[:3, 3], points)
