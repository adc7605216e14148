"""Checks of what is left standing: what has come to a place, and what stood by or on something that was taken away."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.geometry.solids import clearance
from tamp.checking.geometry.transforms import inverse
from tamp.checking.physics.giving_way import convex, let_down, lowered_onto, tips_over
from tamp.checking.physics.righting import lain
from tamp.checking.physics.round_bodies.perching import on_rollers, perched, pressed_away, round_axes
from tamp.checking.physics.round_bodies.rocking import rocked
from tamp.checking.physics.stacks import over_edge, stack_of, upset
from tamp.checking.physics.support import balanced, carriers, slumps, unrest
from tamp.checking.physics.yielding import given_way, gives_way, unbalanced
from tamp.checking.scene import TABLE, Given

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from tamp.checking.actions.arm_motion import Report
    from tamp.checking.scene import Scene, State
    from tamp.checking.tolerances import Tolerances

    Array = NDArray[np.float64]

STICKIER = 1.2
"""Times the friction that is given: what slides only where there is less, one simulator holds and another lets go."""


def check_uncovered(scene: Scene, state: State, name: str, allow: Tolerances, report: Report) -> None:
    """Nothing that stands on the object, leans on it, or is held down by it, may fall when it leaves.

    What stands on it may slump to where the rest carries it, and what it held up, or down, may come down as far. Where
    that is, is noted as what follows it.
    """
    beside = [other for other in sorted(state.poses) if other != name and _touches(scene, state, name, other, allow)]
    slumped = _slumped(scene, state, name, beside, allow, report)
    rest = state.without(name)
    steady = [other for other in beside if not slumped.intersection(stack_of(scene, rest, other, allow).names)]
    for falls in (upset, _upset_in_truth):
        for sentence, bodies, depth in falls(scene, state, rest, steady, allow):
            report("precondition", f"when {name} is taken away, {sentence}", bodies=(name, *bodies), depth=depth)
    under = {*carriers(scene, state, name, allow).bodies} - {TABLE}
    left, loaded = ({body for other in under for body in over_edge(scene, at, other, allow)} for at in (rest, state))
    for body in sorted(left - loaded - slumped):
        sentence = f"when {name} is taken away, {body} tips over: its load is on the edge of what carries it, or beyond"
        report("precondition", sentence, bodies=(name, body))
    for sentence, bodies in let_down(scene, state, rest, beside, allow):
        report("precondition", f"when {name} is taken away, {sentence}", bodies=(name, *bodies))
    firm = replace(allow, standing=allow.firm)
    held = [other for other in beside if _touches(scene, state, name, other, firm)]
    ends: dict[str, Array] = {}
    for sentence, bodies in _giving_way(scene, state, rest, held, ends, allow):
        report("precondition", f"when {name} is taken away, {sentence}", bodies=(name, *bodies))
    ends = _moved(scene, state, ends, allow.standing)  # gaps between them are slack
    for other in (other for other in beside if other not in slumped):
        if not _rolling(scene, state, other, allow, allow.slump):
            for sentence, bodies in _rolling(scene, rest, other, allow, allow.slump):
                report("precondition", f"when {name} is taken away, {sentence}", bodies=(name, *bodies))
            if (lies := lain(scene, rest, other, allow)) is not rest.poses[other]:
                ends[other] = lies
    ends |= {other: state.given[other].pose for other in slumped & state.given.keys()}
    state.follows |= _moved(scene, state, ends, allow.balance)
    state.follows.pop(name, None)
    state.came.discard(name)
    left = {body for other in steady for body in stack_of(scene, rest, other, allow).names}
    for sentence, bodies in rocked(scene, rest, sorted(left), allow):
        if not any(True for _ in rocked(scene, state, bodies[:1], allow)):
            report("precondition", f"when {name} is taken away, {sentence}", bodies=(name, *bodies))


def _giving_way(
    scene: Scene, before: State, after: State, names: Sequence[str], ends: dict[str, Array], allow: Tolerances
) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Which bodies give way with the stacks of certain bodies, one of which has left, as `gives_way` has it.

    What counts as touching within a millimetre is a broad strip of a face that slants, in which friction could hold
    what really turns about its edge: stacks of bodies of one piece must stay by what they certainly touch, too.
    """
    firm, certain = (replace(allow, standing=gap) for gap in (allow.firm, allow.touching))
    found = [*gives_way(scene, before, after, names, allow.sagged, firm, ends, (allow.standing,))]
    if not found:
        stacks = ((name, stack_of(scene, after, name, allow).names) for name in names)
        single = [name for name, stack in stacks if all(len(scene.solids[body].pieces) == 1 for body in stack)]
        found = [*gives_way(scene, before, after, single, allow.sagged, certain, wider=(allow.firm, allow.standing))]
    yield from found


def _moved(scene: Scene, state: State, ends: Mapping[str, Array], least: float) -> dict[str, Array]:
    """Of where objects come to that which is farther than `least` from where they are said to be [m]."""
    return {other: T for other, T in ends.items() if scene.displacement(other, state.poses[other], T) > least}


def _touches(scene: Scene, state: State, name: str, other: str, allow: Tolerances) -> bool:
    T = inverse(state.poses[name]) @ state.poses[other]
    return clearance(scene.solids[name], scene.solids[other], T, allow.contact) <= allow.standing


def _slumped(scene: Scene, state: State, name: str, beside: list[str], allow: Tolerances, report: Report) -> set[str]:
    """Those beside an object that do not stay as they are without it; how they have given way is noted."""
    slumped = set[str]()
    for other in beside:
        touching = carriers(scene, state, other, allow)
        if (
            name not in touching.patches
            or balanced(scene, state, other, touching.without(name), allow) >= allow.balance
        ):
            continue
        if name not in touching.bodies and balanced(scene, state, other, touching, allow) < allow.balance:
            continue  # it leans on nothing: it was no better off before
        slumped.add(other)
        given = slumps(scene, state, other, name, allow)
        if given is None:
            verb = "stands" if name in touching.bodies else "leans"
            report("precondition", f"{other} {verb} on {name}, which is taken away", bodies=(name, other))
        else:
            state.given[other] = given
    for other in sorted(state.given.keys() - {name, *slumped}):
        if name not in state.given[other].on:
            continue
        if (given := slumps(scene, state, other, name, allow)) is None:
            sentence = f"{other}, which has given way to {name}, falls when that is taken away too"
            report("precondition", sentence, bodies=(name, other))
        else:
            state.given[other] = given
    state.given.pop(name, None)
    return slumped


def _rolling(
    scene: Scene, state: State, name: str, allow: Tolerances, down: float | None = None
) -> list[tuple[str, tuple[str, ...]]]:
    """Why an object does not stay on what carries it, which rolls, or from which it rolls itself: sentence, bodies.

    `down` as in `perched`.
    """
    return [*perched(scene, state, name, allow, down), *on_rollers(scene, state, name, allow)]


def check_rest(scene: Scene, state: State, name: str, allow: Tolerances, report: Report) -> None:
    """An object that has come to a place stays there, and so does all that it now stands on or touches.

    Where they come to that give way under it, within tolerance, is noted.
    """
    for sentence, bodies, depth in unrest(scene, state, name, allow):
        report("support", sentence, bodies=bodies, depth=depth)
    stack = stack_of(scene, state, name, allow).names
    wrong = (_rolling(scene, state, name, allow), pressed_away(scene, state, name, allow))
    for sentence, bodies in (*wrong[0], *wrong[1], *rocked(scene, state, stack, allow)):
        report("support", sentence, bodies=bodies)
    for falls in (upset, _upset_in_truth):
        for sentence, bodies, depth in falls(scene, state.without(name), state, [name], allow):
            report("support", sentence, bodies=bodies, depth=depth)
    if tips_over(scene, state, name, allow):
        report("support", f"{name} tips over what it first touches, which does not carry it", bodies=(name,))
    for carrier in sorted({*carriers(scene, state, name, allow).bodies} - {TABLE}):
        for body in over_edge(scene, state, carrier, allow):
            sentence = f"{body} tips over: with {name} its load is on the edge of what carries it, or beyond"
            report("support", sentence, bodies=(body, name))
    _note_given_way(scene, state, name, allow, report)


def _note_given_way(scene: Scene, state: State, name: str, allow: Tolerances, report: Report) -> None:
    """What gives way under an object that has come to a place, within tolerance, is noted where it comes to.

    Of pieces that bulge nobody knows within a millimetre what touches: where there are any, what sets out from rest by
    itself tells nothing, but what does so only with the object on it does; and so does that the object itself
    goes on by more than plans and goals may err.
    """
    near, ends = replace(allow, standing=allow.touching), dict[str, "Array"]()
    before = state.without(name)
    if not convex(scene, state, name, allow):
        under = unbalanced(scene, state, name, near) - {name}
        if not any(other not in unbalanced(scene, before, other, near) for other in under):
            if _goes_on(scene, state, name, 2 * allow.reached, allow):
                sentence = f"{name} does not stay where it is let go: it slides or turns by more than"
                report("support", f"{sentence} {2000 * allow.reached:.0f} mm on what it comes down on", bodies=(name,))
            return
    for sentence, bodies in gives_way(
        scene, before, state, [name], allow.slump, near, ends, (allow.firm, allow.standing)
    ):
        report("support", sentence, bodies=bodies)
    given = _moved(scene, state, ends, allow.standing)
    state.follows |= given
    state.given |= {other: Given(T, frozenset()) for other, T in given.items()}


def _goes_on(scene: Scene, state: State, name: str, most: float, allow: Tolerances) -> bool:
    """Whether an object that comes down on others, which stay, slides or turns on by more than `most` [m].

    Its own shape says where it touches them. How near that is nobody knows for certain, so that it must go on by what
    is nearest alone as well as by all that is `firm`, and though friction were `STICKIER`, from rest at each step. What
    is round is held by facets that it has not: it is not asked.
    """
    if round_axes(scene, state, name):
        return False
    lowered, others = lowered_onto(scene, state, name, allow.standing, allow), frozenset(state.poses) - {name}
    things = (replace(thing, friction=STICKIER * thing.friction) for thing in scene.task.objects)
    sticky = replace(scene, task=replace(scene.task, objects=tuple(things)))
    for bodies, gap in product((scene, sticky), (allow.touching, allow.firm)):
        end = given_way(bodies, lowered, name, most, replace(allow, standing=gap), others)[name]
        if scene.displacement(name, lowered.poses[name], end) <= most:
            return False
    return True


def _upset_in_truth(
    scene: Scene, before: State, after: State, names: Sequence[str], allow: Tolerances
) -> Iterator[tuple[str, tuple[str, ...], float]]:
    """The same as `upset` where a body of those stacks is not where the plan says."""
    said = before.poses | after.poses
    far = {body for body, T in after.stayed.items() if scene.displacement(body, said[body], T) > allow.balance}
    if moved := sorted(far & {body for name in names for body in stack_of(scene, after, name, allow).names}):
        was, there = before.as_stayed(*moved), after.as_stayed(*moved)
        for sentence, bodies, depth in upset(scene, was, there, names, allow):
            yield f"{sentence}, where {moved[0]} is in truth, not where the plan says", bodies, depth
