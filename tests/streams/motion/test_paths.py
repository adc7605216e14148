from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from tamp.streams.motion.inverse_kinematics import inverse_kinematics
from tamp.streams.motion.paths import ENDS, plan_free_motion, plan_holding_motion
from tamp.streams.values import Configuration, Grasp, Placement
from tamp.task import Box, Object, Pose
from tamp.world.motion.paths import densify
from tamp.world.scene import Scene
from tests.streams.tables import CUBE, RED, ToldContext, at, panda, workspace_of

FROM_ABOVE = Grasp(Pose.from_rpy((0.0, 0.0, 0.02), (np.pi, 0.0, 0.0)), 0.05)
HOME = Configuration(tuple(panda().spec.home), panda().spec.gripper.stroke)
WALL = Object("wall", Box((0.3, 0.03, 0.25)), Pose((0.05, 0.0, 0.125)))


@pytest.fixture(scope="module")
def walled():
    return workspace_of(RED, WALL, CUBE)


@pytest.fixture(scope="module")
def ends(walled):
    """Lifted with the red box at its start and at its goal, either side of the wall."""
    found = []
    for placement in (walled.start["red"], walled.goals["red"]):
        _, lifted, _ = next(inverse_kinematics(ToldContext(walled), "red", placement, FROM_ABOVE))
        found.append(lifted)
    return found


def facts(workspace, *names):
    return tuple(at(name, workspace.start[name]) for name in names)


def assert_free(checker, path):
    assert all(checker.edge_free(a, b, 0.02) for a, b in pairwise(path))


def test_a_free_motion_goes_from_start_to_goal_round_what_stands_there(walled, ends):
    context = ToldContext(walled, fluents=facts(walled, "wall", "cube"))
    (path,) = plan_free_motion(context, *ends)
    assert tuple(path.points[0]) == ends[0].q
    assert tuple(path.points[-1]) == ends[1].q
    scene = Scene({"wall": WALL.pose.matrix, "cube": CUBE.pose.matrix}, opening=0.05)
    assert_free(walled.world.checker(scene, margin=0.0), path.points)


def test_a_holding_motion_carries_the_object_round_what_stands_there(walled, ends):
    context = ToldContext(walled, fluents=facts(walled, "wall"))
    (path,) = plan_holding_motion(context, "red", FROM_ABOVE, *ends)
    assert tuple(path.points[0]) == ends[0].q
    assert tuple(path.points[-1]) == ends[1].q
    scene = Scene({"wall": WALL.pose.matrix}).attached("red", FROM_ABOVE.T_object_tool.inverse().matrix, 0.05)
    assert_free(walled.world.checker(scene, margin=0.0), path.points)


def test_what_is_held_keeps_away_from_what_stands_there(walled, ends):
    """It may slip in the fingers."""
    (path,) = plan_holding_motion(ToldContext(walled, fluents=facts(walled, "wall")), "red", FROM_ABOVE, *ends)
    scene = Scene({"wall": WALL.pose.matrix}).attached("red", FROM_ABOVE.T_object_tool.inverse().matrix, 0.05)
    assert_free(walled.world.checker(scene, margin=0.0, held_margin=0.009), path.points)


def test_what_turns_in_the_fingers_has_room_for_that(walled, ends, monkeypatch):
    planned = FROM_ABOVE.T_object_tool.inverse()
    turned = planned @ Pose.from_rpy((0.0, 0.0, 0.0), (0.6, 0.0, 0.0))
    monkeypatch.setattr("tamp.streams.motion.paths.hanging", lambda *asked: turned)
    (path,) = plan_holding_motion(ToldContext(walled, fluents=facts(walled, "wall")), "red", FROM_ABOVE, *ends)
    for T_tool_object in (planned, turned):
        scene = Scene({"wall": WALL.pose.matrix}).attached("red", T_tool_object.matrix, 0.05)
        assert_free(walled.world.checker(scene, margin=0.0), path.points)


def test_where_there_is_no_room_to_turn_it_is_carried_as_planned(walled, ends, monkeypatch):
    monkeypatch.setattr("tamp.streams.motion.paths.hanging", lambda *asked: Pose((0.0, 0.0, 0.3)))  # in the table
    context = ToldContext(walled, fluents=facts(walled, "wall"))
    assert list(plan_holding_motion(context, "red", FROM_ABOVE, *ends)) and not context.reasons


def test_what_is_held_comes_nearer_where_it_has_to(walled, ends):
    start, goal = ends
    T_tool_object = FROM_ABOVE.T_object_tool.inverse().matrix
    lifted = walled.world.robot.forward(np.array(start.q)) @ T_tool_object
    half = RED.shape.size[0] / 2 + CUBE.shape.size[0] / 2
    beside = Pose((lifted[0, 3] + half + 0.005, lifted[1, 3], lifted[2, 3]))
    scene = Scene({"cube": beside.matrix}).attached("red", T_tool_object, 0.05)
    assert walled.world.checker(scene, held_margin=0.01).contact(np.array(start.q)) is not None
    spacious = Scene({"cube": beside.matrix, "wall": WALL.pose.matrix}).attached("red", T_tool_object, 0.05)
    for seed in range(6):  # and only there
        fluents = (at("cube", Placement(beside, ("table",))), *facts(walled, "wall"))
        (path,) = plan_holding_motion(ToldContext(walled, seed, fluents=fluents), "red", FROM_ABOVE, start, goal)
        away = [q for q in densify(path.points) if min(np.linalg.norm(q - np.array(end.q)) for end in ends) > ENDS]
        assert away and all(map(walled.world.checker(spacious, held_margin=0.009).free, away))


def test_what_is_held_is_not_in_its_own_way(walled, ends):
    context = ToldContext(walled, fluents=facts(walled, "red"))
    assert list(plan_holding_motion(context, "red", FROM_ABOVE, ends[0], ends[0]))


def test_the_same_generator_gives_the_same_path(walled, ends):
    first, second = (
        next(plan_free_motion(ToldContext(walled, 5, fluents=facts(walled, "wall")), *ends)).points for _ in range(2)
    )
    assert np.array_equal(first, second)


@pytest.mark.parametrize("blocked", [0, 1])
def test_only_what_stands_at_an_end_of_the_motion_is_blamed(walled, ends, blocked):
    tool = panda().forward(np.array(ends[blocked].q))
    palm = tool[:3, 3] - 0.06 * tool[:3, 2]
    block = at("cube", Placement(Pose(tuple(palm)), ("table",)))
    context = ToldContext(walled, fluents=(*facts(walled, "wall"), block))
    assert list(plan_free_motion(context, *ends)) == []
    (reason,) = context.reasons
    assert "cube" in reason
    assert ("start", "goal")[blocked] in reason
    assert context.causes == [(block,)]


def test_after_the_deadline_nothing_is_searched(walled, ends):
    context = ToldContext(walled, seconds=-1.0)
    assert list(plan_free_motion(context, HOME, ends[0])) == []


@pytest.mark.parametrize(("gap", "moves"), [(0.0015, True), (0.0003, True), (-0.0004, True), (-0.003, False)])
def test_an_arm_that_stands_beside_something_or_against_it_moves_on(walled, ends, gap, moves):
    # A block under a finger: nearer than planned motions come, or a little in it.
    start = np.array(HOME.q)
    tool = panda().forward(start)
    finger = tool[:3, 3] + tool[:3, :3] @ np.array(panda().spec.gripper.axis) * (HOME.opening / 2 + 0.005)

    def block(height):
        return Placement(Pose((finger[0], finger[1], height)), ("table",))

    def distance(height):
        poses = {"cube": block(height).pose.matrix}
        return walled.world.checker(Scene(poses, opening=HOME.opening)).distance(start)

    low, high = float(tool[2, 3]) - 0.06, float(tool[2, 3])
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if distance(middle) > gap else (low, middle)
    assert distance(low) == pytest.approx(gap, abs=2e-4)
    context = ToldContext(walled, fluents=(*facts(walled, "wall"), at("cube", block(low))))
    assert bool(list(plan_free_motion(context, HOME, ends[0]))) == moves


def test_what_bars_the_start_of_a_motion_is_found_out_once_for_all_its_ends(walled, ends, monkeypatch):
    """The cube stands where red is held; whatever the hand may go to, it does not get away from there."""
    asked = []
    plan = type(walled.world.motions).plan
    monkeypatch.setattr(
        type(walled.world.motions), "plan", lambda self, *args, **how: asked.append(args) or plan(self, *args, **how)
    )
    barred = Placement(Pose((RED.pose.xyz[0], RED.pose.xyz[1], 0.12)), ("table",))
    for goal in (ends[1], HOME, ends[0]):
        context = ToldContext(walled, fluents=(at("cube", barred),))
        assert not list(plan_holding_motion(context, "red", FROM_ABOVE, ends[0], goal))
        (reason,) = context.reasons
        assert "the start is in collision" in str(reason) and "cube" in str(reason)
    assert len(asked) == 1
