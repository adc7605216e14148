"""Pairs of bodies that may meet in a motion, where a plan says that they are and where they are in truth.

Each is a body that stands, one that moves, and how deep this may be in that [m].
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.geometry.solids import clearance
from tamp.checking.geometry.transforms import inverse
from tamp.checking.physics.contacts import contacts
from tamp.checking.physics.support import carriers
from tamp.checking.robot.sweep import Looks, Mover, passed, standing, touches
from tamp.checking.scene import ROBOT, TABLE, Scene, State

if TYPE_CHECKING:
    from collections.abc import Iterator

    from tamp.checking.tolerances import Tolerances
    from tamp.task.plan import Move

    Pair = tuple[Mover, Mover, float]

FREE = ("transit", "transfer")
SLIDING = 2e-4
"""What is deeper than that presses [m]."""
BEARING = 2e-5
"""The same of what presses down on an object, which gives no way there [m].

A finger led over the top of a box, 0.1 mm in it, took it along by 88 mm in a simulator, 0.05 mm in it by 6 mm, 0.02 mm
by 3 mm; a domino fell in two simulators in each case.
"""
DOWN = -0.7
"""Vertical component of a normal into an object up to which it is pressed down."""


def pressing(scene: Scene, state: State, move: Move, found: Looks, allow: Tolerances) -> list[Pair]:
    """Pairs of bodies that are in each other at some look by more than rounding, and how deep they may be [m]."""
    carried = state.held or move.pushed
    moving = {body.solid.name: body for body in found.bodies[: len(scene.links.solids)]}
    taken = found.bodies[-1] if carried is not None else None
    others = standing(
        scene.solids, {o: T for o, T in state.standing(scene).items() if carried is None or o != carried.object}
    )
    near = passed(found.bodies, others)  # of a full table most are far from one motion
    return _slight(list(_pairs(scene, move, moving, taken, near, allow)), found)


def grazing(pairs: list[Pair], found: Looks) -> list[Pair]:
    """Those of pairs that are in each other by more than rounding, but no deeper than they may be."""
    met = {touch.bodies for touch in touches(pairs, found.swing)}
    return [pair for pair in _slight(pairs, found) if (pair[0].solid.name, pair[1].solid.name) not in met]


def presses_from(still: Mover, mover: Mover, allow: Tolerances) -> float:
    """How deep something that moves is in an object from where on that takes it along [m]: `SLIDING`, or `BEARING`."""
    for touch in touches([(still, mover, BEARING)]):
        pressing = {mover.solid.name: (mover.solid, mover.T[touch.sample])}
        patch = contacts(still.solid, still.T[0], pressing, allow.standing).patches.get(mover.solid.name)
        if patch is not None and patch.normals[:, 2].mean() < DOWN:
            return BEARING
    return SLIDING


def _slight(pairs: list[Pair], found: Looks) -> list[Pair]:
    """Those that are in each other by more than rounding, or deeper than they may be where that is less."""
    slight = touches(((a, b, min(depth, BEARING)) for a, b, depth in pairs), found.swing)
    named = {touch.bodies for touch in slight}
    return [pair for pair in pairs if (pair[0].solid.name, pair[1].solid.name) in named]


def astray(scene: Scene, state: State, move: Move, found: Looks, taken: Mover | None, allow: Tolerances) -> list[Pair]:
    """Pairs of bodies that come near each other, of which one or both are where they are in truth, and not as said.

    What is taken along may touch what it leaves, or comes to, and be in that as deep as where it rests; and as deep as
    the plan says, where it is lowered: deeper only by how much lower it is.

    Args:
        scene: the world.
        state: where everything stands.
        move: the motion.
        found: how that looks; what is taken along is the last of its bodies.
        taken: what is pushed, where it is in truth, if that is not where the plan says.
        allow: tolerances.
    """
    carried = state.held or move.pushed
    name = "" if carried is None else carried.object
    stayed = {other: T for other, T in state.stayed.items() if other != name}
    truth = taken or _hanging(state, found)
    if not stayed and truth is None:
        return []
    as_said = standing(scene.solids, {other: T for other, T in state.standing(scene).items() if other != name})
    in_truth = [] if truth is None else [truth]
    elsewhere = standing(scene.solids, stayed, astray=True)
    pairs = list[tuple[Mover, Mover]]()
    for movers, others in ((in_truth, as_said), ([*found.bodies, *in_truth], elsewhere)):
        if movers and others:
            pairs += [(other, mover) for other in passed(movers, others) for mover in movers]
    touched, planned = _touched(scene, state, move, name, allow), {other.solid.name: other for other in as_said}

    def depth(other: Mover, mover: Mover) -> float:
        if mover.solid.name != name or other.solid.name not in touched:
            return allow.collision
        if move.phase != "lower":
            return _resting_depth(move, other, mover, allow)
        as_planned = _resting_depth(move, planned[other.solid.name], found.bodies[-1], allow)
        return min(as_planned + _lower(found.bodies[-1], mover), allow.contact)

    return [(other, mover, depth(other, mover)) for other, mover in pairs]


def _lower(said: Mover, truth: Mover) -> float:
    """How much lower some point of a body ends than it is said to [m]."""
    corners, off = said.solid.hull.part.vertices, said.T[-1] - truth.T[-1]
    return float((corners @ off[2, :3] + off[2, 3]).max(initial=0.0))


def _touched(scene: Scene, state: State, move: Move, name: str, allow: Tolerances) -> set[str]:
    """What an object that is taken along touches by the plan's word, and what it is pushed on."""
    touched = {other for other in state.standing(scene) if _claimed(move, name, other)}
    if move.pushed is not None:  # it slides on what carries it, whether the plan says so or not
        touched |= {*carriers(scene, state, name, allow).bodies}
    return touched


def _hanging(state: State, found: Looks) -> Mover | None:
    """What is held where it hangs in truth: aside, lower, or turned, as it stood; None where that is as said."""
    if state.held is None or state.held.object not in state.stayed:
        return None
    said = found.bodies[-1]
    there = said.T @ inverse(said.T[0]) @ state.stayed[said.solid.name]
    return Mover(said.solid, np.ascontiguousarray(there), astray=True)


def _pairs(
    scene: Scene, move: Move, moving: dict[str, Mover], taken: Mover | None, others: list[Mover], allow: Tolerances
) -> Iterator[Pair]:
    robot = scene.links
    for other in others:
        for solid in robot.solids:
            if other.solid.name != TABLE or solid.name not in robot.fixed:
                pressed = solid.name in robot.gripper and _claimed(move, ROBOT, other.solid.name)
                yield other, moving[solid.name], allow.contact if pressed else allow.collision
        if taken is not None:
            sliding = _claimed(move, taken.solid.name, other.solid.name)
            yield other, taken, _resting_depth(move, other, taken, allow) if sliding else allow.collision
    for a, b in robot.pairs:
        yield moving[a.name], moving[b.name], allow.collision
    if taken is not None:
        for solid in robot.solids:
            yield moving[solid.name], taken, allow.contact if solid.name in robot.gripper else allow.collision


def _claimed(move: Move, body: str, other: str) -> bool:
    """Whether a motion's word that two bodies may touch counts: on a free motion it never does."""
    return move.phase not in FREE and bool({(body, other), (other, body)} & move.contacts)


def _resting_depth(move: Move, other: Mover, taken: Mover, allow: Tolerances) -> float:
    """Depth to which what is taken along may enter a body that it touches: no deeper than where it rests on it.

    It rests where a motion begins, but for one that lowers it.
    """
    T = inverse(other.T[0]) @ taken.T[-1 if move.phase == "lower" else 0]
    resting = -clearance(other.solid, taken.solid, T, allow.contact)
    return float(min(max(resting, 0.0) + allow.collision, allow.contact))
