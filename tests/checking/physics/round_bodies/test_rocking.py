from __future__ import annotations

import numpy as np
import pytest

from tamp.checking import check
from tamp.checking.physics.round_bodies.rocking import rocked
from tamp.checking.scene import Scene, State
from tamp.checking.tolerances import DEFAULT
from tamp.task import At, Box, Object, Plan, Pose, Task, load_robot
from tests.checking.handmade import Hand, carry
from tests.checking.mutations.solids import half_round

R = 0.05
YAW = Pose.from_rpy((0.1, 0.0, 0.0), (0.0, 0.0, 0.4))


def found(*things: Object) -> list[str]:
    state = State({o.name: (YAW @ o.pose).matrix for o in things}, np.zeros(7))
    scene = Scene.of(Task("rocking", tuple(things)))
    return [sentence for sentence, _ in rocked(scene, state, sorted(state.poses), DEFAULT)]


def on_its_back(high: float, mass: float, aside: float = 0.0, **also) -> list[str]:
    load = Object("load", Box((0.04, 0.06, high)), Pose((0.0, aside, R + high / 2)), mass=mass)
    return found(Object("half", half_round(R, 0.1, up=False), Pose((0.0, 0.0, R)), mass=0.3), load, *also.values())


@pytest.mark.parametrize(
    ("high", "mass", "aside", "tips"),
    [(0.1, 0.6, 0.0, True), (0.02, 0.01, 0.0, False), (0.02, 0.2, 0.015, True), (0.08, 0.05, 0.0, False)],
)
def test_a_half_round_on_its_back_tips_under_what_is_too_high_or_aside(high, mass, aside, tips):
    assert bool(on_its_back(high, mass, aside)) == tips


def test_what_something_else_holds_does_not_tip():
    wall = Object("wall", Box((0.1, 0.02, 0.12)), Pose((0.0, R + 0.01, 0.06)), mass=2.0)
    assert not on_its_back(0.1, 0.6, wall=wall)


@pytest.mark.parametrize(("aside", "tips"), [(0.0, False), (0.012, True), (-0.012, True)])
def test_a_load_beside_the_middle_tips_a_plank_on_a_round_top(aside, tips):
    half = Object("half", half_round(R, 0.1, up=True), Pose((0.0, 0.0, 0.0)))
    plank = Object("plank", Box((0.05, 0.2, 0.01)), Pose((0.0, 0.0, R + 0.005)), mass=0.1)
    load = Object("load", Box((0.03, 0.04, 0.06)), Pose((0.0, aside, R + 0.04)), mass=0.2)
    assert bool(found(half, plank, load)) == tips


@pytest.mark.parametrize("side", [0.03, 0.006])
def test_towers_stand(side):
    boxes = [Object(f"box{k}", Box((side, side, 0.02)), Pose((0.0, 0.0, 0.01 + 0.02 * k))) for k in range(3)]
    assert not found(*boxes)


@pytest.mark.parametrize("taken", ["put", "take"])
def test_loads_are_neither_put_nor_taken_so_that_the_rest_tips(taken):
    """One of two loads on a plank over a round top is taken away, or put there."""
    at = {"red": Pose((0.05, 0.163, R + 0.04)), "other": Pose((0.05, 0.137, R + 0.04))}
    free = Pose((0.05, -0.25, 0.03))
    start, goal = (at["red"], free) if taken == "take" else (free, at["red"])
    things = [
        Object("red", Box((0.03, 0.022, 0.06)), start, At(goal), mass=0.2),
        Object("plank", Box((0.05, 0.2, 0.01)), Pose((0.05, 0.15, R + 0.005)), mass=0.1),
        Object("half", half_round(R, 0.12, up=True), Pose((0.05, 0.15, 0.0)), mass=1.0),
    ]
    if taken == "take":
        things.append(Object("other", Box((0.03, 0.022, 0.06)), at["other"], mass=0.2))
    under = ("plank", "table") if taken == "take" else ("table", "plank")
    home = load_robot("panda").home
    actions = carry(Hand(home), "red", start, goal, 0.022, under)
    plan = Plan("loads", "panda", 0, {o.name: o.pose for o in things}, home, {"red": goal}, tuple(actions))
    said = " ".join(problem.sentence for problem in check(Task("loads", tuple(things)), plan).problems)
    assert "plank does not keep its balance on half" in said
    assert "at the start" not in said
