from __future__ import annotations

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from tamp.streams.affordances.nudges import nudgeable, nudged
from tamp.streams.grasping.hand_room import hands_over, hemmed_in, with_room
from tamp.streams.pushing.nudge import free_shifts, plan_nudging, pushing_hands
from tamp.streams.pushing.push_motion import push_hits
from tamp.task import Box, Mesh, Object, Pose, Sphere
from tamp.world.scene import Scene
from tamp.world.transforms import moved
from tests.streams.tables import CUBE, OBJECTS, ToldContext, workspace_of

CRATE = Object("crate", Mesh(OBJECTS / "open_box" / "collision.obj", 1.5), Pose((0.10, -0.22, 0.045)))
BALL = Object("ball", Sphere(0.03), Pose((0.10, -0.22, 0.041)), friction=0.3)
CLOSE = Object("close", Sphere(0.03), Pose((0.10, -0.285, 0.041)))
"""Two balls side by side in the crate: there is no room for a finger between them, but over their middles."""


@pytest.fixture(scope="module")
def workspace():
    return workspace_of(CRATE, BALL, CLOSE, CUBE, on={"ball": ("crate",), "close": ("crate",)})


@pytest.fixture(scope="module")
def poses(workspace):
    return {name: place.pose.matrix for name, place in workspace.start.items() if name != "ball"}


@pytest.fixture(scope="module")
def away():
    return np.array([0.0, 0.03, 0.0])


def test_hands_have_the_more_room_the_less_stands_around(workspace, poses):
    hands, T = hands_over(workspace, "ball", workspace.start["ball"]), workspace.start["ball"].pose.matrix
    crowded = with_room(workspace, hands, T, poses)
    free = with_room(workspace, hands, T, {"crate": poses["crate"]})
    assert 0 < len(crowded) < len(free) < len(hands)


WALL = Object("wall", Box((0.04, 0.4, 0.1)), Pose((0.0, 0.2, 0.05)))
BESIDE = Object("beside", Box((0.07, 0.15, 0.09)), Pose((0.06, 0.2, 0.045)))
"""A box that a hand takes across its narrow side only, 5 mm beside a wall."""


@pytest.fixture(scope="module")
def table():
    return workspace_of(WALL, BESIDE, CUBE)


def test_what_stands_close_beside_a_wall_is_hemmed_in(table):
    assert hemmed_in(table, "beside")
    assert not hemmed_in(table, "cube")
    assert not hemmed_in(table, "wall")
    assert not hemmed_in(workspace_of(WALL, replace(BESIDE, pose=Pose((0.1, 0.2, 0.045)))), "beside")


def test_on_the_table_there_are_longer_ways_out_but_not_over_its_edge(table):
    start, wall = table.start["beside"], {"wall": table.start["wall"].pose.matrix}
    shifts = np.array(list(free_shifts(table, "beside", start, wall)))
    assert np.linalg.norm(shifts, axis=1).max() == pytest.approx(0.16)
    ends = [nudged(start, shift) for shift in shifts]
    assert not any(table.world.overlap("beside", end.pose.matrix, "wall", wall["wall"], 0.001) for end in ends)
    edge = table.task.table.center[0] + table.task.table.size[0] / 2
    near = replace(start, pose=Pose((edge - 0.06, 0.2, 0.045)))
    farthest = max(shift[0] for shift in free_shifts(table, "beside", near, wall))
    assert 0.0 < farthest < 0.06


def test_a_nudge_stays_on_one_level_in_one_thing(workspace, away):
    start = workspace.start["ball"]
    assert nudgeable(workspace, "ball", start, nudged(start, away))
    for shift in ([0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.02, 0.0, 0.01]):
        assert not nudgeable(workspace, "ball", start, nudged(start, np.array(shift)))
    cube = workspace.start["cube"]
    assert not nudgeable(workspace, "cube", cube, nudged(cube, away))


def test_what_an_object_sticks_to_would_come_along(away):
    def may_be_nudged(friction):
        rough = workspace_of(CRATE, replace(BALL, friction=friction), on={"ball": ("crate",)})
        start = rough.start["ball"]
        return nudgeable(rough, "ball", start, nudged(start, away))

    assert may_be_nudged(0.9) and not may_be_nudged(1.1)  # the table's is 1


def test_what_has_a_neighbour_is_not_nudged_into_it(workspace, poses):
    shifts = np.array(list(free_shifts(workspace, "ball", workspace.start["ball"], poses)))
    assert len(shifts) and np.linalg.norm(shifts, axis=1).max() == pytest.approx(0.04)
    centres = workspace.start["ball"].pose.xyz + shifts
    assert np.linalg.norm(centres - CLOSE.pose.xyz, axis=1).min() > 2 * 0.03 - 0.001


@pytest.mark.parametrize("left", np.arange(0.0, 0.01, 0.001))
def test_what_is_nudged_gets_hardly_deeper_into_what_it_lies_in(left, poses):
    """Wherever it lies a little before a wall of that."""
    crate, alone = poses["crate"], workspace_of(CRATE, BALL, on={"ball": ("crate",)})
    wall = next(x for x in np.arange(0.0, 0.3, 0.001) if _apart(alone, x, crate) < 0.0)
    start = nudged(alone.start["ball"], np.array([wall - 0.03 - left, 0.0, 0.0]))
    ends = [moved(start.pose.matrix, shift) for shift in free_shifts(alone, "ball", start, {"crate": crate})]
    assert ends and min(alone.world.separation("ball", end, "crate", crate) for end in ends) > -0.001


def _apart(workspace, x, crate):
    there = moved(workspace.start["ball"].pose.matrix, np.array([x, 0.0, 0.0]))
    return workspace.world.separation("ball", there, "crate", crate)


def test_the_hand_touches_from_behind_and_meets_nothing_else(workspace, poses, away):
    ball = {"ball": workspace.start["ball"].pose.matrix}
    own, others = (workspace.world.free_hand(Scene(each), 0.0, ignore=("table",)) for each in (ball, poses))
    found = list(pushing_hands(workspace, "ball", workspace.start["ball"], away, poses))
    assert found
    for T, opening in found:
        ahead = np.eye(4)
        ahead[:3, 3] = 0.002 * away / np.linalg.norm(away)
        assert not own.hit(T, opening) and own.hit(ahead @ T, opening)
        assert not others.hit(T, opening)


def test_what_sticks_is_not_pushed_where_it_would_tip(poses, away):
    sticky = workspace_of(CRATE, replace(BALL, friction=1.0), CLOSE, on={"ball": ("crate",), "close": ("crate",)})
    assert not list(pushing_hands(sticky, "ball", sticky.start["ball"], away, {"crate": poses["crate"]}))


def test_the_arm_takes_the_object_straight_to_where_it_shall_be(workspace, away):
    start = workspace.start["ball"]
    end = nudged(start, away)
    before, after, nudge = next(plan_nudging(ToldContext(workspace), "ball", start, end))
    robot = workspace.world.robot
    for q, place in ((nudge.push[0], start), (nudge.push[-1], end)):
        np.testing.assert_allclose((robot.forward(q) @ nudge.T_tool_object.matrix)[:3, 3], place.pose.xyz, atol=1e-4)
    assert before.q == tuple(nudge.approach[0]) and after.q == tuple(nudge.retreat[-1])
    others = {name: place for name, place in workspace.start.items() if name != "ball"}
    assert push_hits(workspace, nudge, others) is None


def test_into_a_neighbour_there_is_no_way(workspace):
    start = workspace.start["ball"]
    into = nudged(start, np.array([0.0, -0.03, 0.0]))
    assert not list(islice(plan_nudging(ToldContext(workspace), "ball", start, into), 1))
