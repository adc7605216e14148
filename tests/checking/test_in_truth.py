"""What is elsewhere than a plan says is pressed on, rubbed along and met there, whatever meets it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tamp.checking import check
from tamp.checking.actions.closing_pads import note_lies
from tamp.checking.actions.deviations import check_strayed
from tamp.checking.actions.fall import check_fall
from tamp.checking.scene import Scene, State
from tamp.checking.tolerances import DEFAULT
from tamp.task import Action, At, Box, Fall, Move, Object, Plan, Pose, Task, Trajectory, load_robot
from tests.checking.handmade import DOWN, OPEN, Hand, above, carry
from tests.checking.mutations.editing import shifted
from tests.checking.test_carried_astray import calm, let_go_aside

HOME = load_robot("panda").home
BESIDE, TIP, LEFT, RIGHT = 0.045, 0.00885, 0.0061, 0.0055
"""Of an open finger to the tool, of its tip under that, and of that tip to both sides of the tool [m]."""


def slowly(path: Trajectory, times: float = 6.0) -> Trajectory:
    return Trajectory(path.times * times, path.positions, path.velocities / times)


def led_along(thing: Object, aside: float, along: tuple[float, ...], depth: float = 6e-4) -> list[str]:
    """What is said of a finger that goes along y from place to place, on the top of a box by 4.5 mm of its edge.

    That is where the task has the box; said to start aside, along x, it would not be under the finger.
    """
    size, (x, y, z) = thing.shape.size, thing.pose.xyz
    tool = (x - size[0] / 2 - RIGHT + 0.0045, y - BESIDE, size[2] + TIP - depth)
    tops = [Pose((tool[0], tool[1] + by, tool[2]), DOWN) for by in along]
    hand = Hand(HOME)
    ways = [hand.free(above(tops[0])), *(hand.line(to) for to in (*tops, above(tops[-1])))]
    action = Action("move", (), tuple(Move("transit", slowly(way), OPEN) for way in ways))
    start = {thing.name: Pose((x + aside, y, z), thing.pose.quat)}
    plan = Plan("led", "panda", 0, start, HOME, {}, (action,))
    return [problem.sentence for problem in check(Task("led", (thing,)), plan).problems]


@pytest.mark.parametrize(("far", "taken"), [(0.08, True), (0.003, False)])
def test_what_stays_elsewhere_is_taken_along_by_what_slides_over_it_there(far, taken):
    box = Object("box", Box((0.06, 0.15, 0.06)), Pose((0.15, 0.09, 0.03)), mass=0.1)
    found = led_along(box, 0.0055, (-0.06, -0.06 + far))
    assert any("presses on box as it slides over it" in sentence for sentence in found) == taken, found
    assert bool(found) == taken, found


@pytest.mark.parametrize(("steps", "falls"), [(2, False), (5, True)])
def test_what_presses_goes_on_from_motion_to_motion_where_something_stays_elsewhere(steps, falls):
    """A finger drags the top of a domino along by 4.5 mm at a time: it lay 126 and 111 mm off in two simulators."""
    domino = Object("domino", Box((0.06, 0.02, 0.15)), Pose((0.15, 0.045, 0.075)), mass=0.1)
    found = led_along(domino, 0.0055, tuple(-0.01 + 0.0045 * np.arange(steps)), depth=9e-4)
    assert any("pushes domino, which rolls or tips over" in sentence for sentence in found) == falls, found
    assert bool(found) == falls, found


@pytest.mark.parametrize(
    ("gap", "domino_too", "claims", "wrong"),
    [
        (1.5e-3, False, False, True),
        (1.5e-3, False, True, True),
        (4.6e-3, False, True, False),
        (4.6e-3, True, False, True),
        (9e-3, True, False, False),
    ],
)
def test_what_is_astray_in_the_hand_meets_what_is_astray_whatever_a_plan_says_that_it_touches(
    gap, domino_too, claims, wrong
):
    """A box is let go twice aside, and so is a domino that it is put down beside: that lay 52 to 56 mm off in two."""
    hand, domino, box = Hand(HOME), Box((0.012, 0.05, 0.07)), Box((0.04, 0.05, 0.06))
    stood, first = Pose((0.05, 0.0, 0.035)), Pose((0.05, -0.25, 0.03))
    actions, stands = let_go_aside(hand, "domino", stood, 1.9e-3 * domino_too, grip_height=0.02)
    more, said = let_go_aside(hand, "box", first, -1.9e-3)
    goal = Pose((stands.xyz[0] - 0.026 - gap, 0.0, 0.03))
    *before, place = carry(hand, "box", said, goal, 0.05, ("table", "table"))
    touching = frozenset({("box", "domino")} if claims else ())
    steps = (replace(s, contacts=s.contacts | touching) if isinstance(s, Move) else s for s in place.steps)
    actions += [*more, *before, replace(place, steps=tuple(steps))]
    task = Task("astray", (Object("domino", domino, stood, mass=0.1), Object("box", box, first, At(goal))))
    plan = Plan("astray", "panda", 0, {"domino": stood, "box": first}, HOME, {"box": goal}, calm(actions))
    found = [problem.sentence for problem in check(task, plan).problems]
    assert any(" meets " in sentence for sentence in found) == wrong, found
    assert bool(found) == wrong, found


@pytest.mark.parametrize(("by", "gap", "wrong"), [(1.9e-3, 1.5e-3, True), (0.0, 1.5e-3, False), (1.9e-3, 6e-3, False)])
def test_what_drops_is_met_on_its_way_down_where_it_is_in_truth(by, gap, wrong):
    """A box drops by 12 mm beside a low slab, and onto its edge: 73 and 72 mm off in two simulators."""
    hand, box, first, goal = Hand(HOME), Box((0.04, 0.05, 0.1)), Pose((0.05, -0.25, 0.05)), Pose((0.05, 0.0, 0.05))
    actions, said = let_go_aside(hand, "box", first, -by, grip_height=0.03)
    *before, place = carry(hand, "box", said, above(goal, 0.012), 0.05, ("table", "table"), grip_height=0.03)
    lower, release, leave = place.steps
    actions += [*before, replace(place, steps=(lower, replace(release, pose=goal), leave))]
    slab = Object("slab", Box((0.06, 0.1, 0.008)), Pose((0.05 + 0.02 + gap + 0.03, 0.0, 0.004)), mass=0.3)
    starts = {"slab": slab.pose, "box": first}
    plan = Plan("drop", "panda", 0, starts, HOME, {"box": goal}, calm(actions))
    found = [p.sentence for p in check(Task("drop", (slab, Object("box", box, first, At(goal)))), plan).problems]
    assert any("box drops through slab" in sentence for sentence in found) == wrong, found
    assert bool(found) == wrong, found


@pytest.mark.parametrize(("astray", "gap", "wrong"), [("domino", 2e-3, True), ("box", 2e-3, True), (None, 2e-3, False)])
def test_what_turns_over_is_met_where_it_is_in_truth(astray, gap, wrong):
    """A box turns over its edge, and down beside a domino: one of them is nearer to the other than it is said to be."""
    half, tall = 0.03, 0.16
    box = Object("box", Box((0.06, 0.06, tall)), Pose((0.0, 0.0, tall / 2)))
    domino = Object("domino", Box((0.05, 0.01, 0.05)), Pose((half + 0.08, half + gap + 0.005, 0.025)))
    tipped = Pose.from_rpy((0.0, 0.0, 0.0), (0.0, 0.5, 0.0))
    state = State({"domino": domino.pose.matrix}, np.array(HOME), OPEN)
    edge = np.array([half, 0.0, 0.0])
    state.poses["box"] = tipped.matrix @ shifted(box.pose, -edge).matrix
    state.poses["box"][:3, 3] += edge
    for name, by in (("domino", -4e-3), ("box", 4e-3)):
        if name == astray:
            state.stayed[name] = state.poses[name].copy()
            state.stayed[name][1, 3] += by
    lies, found = Pose.from_rpy((half + tall / 2, 0.0, 0.03), (0.0, np.pi / 2, 0.0)), list[str]()
    scene = Scene.of(Task("over", (box, domino)))
    check_fall(
        scene, state, Fall("box", lies), DEFAULT, lambda _, sentence, **about: found.append(sentence), toppled=True
    )
    assert any("mm into domino" in sentence for sentence in found) == wrong, found
    assert bool(found) == wrong, found


@pytest.mark.parametrize(
    ("aside", "turn", "times"), [(9e-5, 0.0, 40), (0.0, 5e-4, 40), (9e-5, 0.0, 1), (1e-8, 0.0, 40)]
)
def test_the_least_ways_aside_and_turns_add_up(aside, turn, times):
    """Something long is let go where it lies, time and again, and said to lie by so little aside, or turned."""
    plank = Object("plank", Box((0.3, 0.05, 0.06)), Pose((0.05, 0.0, 0.03)))
    scene, said = Scene.of(Task("creeps", (plank,))), list[str]()
    state = State({"plank": plank.pose.matrix}, np.array(HOME), OPEN)
    for _ in range(times):
        held = state.poses["plank"]
        lies = Pose((aside, 0.0, 0.0)).matrix @ held @ Pose.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, turn)).matrix
        check_strayed(scene, state, "plank", held, lies, DEFAULT, lambda _, sentence, **about: said.append(sentence))
        state.poses["plank"] = lies
        note_lies(scene, state, "plank", held)
    truth = state.stayed.get("plank", state.poses["plank"])
    assert not said
    assert scene.displacement("plank", truth, plank.pose.matrix) < 2e-4
