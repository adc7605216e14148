"""What has no goal and stands where another shall be: it has to leave, and excuses nobody."""

from __future__ import annotations

import pytest

from tamp.checking import check
from tamp.task import At, Box, Object, Plan, Pose, Task
from tests.checking.handmade import Hand, carry, two_boxes
from tests.checking.judging import kinds

HOME = two_boxes()[1].home
CUBE = Box((0.04, 0.04, 0.06))
GOAL = Pose((0.05, 0.1, 0.03))


def idle(task: Task, **poses: Pose) -> Plan:
    """A plan that does nothing and takes objects to be at their goals."""
    start = {thing.name: thing.pose for thing in task.objects}
    return Plan(task.name, "panda", 0, start, HOME, {**{"red": start["red"]}, **poses}, ())


@pytest.mark.parametrize("thick", [0.01, 0.03, 0.05])
def test_what_stands_on_something_at_its_goal_is_not_there(thick):
    slab = Object("slab", Box((0.1, 0.06, thick)), Pose((*GOAL.xyz[:2], thick / 2)))
    red = Object("red", CUBE, Pose((*GOAL.xyz[:2], 0.03 + thick)), At(GOAL))
    task = Task("upon", (red, slab))
    assert kinds(task, idle(task)) == {"goal"}
    assert kinds(task, idle(task, red=GOAL)) == {"goal"}


@pytest.mark.parametrize("beside", [0.012, 0.02])
def test_what_stands_beside_something_at_its_goal_is_not_there(beside):
    block = Object("block", CUBE, Pose((GOAL.xyz[0] - 0.04 + beside, *GOAL.xyz[1:])))
    red = Object("red", CUBE, Pose((GOAL.xyz[0] + beside, *GOAL.xyz[1:])), At(GOAL))
    task = Task("beside", (red, block))
    assert kinds(task, idle(task)) == {"goal"}


@pytest.mark.parametrize(("over", "accepted"), [(0.004, True), (0.009, False)])
def test_what_has_stood_there_from_the_beginning_pushes_a_goal_aside_by_rounding(over, accepted):
    block = Object("block", Box((0.04, 0.04, 0.06)), Pose((GOAL.xyz[0] - 0.04 + over, *GOAL.xyz[1:])), mass=5.0)
    red = Object("red", CUBE, Pose((GOAL.xyz[0] + over, *GOAL.xyz[1:])), At(GOAL))
    task = Task("rounded", (red, block))
    assert check(task, idle(task)).accepted is accepted


@pytest.mark.parametrize("thick", [0.02, 0.04])
def test_what_a_plan_puts_where_another_shall_be_does_not_raise_that(thick):
    """Put there first, a box carries what is stacked on it; the task's goal is on the table all the same."""
    start, aside = Pose((0.05, -0.25, 0.03)), Pose((0.15, -0.1, thick / 2))
    red = Object("red", CUBE, start, At(GOAL))
    box = Object("box", Box((0.05, 0.05, thick)), aside)
    under, top = Pose((*GOAL.xyz[:2], thick / 2)), Pose((*GOAL.xyz[:2], thick + 0.03))
    hand = Hand(HOME)
    actions = [
        *carry(hand, "box", aside, under, 0.05, ("table", "table")),
        *carry(hand, "red", start, top, 0.04, ("table", "box")),
    ]
    task = Task("raised", (red, box))
    plan = Plan("raised", "panda", 0, {"red": start, "box": aside}, HOME, {"red": top}, tuple(actions))
    assert "goal" in kinds(task, plan)
