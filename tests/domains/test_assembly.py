from dataclasses import replace
from itertools import islice, pairwise

import numpy as np
import pytest

from tamp.domains.tabletop import DOMAIN
from tamp.domains.timing import NotFree
from tamp.planning import GroundAction
from tamp.streams.grasping.sampler import sample_grasp
from tamp.streams.motion.inverse_kinematics import inverse_kinematics
from tamp.streams.motion.paths import plan_free_motion, plan_holding_motion
from tamp.streams.values import Configuration
from tamp.task import Box, Grip, Move, Object, Pose, Release
from tests.streams.tables import CUBE, RED, ToldContext, at, panda, workspace_of

HOME = Configuration(tuple(panda().spec.home), panda().spec.gripper.stroke)


@pytest.fixture(scope="module")
def workspace():
    return workspace_of(RED, CUBE)


def carried(workspace):
    """A solution: the red box from its start to its goal, values from the samplers."""
    start, goal = workspace.start["red"], workspace.goals["red"]
    for grasp in islice(sample_grasp(ToldContext(workspace), "red"), 10):
        there = next(inverse_kinematics(ToldContext(workspace), "red", start, grasp), None)
        here = next(inverse_kinematics(ToldContext(workspace), "red", goal, grasp), None)
        if there is not None and here is not None:
            break
    assert there is not None
    assert here is not None
    (before, lifted, picking), (after, lowered, placing) = there, here
    cube = at("cube", workspace.start["cube"])
    context = ToldContext(workspace, fluents=(cube, at("red", start)))
    (empty,) = plan_free_motion(context, HOME, before)
    (full,) = plan_holding_motion(ToldContext(workspace, fluents=(cube,)), "red", grasp, lifted, lowered)
    return (
        GroundAction("move-free", (HOME, before, empty)),
        GroundAction("pick", ("red", start, grasp, before, lifted, picking)),
        GroundAction("move-holding", ("red", grasp, lifted, lowered, full)),
        GroundAction("place", ("red", goal, grasp, after, lowered, placing)),
    )


@pytest.fixture(scope="module")
def solution(workspace):
    return carried(workspace)


@pytest.fixture(scope="module")
def actions(workspace, solution):
    return DOMAIN.timed(workspace, solution)


def moves(actions):
    return [step for action in actions for step in action.steps if isinstance(step, Move)]


def test_actions_keep_their_names_and_say_what_they_are_about(actions):
    assert [str(action) for action in actions] == ["move()", "pick(red, table)", "move(red)", "place(red, table)"]


def test_the_steps_come_in_the_order_in_which_hands_do_them(actions):
    told = [step.phase if isinstance(step, Move) else type(step).__name__ for a in actions for step in a.steps]
    assert told == ["transit", "approach", "Grip", "lift", "transfer", "lower", "Release", "retreat"]


def test_each_motion_begins_where_the_last_one_ended_and_stands_still_at_both_ends(actions):
    assert np.allclose(moves(actions)[0].trajectory.positions[0], HOME.q)
    for before, after in pairwise(moves(actions)):
        assert np.allclose(before.trajectory.positions[-1], after.trajectory.positions[0], atol=1e-9)
    for move in moves(actions):
        assert np.allclose(move.trajectory.velocities[[0, -1]], 0.0)
        assert (np.diff(move.trajectory.times) > 0).all()


def test_positions_and_speeds_keep_the_robots_limits(actions):
    spec = panda().spec
    for move in moves(actions):
        assert (move.trajectory.positions >= np.array(spec.lower) - 1e-6).all()
        assert (move.trajectory.positions <= np.array(spec.upper) + 1e-6).all()
        assert (np.abs(move.trajectory.velocities) <= np.array(spec.velocity) * 1.001).all()


def test_what_is_gripped_is_held_until_it_is_released_at_the_goal(actions, workspace, solution):
    steps = [step for action in actions for step in action.steps]
    (grip,) = (step for step in steps if isinstance(step, Grip))
    (release,) = (step for step in steps if isinstance(step, Release))
    grasp = solution[1].args[2]
    assert grip.attachment.object == release.object == "red"
    assert np.allclose((grasp.T_object_tool @ grip.attachment.T_tool_object).matrix, np.eye(4), atol=1e-9)
    assert grip.width == grasp.width
    assert release.pose == workspace.goals["red"].pose
    for move in moves(actions):
        holding = move.phase in ("lift", "transfer", "lower")
        assert move.held == (grip.attachment if holding else None)


def test_only_what_must_touch_may_touch(actions):
    allowed = {move.phase: move.contacts for move in moves(actions)}
    assert allowed["transit"] == allowed["transfer"] == frozenset()
    assert allowed["approach"] == allowed["retreat"] == {("robot", "red")}
    assert allowed["lift"] == allowed["lower"] == {("red", "table"), ("red", "cube")}


def test_a_motion_through_something_is_not_free(workspace, solution):
    wall = Object("wall", Box((0.4, 0.03, 0.6)), Pose((0.05, 0.0, 0.3)))
    blocked = workspace_of(RED, CUBE, wall)
    with pytest.raises(NotFree, match=r"^transit: .*touches something"):
        DOMAIN.timed(blocked, solution)


def test_an_action_of_another_domain_is_a_bug(workspace, solution):
    with pytest.raises(ValueError, match="no action 'push'"):
        DOMAIN.timed(workspace, [replace(solution[0], name="push")])
