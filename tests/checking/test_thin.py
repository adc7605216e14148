"""Bodies of a millimetre: half of what two of them are thick together is less than what counts as rounding."""

from __future__ import annotations

import math

import pytest

from tamp.checking import check
from tamp.task import Action, Attachment, Box, Grip, Mesh, Move, Object, Plan, Pose, Release, Task, load_robot
from tests.checking.handmade import Hand, above, two_boxes
from tests.task.meshes import parts_obj

HOME = load_robot("panda").home
ALONG = Pose((0.0, 0.0, 0.0)) @ Pose.from_rpy((0, 0, 0), (math.pi, 0, math.pi / 2))
CARD, OPENING = 0.001, 0.03


def standing_wall(path, height: float) -> Mesh:
    """A wall of a millimetre across x that stands on a foot."""
    foot, wall = ((-0.03, -0.06, 0.0), (0.03, 0.06, 0.005)), ((-0.0005, -0.06, 0.0), (0.0005, 0.06, height))
    path.write_text(parts_obj([foot, wall]), encoding="utf-8")
    return Mesh(path)


def slot(path) -> Mesh:
    """A foot, and two cheeks that keep a card upright between them."""
    foot = ((-0.03, -0.03, 0.0), (0.03, 0.03, 0.01))
    cheeks = [((0.00075, -0.03, 0.0), (0.03, 0.03, 0.04)), ((-0.03, -0.03, 0.0), (-0.00075, 0.03, 0.04))]
    path.write_text(parts_obj([foot, *cheeks]), encoding="utf-8")
    return Mesh(path)


def said(tmp_path, height: float, goal: Pose, through: tuple[Pose, ...] = (), on: str = "wall", aside: float = 0.0):
    """What is said of a card that is taken from one slot, led somewhere near a wall, and put on something."""
    start, tall = Pose((0.1, -0.2, 0.08)), 0.14
    wall = Pose((0.03 + aside, 0.2, 0.0))
    things = (
        Object("card", Box((CARD, 0.06, tall)), start, mass=0.05),
        Object("slot", slot(tmp_path / "slot.obj"), Pose((0.1, -0.2, 0.0)), mass=1.0),
        Object("other", slot(tmp_path / "other.obj"), Pose((-0.1, 0.2, 0.0)), mass=1.0),
        Object("wall", standing_wall(tmp_path / "wall.obj", height), wall, mass=1.0),
    )
    hand, grip = Hand(HOME), Pose((0.0, 0.0, 0.06)) @ ALONG
    held = Attachment("card", grip.inverse())
    leaves, comes = (frozenset({("robot", "card"), ("card", other)}) for other in ("slot", on))
    go = Move("transit", hand.free(above(start @ grip)), OPENING)
    reach = Move("approach", hand.line(start @ grip), OPENING, contacts=leaves)
    lift = Move("lift", hand.line(above(start @ grip)), CARD, held, leaves)
    first, *rest = (*through, Pose((*goal.xyz[:2], goal.xyz[2] + 0.05)))
    carry = [Move("transfer", hand.free(first @ grip), CARD, held)]
    carry += [Move("transfer", hand.line(at @ grip), CARD, held) for at in rest]
    lower = Move("lower", hand.line(goal @ grip), CARD, held, comes)
    leave = Move("retreat", hand.line(above(goal @ grip)), OPENING, contacts=comes)
    actions = (
        Action("move", (), (go,)),
        Action("unstack", ("card",), (reach, Grip(held, CARD), lift)),
        *(Action("move", (), (move,)) for move in carry),
        Action("stack", ("card",), (lower, Release("card", goal, OPENING), leave)),
    )
    plan = Plan("thin", "panda", 0, {thing.name: thing.pose for thing in things}, HOME, {}, actions)
    return [problem.sentence for problem in check(Task("thin", things), plan).problems]


@pytest.mark.parametrize(("height", "wrong"), [(0.1, True), (0.02, False)])
def test_a_card_is_not_led_with_its_face_through_a_wall_as_thin(tmp_path, height, wrong):
    """It is nowhere deeper in the wall than a millimetre, and comes out on the other side."""
    through = (Pose((0.11, 0.2, 0.12)), Pose((-0.05, 0.2, 0.12)), Pose((-0.1, 0.2, 0.15)))
    found = said(tmp_path, height, Pose((-0.1, 0.2, 0.08)), through, on="other")
    assert any("card and wall interpenetrate" in sentence for sentence in found) == wrong, found
    assert bool(found) == wrong, found


def test_a_card_does_not_stand_in_a_wall_as_thin(tmp_path):
    found = said(tmp_path, 0.1, Pose((0.03, 0.2, 0.075)))
    assert "card stands 1.0 mm inside wall" in found


@pytest.mark.parametrize(("above_it", "wrong"), [(0.0, True), (0.0003, True), (0.001, False)])
def test_cards_do_not_lie_in_each_other(above_it, wrong):
    card = Box((0.1, 0.08, CARD))
    heights = (CARD / 2, CARD / 2 + above_it)
    things = tuple(Object(f"card{i}", card, Pose((0.1, 0.2, z))) for i, z in enumerate(heights))
    plan = Plan("pile", "panda", 0, {thing.name: thing.pose for thing in things}, two_boxes()[1].home, {}, ())
    assert bool(check(Task("pile", things), plan).problems) == wrong
