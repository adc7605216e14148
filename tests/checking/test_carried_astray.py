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
    assert ("box may be 3.8 mm aside" in found) == wrong, found
