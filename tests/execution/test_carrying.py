import numpy as np
import pytest

from tamp.execution.carrying import can_carry
from tamp.execution.settling import settle
from tamp.task import Attachment, Box, Grip, Object, Pose, Task, load_robot
from tamp.world.geometry import load_geometry
from tamp.world.robot_model import robot_model
from tamp.world.world import World
from tests.execution.planning_by_hand import DOWN, HandPlanner

BOARD = Object("board", Box((0.03, 0.12, 0.03)), Pose((0.1, 0.2, 0.015)))
POST = Object("post", Box((0.02, 0.02, 0.1)), Pose((0.1, -0.11, 0.05)))
GOAL = Pose((0.1, -0.2, 0.015))
TASK = Task("board and post", (BOARD, POST))


AS_PLANNED = Pose()


def carried(turn=AS_PLANNED, post=POST.pose):
    """Whether the board, which `turn` took from where it should lie in the hand, can be carried past the post."""
    poses = dict(settle(TASK).poses)
    hand = HandPlanner(TASK, poses)
    hand.pick("board", DOWN, 0.03)
    hand.place(GOAL)
    steps = [step for action in hand.plan().actions for step in action.steps]
    grip = next(i for i, step in enumerate(steps) if isinstance(step, Grip))
    held = Attachment("board", turn @ steps[grip].attachment.T_tool_object)
    world = World(robot_model(load_robot("panda")), {o.name: load_geometry(o.shape) for o in TASK.objects}, TASK.table)
    return can_carry(world, {**poses, "post": post}, held, steps[grip + 1 :])


def test_what_lies_in_the_hand_as_planned_can_be_carried():
    assert carried()


def test_what_would_be_put_into_something_cannot():
    assert not carried(post=Pose((0.1, -0.2, 0.05)))


@pytest.mark.parametrize(("angle", "free"), [(0.0, True), (np.pi / 2, False)])
def test_the_object_counts_as_it_lies_in_the_hand_now(angle, free):
    assert carried(Pose.from_rpy((0, 0, 0), (0, 0, angle)), post=Pose((0.145, -0.2, 0.05))) == free


def test_the_table_does_not_count():
    assert carried(Pose((0.0, 0.0, 0.02)))
