"""What moves may be in what stands by a tolerance: does that roll or slide on, or tip over, where it is pushed so far?

A narrow thing falls at a touch. What presses on it takes it along as far as it goes meanwhile, and strikes it as fast:
where little friction holds it, it slides on. What is pressed may tilt a little, and something roll or tip off it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.actions.collisions.blow import HELD, inertia
from tamp.checking.actions.collisions.pairs import presses_from
from tamp.checking.geometry.transforms import inverse
from tamp.checking.physics.contacts import contacts
from tamp.checking.physics.round_bodies.perching import ASIDE, rolls_on, tilting_axes
from tamp.checking.physics.support import carriers
from tamp.checking.physics.tilting import tilted_off
from tamp.checking.robot.sweep import Mover, pressed_looks, touches
from tamp.checking.scene import GRAVITY

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from tamp.checking.scene import Scene, State
    from tamp.checking.tolerances import Tolerances

    Array = NDArray[np.float64]

REBOUND = 1.5
"""How many times as fast as what strikes it something goes that is struck, at most."""
TOWARDS = 0.5
"""Cosine between a blow and a way from which on it tips over that way."""


@dataclass(frozen=True, eq=False)
class Push:
    """How something that moves presses on an object.

    Attributes:
        points: where it first does, shape (n, 3).
        deep: how deep it is in the object [m].
        normal: mean of the normals there, into the object, shape (3,).
        ways: how it goes on there, from one look to the next, shape (n, 3) [m].
        turns: how much farther any other point of it may go meanwhile, since it turns, shape (n,) [m].
        durations: of these, shape (n,) [s].
        throughout: at which of them it presses from one look to the next, shape (n,).
        during: the same, and those before and after.
        lasts: whether it still presses in the end.
    """

    points: Array
    deep: float
    normal: Array
    ways: Array
    turns: Array
    durations: Array
    throughout: NDArray[np.bool_]
    during: NDArray[np.bool_]
    lasts: bool

    def taken(self, ahead: Array) -> float:
        """How far it takes the object along a unit vector, shape (3,), at most [m]."""
        return self.deep + float(np.maximum(self.ways @ ahead + self.turns, 0.0)[self.throughout].sum())

    def speed(self, ahead: Array) -> float:
        """How fast, at most [m/s]."""
        return float(((self.ways @ ahead + self.turns) / self.durations)[self.during].max(initial=0.0))


def pushed_over(
    scene: Scene,
    state: State,
    pressed: list[tuple[Mover, Mover, float]],
    met: set[str],
    times: Array,
    allow: Tolerances,
) -> Iterator[tuple[str, str]]:
    """What moves, and objects that it pushes, though within tolerance, and that roll on by themselves, or tip over.

    What it leaves, or comes to, it pushes where it is deeper in it than at rest. Where it pressed on something as the
    last motion ended, it goes on from there. What is astray is asked about where all that is so is. The robot's base
    pushes nothing that has leant on it all the while.

    Args:
        scene: the world.
        state: where everything stands.
        pressed: bodies that stand, bodies that move, and how deep these may be in those [m].
        met: what is deeper in something than it may, and not asked about.
        times: when bodies that move are looked at, shape (n,) [s].
        allow: tolerances.
    """
    before, state.pressed = state.pressed, {}
    truth = state.as_stayed()
    for still, mover, depth in pressed:
        name = still.solid.name
        if name not in state.poses or name in met:
            continue
        if mover.solid.name in scene.links.fixed and state.unmoved(name):
            continue
        deep = depth - allow.collision + presses_from(still, mover, allow)
        pair, there = (mover.solid.name, mover.astray, name, still.astray), truth if still.astray else state
        push = _push(still, mover, deep, times, allow, before.get(pair))
        if push is not None and push.lasts:
            state.pressed[pair] = push.ways[push.throughout], push.turns[push.throughout]
        moved = set_off(scene, there, still, mover, deep, allow) or (
            push is not None and _knocks_over(scene, there, name, push, allow)
        )
        tilted = push is not None and any(True for _ in tilted_off(scene, there, name, push.points, depth, allow))
        if moved or tilted:
            yield mover.solid.name, name


def set_off(scene: Scene, state: State, still: Mover, mover: Mover, deep: float, allow: Tolerances) -> bool:
    """Whether an object rolls on from where something that moves is first deeper in it than that [m]."""
    for touch in touches([(still, mover, deep)]):
        pushing = {mover.solid.name: (mover.solid, mover.T[touch.sample])}
        patch = contacts(still.solid, still.T[0], pushing, allow.standing).patches.get(mover.solid.name)
        ahead = np.zeros(3) if patch is None else patch.normals.mean(axis=0) * (1.0, 1.0, 0.0)
        level = float(np.linalg.norm(ahead))
        if level > ASIDE and rolls_on(scene, state, still.solid.name, ahead / level, allow):
            return True
    return False


def _push(
    still: Mover,
    mover: Mover,
    deep: float,
    times: Array,
    allow: Tolerances,
    before: tuple[Array, Array] | None,
) -> Push | None:
    """How what moves presses on an object while it is deeper in it than so far [m]; None where it does not.

    Args:
        still: the object.
        mover: what moves, looked at at each time.
        deep: what is no deeper does not press.
        times: shape (n,) [s].
        allow: tolerances.
        before: how it went on and turned as it pressed on the object up to now, as in `State.pressed`.
    """
    first = touches([(still, mover, deep)])
    pressed = pressed_looks(still, mover, deep) if first else np.zeros(0, bool)
    if not pressed.any():
        return None
    T = mover.T[first[0].sample]
    pushing = {mover.solid.name: (mover.solid, T)}
    patch = contacts(still.solid, still.T[0], pushing, allow.standing).patches.get(mover.solid.name)
    if patch is None:
        return None
    at = patch.points.mean(axis=0)
    place = (mover.T @ inverse(T) @ np.append(at, 1.0))[:, :3]
    during, throughout = pressed[1:] | pressed[:-1], pressed[1:] & pressed[:-1]
    ways, turned = np.diff(place, axis=0), np.diff(mover.T[:, :3, :3], axis=0)
    turns, durations = np.sqrt((turned**2).sum(axis=(1, 2)) / 2.0) * 2.0 * mover.solid.radius, np.diff(times)
    if before is not None and pressed[0]:
        earlier = len(before[0])
        ways, turns = np.concatenate([before[0], ways]), np.concatenate([before[1], turns])
        durations = np.concatenate([np.full(earlier, np.inf), durations])
        during = np.concatenate([np.zeros(earlier, bool), during])
        throughout = np.concatenate([np.ones(earlier, bool), throughout])
    normal: Array = patch.normals.mean(axis=0)
    return Push(patch.points, deep, normal, ways, turns, durations, throughout, during, bool(pressed[-1]))


def _knocks_over(scene: Scene, state: State, name: str, push: Push, allow: Tolerances) -> bool:
    """Whether an object that stands tips over, or slides on, as something presses on it."""
    blows = _aside(push.normal)
    if any(_slides_on(scene, state, name, blow, push, allow) for blow in blows):
        return True
    for way in push.ways[push.during]:
        blows += _aside(way)
    return _tips(scene, state, name, blows, push, allow)


def _slides_on(scene: Scene, state: State, name: str, ahead: Array, push: Push, allow: Tolerances) -> bool:
    """Whether an object that is struck along a level unit vector, shape (3,), slides on by more than a little."""
    touching = carriers(scene, state, name, allow)
    if any((held.normals @ ahead < -HELD).any() for held in touching.patches.values()):
        return False
    friction = scene.friction(name) * min((scene.friction(other) for other in touching.bodies), default=0.0)
    return (REBOUND * push.speed(ahead)) ** 2 > 2 * friction * GRAVITY * allow.strayed


def _aside(way: Array) -> list[Array]:
    """The level unit vector along a vector of shape (3,), where that points aside at all."""
    length, level = float(np.linalg.norm(way)), float(np.hypot(way[0], way[1]))
    return [way * (1.0, 1.0, 0.0) / level] if level > ASIDE * length else []


def _tips(scene: Scene, state: State, name: str, blows: list[Array], push: Push, allow: Tolerances) -> bool:
    """Whether an object tips over as something presses on it, and on ahead along some level unit vectors, (3,)."""
    touching, middle = carriers(scene, state, name, allow), scene.center_of_mass(name, state.poses[name])
    base = np.concatenate([np.zeros((0, 3)), *touching.points.values()])
    if not len(base) or not blows:
        return False
    for ahead in tilting_axes(scene, state, (name,)):
        if max(float(blow @ ahead) for blow in blows) < TOWARDS:
            continue
        if any((held.normals @ ahead < -HELD).any() for held in touching.patches.values()):
            continue
        edge = base[(base @ ahead).argmax()]
        height = float(middle[2] - edge[2])
        lever = max(float(push.points[:, 2].mean() - edge[2]), height)
        inside = max(float((edge - middle) @ ahead) - push.taken(ahead) * height / max(lever, 1e-9), 0.0)
        around = inertia(scene, state, name, np.cross((0.0, 0.0, 1.0), ahead), middle - edge)
        energy = around * (REBOUND * push.speed(ahead) / max(lever, 1e-9)) ** 2 / 2
        if energy >= scene.task.object(name).mass * GRAVITY * (np.hypot(inside, height) - height):
            return True
    return False
