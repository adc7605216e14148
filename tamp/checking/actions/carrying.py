"""Rules of what a hand does that carries: pick, move, place, and lay, which lets go of what then falls."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise, takewhile
from typing import TYPE_CHECKING

from tamp.checking.actions.collisions.pairs import FREE
from tamp.checking.actions.fall import falls_straight
from tamp.checking.actions.rule import carry_out, has_steps, named_apart, needs_empty_hand, needs_in_hand, stands_on
from tamp.checking.geometry.pad_region import between_pads
from tamp.checking.geometry.transforms import inverse
from tamp.checking.physics.support import carriers
from tamp.checking.scene import TABLE
from tamp.task.plan import Fall, Grip, Move, Release

if TYPE_CHECKING:
    from tamp.checking.replay import Replay
    from tamp.task.plan import Action, Step


@dataclass(frozen=True)
class Transport:
    """The arm moves without touching anything, its hand empty or with the object that the action names."""

    def check(self, replay: Replay, action: Action) -> None:
        """Judge the motion."""
        if has_steps(replay, action):
            if action.arguments:
                needs_in_hand(replay, action.arguments[0])
            named_apart(replay, action, "", FREE, ())
            for step in action.steps:
                carry_out(replay, step)


@dataclass(frozen=True)
class Pick:
    """The hand closes on an object and lifts it off what the action names.

    Attributes:
        from_table: whether that is the table, or else an object, of which the action need not tell the name.
    """

    from_table: bool

    def check(self, replay: Replay, action: Action) -> None:
        """Judge grip and lift; afterwards the object is held."""
        if not has_steps(replay, action, "grip"):
            return
        named_apart(replay, action, "grip", ("approach", "transit"), ("lift", "transfer"))
        if needs_empty_hand(replay, action) and action.arguments:
            self._check_place(replay, *action.arguments)
        for before, step in zip((None, *action.steps), action.steps, strict=False):
            carry_out(replay, step if isinstance(before, Grip) else _in_between(step, "lift"))

    def _check_place(self, replay: Replay, name: str, *named: str) -> None:
        if name not in replay.state.poses:
            return
        _check_kind(replay, name, self.from_table)
        stands_on(replay, name, named)


@dataclass(frozen=True)
class Place:
    """The hand lets go of what it holds, which stands on what the action names.

    Attributes:
        on_table: whether that is the table, or else an object, of which the action need not tell the name.
        falls: whether the object falls over, or down, when it is let go.
    """

    on_table: bool
    falls: bool = False

    def check(self, replay: Replay, action: Action) -> None:
        """Judge release and fall; afterwards the hand is empty and away."""
        if not has_steps(replay, action, "release", *(("drop",) if self.falls else ())):
            return
        named_apart(replay, action, "release", ("lower", "transfer"), ("retreat", "transit"))
        name = action.arguments[0] if action.arguments else ""
        if name in replay.state.poses:
            needs_in_hand(replay, name)
        falling = next((step.object for step in action.steps if isinstance(step, Fall)), "")
        if falling:
            _check_prompt(replay, action)
        steps = list(action.steps)
        while steps:
            step = steps.pop(0)
            lowers = any(isinstance(after, Release) for after in steps[:1])
            carry_out(replay, step if lowers else _in_between(step, "lower"), falls=falling)
            if falling in replay.state.poses and isinstance(step, Release):
                steps = _as_it_falls(replay, steps)
        if name in replay.state.poses and replay.state.held is None:
            _check_kind(replay, name, self.on_table)
            stands_on(replay, name, action.arguments[1:])
            _check_clear(replay, name)


def _in_between(step: Step, phase: str) -> Step:
    """A step as what it is where it is a motion of a phase, and not the one at the grip or at the release.

    Only the one that follows the grip lifts an object off what it touches, and only the one before the release lowers
    it: bounds of such motions are not for each of many.
    """
    if isinstance(step, Move) and step.phase == phase:
        return replace(step, phase="transfer", contacts=frozenset())
    return step


def _check_kind(replay: Replay, name: str, on_table: bool) -> None:
    """An object stands on the table, or on an object or leaning on one, as the action's name has it."""
    touching = carriers(replay.scene, replay.state, name, replay.allow)
    under, objects = touching.bodies, [other for other in sorted(touching.patches) if other != TABLE]
    if on_table and under and TABLE not in under:
        replay.report("precondition", f"{name} stands on {', '.join(under)}, not on the table", (name, *under))
    if not on_table and under and not objects:
        replay.report("precondition", f"{name} stands on the table, not on an object", (name,))


def _check_prompt(replay: Replay, action: Action) -> None:
    """What is let go falls at once, or as the fingers that it leans on leave: nothing else comes in between."""
    steps = [step for step in action.steps if not isinstance(step, Move) or step.phase != "retreat"]
    if not any(isinstance(a, Release) and isinstance(b, Fall) for a, b in pairwise(steps)):
        replay.report("fall", "what is let go falls at once, not after other motions")
    waited = 0.0
    for before, step in pairwise(action.steps):
        waited = 0.0 if isinstance(before, Release) else waited
        if isinstance(step, Move):
            waited += step.trajectory.duration
        if isinstance(step, Fall) and waited > replay.allow.leaving:
            replay.report("fall", f"what is let go falls at once, not {waited:.1f} s later")


def _as_it_falls(replay: Replay, steps: list[Step]) -> list[Step]:
    """The steps after a release in the order in which they happen.

    What falls straight leans on nothing, and has fallen before the hand moves.
    """
    state = replay.state
    moves = list(takewhile(lambda step: isinstance(step, Move), steps))
    fall = steps[len(moves)] if len(moves) < len(steps) else None
    if not isinstance(fall, Fall) or not moves:
        return steps
    if falls_straight(state.poses[fall.object], fall.pose.matrix):
        return [fall, *moves, *steps[len(moves) + 1 :]]
    return steps


def _check_clear(replay: Replay, name: str) -> None:
    """After letting go, the gripper has left: the object is no longer between the pads."""
    tree = replay.scene.links.tree
    T_tool_object = inverse(tree.tool(replay.state.q[None])[0]) @ replay.state.poses[name]
    gripper, depth = tree.spec.gripper, tree.pad_depth(tree.spec.gripper.stroke)
    if between_pads(replay.scene.solids[name], T_tool_object, gripper, gripper.stroke, depth) is not None:
        replay.report("release", f"the gripper does not retreat from {name}", (name,))
