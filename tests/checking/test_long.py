"""What is long: a turn within tolerance takes its ends farther than shifts may come to."""

from __future__ import annotations

import numpy as np
import pytest

from tamp.checking import check
from tamp.task import Action, At, Attachment, Box, Grip, Move, Object, Plan, Pose, Release, Task, Trajectory
from tests.checking.handmade import DOWN, OPEN, Hand, above, two_boxes
from tests.checking.mutations.editing import shifted

HOME = two_boxes()[1].home
TURN = 0.019
"""Less than a grip, or a release, may be off [rad]."""
ACROSS = (np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0)
"""Orientation of a tool that points down, its fingers before and behind it."""
CLEAR = 0.25
FRONT = 0.0264
"""Of closed fingers beside the tool [m]."""


def turned(pose: Pose, angle: float) -> Pose:
    return Pose.from_rpy(pose.xyz, (0.0, 0.0, angle))


def moved(hand: Hand, grip: Pose, lies: Pose, said: Pose, end: Pose, rests: Pose, width: float, opened: float):
    """Pick up what `lies` there, and is said to once gripped, and let go of it at `end`, where it is said to rest."""
    tool, on = lies @ grip, frozenset({("red", "table"), ("plank", "table")})
    name = "plank" if width < 0.02 else "red"
    held = Attachment(name, tool.inverse() @ said)
    over = end @ held.T_tool_object.inverse()
    reach = Move("transit", hand.turned(above(tool, CLEAR)), OPEN)
    down = Move("approach", hand.line(tool), OPEN)
    lift = Move("lift", hand.line(above(tool, CLEAR)), width, held, on)
    carry = Move("transfer", hand.turned(above(over, CLEAR)), width, held)
    lower = Move("lower", hand.line(over), width, held, on)
    leave = Move("retreat", hand.line(above(over, CLEAR)), opened)
    return [
        Action("move", (), (reach,)),
        Action("pick", (name,), (down, Grip(held, width), lift)),
        Action("move", (name,), (carry,)),
        Action("place", (name,), (lower, Release(name, rests, opened), leave)),
    ]


def said_of(things: list[Object], actions: list[Action], goals: dict[str, Pose]) -> str:
    things = [Object(o.name, o.shape, o.pose, At(goals[o.name]) if o.name in goals else None, o.mass) for o in things]
    plan = Plan("long", "panda", 0, {o.name: o.pose for o in things}, HOME, goals, tuple(actions))
    return " ".join(problem.sentence for problem in check(Task("long", tuple(things)), plan).problems)


@pytest.mark.parametrize("angle", [0.0, TURN])
def test_what_is_long_meets_in_the_hand_what_its_ends_meet(angle):
    """It is said to turn as the fingers close: a domino beside its end lay 153 mm off in PyBullet and MuJoCo."""
    lies, end = Pose((0.0, 0.0, 0.03)), Pose((0.12, 0.0, 0.03))
    bar = Object("red", Box((0.03, 0.7, 0.06)), lies, mass=0.3)
    domino = Object("domino", Box((0.01, 0.05, 0.2)), Pose((0.1435, 0.3, 0.1)))
    grip = Pose((0.0, 0.0, 0.0), ACROSS)
    actions = moved(Hand(HOME), grip, lies, turned(lies, angle), end, end, 0.03, OPEN)
    said = said_of([bar, domino], actions, {"red": end})
    assert (said != "") == (angle > 0.0)
    assert ("domino meets red" in said) == (angle > 0.0)


@pytest.mark.parametrize("angle", [0.0, TURN])
def test_what_is_long_is_met_where_its_ends_were_let_go(angle):
    """It is said to turn as it is let go: put down beside its end, a block knocked it over, 59 and 74 mm off."""
    lies, end, thin = Pose((-0.02, 0.0, 0.04)), Pose((0.1, 0.0, 0.04)), 0.008
    plank = Object("plank", Box((thin, 0.5, 0.08)), lies, mass=0.05)
    beside = 0.1 + thin / 2 - 0.23 * np.tan(angle) + 0.021
    start, goal = Pose((0.2, -0.1, 0.02)), Pose((beside, 0.23, 0.02))
    block = Object("red", Box((0.04, 0.02, 0.04)), start, mass=0.3)
    hand, rests = Hand(HOME), turned(end, angle)
    actions = [
        *moved(hand, Pose((0.0, 0.0, 0.03), ACROSS), lies, lies, end, rests, thin, OPEN),
        *moved(hand, Pose((0.0, 0.0, 0.012), DOWN), start, start, goal, goal, 0.02, 0.03),
    ]
    said = said_of([plank, block], actions, {"plank": rests, "red": goal})
    assert (said != "") == (angle > 0.0)
    assert ("red meets plank" in said) == (angle > 0.0)


@pytest.mark.parametrize("angle", [0.0, TURN])
def test_what_is_long_is_pushed_as_it_lies(angle):
    """It is said to turn as the push begins: its end pushed a domino by 2 mm in PyBullet, 6 mm in MuJoCo."""
    lies, by = Pose((0.05, 0.0, 0.02)), np.array([0.0, 0.08, 0.0])
    plank = Object("plank", Box((0.5, 0.06, 0.04)), lies, mass=0.2)
    ends = turned(shifted(lies, by), angle)
    ahead = 0.11 - 0.2 * np.tan(angle) + 0.0006
    domino = Object("domino", Box((0.02, 0.008, 0.25)), Pose((-0.17, ahead + 0.004, 0.125)))
    hand, tool = Hand(HOME), Pose((0.05, -0.03 - FRONT + 0.002, 0.02), DOWN)
    back = shifted(tool, np.array([0.0, -0.03, 0.0]))
    go = Move("transit", hand.free(above(back)), 0.0)
    reach = [Move("approach", hand.line(to), 0.0) for to in (back, tool)]
    way = hand.line(shifted(tool, by))
    way = Trajectory(way.times * 3, way.positions, way.velocities / 3)
    pushed = Attachment("plank", tool.inverse() @ turned(lies, angle))
    push = Move("push", way, 0.0, None, frozenset({("plank", "table")}), pushed)
    leave = [Move("retreat", hand.line(shifted(to, by)), 0.0) for to in (back, above(back))]
    actions = [Action("move", (), (go,)), Action("slide", ("plank", "table"), (*reach, push, *leave))]
    said = said_of([plank, domino], actions, {"plank": ends})
    assert (said != "") == (angle > 0.0), said
    assert ("plank is said to be turned" in said) == (angle > 0.0), said
