from __future__ import annotations

import pytest

from tamp.checking import check
from tamp.task import Action, Box, Move, Object, Plan, Pose, Task
from tests.checking.handmade import DOWN, OPEN, Hand, above, two_boxes

HOME = two_boxes()[1].home
TOP, TIP = 0.05, 0.00885  # of the box, and of the fingers under the tool's point [m]


def brushing(depth, along):
    """A finger of the open hand comes down on a box until it is so deep in it, and goes along it so far [m]."""
    box = Object("red", Box((0.05, 0.05, TOP)), Pose((0.05, 0.045, TOP / 2)))
    hand, z = Hand(HOME), TOP + TIP - depth
    first, last = Pose((0.05, 0.0, z), DOWN), Pose((0.05 + along, 0.0, z), DOWN)
    ways = [hand.free(above(first, 0.1)), hand.line(first), hand.line(last), hand.line(above(last, 0.1))]
    action = Action("move", (), tuple(Move("transit", way, OPEN) for way in ways))
    return Task("brush", (box,)), Plan("brush", "panda", 0, {"red": box.pose}, HOME, {}, (action,))


@pytest.mark.parametrize(
    ("depth", "along", "taken"), [(0.0006, 0.06, True), (0.0006, 0.002, False), (0.0, 0.06, False)]
)
def test_what_the_hand_presses_on_as_it_slides_over_it_comes_along(depth, along, taken):
    found = [problem.sentence for problem in check(*brushing(depth, along)).problems]
    assert any("finger presses on red as it slides over it" in sentence for sentence in found) == taken
