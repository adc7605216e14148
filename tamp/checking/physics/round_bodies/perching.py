"""Does what stands on something round stay there: on a ball, on a can that lies, on its own tip?

Contact points within a tolerance make a patch of what is a point of a ball. What is carried by one body alone,
itself on one other, needs more: tilted a little, and down again, that body must have its centre of mass higher. And
nothing stays whose own centre of mass is lower after it has rolled a little on what carries it, as long as that stays.
What is no higher after it is tilted rolls: on when a hand that pushed it stops, and with all that is put on it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.geometry.solids import clearance
from tamp.checking.geometry.transforms import inverse, rotation
from tamp.checking.physics import equilibrium
from tamp.checking.physics.righting import lain
from tamp.checking.physics.round_bodies.rolling import rolls_down
from tamp.checking.physics.support import carriers
from tamp.checking.scene import TABLE
from tamp.task.mesh.enclosure import lies_in
from tamp.task.model import Capsule, Cylinder, Sphere

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from tamp.checking.scene import Scene, State
    from tamp.checking.tolerances import Tolerances

    Array = NDArray[np.float64]

TILTS = (0.05, 0.15, 0.35)
"""By which a body is tilted [rad]."""
RISES = 1.5e-4
"""What a centre of mass must rise by on the way for a body to come back; what rolls on facets rises by less [m]."""
FALLS = 4e-4
"""What it is lower by after it has rolled a little, where it does not stay [m]."""
STEEP = 0.7
"""Vertical component of a contact normal below which it holds from aside."""
WAYS = 8
"""In which a body rolls."""
BROAD = 0.01
"""What stands on a plane that reaches as far to every side of its centre of mass does not roll [m]."""
ALONG = 0.5
"""Cosine between a push and the way that something rolls, or that something holds it back, from which on it does."""
PLANE = 5e-5
"""Corners no farther apart in height are in one plane [m]."""
LEVEL = 0.1
"""Level share of an axis from which on it counts."""
ASIDE = 0.3
"""Level share of a contact normal from which on it pushes aside."""
PRESSED = 2e-4
"""What is no deeper than this in something does not push it [m]."""
LADEN = 20.0
"""What rolls does not stay on something that is lighter by this factor: that is not level enough under it."""
ROUND = (Sphere, Cylinder, Capsule)
NEAR = 2e-5
"""What is nearer than this touches [m]."""
STEP = 4e-4
"""How far it comes down where a gap is not certain [m]."""
LOOKS = 300


def perched(
    scene: Scene, state: State, name: str, allow: Tolerances, down: float | None = None
) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Why an object does not stay on what carries it, since one of them rolls or it rights itself: sentence, bodies.

    It may come `down` so far as it rights itself [m], and must stay where that takes it; as a gap may be wide below
    what stands where that is None.
    """
    under = carriers(scene, state, name, allow).bodies
    if (below := _rolling(scene, state, name, allow)) is not None:
        yield f"{name} does not stay on {under[0]}, which rolls on {below}", (name, *under)
        return
    if _rolls_down(scene, state, name, allow):
        yield f"{name} does not stay on {' and '.join(under)}: it rolls down", (name, *under)
        return
    end = lain(scene, state, name, allow)
    far = scene.displacement(name, state.poses[name], end)
    settled = state if down is None or far > down else replace(state, poses={**state.poses, name: end})
    if _tilts_off(scene, settled, name, allow):
        yield f"{name} does not stay on {' and '.join(under)}: it tilts, or rolls, and comes down", (name, *under)
    elif _outweighs(scene, state, name, allow):
        sentence = f"{name}, which rolls, does not stay on {under[0]}, which is so much lighter that it tilts"
        yield sentence, (name, *under)
    elif far > (allow.standing if down is None else down):
        yield f"{name} does not stay tilted on {under[0]}: it comes down by {1000 * far:.0f} mm", (name, *under)


def _rolling(scene: Scene, state: State, name: str, allow: Tolerances) -> str | None:
    """On what the one body rolls that an object touches, or None where that does not roll on one body alone."""
    touching = carriers(scene, state, name, allow)
    if len(touching.patches) != 1 or touching.bodies in ((), (TABLE,)):
        return None
    (under,) = touching.bodies
    alone = state.without(name)
    below = carriers(scene, alone, under, allow)
    if len(below.patches) != 1 or not below.bodies:
        return None
    on = _standing_on(scene, alone, below.bodies)
    rolls = _rolls_about(scene, alone, under, on)
    return below.bodies[0] if any(map(rolls, _level_axes(scene, alone, under))) else None


def on_rollers(scene: Scene, state: State, name: str, allow: Tolerances) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Why an object does not stay where it is put on several bodies, if all roll the same way: sentence, bodies."""
    touching, alone = carriers(scene, state, name, allow), state.without(name)
    under = touching.bodies
    if len(under) < 2 or TABLE in under or len(under) < len(touching.patches):
        return
    below: dict[str, dict[str, Array]] = {}
    for body in under:
        carried = carriers(scene, alone, body, allow)
        if len(carried.patches) != 1 or not carried.bodies or _flat(scene, body, alone.poses[body], BROAD):
            return
        below[body] = _standing_on(scene, alone, carried.bodies)
    rolls = [_rolls_about(scene, alone, body, below[body]) for body in under]
    for axis in (axis for body in under for axis in _level_axes(scene, alone, body)):
        if all(about(axis) for about in rolls):
            yield f"{name} does not stay on {' and '.join(under)}, which all roll the same way", (name, *under)
            return


def pressed_away(scene: Scene, state: State, name: str, allow: Tolerances) -> Iterator[tuple[str, tuple[str, ...]]]:
    """What an object that has come to a place is pressed against from aside, and that rolls away: sentence, bodies."""
    for other, patch in carriers(scene, state, name, allow).patches.items():
        ahead = -patch.normals.mean(axis=0) * (1.0, 1.0, 0.0)
        level = float(np.linalg.norm(ahead))
        if other == TABLE or level < ASIDE:
            continue
        apart = clearance(scene.solids[other], scene.solids[name], inverse(state.poses[other]) @ state.poses[name], 0.0)
        if apart < -PRESSED and rolls_on(scene, state, other, ahead / level, allow):
            yield f"{name} is pressed {-1000 * apart:.1f} mm into {other}, which rolls or tips over", (name, other)


def rolls_on(scene: Scene, state: State, name: str, ahead: Array, allow: Tolerances) -> bool:
    """Whether an object rolls on when a hand that pushed it `ahead`, a level unit vector, shape (3,), stops."""
    touching = carriers(scene, state, name, allow)
    stopped = any((patch.normals @ ahead < -ALONG).any() for patch in touching.patches.values())
    if stopped or not touching.bodies or _flat(scene, name, state.poses[name], BROAD):
        return False
    # What touches it from behind neither carries it nor holds it back.
    behind = {body for body, patch in touching.patches.items() if patch.normals.mean(axis=0) @ ahead > ALONG}
    under = tuple(body for body in touching.bodies if body not in behind)
    across, below = np.array([-ahead[1], ahead[0], 0.0]), _standing_on(scene, state, under)
    if not below:
        return False
    axes = [across, *(axis for axis in _level_axes(scene, state, name) if abs(axis @ across) > ALONG)]
    return any(map(_rolls_about(scene, state, name, below), axes))


def rolls_away(scene: Scene, state: State, name: str, ahead: Array | None, allow: Tolerances) -> bool:
    """Whether an object that has fallen, and went `ahead`, shape (3,), as it turned, rolls on; None: it fell straight.

    What lies in something rolls no farther than that lets it.
    """
    touching = carriers(scene, state, name, allow)
    if not touching.bodies or _flat(scene, name, state.poses[name], BROAD):
        return False
    level = np.zeros(2) if ahead is None else ahead[:2] / max(float(np.hypot(ahead[0], ahead[1])), 1e-9)
    across = [side * np.array([-axis[1], axis[0]]) for axis in round_axes(scene, state, name) for side in (1.0, -1.0)]
    free = (
        not any((patch.normals[:, :2] @ way < -ALONG).any() for patch in touching.patches.values())
        for way in across
        if ahead is None or way @ level > ALONG
    )
    shape, objects = scene.task.object(name).shape, sorted(state.poses.keys() - {name})
    return any(free) and not any(
        lies_in(shape, state.poses[name], scene.task.object(other).shape, state.poses[other]) for other in objects
    )


def _standing_on(scene: Scene, state: State, bodies: tuple[str, ...]) -> dict[str, Array]:
    return {body: scene.T_world_table if body == TABLE else state.poses[body] for body in bodies}


def _tilts_off(scene: Scene, state: State, name: str, allow: Tolerances) -> bool:
    """Whether an object tilts or rolls down on what carries it: from a dome, a slope, an edge, or its own tip."""
    T, touching = state.poses[name], carriers(scene, state, name, allow)
    under = touching.bodies
    level = all((patch.normals[:, 2] > equilibrium.LEVEL).all() for patch in touching.patches.values())
    if not under or (level and _flat(scene, name, T, allow.balance)):
        return False
    normals = np.concatenate([patch.normals for patch in touching.patches.values()])
    ways = np.unique(np.round(normals[:, :2], 2), axis=0)
    across = ways @ ways.T
    if (normals[:, 2] < STEEP).any() or across.min() < -(ASIDE**2):
        return False  # it leans on something besides, lies between what pushes it from two sides, or is held down
    others = {o: at for o, at in state.standing(scene).items() if o in under}
    center = scene.center_of_mass(name, T)
    pivot = np.array([*center[:2], (scene.solids[name].hull.part.vertices @ T[2, :3] + T[2, 3]).min()])
    flat = comes_down(scene, name, T, np.eye(3), pivot, others)
    if np.isinf(flat):
        return False
    for axis in tilting_axes(scene, state, ()):
        rises = (comes_down(scene, name, T, rotation(axis, tilt), pivot, others) - flat for tilt in TILTS)
        if all((last := risen) < RISES / 2 for risen in rises) and last < -FALLS:
            return True
    return False


def _rolls_down(scene: Scene, state: State, name: str, allow: Tolerances) -> bool:
    """Whether what is perfectly round rolls away on what carries it: facets would hold on that."""
    shape, under = scene.task.object(name).shape, carriers(scene, state, name, allow).bodies
    return isinstance(shape, ROUND) and under not in ((), (TABLE,)) and rolls_down(scene, state, name, shape, allow)


def _outweighs(scene: Scene, state: State, name: str, allow: Tolerances) -> bool:
    """Whether something that rolls by nothing stands on one object alone, which is lighter by far.

    Rigid bodies would stay in balance. What is pressed gives way a little under one side, the lighter the more in
    simulators, and that is enough for what rolls.
    """
    touching = carriers(scene, state, name, allow)
    if len(touching.patches) != 1 or touching.bodies in ((), (TABLE,)):
        return False
    (under,) = touching.bodies
    if scene.task.object(name).mass <= LADEN * scene.task.object(under).mass:
        return False
    if _flat(scene, name, state.poses[name], allow.balance):
        return False
    below = _standing_on(scene, state, touching.bodies)
    return any(map(_rolls_about(scene, state, name, below), _level_axes(scene, state, name)))


def _flat(scene: Scene, name: str, T: Array, margin: float) -> bool:
    """Whether corners of an object in one level plane carry it, its centre of mass so far inside them [m]."""
    corners = scene.solids[name].hull.part.vertices @ T[:3, :3].T + T[:3, 3]
    base = corners[corners[:, 2] < corners[:, 2].min() + PLANE]
    up = np.tile([0.0, 0.0, 1.0], (len(base), 1))
    inside = equilibrium.balance(base, up, np.ones(len(base)), scene.center_of_mass(name, T), margin)
    return inside >= margin


def comes_down(
    scene: Scene,
    name: str,
    T: Array,
    R: Array,
    pivot: Array,
    others: Mapping[str, Array],
    center: Array | None = None,
) -> float:
    """How high the centre of mass of a body is that is turned about a point, and comes straight down on others [m].

    Infinite where it is in one of them above that already. `center`, shape (3,), in the world, is that of the body at T
    with all that it carries; without it, that of the body.
    """
    turned = T.copy()
    turned[:3, :3] = R @ T[:3, :3]
    turned[:3, 3] = pivot + R @ (T[:3, 3] - pivot)
    turned[2, 3] += scene.solids[name].radius * TILTS[-1]
    step = STEP
    for look in range(LOOKS):
        gaps = (
            clearance(scene.solids[o], scene.solids[name], inverse(at) @ turned, np.inf) for o, at in others.items()
        )
        gap = min(gaps)
        if gap < -NEAR and look == 0:
            return np.inf
        if gap < -NEAR:  # halving the way down to where it just touches: a gap of 0 may be a wider one
            turned[2, 3] += step
            step /= 2
            if step < NEAR:
                break
        turned[2, 3] -= max(gap, step)
    own = scene.center_of_mass(name, T) if center is None else center
    return float((turned @ inverse(T) @ np.append(own, 1.0))[2])


def _rolls_about(scene: Scene, state: State, name: str, below: Mapping[str, Array]) -> Callable[[Array], bool]:
    """Tells of level axes whether the centre of mass of a body rises by nothing as it is tilted on what carries it."""
    T, center = state.poses[name], scene.center_of_mass(name, state.poses[name])
    flat = comes_down(scene, name, T, np.eye(3), center, below)

    def about(axis: Array) -> bool:
        tilted = (comes_down(scene, name, T, rotation(axis, tilt), center, below) - flat for tilt in TILTS)
        return all(rise < RISES for rise in tilted)

    return about


def round_axes(scene: Scene, state: State, name: str) -> list[Array]:
    """The level axes about which a body would roll on a plane: tilted by a little either way, it rises by nothing."""
    corners = scene.solids[name].hull.part.vertices @ state.poses[name][:3, :3].T + state.poses[name][:3, 3]
    arms = corners - scene.center_of_mass(name, state.poses[name])
    flat = -arms[:, 2].min()
    return [
        axis
        for axis in _level_axes(scene, state, name)
        if all(-(arms @ rotation(axis, side * tilt)[2]).min() - flat < RISES for tilt in TILTS for side in (1, -1))
    ]


def tilting_axes(scene: Scene, state: State, bodies: Iterable[str]) -> list[Array]:
    """Level unit vectors about which something is tilted: all round, and about axes of bodies that may be long."""
    angles = np.linspace(0.0, 2 * np.pi, WAYS, endpoint=False)
    own = [side * axis for body in bodies for axis in _level_axes(scene, state, body) for side in (1.0, -1.0)]
    return [*np.stack([np.cos(angles), np.sin(angles), np.zeros(WAYS)], axis=1), *own]


def _level_axes(scene: Scene, state: State, name: str) -> Iterator[Array]:
    """Level unit vectors along the principal axes of a body, and across them: what is round rolls about one."""
    points = scene.solids[name].hull.part.vertices @ state.poses[name][:3, :3].T
    for axis in np.linalg.eigh(np.cov(points.T))[1].T:
        length = float(np.hypot(axis[0], axis[1]))
        if length > LEVEL:
            yield np.array([axis[0], axis[1], 0.0]) / length
            yield np.array([-axis[1], axis[0], 0.0]) / length
