"""What does a body that falls knock over? What carries it where it lands, and what it strikes as it turns down."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.geometry.transforms import rotation
from tamp.checking.physics import equilibrium
from tamp.checking.physics.contacts import Contacts
from tamp.checking.physics.stacks import Pushed, off_balance, stack_of
from tamp.checking.physics.support import carriers, height_above, stays_after
from tamp.checking.physics.tilting import above, falls_off
from tamp.checking.physics.tipping import rise_to_tip
from tamp.checking.scene import GRAVITY, TABLE

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from numpy.typing import NDArray

    from tamp.checking.scene import Scene, State
    from tamp.checking.tolerances import Tolerances

    Array = NDArray[np.float64]

ALIKE = 0.05  # masses that differ by such a share are one
PASSED = 0.5  # share of the energy passed on in a blow without a rebound that is counted on
HELD = 0.5  # level share of a contact normal from which on it keeps a body from tipping that way
MAY_TIP = 0.2  # share of what it takes to tip over from which on it may: edges slip, and a hand adds some
STRAY = 0.015  # share of a fall's energy that rocks what comes down, to whatever side
UP = np.array([0.0, 0.0, 1.0])
ANGLES = np.linspace(0.0, 2 * np.pi, 72, endpoint=False)  # of the level ways in which something may tip [rad]
WAYS = np.stack([np.cos(ANGLES), np.sin(ANGLES), np.zeros_like(ANGLES)], axis=1)

RECOIL = 0.37  # of its weight, with which a rod that falls over pushes back where it stands, at most


@dataclass(frozen=True, eq=False)
class Blow:
    """What comes down on what carries it.

    Attributes:
        energy: of the fall, in terms of weight [kg m].
        mass: of all that comes down [kg].
        center: where it does, shape (3,).
        bodies: what comes down, the lowest last.
        met: the last two of them of which the upper one had several carriers, or none.
    """

    energy: float
    mass: float
    center: Array
    bodies: tuple[str, ...]
    met: tuple[str, ...] = ()


def knocked_over(
    scene: Scene, state: State, name: str, drop: float, allow: Tolerances, spared: tuple[str, ...] = ()
) -> Iterator[str]:
    """What carries an object that has fallen, and tips over with all that the blow falls on.

    What falls on one body falls on it with its centre of mass. Of several it meets one first: each must bear the whole
    blow where it is met, but for those that it slides past, see `slid_past`. There are 2^n ways down a wall: of those
    that came over the same contact with about the same mass one goes on. None goes over what is `spared`.
    """
    mass, center = scene.task.object(name).mass, scene.center_of_mass(name, state.poses[name])
    coming, seen = [Blow(mass * drop, mass, center, (*spared, name))], set()
    while coming:
        blow = coming.pop()
        like = blow.bodies[-1], blow.met, round(np.log(blow.mass) / ALIKE)
        if like in seen:
            continue
        seen.add(like)
        for struck, stands in _struck(scene, state, blow, allow):
            if not stands:
                yield struck.bodies[-1]
            coming.append(struck)


def _struck(scene: Scene, state: State, blow: Blow, allow: Tolerances) -> Iterator[tuple[Blow, bool]]:
    """The blow as it goes on with each body that it meets, and whether that one stands.

    To tip it over the blow lifts the common centre of mass over the edge of what the body stands on.
    """
    carried = carriers(scene, state, blow.bodies[-1], allow)
    points = carried.without(*slid_past(scene, state, blow.bodies[-1], carried).patches).points
    for name in sorted(points.keys() - {TABLE, *blow.bodies}):
        more, middle = scene.task.object(name).mass, scene.center_of_mass(name, state.poses[name])
        alone = len(points) == 1
        at = blow.center if alone else points[name].mean(axis=0)
        mass, center = blow.mass + more, (blow.mass * at + more * middle) / (blow.mass + more)
        height = float(center[2] - middle[2]) + height_above(scene, name, state.poses[name])
        lift = min(allow.rolling * blow.energy / mass, allow.rocking * height)
        margin = float(np.sqrt((height + lift) ** 2 - height**2))
        touching = carriers(scene, state, name, allow).without(*blow.bodies)
        if not touching.patches:  # that nothing carries it is told where it was put, or of the start
            continue
        friction = {other: scene.friction(name) * scene.friction(other) for other in touching.patches}
        met = blow.met if alone else (blow.bodies[-1], name)
        struck = Blow(blow.energy, mass, center, (*blow.bodies, name), met)
        yield struck, bool(touching.balance(center, friction, margin) >= margin)


def slid_past(scene: Scene, state: State, name: str, touching: Contacts) -> Contacts:
    """Those contacts of an object that do not stop its fall, if another one does: they are steeper than friction holds.

    Such a flank is struck aside.
    """
    steep = {}
    for other, patch in touching.patches.items():
        friction = scene.friction(name) * scene.friction(other)
        if other != TABLE and not equilibrium.holds_up(patch.normals, friction):
            steep[other] = patch
    return Contacts(steep if len(steep) < len(touching.patches) else {})


def struck_aside(
    scene: Scene,
    state: State,
    name: str,
    drop: float,
    turn: tuple[Array, Array] | None,
    met: Contacts,
    allow: Tolerances,
) -> Iterator[str]:
    """What an object that has fallen strikes as it lands, and tips over.

    Friction may press what is struck down, so that the blow may point lower than across the face by the cone's angle.
    What falls straight strikes with the part of its speed that is along the blow.

    Args:
        scene: the bodies.
        state: where all of them are, the object where it has come down.
        name: the object.
        drop: how far its centre of mass has come down [m].
        turn: of the fall: its axis, a unit vector, and a point on it, shape (3,) each; None where it falls straight.
        met: what the object touches that it did not touch before, and strikes from aside.
        allow: tolerances.
    """
    for other in sorted(met.patches.keys() - {TABLE}):
        patch = met.patches[other]
        at, blow = patch.points.mean(axis=0), -patch.normals.mean(axis=0)
        ahead = blow * (1.0, 1.0, 0.0) / max(float(np.hypot(blow[0], blow[1])), 1e-9)
        touching = carriers(scene, state, other, allow).without(name)
        base = np.concatenate([np.zeros((0, 3)), *touching.points.values()])
        if not len(base) or any((held.normals @ ahead < -HELD).any() for held in touching.patches.values()):
            continue
        edge = base[(base @ ahead).argmax()], np.cross((0.0, 0.0, 1.0), ahead)
        middle = scene.center_of_mass(other, state.poses[other])
        inside, height = float((edge[0] - middle) @ ahead), float(middle[2] - edge[0][2])
        needed = scene.task.object(other).mass * (np.hypot(max(inside, 0.0), height) - height)
        cone = float(np.arctan(scene.friction(name) * scene.friction(other)))
        lower = (rotation(edge[1], turned) @ blow / np.linalg.norm(blow) for turned in (0.0, cone))
        energy = scene.task.object(name).mass * drop
        ends = ((name, turn), (other, edge[::-1]))
        least = min(_passed(scene, state, ends, at, each) for each in lower)
        if PASSED * energy * least > needed:
            yield other


def tips_on(
    scene: Scene, state: State, name: str, drop: float, turn: tuple[Array, Array], allow: Tolerances
) -> str | None:
    """Over the edge of what an object tips on that has turned over and come down on it; None where it stays.

    What it strikes farthest ahead stops it there and nowhere else: its angular momentum about that place is kept, and
    it goes on turning about it. Some of its energy goes any way, since nothing strikes a face evenly: it rocks from one
    side onto the other. To tip it must lift its centre of mass over that, and over what of it comes down meanwhile.

    Args:
        scene: the bodies.
        state: where all of them are, the object where it has come down.
        name: the object.
        drop: how far its centre of mass has come down [m].
        turn: of the fall: its axis, a unit vector, and a point on it, shape (3,) each.
        allow: tolerances.
    """
    axis, pivot = turn
    touching = carriers(scene, state, name, allow)
    if not touching.points:
        return None
    points = np.concatenate(list(touching.points.values()))
    under = [other for other, found in touching.points.items() for _ in found]
    center = scene.center_of_mass(name, state.poses[name])
    for way in WAYS:
        if any((held.normals @ way < -HELD).any() for held in touching.patches.values()):
            continue
        over, last, first = np.cross(UP, way), int((points @ way).argmax()), int((points @ way).argmin())
        lever = center - points[last]
        ahead = _kept(scene, state, name, (axis, center - pivot), (over, lever))
        rocking = _kept(scene, state, name, (over, center - points[first]), (over, lever))
        energy = drop * max(ahead, STRAY * rocking)
        if energy > MAY_TIP * rise_to_tip(scene, state, name, under[last], points[last], way):
            return under[last]
    return None


def _kept(scene: Scene, state: State, name: str, before: tuple[Array, Array], after: tuple[Array, Array]) -> float:
    """Share of its energy that a body keeps which turned about one axis, and is stopped so as to turn about another.

    Each is given as a unit vector, shape (3,), and the way from the axis to the centre of mass, shape (3,) [m].
    """
    (axis, arm), (over, lever) = before, after
    R, mass = state.poses[name][:3, :3], scene.task.object(name).mass
    momentum = float(over @ (R @ scene.inertia(name) @ R.T @ axis + mass * np.cross(lever, np.cross(axis, arm))))
    swings = inertia(scene, state, name, axis, arm) * inertia(scene, state, name, over, lever)
    return float(max(momentum, 0.0) ** 2 / swings)


def pushed_back(scene: Scene, state: State, name: str, ahead: Array, allow: Tolerances) -> Iterator[str]:
    """What an object stands on with its edge, and pushes over behind it as it begins to turn `ahead`, shape (3,).

    The edge pushes back as the centre of mass gets faster ahead, by no more than friction bears. What it stands on
    passes that on to what carries that.
    """
    back = -ahead * (1.0, 1.0, 0.0) / max(float(np.hypot(ahead[0], ahead[1])), 1e-9)
    mass = scene.task.object(name).mass
    for other, points in sorted(carriers(scene, state, name, allow).points.items()):
        touching = Contacts({}) if other == TABLE else carriers(scene, state, other, allow).without(name)
        base = np.concatenate([np.zeros((0, 3)), *touching.points.values()])
        if not len(base) or any((held.normals @ back < -HELD).any() for held in touching.patches.values()):
            continue
        at, edge = points.mean(axis=0), base[(base @ back).argmax()]
        friction = min(scene.friction(name) * scene.friction(other), RECOIL)
        push = friction * float(at[2] - edge[2])
        inside = float((edge - scene.center_of_mass(other, state.poses[other])) @ back)
        if scene.task.object(other).mass * inside + mass * (float((edge - at) @ back) - push) < 0.0:
            yield other
            continue
        force = mass * GRAVITY * (friction * back - (0.0, 0.0, 1.0))
        yield from _unbalanced(scene, state.without(name), Pushed(other, force, at), allow)


def _unbalanced(scene: Scene, state: State, pushed: Pushed, allow: Tolerances) -> Iterator[str]:
    """What tips over in the stack of an object that is pushed; that it slides a little is not asked."""
    stack = stack_of(scene, state, pushed.name, allow)
    before, after = off_balance(scene, state, stack), off_balance(scene, state, stack, pushed)
    for name, far in sorted(after.items()):
        if before.get(name, 0.0) + allow.balance < far < np.inf:
            yield name
            return


def _passed(
    scene: Scene, state: State, ends: Iterable[tuple[str, tuple[Array, Array] | None]], at: Array, blow: Array
) -> float:
    """The share of the energy of a body that falls that it passes on to another at rest, which it turns.

    Where they meet they go on together: m M / (m + M)^2, m and M being the masses that each moves there as if it had,
    of the energy that is in the speed along the blow.

    Args:
        scene: the bodies.
        state: where they are.
        ends: the two, and the line about which each of them turns: its direction, a unit vector, and a point on it;
            None for what falls straight.
        at: where they meet, shape (3,).
        blow: the unit vector, shape (3,), along which the one pushes the other there.
    """
    masses, along = [], 1.0
    for name, turn in ends:
        if turn is None:
            along = max(-float(blow[2]), 0.0) ** 2
            masses.append(scene.task.object(name).mass)
            continue
        axis, point = turn
        lever = float(np.cross(axis, at - point) @ blow)
        if lever <= 0.0:
            return 0.0
        beside = scene.center_of_mass(name, state.poses[name]) - point
        masses.append(inertia(scene, state, name, axis, beside) / lever**2)
    return along * masses[0] * masses[1] / (masses[0] + masses[1]) ** 2


def inertia(scene: Scene, state: State, name: str, axis: Array, lever: Array) -> float:
    """Moment of inertia of a body about an axis, a unit vector, so far from its centre of mass [kg m^2]."""
    along, beside = state.poses[name][:3, :3].T @ axis, lever - axis * (axis @ lever)
    return float(along @ scene.inertia(name) @ along) + scene.task.object(name).mass * float(beside @ beside)


def upset_by_fall(
    scene: Scene, state: State, name: str, drop: float, allow: Tolerances, struck: Iterable[str] = ()
) -> Iterator[tuple[str, tuple[str, ...]]]:
    """What does not stay where it is as an object comes straight down by a drop [m], or that itself does not.

    `struck` are those that it knocks over from aside.
    """
    lift = min(allow.rolling * drop, allow.rocking * height_above(scene, name, state.poses[name]))
    if not stays_after(scene, state, name, lift, allow):
        yield f"{name} does not stay where it falls {1000 * drop:.0f} mm: it rolls or tips on", (name,)
    yield from tipped_over((*struck, *knocked_over(scene, state, name, drop, allow)), name, drop)
    yield from jolted(scene, state, name, drop, allow)


def jolted(
    scene: Scene, state: State, name: str, drop: float, allow: Tolerances
) -> Iterator[tuple[str, tuple[str, ...]]]:
    """What does not stay on an object as another one falls on that beside what carries it: sentence, bodies.

    Both go on together, tilt until their weights have taken up what is left of the fall, and swing back.
    """
    mass, at, rest = scene.task.object(name).mass, scene.center_of_mass(name, state.poses[name]), state.without(name)
    for other in sorted(carriers(scene, state, name, allow).points.keys() - {TABLE}):
        base = np.concatenate([np.zeros((0, 3)), *carriers(scene, rest, other, allow).points.values()])
        loads = above(scene, rest, other, allow) if len(base) else []
        if not loads:
            continue
        ahead = (at - base.mean(axis=0)) * (1.0, 1.0, 0.0)
        ahead /= max(float(np.linalg.norm(ahead)), 1e-9)
        edge = base[(base @ ahead).argmax()]
        lever, around, arm = float((at - edge) @ ahead), 0.0, 0.0
        for body in (other, *loads):
            beside = scene.center_of_mass(body, state.poses[body]) - edge
            around += inertia(scene, state, body, np.cross((0.0, 0.0, 1.0), ahead), beside)
            arm -= scene.task.object(body).mass * float(beside @ ahead)
        if lever <= 0.0:
            continue
        share = mass * lever**2 / (mass * lever**2 + around)
        for body, how in falls_off(scene, rest, other, share * mass * drop / max(arm - mass * lever, 1e-9), allow):
            yield (
                f"{body} {how}, as {other} tilts under it when {name} falls {1000 * drop:.0f} mm onto it",
                (body, name),
            )


def tipped_over(struck: Iterable[str], name: str, drop: float) -> Iterator[tuple[str, tuple[str, ...]]]:
    """What tips over as an object falls onto it: sentence, bodies."""
    for other in dict.fromkeys(struck):
        yield f"{other} tips over when {name} falls {1000 * drop:.0f} mm onto it", (other, name)
