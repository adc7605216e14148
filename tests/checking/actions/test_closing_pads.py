"""What pads turn, or draw along, as they close: it meets things on its way, and is put down as it lies then."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.checking import check
from tamp.checking.actions.closing_pads import note_turned_over
from tamp.checking.scene import Scene, State
from tamp.task import (
    Action,
    At,
    Attachment,
    Box,
    Cylinder,
    Grip,
    Move,
    Object,
    Plan,
    Pose,
    Release,
    Shape,
    Sphere,
    Task,
    load_robot,
)
from tests.checking.handmade import DOWN, OPEN, Hand, above

HOME = load_robot("panda").home
BAR = Box((0.2, 0.02, 0.04))


def carried(red: Object, goal: Pose, width: float, T_object_tool: Pose, on: str, *others: Object) -> str:
    """What the checker says of a plan that picks red from the table and puts it on something."""
    hand, held = Hand(HOME), Attachment("red", T_object_tool.inverse())
    take, leave = red.pose @ T_object_tool, goal @ T_object_tool
    rests, comes = frozenset({("red", "table")}), frozenset({("red", on)})
    steps = [
        Move("transit", hand.free(above(take)), OPEN),
        Move("approach", hand.line(take), OPEN),
        Grip(held, width),
        Move("lift", hand.line(above(take)), width, held, rests),
        Move("transfer", hand.free(above(leave)), width, held),
        Move("lower", hand.line(leave), width, held, comes),
        Release("red", goal, OPEN),
        Move("retreat", hand.line(above(leave)), OPEN),
    ]
    named = [("move", steps[:1]), ("pick", steps[1:4]), ("move", steps[4:5]), ("place", steps[5:])]
    if on != "table":
        named[-1] = ("stack", steps[5:])
    actions = tuple(Action(name, () if name == "move" else ("red",), tuple(done)) for name, done in named)
    task = Task("carried", (replace(red, goal=At(goal)), *others))
    plan = Plan("carried", "panda", 0, {o.name: o.pose for o in task.objects}, HOME, {"red": goal}, actions)
    return " ".join(problem.sentence for problem in check(task, plan).problems)


def askew(degrees: float) -> tuple[Pose, float]:
    """T_object_tool of a hand that points down on the bar, turned about the vertical, and how wide that is for it."""
    angle = np.radians(degrees)
    turned = Pose.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, angle)) @ Pose((0.0, 0.0, 0.0), DOWN)
    return turned, float(0.02 * np.cos(angle) + 0.012 * np.sin(angle))


@pytest.mark.parametrize(("degrees", "met"), [(0.0, False), (6.0, True), (-6.0, True)])
def test_what_pads_turn_until_it_lies_flush_meets_what_stands_beside_its_ends(degrees, met):
    """PyBullet: dominoes lay 88 to 107 mm off."""
    start, goal = Pose((0.05, -0.2, 0.02)), Pose((0.05, 0.2, 0.02))
    domino = Box((0.04, 0.006, 0.1))
    dominoes = [Object(f"domino{y}", domino, Pose((0.13, -0.2 + y, 0.05)), mass=0.05) for y in (-0.019, 0.019)]
    grip, width = askew(degrees)
    said = carried(Object("red", BAR, start), goal, width, grip, "table", *dominoes)
    assert (said != "") == met
    assert ("closing pads turn, or draw, red into domino" in said) == met


@pytest.mark.parametrize(("degrees", "tips"), [(0.0, False), (6.0, False), (11.0, True)])
def test_what_pads_turn_is_put_down_as_it_lies_then(degrees, tips):
    """PyBullet: where it was turned by 11 degrees one end came down beside its post, 61 mm off."""
    start, goal = Pose((0.05, -0.2, 0.02)), Pose((0.05, 0.2, 0.08))
    posts = [Object(f"post{x}", Box((0.012, 0.012, 0.06)), Pose((0.05 + x, 0.2, 0.03))) for x in (-0.09, 0.09)]
    grip, width = askew(degrees)
    said = carried(Object("red", BAR, start), goal, width, grip, "post-0.09", *posts)
    assert (said != "") == tips
    assert ("tips over as it lies where closing pads have turned it" in said) == tips


@pytest.mark.parametrize(("friction", "slips"), [(0.02, True), (0.03, True), (0.05, False)])
def test_fingers_squeeze_out_what_is_as_slippery_as_ice(friction, slips):
    """PyBullet: 25 grams of it came out of the closing pads, 0.4 to 1.3 m off; with 0.05 it ends where it should."""
    start, goal = Pose((0.05, -0.2, 0.03)), Pose((0.05, 0.2, 0.03))
    red = Object("red", Box((0.04, 0.04, 0.06)), start, friction=friction, mass=0.025)
    said = carried(red, goal, 0.04, Pose((0.0, 0.0, 0.0), DOWN), "table")
    assert (said != "") == slips
    assert ("red slips out of the fingers, whose friction with it is below 0.04" in said) == slips


@pytest.mark.parametrize(
    ("shape", "turn"), [(Sphere(0.02), (0.0, 0.0, 0.0)), (Cylinder(0.02, 0.06), (0.0, np.pi / 2, 0.0))]
)
@pytest.mark.parametrize(("aside", "rolls"), [(-0.0018, True), (0.0, False), (0.0018, False)])
def test_what_pads_draw_along_pushes_nothing_that_rolls(shape: Shape, turn, aside, rolls):
    """PyBullet and MuJoCo: what stood 0.3 mm beside it rolled 38 mm to a metre away."""
    start, goal = Pose((0.05, -0.2, 0.03)), Pose((0.05, 0.2, 0.03))
    other = Object("round", shape, Pose.from_rpy((0.05, -0.2403, 0.02), turn), mass=0.05)
    grip = Pose((0.0, aside, 0.022), DOWN)
    said = carried(Object("red", Box((0.03, 0.04, 0.06)), start), goal, 0.04, grip, "table", other)
    assert (said != "") == rolls
    assert ("closing pads turn, or draw, red into round" in said) == rolls


@given(
    yaw=st.floats(-0.05, 0.05),
    aside=st.tuples(st.floats(-0.005, 0.005), st.floats(-0.005, 0.005)),
    turn=st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5)),
)
@settings(max_examples=20, deadline=None)
def test_what_turns_over_beside_where_it_is_said_to_lies_as_far_aside(yaw, aside, turn):
    box = Object("box", Box((0.05, 0.1, 0.2)), Pose((0.1, 0.2, 0.1)))
    scene = Scene.of(Task("falls", (box,)))
    moved = Pose.from_rpy((*aside, 0.0), (0.0, 0.0, yaw)).matrix
    before, after = box.pose.matrix, Pose.from_rpy((0.15, 0.2, 0.05), (*turn, 0.0)).matrix
    state = State({"box": after}, np.zeros(7))
    note_turned_over(scene, state, "box", moved @ before, before, after)
    assert np.abs(state.stayed.get("box", after) - moved @ after).max() < 2e-4
