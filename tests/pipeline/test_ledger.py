import math
from dataclasses import replace

import pytest

from tamp.pipeline.asking import Asker
from tamp.pipeline.ledger import Ledger
from tamp.pipeline.progress import Progress
from tamp.task import At, Pose, Task
from tests.pipeline.test_ordering import BOARD, RED, attempt


def ledger(*objects):
    return Ledger(Asker(Progress(attempt(Task("goals", objects))), 0, math.inf, "adaptive"))


@pytest.mark.parametrize(("off", "near"), [(0.02, True), (0.04, False)])
def test_what_is_near_its_goal_counts_as_there_and_stands_at_it_from_then_on(off, near):
    x, y, z = RED.goal.pose.xyz
    goals = ledger(replace(RED, pose=Pose((x + off, y, z))))
    assert goals.reach_near(["red"]) is near
    assert (goals.reached, set(goals.left)) == (({"red"}, set()) if near else (set(), {"red"}))
    workspace = goals.asker.workspace
    assert (workspace.goals["red"] == workspace.start["red"]) is near


def test_what_can_be_grasped_is_not_given_up_while_others_are_far():
    near, far = (replace(RED, name=name, pose=Pose((x, -0.2, 0.04))) for name, x in (("near", 0.07), ("far", 0.25)))
    goals = ledger(near, replace(far, goal=At(Pose((0.25, 0.2, 0.04)))))
    goals.reach_hard_to_grasp()
    assert set(goals.left) == {"near", "far"}


@pytest.mark.parametrize(("off", "left"), [(0.2, ["red"]), (0.0, ["board", "red"])])
def test_what_lies_too_flat_for_any_hand_near_its_goal_stays_there_while_others_are_far(off, left):
    board = replace(BOARD, goal=At(Pose((-0.03, 0.3, 0.01))))
    red = replace(RED, pose=Pose((0.05, off - 0.2, 0.04)))
    goals = ledger(board, red)
    goals.reach_hard_to_grasp()
    assert list(goals.left) == left
