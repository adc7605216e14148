"""A domain from outside brings its own rules."""

from __future__ import annotations

from dataclasses import dataclass, replace

import pytest

from tamp.checking import check
from tamp.checking.actions.rule import carry_out, has_steps, needs_empty_hand, stands_on
from tamp.checking.actions.tabletop import TABLETOP
from tamp.checking.geometry.solids import clearance
from tamp.checking.geometry.transforms import inverse
from tamp.task import Action, Box, Move, Object, Plan, Pose, Region, Task
from tests.checking.handmade import DOWN, Hand, above, two_boxes

BUTTON = Object("button", Box((0.04, 0.04, 0.03)), Pose((0.1, 0.0, 0.015)))
HOME = two_boxes()[1].home


@dataclass(frozen=True)
class Press:
    """The closed hand comes down on an object until a finger touches it, and leaves again."""

    def check(self, replay, action):
        if not (has_steps(replay, action) and needs_empty_hand(replay, action)):
            return
        name, pressed = action.arguments[0], False
        for step in action.steps:
            carry_out(replay, step)
            pressed |= self._touches(replay, name)
        if not pressed:
            replay.report("precondition", f"no finger touches {name}", (name,))
        replay.state.facts.add(("pressed", name))

    def _touches(self, replay, name):
        scene, state = replay.scene, replay.state
        placed = scene.links.tree.forward(state.q[None], state.opening)
        fingers = [link for link in scene.links.solids if link.name in scene.links.tree.spec.gripper.fingers]
        T = [inverse(state.poses[name]) @ placed[link.name][0] for link in fingers]
        return any(clearance(scene.solids[name], link, at, 0.004) < 0.002 for link, at in zip(fingers, T, strict=True))


@dataclass(frozen=True)
class Clean:
    """What stands in a region that washes is clean afterwards; the arm does not move."""

    def check(self, replay, action):
        if action.steps:
            replay.report("precondition", "cleaning moves nothing")
        if has_steps(replay, replace(action, steps=())):
            stands_on(replay, action.arguments[0], action.arguments[1:])
            replay.state.facts.add(("cleaned", action.arguments[0]))


@dataclass(frozen=True)
class Cook:
    """What is clean and stands on a stove is cooked afterwards."""

    def check(self, replay, action):
        name, stove = action.arguments
        stands_on(replay, name, (stove,))
        if ("cleaned", name) not in replay.state.facts:
            replay.report("precondition", f"{name} is not clean", (name,))


def pressing(height):
    """A plan that presses a button with the fingertips at a height above its top."""
    hand, tip = Hand(HOME), Pose((0.1, 0.0, 0.03 + height), DOWN)
    near = frozenset({("robot", "button")})
    steps = (
        Move("transit", hand.free(above(tip)), 0.0),
        Move("approach", hand.line(tip), 0.0, contacts=near),
        Move("retreat", hand.line(above(tip)), 0.0, contacts=near),
    )
    task = Task("press", (BUTTON,))
    return task, Plan("press", "panda", 0, {"button": BUTTON.pose}, HOME, {}, (Action("press", ("button",), steps),))


def test_without_a_rule_it_is_refused_and_with_one_it_is_judged():
    rules = {**TABLETOP, "press": Press()}
    tip = 0.0105  # the pads' centres are so much above the fingertips
    assert "no rule for action 'press'" in str(check(*pressing(tip)))
    assert check(*pressing(tip), rules=rules).accepted, str(check(*pressing(tip), rules=rules))
    assert "no finger touches button" in str(check(*pressing(0.05), rules=rules))


@pytest.mark.parametrize(
    ("names", "wrong"),
    [
        (("clean", "cook"), None),
        (("cook",), "is not clean"),
        (("clean", "fry"), "no rule for action 'fry'; it has: clean, cook"),
    ],
)
def test_motionless_actions_keep_facts(names, wrong):
    place = Region("hob", (0.1, 0.0), (0.2, 0.2))
    task = Task("kitchen", (BUTTON,), regions=(place,))
    actions = tuple(Action(name, ("button", "hob"), ()) for name in names)
    verdict = check(
        task,
        Plan("kitchen", "panda", 0, {"button": BUTTON.pose}, HOME, {}, actions),
        rules={"clean": Clean(), "cook": Cook()},
    )
    assert verdict.accepted if wrong is None else wrong in str(verdict)
