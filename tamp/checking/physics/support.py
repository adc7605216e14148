"""Does an object stay where it stands: carried, in balance, in nothing else, and when one of its supports leaves?"""

from __future__ import annotations

from dataclasses import replace
from heapq import heappop, heappush
from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.geometry.solids import clearance, crossed
from tamp.checking.geometry.transforms import inverse, turned
from tamp.checking.physics.contacts import Contacts, Patch, contacts
from tamp.checking.scene import TABLE, Given, State

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from tamp.checking.scene import Scene
    from tamp.checking.tolerances import Tolerances

    Array = NDArray[np.float64]


def carriers(scene: Scene, state: State, name: str, allow: Tolerances) -> Contacts:
    """What an object touches, and what of that carries it from below."""
    others = (other for other in state.standing(scene) if other != name)
    found = {other: patch_between(scene, state, name, other, allow) for other in others}
    return Contacts({other: patch for other, patch in found.items() if patch is not None})


def patch_between(scene: Scene, state: State, a: str, b: str, allow: Tolerances) -> Patch | None:
    """Where one standing body touches another, with normals into the first, or None; looked at once for two poses."""
    T_a, T_b = (scene.T_world_table if name == TABLE else state.poses[name] for name in (a, b))
    first, second = scene.solids[a], scene.solids[b]
    apart = T_a[:3, :3] @ first.center + T_a[:3, 3] - T_b[:3, :3] @ second.center - T_b[:3, 3]
    if apart @ apart > (first.radius + second.radius + allow.standing) ** 2:
        return None
    known = state.touching.get((a, b))
    if known is None or known[0] is not T_a or known[1] is not T_b:
        deep = max(2 * allow.standing, allow.sinking)
        patch = contacts(first, T_a, {b: (second, T_b)}, allow.standing, deep).patches.get(b)
        state.touching[a, b] = T_a, T_b, patch
        state.touching[b, a] = T_b, T_a, None if patch is None else Patch(patch.points, -patch.normals)
    return state.touching[a, b][2]


def unrest(scene: Scene, state: State, name: str, allow: Tolerances) -> Iterator[tuple[str, tuple[str, ...], float]]:
    """Why an object does not stay where it stands: sentence, bodies, depth [m]."""
    yield from overlaps(scene, state, name, allow)
    carried = carriers(scene, state, name, allow)
    if not carried.bodies:
        yield f"{name} stands in the air: nothing carries it", (name,), 0.0
        return
    for where, far in misplaced(scene, state, name, allow):
        yield f"{name} stands {where}, with what carries it", (name, *carried.bodies), far
    balance = sunk_balance(scene, state, name, allow, allow.balance)
    if balance < allow.balance:
        outside = "on the edge of" if balance >= 0.0 else f"{-1000 * balance:.0f} mm outside"
        sentence = f"{name} tips over: its centre of mass is {outside} what carries it ({', '.join(carried.bodies)})"
        if balance == -float("inf"):
            sentence = f"{name} slides: friction does not hold it where it leans ({', '.join(sorted(carried.patches))})"
        yield sentence, (name, *carried.bodies), min(max(-balance, 0.0), scene.solids[name].radius)


def without_part(touching: Contacts, bodies: Sequence[str]) -> list[str]:
    """Those of some bodies that have no part in keeping an object up: it neither stands on them nor leans on them.

    Only what stands on one of them can lean on another: what pushes from the side alone carries no weight.
    """
    stands = any(body in touching.bodies for body in bodies)
    return [body for body in bodies if body not in (touching.patches if stands else touching.bodies)]


def balanced(
    scene: Scene, state: State, name: str, touching: Contacts, allow: Tolerances, wanted: float | None = None
) -> float:
    """How well an object rests on certain contacts [m], see `equilibrium.balance`; `wanted` or else allow.balance."""
    center = scene.center_of_mass(name, state.poses[name])
    friction = {other: scene.friction(name) * scene.friction(other) for other in touching.patches}
    return touching.balance(center, friction, allow.balance if wanted is None else wanted)


SINK = 5e-4
"""How far an object sinks between two looks at what carries it, and so deep it may touch what stops it [m]."""


def sunk_balance(scene: Scene, state: State, name: str, allow: Tolerances, wanted: float) -> float:
    """How well an object rests once it has sunk to where something stops it, by no more than counts as standing [m].

    What is let go a millimetre above its place drops by that, and only then touches the walls that it leans on.
    """
    best, at = balanced(scene, state, name, carriers(scene, state, name, allow), allow, wanted), state.poses[name]
    if best >= wanted:
        return best
    apart = gaps(scene, state, name, allow)
    for sunk in np.arange(SINK, allow.standing + SINK / 2, SINK):
        lowered = at.copy()
        lowered[2, 3] -= sunk
        there = replace(state, poses={**state.poses, name: lowered}, touching={})
        lower = gaps(scene, there, name, allow)
        if any(lower[other] < min(apart[other], -SINK) for other in apart):
            break
        best = max(best, balanced(scene, there, name, carriers(scene, there, name, allow), allow, wanted))
    return best


def gaps(scene: Scene, state: State, name: str, allow: Tolerances) -> dict[str, float]:
    """How far an object is from each other body that stands, up to what counts as standing on it [m]."""
    T = state.poses[name]
    return {
        other: clearance(scene.solids[other], scene.solids[name], inverse(T_other) @ T, allow.standing)
        for other, T_other in state.standing(scene).items()
        if other != name
    }


def stays_after(scene: Scene, state: State, name: str, lift: float, allow: Tolerances, least: float = 0.0) -> bool:
    """Whether an object that has fallen straight down stays where it is.

    To tip or roll it must lift its centre of mass over the edge of what carries it; what is left of the fall does that.

    Args:
        scene: the bodies.
        state: where all of them are, the object where it has come down.
        name: the object.
        lift: how high what is left of its fall would lift it [m].
        allow: tolerances.
        least: how far inside what carries it its centre of mass must be in any case [m].
    """
    height = height_above(scene, name, state.poses[name])
    margin = max(least, float(np.sqrt((height + lift) ** 2 - height**2)))
    return sunk_balance(scene, state, name, allow, margin) >= margin


def height_above(scene: Scene, name: str, T: Array) -> float:
    """How high the centre of mass of an object at T is above its lowest point [m]."""
    corners = scene.solids[name].hull.part.vertices @ T[:3, :3].T + T[:3, 3]
    return float(scene.center_of_mass(name, T)[2] - corners[:, 2].min())


def overlaps(scene: Scene, state: State, name: str, allow: Tolerances) -> Iterator[tuple[str, tuple[str, ...], float]]:
    """What an object stands deeper in than contact explains: sentence, bodies, depth [m]."""
    others = state.standing(scene)
    for other in sorted(others):
        if other == name:
            continue
        T = inverse(others[other]) @ state.poses[name]
        convex = all(len(scene.solids[body].pieces) == 1 for body in (name, other))
        deepest = allow.sunk if convex or other == TABLE else allow.pieces
        first, second = scene.solids[other], scene.solids[name]
        apart = clearance(first, second, T, min(deepest, (first.thinnest + second.thinnest) / 4))
        if apart < -deepest or (-apart > (first.thinnest + second.thinnest) / 4 and crossed(first, second, T)):
            yield f"{name} stands {-1000 * apart:.1f} mm inside {other}", (name, other), -apart


def misplaced(scene: Scene, state: State, name: str, allow: Tolerances) -> Iterator[tuple[str, float]]:
    """Why an object stands too high or too low with all that carries it: sentence, and by how much [m].

    Gaps that each count as standing, and depths that each count as touching, must not add up over a stack.
    """
    if (high := _way_down(scene, state, name, 1.0, allow)) > allow.sagging:
        yield f"{1000 * high:.1f} mm above where it stands", high
    if (low := _way_down(scene, state, name, -1.0, allow)) > allow.sinking:
        yield f"{1000 * low:.1f} mm below where it stands", low


def _way_down(scene: Scene, state: State, name: str, sign: float, allow: Tolerances) -> float:
    """The least sum of gaps, or of depths where `sign` is -1, from an object down to the table [m].

    What carries it best is the way down on which it is least.
    """
    far, waiting = set[str](), [(0.0, name)]
    while waiting:
        total, lowest = heappop(waiting)
        if lowest == TABLE:
            return total
        if lowest in far:
            continue
        far.add(lowest)
        for other in carriers(scene, state, lowest, allow).bodies:
            T = inverse(scene.T_world_table if other == TABLE else state.poses[other]) @ state.poses[lowest]
            gap = clearance(scene.solids[other], scene.solids[lowest], T, allow.standing)
            heappush(waiting, (total + max(sign * gap, 0.0), other))
    return 0.0


STEP = 0.001
"""How far the fastest side of a slumping object moves between two looks [m]."""


def slumps(scene: Scene, state: State, name: str, leaving: str, allow: Tolerances) -> Given | None:
    """How an object that `leaving` carried tilts until the rest carries it; None where that is by over `allow.slump`.

    It gives by no more than `allow.slack` until something near carries it, as a plate does in a rack; or it tilts over
    the edge of what still carries it, to where its centre of mass lies, as every body does at first.
    What carries a third object is not let slump.
    """
    without = State({o: T for o, T in state.poses.items() if o != leaving}, state.q)
    if _carries(scene, without, name, allow):
        return None
    wider = replace(allow, standing=allow.standing + allow.slack)
    near = carriers(scene, replace(without, touching={}), name, wider)
    T = state.poses[name]
    if balanced(scene, without, name, near, allow) >= allow.balance:
        return Given(T, frozenset(near.patches))
    found = tipping(carriers(scene, without, name, allow), scene.center_of_mass(name, T))
    if found is None:
        return None
    pivot, axis = found
    angle = STEP / scene.solids[name].radius
    for k in range(1, int(np.pi / angle)):
        tilted = turned(T, pivot, axis, k * angle)
        if scene.displacement(name, T, tilted) > allow.slump:
            return None
        without.poses[name] = tilted
        if any(True for _ in overlaps(scene, without, name, allow)):
            return None
        touching = carriers(scene, without, name, allow)
        if balanced(scene, without, name, touching, allow) >= allow.balance:
            return Given(tilted, frozenset(touching.patches))
    return None


def _carries(scene: Scene, state: State, name: str, allow: Tolerances) -> bool:
    """Whether anything stands on an object, but for what that stands in: a rack's bars touch a plate from above too."""
    below = {name: (scene.solids[name], state.poses[name])}
    for other in sorted(state.poses.keys() - set(carriers(scene, state, name, allow).bodies)):
        T = inverse(state.poses[name]) @ state.poses[other]
        if other == name or clearance(scene.solids[name], scene.solids[other], T, allow.contact) > allow.standing:
            continue
        if contacts(scene.solids[other], state.poses[other], below, allow.standing).bodies:
            return True
    return False


def tipping(carried: Contacts, center: Array, within: float = 0.0) -> tuple[Array, Array] | None:
    """The contact about which a body tips, and the unit axis, shape (3,) each; None where its centre is over them.

    That is by at least so much `within` their edge [m].
    """
    points = np.concatenate([np.zeros((0, 3)), *carried.points.values()])
    angles = np.linspace(0.0, 2 * np.pi, 720, endpoint=False)
    ways = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=1)
    if not len(points):
        return None
    reach = ((points - center) @ ways.T).max(axis=0)
    worst = int(reach.argmin())
    if reach[worst] >= within:
        return None
    return points[(points @ ways[worst]).argmax()], np.cross((0.0, 0.0, 1.0), ways[worst])
