from __future__ import annotations

from itertools import islice

import numpy as np
import pytest

from tamp.streams.collisions import ARM_MARGIN
from tamp.streams.grasping.sampler import sample_grasp
from tamp.streams.hand.clearance import opening_for
from tamp.streams.motion.handling_contacts import handling_hits
from tamp.streams.motion.inverse_kinematics import handlings as reaching
from tamp.streams.motion.inverse_kinematics import inverse_kinematics
from tamp.streams.motion.lift import LIFTS
from tamp.streams.values import Grasp, Placement
from tamp.task import Box, Object, Pose
from tamp.world.scene import Scene
from tests.streams.tables import RED, ToldContext, at, panda, workspace_of

FROM_ABOVE = Grasp(Pose.from_rpy((0.0, 0.0, 0.02), (np.pi, 0.0, 0.0)), 0.05)
FROM_BELOW = Grasp(Pose((0.0, 0.0, -0.02)), 0.05)


def tools(path):
    return np.array([panda().forward(q) for q in path])


@pytest.fixture(scope="module")
def handlings(table):
    """What inverse kinematics gives for the first grasps of the red box where it stands and where it shall stand."""
    found = []
    for placement in (table.start["red"], table.goals["red"]):
        for grasp in islice(sample_grasp(ToldContext(table), "red"), 3):
            found += inverse_kinematics(ToldContext(table), "red", placement, grasp)
    return found


def test_some_are_found(handlings):
    assert len(handlings) > 6


def test_the_approach_ends_where_the_lift_begins_with_the_tool_at_the_grasp(handlings):
    for _, _, handling in handlings:
        assert np.array_equal(handling.approach[-1], handling.lift[0])
        T_world_tool = handling.placement.pose.matrix @ handling.grasp.T_object_tool.matrix
        assert np.allclose(panda().forward(handling.lift[0]), T_world_tool, atol=2e-4)


def test_the_configurations_are_the_ends_of_the_handling(table, handlings):
    for before, after, handling in handlings:
        assert before.q == tuple(handling.approach[0])
        assert after.q == tuple(handling.lift[-1])
        assert before.opening == handling.opening == opening_for(panda().spec.gripper, handling.grasp)
        assert after.opening == handling.grasp.width


def test_the_approach_is_straight_along_the_tool_and_does_not_turn(handlings):
    for _, _, handling in handlings:
        T = tools(handling.approach)
        last = T[-1]
        behind = (T[:, :3, 3] - last[:3, 3]) @ last[:3, :3]
        assert np.allclose(behind[:, :2], 0.0, atol=1e-3)
        assert (np.diff(behind[:, 2]) > 0).all()
        assert behind[0, 2] < -0.04
        assert np.allclose(T[:, :3, :3], last[:3, :3], atol=1e-2)


def test_the_lift_is_straight_up(handlings):
    for _, _, handling in handlings:
        T = tools(handling.lift)
        risen = T[:, :3, 3] - T[0, :3, 3]
        assert np.allclose(risen[:, :2], 0.0, atol=1e-3)
        assert (np.diff(risen[:, 2]) > 0).all()
        assert min(abs(risen[-1, 2] - lift) for lift in LIFTS) < 1e-3
        assert np.allclose(T[:, :3, :3], T[0, :3, :3], atol=1e-2)


def test_every_point_is_within_the_joint_limits(handlings):
    robot = panda()
    for _, _, handling in handlings:
        for path in (handling.approach, handling.lift):
            assert (path >= np.array(robot.lower) - 1e-9).all()
            assert (path <= np.array(robot.upper) + 1e-9).all()


def test_every_handling_is_free_of_collision(table, handlings):
    for _, _, handling in handlings:
        obj, held = {"red": handling.placement.pose.matrix}, handling.grasp.T_object_tool.inverse().matrix
        empty = table.world.checker(Scene(obj, opening=handling.opening), margin=0.001, touch={"red": 0.0})
        assert empty.path_free(handling.approach, resolution=0.02)
        holding = Scene().attached("red", held, handling.grasp.width)
        assert table.world.checker(holding, margin=0.001, held_margin=-0.003).path_free(handling.lift, resolution=0.02)


def test_those_that_are_free_of_what_stands_around_come_first():
    wall = Object("wall", Box((0.02, 0.16, 0.14)), Pose((0.16, 0.2, 0.07)))
    workspace = workspace_of(RED, wall)
    around = {"wall": workspace.start["wall"]}
    seen = set()
    for grasp in islice(sample_grasp(ToldContext(workspace_of(RED)), "red"), 12):
        context = ToldContext(workspace, bound=(at("wall", around["wall"]),))
        found = inverse_kinematics(context, "red", workspace.start["red"], grasp)
        blocked = [bool(handling_hits(workspace, handling, around)) for _, _, handling in found]
        assert blocked == sorted(blocked)
        seen.update(blocked)
    assert False in seen


def test_the_same_generator_gives_the_same_handlings(table):
    def first(seed):
        found = inverse_kinematics(ToldContext(table, seed), "red", table.start["red"], FROM_ABOVE)
        return [before.q for before, _, _ in found]

    assert first(1)
    assert first(1) == first(1)


@pytest.mark.parametrize(
    ("pose", "grasp", "reason"),
    [
        (Pose((2.0, 0.0, 0.04)), FROM_ABOVE, "no inverse kinematics"),
        (RED.pose, FROM_BELOW, "the hand would hit table"),
    ],
)
def test_where_nothing_is_found_the_reason_is_told(table, pose, grasp, reason):
    context = ToldContext(table)
    assert list(inverse_kinematics(context, "red", Placement(pose, ("table",)), grasp)) == []
    assert context.reasons == [reason]


def test_a_lid_close_above_is_named():
    lid = Object("lid", Box((0.3, 0.3, 0.02)), Pose((0.05, 0.2, 0.17)))
    workspace = workspace_of(RED, lid)
    context = ToldContext(workspace, bound=(at("lid", workspace.start["lid"]),))
    found = list(inverse_kinematics(context, "red", workspace.start["red"], FROM_ABOVE))
    assert found  # the lid may move
    hits = [handling_hits(workspace, h, {"lid": workspace.start["lid"]}) for _, _, h in found]
    assert all(hit["lid"].endswith("would hit lid") for hit in hits)


def test_what_touches_a_wall_is_drawn_away_from_it():
    book = Object("book", Box((0.1, 0.03, 0.12)), Pose((0.05, 0.2, 0.061)))
    wall = Object("wall", Box((0.02, 0.1, 0.3)), Pose((0.1105, 0.2, 0.15)))
    workspace = workspace_of(book, wall)
    grasp = next(sample_grasp(ToldContext(workspace), "book"))
    _, _, handling = next(inverse_kinematics(ToldContext(workspace), "book", workspace.start["book"], grasp))
    T_end = workspace.world.robot.forward(handling.lift[-1]) @ grasp.T_object_tool.inverse().matrix
    assert workspace.world.separation("book", T_end, "wall", wall.pose.matrix) > ARM_MARGIN


def test_nothing_is_let_fall_against_the_robots_base(table):
    x, y, _ = table.world.robot.spec.T_world_base.xyz
    rests = Pose((x + 0.06, y, 0.04))
    fall = (Pose.from_rpy((x + 0.06, y, 0.05), (0.0, 0.4, 0.0)), rests)
    context = ToldContext(table)
    assert not list(reaching(context, "red", Placement(rests, ("table",)), FROM_ABOVE, fall))
    assert context.reasons == ["red would fall against the robot's base"]


def test_the_arm_puts_an_object_down_near_to_how_it_took_it(table):
    def ends(placement, grasp):
        found = inverse_kinematics(ToldContext(table), "red", placement, grasp)
        return [np.array(handling.approach[-1]) for _, _, handling in found]

    for grasp in islice(sample_grasp(ToldContext(table), "red"), 6):
        taken, put = (ends(placement, grasp) for placement in (table.start["red"], table.goals["red"]))
        if taken and put:
            away = [float(np.linalg.norm(q - taken[0])) for q in put]
            assert away[0] < 3.0
            assert away[0] <= min(away) + 0.5
