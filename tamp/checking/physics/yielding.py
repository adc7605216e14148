"""How does a whole stack give way that is not in balance, and where does that end?

Bodies that lean on each other hold each other up; where one leaves, or comes, all of them move until they touch anew.
From rest they set out as near to free fall as what they touch lets them (Gauss, "Über ein neues allgemeines Grundgesetz
der Mechanik", Journal für die reine und angewandte Mathematik 4, 1829): the pushes within friction that make up best
for their weights leave the accelerations. Followed in small steps, each from rest, that is a slump: slower than a fall.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.geometry.transforms import turned
from tamp.checking.physics import equilibrium
from tamp.checking.physics.least_squares import nnls
from tamp.checking.physics.stacks import pushes_of, stack_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from numpy.typing import NDArray

    from tamp.checking.physics.stacks import Stack
    from tamp.checking.scene import Scene, State
    from tamp.checking.tolerances import Tolerances

    Array = NDArray[np.float64]

STEP = 5e-4
"""How far the fastest side of a body that gives way moves between two looks [m]."""
LOOKS = 200
ROUNDING = 0.001
"""Accelerations up to this share of gravity are none."""


def gives_way(
    scene: Scene,
    before: State,
    after: State,
    names: Iterable[str],
    most: float,
    allow: Tolerances,
    ends: dict[str, Array] | None = None,
) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Which bodies give way by more than so much [m] with a change to the stacks of certain bodies: sentence, bodies.

    Touched is what is no farther than `allow.standing`. What would give way as far before is not what the change is to
    blame for. Where the bodies of a stack that does not give way by so much come to is noted in `ends`.
    """
    waiting = sorted(names)
    while waiting:
        poses = given_way(scene, after, waiting[0], most, allow)
        far = {name: scene.displacement(name, after.poses[name], T) for name, T in poses.items()}
        waiting = [name for name in waiting if name not in far]
        if ends is not None and max(far.values()) <= most:
            ends |= poses
        gone = max(far, key=lambda name: far[name])
        if far[gone] <= most:
            continue
        if gone in before.poses and slump(scene, before, gone, most, allow)[gone] > most:
            continue
        among = ", ".join(sorted(far.keys() - {gone})) or "nothing that holds it"
        sentence = f"{gone} gives way by more than {1000 * most:.0f} mm with what it leans or stands on ({among})"
        yield sentence, (gone,)


def slump(scene: Scene, state: State, name: str, most: float, allow: Tolerances) -> dict[str, float]:
    """How far each body of the stack of a body moves until all are in balance [m]; followed until one has by `most`."""
    poses = given_way(scene, state, name, most, allow)
    return {body: scene.displacement(body, state.poses[body], T) for body, T in poses.items()}


def given_way(
    scene: Scene, state: State, name: str, most: float, allow: Tolerances, firm: frozenset[str] = frozenset()
) -> dict[str, Array]:
    """Where each body of the stack of a body comes to until all are in balance, shape (4, 4), followed as in `slump`.

    What loses touch with the others on its way is followed on; what is `firm` stays.
    """
    there = replace(state, poses=dict(state.poses), touching={})
    far, resting = dict[str, float](), set[tuple[str, ...]]()
    for _ in range(LOOKS):
        ways: dict[str, tuple[Array, Array]] = {}
        still = set[tuple[str, ...]]()
        for body in (name, *far):
            if body not in ways:
                stack = stack_of(scene, there, body, allow, firm)
                # What was at rest at the last look still is, unless something more touches it.
                set_out = {} if stack.names in resting else _set_out(scene, there, stack)
                ways |= _rest(stack) | set_out
                if not set_out:
                    still.add(stack.names)
        far |= {body: 0.0 for body in ways if body not in far}
        fastest = _fastest(scene, ways)
        if fastest == 0.0:
            break
        moving = {body for body, (way, turn) in ways.items() if way.any() or turn.any()}
        resting = {names for names in still if moving.isdisjoint(names)}
        for body, (way, turn) in ways.items():
            T = there.poses[body]
            there.poses[body] = _moved(T, scene.center_of_mass(body, T), way, turn, STEP / fastest)
            far[body] = scene.displacement(body, state.poses[body], there.poses[body])
        if max(far.values()) > most:
            break
    return {body: there.poses[body] for body in far}


def unbalanced(scene: Scene, state: State, name: str, allow: Tolerances) -> frozenset[str]:
    """The bodies of the stack of a body, itself among them, that what they touch does not keep from setting out."""
    there = replace(state, touching={})  # what is kept there may be by other tolerances
    stack = stack_of(scene, there, name, allow)
    ways = _set_out(scene, there, stack)
    return frozenset(body for body in ways if _fastest(scene, {body: ways[body]}) > ROUNDING)


def _set_out(scene: Scene, state: State, stack: Stack) -> dict[str, tuple[Array, Array]]:
    """As `_accelerations`, empty where that is no more than rounding, and what cones cut to edges leave out."""
    ways = _accelerations(scene, state, stack.names, pushes_of(scene, state, stack))
    friction = max((scene.friction(a) * scene.friction(b) for a, b in stack.touching), default=0.0)
    still = ROUNDING + friction * (1.0 - np.cos(np.pi / equilibrium.EDGES))
    return ways if _fastest(scene, ways) > still else {}


def _rest(stack: Stack) -> dict[str, tuple[Array, Array]]:
    return {name: (np.zeros(3), np.zeros(3)) for name in stack.names}


def _fastest(scene: Scene, ways: Mapping[str, tuple[Array, Array]]) -> float:
    """The most that a side of any of some bodies is accelerated by, over g."""
    return max(
        float(np.linalg.norm(way) + scene.solids[body].radius * np.linalg.norm(turn))
        for body, (way, turn) in ways.items()
    )


def _moved(T: Array, center: Array, way: Array, turn: Array, share: float) -> Array:
    """A pose after its centre has gone a share of a way, shape (3,), and it has turned about that by one of a turn."""
    angle = float(np.linalg.norm(turn))
    moved = turned(T, center, turn / angle, share * angle) if angle > 0.0 else T.copy()
    moved[:3, 3] += share * way
    return moved


def _accelerations(scene: Scene, state: State, names: tuple[str, ...], pushes: Array) -> dict[str, tuple[Array, Array]]:
    """How the bodies of a stack set out from rest: of each the acceleration of its centre, and of its turn, over g.

    Args:
        scene: the bodies.
        state: where they are.
        names: of the stack.
        pushes: as `pushes_of` has them.
    """
    masses = np.array([scene.task.object(name).mass for name in names])
    mean = float(masses.mean())
    easy = np.zeros((6 * len(names), 6 * len(names)))  # the square root of how easily each body is moved
    wanted = np.zeros(6 * len(names))
    for index, (name, mass) in enumerate(zip(names, masses, strict=True)):
        R = state.poses[name][:3, :3]
        moments, axes = np.linalg.eigh(R @ scene.inertia(name) @ R.T)
        ways, turns = slice(6 * index, 6 * index + 3), slice(6 * index + 3, 6 * index + 6)
        easy[ways, ways] = np.eye(3) / np.sqrt(mass)
        easy[turns, turns] = equilibrium.SCALE * axes @ np.diag(1.0 / np.sqrt(np.maximum(moments, 1e-15))) @ axes.T
        wanted[6 * index + 2] = mass / mean
    found, _ = nnls(easy @ pushes, easy @ wanted)
    left = mean * (easy @ (easy @ (pushes @ found - wanted)))
    return {
        name: (left[6 * index : 6 * index + 3], left[6 * index + 3 : 6 * index + 6] / equilibrium.SCALE)
        for index, name in enumerate(names)
    }
