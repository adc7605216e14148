"""Check of a nudge: a push of a few centimetres on or in what carries the object, by the tip of the hand at its flank.

A single contact keeps an object before it as long as the line from there to the centre of mass lies within its cone of
friction (Mason, International Journal of Robotics Research 5, 1986); what it presses down a little slides along all the
same, as friction under the object grows less than the push does.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.actions.arm_motion import check_move
from tamp.checking.actions.grip_and_release import check_righted
from tamp.checking.actions.left_standing import check_rest
from tamp.checking.actions.pushes.push import (
    aslant,
    check_path,
    check_stopped,
    direction,
    founded,
    sliding,
    tipping,
    touched_behind,
    unfollowed,
    watch,
)
from tamp.checking.geometry.transforms import inverse
from tamp.checking.physics.equilibrium import reach
from tamp.checking.physics.giving_way import lowered_onto
from tamp.checking.physics.stacks import Pushed, Stack, off_balance, stack_of
from tamp.checking.physics.support import balanced, carriers
from tamp.checking.scene import GRAVITY, TABLE, Scene, State

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from tamp.checking.actions.arm_motion import Report
    from tamp.checking.tolerances import Tolerances
    from tamp.task.plan import Attachment, Move

    Array = NDArray[np.float64]

LOOK = 0.001
"""How far an object goes between two looks at what carries it closely [m]."""
CLOSELY = 1e-4
"""What it touches for certain is no farther from it [m]; a notch of twice as much it catches in."""
SLIDES = 0.96
"""Share of friction that a linearised cone bears in each direction, and at which something as good as slides."""


def check_nudge(scene: Scene, state: State, move: Move, pushed: Attachment, allow: Tolerances, report: Report) -> None:
    """Judge a motion that nudges an object; afterwards the object rests where the hand has left it."""
    name, under = pushed.object, carriers(scene, state, pushed.object, allow).bodies
    move = founded(move, name, under)
    if unfollowed(scene, state, move, allow, report):
        return
    seen = watch(scene, move, pushed, allow, report)
    if seen is None:
        return
    path = check_path(scene, state, move, pushed, under, seen, allow, report)
    state.nudged[name] = state.nudged.get(name, 0.0) + float(np.linalg.norm(path[-1, :3, 3] - path[0, :3, 3]))
    wrong = (
        *_loose(scene, state, move, name, path, allow),
        *_dragged(scene, state, name, under, allow),
        *tipping(scene, state, move, name, seen, under, allow),
    )
    for sentence in wrong:
        report("push", sentence, bodies=(name,))
    touching = touched_behind(scene, move, name, path[0], direction(path), allow.nudge, allow).points
    check_move(scene, state, move, allow, report, seen, sliding(scene, state, name, under, path, allow))
    for sentence in _tips_in(scene, state, name, path, touching, under, allow):
        report("push", sentence, bodies=(name, *under))
    _check_way(scene, state, name, path, touching, allow, report)
    check_rest(scene, state, name, allow, report)

    def say(_: str, sentence: str, bodies: tuple[str, ...], depth: float = 0.0) -> None:
        report("push", sentence, bodies=bodies, depth=depth)

    check_righted(scene, state, name, path[-1], allow, say)
    if TABLE in under:  # what lies in something does not roll out of that
        check_stopped(scene, state, name, direction(path), allow, report)
    after = carriers(scene, state, name, allow).bodies
    if not {*after} & {*under}:
        report("push", f"{name} is nudged off {' and '.join(under) or 'nothing'}", bodies=(name, *under))


def _tips_in(
    scene: Scene, state: State, name: str, path: Array, touching: Array, under: tuple[str, ...], allow: Tolerances
) -> Iterator[str]:
    """Why an object would tip into a notch or a gap on its way, and not slide over it.

    What carries it is what it touches there as closely as where it began; that bears its weight, and the moment of a
    finger that touches it at places of shape (n, 3) and of the friction that it overcomes. (Contacts within what counts
    as standing would carry it over the bottom of a notch as deep as that.)
    """
    if not len(touching):
        return
    friction = scene.friction(name) * min((scene.friction(other) for other in under), default=0.0)
    low = (scene.solids[name].hull.part.vertices @ path[0, 2, :3] + path[0, 2, 3]).min()
    shift = friction * float(touching[:, 2].min() - low) * direction(path)
    closely = np.geomspace(CLOSELY, allow.standing, round(np.log2(allow.standing / CLOSELY)) + 1)
    tight = next((float(t) for t in closely if _carried(scene, state, name, path[0], shift, float(t), allow)), None)
    if tight is None:
        return
    for far in np.arange(LOOK, float(np.linalg.norm(path[-1, :3, 3] - path[0, :3, 3])), LOOK):
        T = path[0].copy()
        T[:3, 3] += far * direction(path)
        if not _carried(scene, state, name, T, shift, tight, allow):
            yield f"{name} would tip into what is lower {1000 * far:.0f} mm on its way, and catch there"
            return


def _carried(scene: Scene, state: State, name: str, T: Array, shift: Array, within: float, allow: Tolerances) -> bool:
    """Whether an object at T, come down on what it first touches, is carried by what is within a distance of it [m].

    With its centre of mass there, and as far ahead of that as a push, and friction, in effect `shift` it, shape (3,).
    """
    there = replace(state, poses={**state.poses, name: T}, touching={})
    there = lowered_onto(scene, there, name, allow.standing, allow)
    near = carriers(scene, there, name, replace(allow, standing=within))
    if not near.points or balanced(scene, there, name, near, allow, 0.0) < 0.0:
        return False
    far, points = float(np.linalg.norm(shift[:2])), np.concatenate(list(near.points.values()))
    center = scene.center_of_mass(name, there.poses[name])
    return far == 0.0 or reach(points[:, :2], center[:2], shift[:2] / far) >= far


def _check_way(
    scene: Scene, state: State, name: str, path: Array, touching: Array, allow: Tolerances, report: Report
) -> None:
    """The object, and what carries it, stay in balance all the way; afterwards the object is at the end.

    `touching` is where a finger touches it at first, shape (n, 3).
    """
    travel = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path[:, :3, 3], axis=0), axis=1))])
    for k in np.unique(np.searchsorted(travel, np.arange(0.0, travel[-1], allow.step))):
        state.poses[name] = path[k]
        if k and balanced(scene, state, name, carriers(scene, state, name, allow), allow) < 0.0:
            report("support", f"{name} loses its balance on its way", bodies=(name,))
            break
        at = path[k] @ inverse(path[0]) @ np.append(touching.mean(axis=0), 1.0) if len(touching) else None
        if at is not None and (tipped := _tipped(scene, state, name, direction(path), at[:3], allow)):
            sentence = f"{name} is nudged on what does not stay: that would tip over, or slide ({', '.join(tipped)})"
            report("support", sentence, bodies=(name, *tipped))
            break
    state.poses[name] = path[-1]


def _tipped(scene: Scene, state: State, name: str, ahead: Array, at: Array, allow: Tolerances) -> list[str]:
    """What loses its balance among all that an object stands on, as a finger pushes that `at` a place, shape (3,).

    Friction passes the push on to what carries it. What would roll or tip before the finger on anything that stays put
    is judged by its contacts alone.
    """
    under = carriers(scene, state, name, allow).bodies
    if under in ((), (TABLE,)):
        return []
    friction = scene.friction(name) * min(scene.friction(other) for other in under)
    force = SLIDES * friction * scene.task.object(name).mass * GRAVITY * ahead
    stack, push = stack_of(scene, state, name, allow), Pushed(name, force, at)
    alone = Stack((name,), {pair: patch for pair, patch in stack.touching.items() if name in pair})
    if off_balance(scene, state, alone, push).get(name, 0.0) > allow.balance:
        return []
    before, pushed = off_balance(scene, state, stack), off_balance(scene, state, stack, push)
    return [other for other, far in sorted(pushed.items()) if far > before.get(other, 0.0) + allow.balance]


def _loose(scene: Scene, state: State, move: Move, name: str, path: Array, allow: Tolerances) -> Iterator[str]:
    """Why a fingertip would not keep an object before it on all of its way."""
    ahead = direction(path)
    if state.nudged[name] > allow.nudged:
        far = f"{1000 * state.nudged[name]:.0f} mm since it was last gripped"
        yield f"{name} is nudged by {far}: nobody knows where it comes to rest"
    touching = touched_behind(scene, move, name, path[0], ahead, allow.nudge, allow)
    if not len(touching.points):
        yield f"no finger touches {name} on the side away from where it is nudged"
        return
    yield from aslant(scene, name, touching, ahead)
    lever = scene.center_of_mass(name, path[0]) - touching.points
    across = np.abs(lever @ [-ahead[1], ahead[0], 0.0])
    if not (across < np.tan(allow.push) * (lever @ ahead)).any():
        yield f"{name} would turn away: the finger does not press towards its centre of mass"


def _dragged(scene: Scene, state: State, name: str, under: tuple[str, ...], allow: Tolerances) -> Iterator[str]:
    """Why what an object lies in would come along with it, if it would."""
    for carrier in under:
        if carrier == TABLE:
            continue
        held = [
            scene.friction(carrier) * scene.friction(other) for other in carriers(scene, state, carrier, allow).bodies
        ]
        if scene.friction(name) * scene.friction(carrier) > min(held, default=0.0):
            yield f"{carrier} would come along when {name} is nudged in it"
