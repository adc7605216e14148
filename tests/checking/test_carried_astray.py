"""What stands on something that is elsewhere than a plan says, by shifts that are each within tolerance."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tamp.checking import check
from tamp.task import At, Box, Object, Plan, Pose, Task, load_robot
from tests.checking.handmade import Hand, carry

HOME = load_robot("panda").home


@pytest.mark.parametrize(("by", "within", "wrong"), [(1.9e-3, 3e-3, True), (1.9e-3, 6e-3, False), (0.0, 3e-3, False)])
def test_what_was_let_go_aside_twice_carries_nothing_on_its_edge(by, within, wrong):
    """A block is put down twice where it is not said to stand; what is put on its edge falls off it in a simulator."""
    hand, actions = Hand(HOME), []
    block, box = Box((0.06, 0.05, 0.06)), Box((0.04, 0.04, 0.05))
    stands, first = Pose((0.05, 0.0, 0.03)), Pose((0.05, -0.25, 0.025))
    start = stands
    for _ in range(2):
        *before, place = carry(hand, "block", stands, stands, 0.05, ("table", "table"))
        stands = Pose((stands.xyz[0] + by, *stands.xyz[1:]))
        lower, release, leave = place.steps
        actions += [*before, replace(place, steps=(lower, replace(release, pose=stands), leave))]
    goal = Pose((stands.xyz[0] + 0.03 - within, 0.0, 0.085))
    actions += carry(hand, "box", first, goal, 0.04, ("table", "block"), grip_height=0.0)
    task = Task("astray", (Object("block", block, start), Object("box", box, first, At(goal))))
    plan = Plan("astray", "panda", 0, {"block": start, "box": first}, HOME, {"box": goal}, tuple(actions))
    found = " ".join(problem.sentence for problem in check(task, plan).problems)
    assert ("box tips over where block stays" in found) == wrong, found


@pytest.mark.parametrize(("by", "gap", "wrong"), [(1.9e-3, 1.5e-3, True), (1.9e-3, 6e-3, False), (0.0, 1.5e-3, False)])
def test_what_was_let_go_aside_is_met_where_it_stands(by, gap, wrong):
    """A domino is let go twice beside where it is said to stand; what is put down there pushes it over."""
    hand, actions = Hand(HOME), []
    domino, box = Box((0.012, 0.05, 0.1)), Box((0.04, 0.05, 0.06))
    stands, first = Pose((0.05, 0.0, 0.05)), Pose((0.05, -0.25, 0.03))
    start = stands
    for _ in range(2):
        *before, place = carry(hand, "domino", stands, stands, 0.05, ("table", "table"), grip_height=0.03)
        stands = Pose((stands.xyz[0] + by, *stands.xyz[1:]))
        lower, release, leave = place.steps
        actions += [*before, replace(place, steps=(lower, replace(release, pose=stands), leave))]
    goal = Pose((stands.xyz[0] - 0.026 - gap, 0.0, 0.03))
    actions += carry(hand, "box", first, goal, 0.05, ("table", "table"))
    task = Task("astray", (Object("domino", domino, start), Object("box", box, first, At(goal))))
    plan = Plan("astray", "panda", 0, {"domino": start, "box": first}, HOME, {"box": goal}, tuple(actions))
    found = " ".join(problem.sentence for problem in check(task, plan).problems)
    assert ("box meets domino" in found or "box and domino" in found) == wrong, found


@pytest.mark.parametrize(("across", "wrong"), [(1.8e-3, True), (0.0, False)])
def test_what_pads_have_drawn_along_carries_nothing_on_its_edge(across, wrong):
    hand, block, box = Hand(HOME), Box((0.06, 0.05, 0.06)), Box((0.04, 0.04, 0.05))
    start, stands, first = Pose((0.05, -0.1, 0.03)), Pose((0.05, 0.1, 0.03)), Pose((0.05, -0.3, 0.025))
    goal = Pose((0.05, 0.1 + 0.025 - 0.0015, 0.085))
    actions = [
        *carry(hand, "block", start, stands, 0.05, ("table", "table"), across=across),
        *carry(hand, "box", first, goal, 0.04, ("table", "block"), grip_height=0.0),
    ]
    task = Task("drawn", (Object("block", block, start, At(stands)), Object("box", box, first, At(goal))))
    goals = {"block": stands, "box": goal}
    plan = Plan("drawn", "panda", 0, {"block": start, "box": first}, HOME, goals, tuple(actions))
    found = " ".join(problem.sentence for problem in check(task, plan).problems)
    assert ("box may be 1.8 mm aside" in found) == wrong, found
