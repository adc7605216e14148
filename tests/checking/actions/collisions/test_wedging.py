from __future__ import annotations

from dataclasses import replace

import pytest

from tamp.checking import check
from tamp.task import At, Box, Mesh, Move, Object, Plan, Pose, Release, Task, load_robot
from tests.checking.handmade import OPEN, Hand, carry
from tests.task.meshes import parts_obj

HOME, OUTSIDE = load_robot("panda").home, Pose((0.05, 0.2, 0.04))
INSIDE = Pose((0.05, -0.2, 0.044))


def crate(path, half: float) -> Mesh:
    """A crate of 3.4 cm, as wide inside along x as fits twice `half` [m]."""
    walls = [
        ((-0.04, -0.04, 0.0), (0.04, 0.04, 0.004)),
        ((half, -0.04, 0.004), (0.04, 0.04, 0.04)),
        ((-0.04, -0.04, 0.004), (-half, 0.04, 0.04)),
        ((-half, -0.04, 0.004), (half, -0.034, 0.04)),
        ((-half, 0.034, 0.004), (half, 0.04, 0.04)),
    ]
    path.write_text(parts_obj(walls))
    return Mesh(path)


@pytest.mark.parametrize("way", ["out", "in"])
@pytest.mark.parametrize(
    ("narrow", "aside", "wrong"), [(0.0, 0.0, False), (1e-4, 0.0, True), (0.001, 0.0, True), (-0.001, 0.0014, False)]
)
def test_what_is_wedged_in_a_crate_is_neither_drawn_out_of_it_nor_put_into_it(tmp_path, way, narrow, aside, wrong):
    """What is pressed from one side alone gives way."""
    around = Object("crate", crate(tmp_path / "crate.obj", 0.025 - narrow), Pose((0.05 + aside, -0.2, 0.0)), mass=0.1)
    start, goal = (INSIDE, OUTSIDE) if way == "out" else (OUTSIDE, INSIDE)
    under = ("crate", "table") if way == "out" else ("table", "crate")
    red = Object("red", Box((0.05, 0.05, 0.08)), start, At(goal))
    actions = carry(Hand(HOME), "red", start, goal, 0.05, under, grip_height=0.02)
    starts = {"red": start, "crate": around.pose}
    plan = Plan("wedged", "panda", 0, starts, HOME, {"red": goal}, tuple(actions))
    said = " ".join(problem.sentence for problem in check(Task("wedged", (red, around)), plan).problems)
    assert ("red is wedged in crate" in said) == wrong
    assert bool(said) == wrong
    unsaid = [
        replace(a, steps=tuple(replace(s, contacts=frozenset()) if isinstance(s, Move) else s for s in a.steps))
        for a in actions
    ]
    found = check(Task("wedged", (red, around)), replace(plan, actions=tuple(unsaid))).problems
    assert not wrong or found, "it is wedged though nobody says that it touches the crate"


@pytest.mark.parametrize(("narrow", "wrong"), [(0.001, True), (0.0, True), (-0.0015, False)])
def test_nothing_drops_into_what_has_no_room_for_it(tmp_path, narrow, wrong):
    """In a simulator it gets stuck on top, or tilted."""
    around = Object("crate", crate(tmp_path / "crate.obj", 0.025 - narrow), Pose((0.05, -0.2, 0.0)), mass=0.2)
    above = Pose((0.05, -0.2, INSIDE.xyz[2] + 0.014))
    red = Object("red", Box((0.05, 0.05, 0.08)), OUTSIDE, At(INSIDE))
    actions = carry(Hand(HOME), "red", OUTSIDE, above, 0.05, ("table", "crate"), grip_height=0.02)
    lower, _, retreat = actions[-1].steps
    actions[-1] = replace(actions[-1], steps=(lower, Release("red", INSIDE, OPEN), retreat))
    starts = {"red": OUTSIDE, "crate": around.pose}
    plan = Plan("wedged", "panda", 0, starts, HOME, {"red": INSIDE}, tuple(actions))
    said = " ".join(problem.sentence for problem in check(Task("wedged", (red, around)), plan).problems)
    assert ("red gets stuck in crate" in said) == wrong
    assert bool(said) == wrong
