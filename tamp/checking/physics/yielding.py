"""How does a whole stack give way that is not in balance, and where does that end?

Bodies that lean on each other hold each other up; where one leaves, or comes, all of them move until they touch anew.
They move as near to free fall as what they touch lets them (Gauss, "Über ein neues allgemeines Grundgesetz der
Mechanik", Journal für die reine und angewandte Mathematik 4, 1829): the pushes within friction that make up best for
their weights, and for the momentum that takes them into each other, leave the velocities. Followed in small steps
(Anitescu, "Optimization-based simulation of nonsmooth rigid multibody dynamics", Mathematical Programming 105, 2006),
what touches anew loses what takes it there, and goes on with the rest: past a place where it would stay from rest.
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
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from tamp.checking.physics.stacks import Stack
    from tamp.checking.scene import Scene, State
    from tamp.checking.tolerances import Tolerances

    Array = NDArray[np.float64]
    Velocity = tuple[Array, Array]
    """Of a body's centre of mass [m^0.5], and of its turn [1 / m^0.5], shape (3,) each: time makes gravity 1."""

STEP = 5e-4
"""How far the fastest side of a body that gives way moves between two looks [m]."""
LOOKS = 200
LONGEST = STEP**0.5
"""Span of time between two looks at what hardly moves; time is counted so that gravity is 1 [m^0.5]."""
ROUNDING = 0.001
"""Accelerations up to this share of gravity are none."""
LEAST = 1e-15
"""Moments of inertia are no less [kg m^2]."""
AT_ONCE = 10.0
"""How much more a bound weighs than what is sought within it."""
UP = np.array([0.0, 0.0, 1.0])
STILL = (np.zeros(3), np.zeros(3))
"""The velocity of what is at rest."""


def gives_way(
    scene: Scene,
    before: State,
    after: State,
    names: Iterable[str],
    most: float,
    allow: Tolerances,
    ends: dict[str, Array] | None = None,
    wider: Sequence[float] = (),
) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Which bodies give way by more than so much [m] with a change to the stacks of certain bodies: sentence, bodies.

    Touched is what is no farther than `allow.standing`. What would give way as far before is not what the change is to
    blame for, but touches what holds it then over a wider gap: of the `wider` ones [m], which rise, the least that has
    it stay before counts for it. Where the bodies of a stack that does not give way by so much come to is noted in
    `ends`.
    """
    waiting = sorted(names)
    while waiting:
        far = slump(scene, after, waiting[0], most, allow)
        waiting = [name for name in waiting if name not in far]
        if ends is not None and 0.0 < max(far.values()) <= most:
            ends |= given_way(scene, after, next(iter(far)), most, allow)
        gone = max(far, key=lambda name: far[name])
        if far[gone] <= most:
            continue
        if gone in before.poses and (was := slump(scene, before, gone, most, allow)[gone]) > 0.0:
            if was > most:
                if wider:
                    near = replace(allow, standing=wider[0])
                    yield from gives_way(scene, before, after, [gone], most, near, wider=wider[1:])
                continue
            there = given_way(scene, after, gone, most, allow)[gone]
            if scene.displacement(gone, after.poses[gone], there) <= most:
                continue  # what set out by itself before tells nothing of momentum
        among = ", ".join(sorted(far.keys() - {gone})) or "nothing that holds it"
        sentence = f"{gone} gives way by more than {1000 * most:.0f} mm with what it leans or stands on ({among})"
        yield sentence, (gone,)


def slump(
    scene: Scene, state: State, name: str, most: float, allow: Tolerances, firm: frozenset[str] = frozenset()
) -> dict[str, float]:
    """How far each body of the stack of a body moves until all are in balance [m]; followed until one has by `most`.

    That is from rest at each step, or with all the momentum that it gains, whichever takes it farther.
    """
    far = dict[str, float]()
    for slow in (True, False):
        for body, T in given_way(scene, state, name, most, allow, firm, slow).items():
            far[body] = max(far.get(body, 0.0), scene.displacement(body, state.poses[body], T))
        if not 0.0 < max(far.values()) <= most:
            break
    return far


def given_way(
    scene: Scene,
    state: State,
    name: str,
    most: float,
    allow: Tolerances,
    firm: frozenset[str] = frozenset(),
    slow: bool = True,
) -> dict[str, Array]:
    """Where each body of the stack of a body comes to until all are at rest, shape (4, 4), followed as in `slump`.

    What loses touch with the others on its way is followed on; what is `firm` stays. What goes `slow` sets out from
    rest at each step.
    """
    there = replace(state, poses=dict(state.poses), touching={})
    far, resting = dict[str, float](), set[tuple[str, ...]]()
    going: dict[str, Velocity] = {}
    for _ in range(LOOKS):
        span = min(STEP / _fastest(scene, going), LONGEST) if going else 1.0
        after: dict[str, Velocity] = {}
        still = set[tuple[str, ...]]()
        for body in (name, *far):
            if body not in after:
                stack = stack_of(scene, there, body, allow, firm)
                # What was at rest at the last look still is, unless something more touches it.
                moved = {} if stack.names in resting else _a_span_on(scene, there, stack, going, span)
                after |= dict.fromkeys(stack.names, STILL) | moved
                if not moved:
                    still.add(stack.names)
        far |= {body: 0.0 for body in after if body not in far}
        fastest = _fastest(scene, after)
        if fastest == 0.0:
            break
        share = 1.0 if going else float(np.sqrt(STEP / fastest))  # from rest velocities grow as the span does
        moving = {body: (share * way, share * turn) for body, (way, turn) in after.items() if way.any() or turn.any()}
        resting = {names for names in still if moving.keys().isdisjoint(names)}
        going = {} if slow else moving
        for body, (way, turn) in moving.items():
            T = there.poses[body]
            there.poses[body] = _moved(T, scene.center_of_mass(body, T), way, turn, share * span)
            far[body] = scene.displacement(body, state.poses[body], there.poses[body])
        if max(far.values()) > most:
            break
    return {body: there.poses[body] for body in far}


def unbalanced(scene: Scene, state: State, name: str, allow: Tolerances) -> frozenset[str]:
    """The bodies of the stack of a body, itself among them, that what they touch does not keep from setting out."""
    there = replace(state, touching={})  # what is kept there may be by other tolerances
    stack = stack_of(scene, there, name, allow)
    ways = _a_span_on(scene, there, stack, {}, 1.0)
    return frozenset(body for body in ways if _fastest(scene, {body: ways[body]}) > ROUNDING)


def _a_span_on(
    scene: Scene, state: State, stack: Stack, going: Mapping[str, Velocity], span: float
) -> dict[str, Velocity]:
    """As `_velocities`, empty where that is no more than rounding; cones have their edges round the true ones."""
    pushes = pushes_of(scene, state, stack, 1.0 / np.cos(np.pi / equilibrium.EDGES))
    after = _velocities(scene, state, stack.names, pushes, going, span)
    return after if _fastest(scene, after) > ROUNDING * span else {}


def _fastest(scene: Scene, ways: Mapping[str, Velocity]) -> float:
    """The velocity of the fastest side of any of some bodies."""
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


def _velocities(
    scene: Scene,
    state: State,
    names: tuple[str, ...],
    pushes: Array,
    going: Mapping[str, Velocity],
    span: float,
) -> dict[str, Velocity]:
    """How the bodies of a stack move after a span of time; from rest after a span of 1 these are accelerations, over g.

    Args:
        scene: the bodies.
        state: where they are.
        names: of the stack.
        pushes: as `pushes_of` has them.
        going: how those of them move that are not at rest.
        span: of time, in which weight and pushes act.
    """
    masses = np.array([scene.task.object(name).mass for name in names])
    mean = float(masses.mean())
    easy = np.zeros((6 * len(names), 6 * len(names)))  # the square root of how easily each body is moved
    wanted, weights = np.zeros(6 * len(names)), 0.0  # of all, with the momentum that may have to be caught
    for index, (name, mass) in enumerate(zip(names, masses, strict=True)):
        R = state.poses[name][:3, :3]
        moments, axes = np.linalg.eigh(R @ scene.inertia(name) @ R.T)
        moments = np.maximum(moments, LEAST)
        ways, turns = slice(6 * index, 6 * index + 3), slice(6 * index + 3, 6 * index + 6)
        easy[ways, ways] = np.eye(3) / np.sqrt(mass)
        easy[turns, turns] = equilibrium.SCALE * axes @ np.diag(1.0 / np.sqrt(moments)) @ axes.T
        way, turn = going.get(name, STILL)
        wanted[ways] = mass / mean * (span * UP - way)
        wanted[turns] = -axes @ (moments * (turn @ axes)) / (mean * equilibrium.SCALE)
        weights += mass / mean * (span + float(np.linalg.norm(way)))
    found = _bounded(easy @ pushes, easy @ wanted, equilibrium.PRESSED * weights)
    left = mean * (easy @ (easy @ (pushes @ found - wanted)))
    return {
        name: (left[6 * index : 6 * index + 3], left[6 * index + 3 : 6 * index + 6] / equilibrium.SCALE)
        for index, name in enumerate(names)
    }


def _bounded(A: Array, b: Array, most: float) -> Array:
    """The x >= 0, of a sum of no more than `most`, that makes |A x - b| least, shape (n,)."""
    found, _ = nnls(A, b)
    if found.sum() <= most:
        return found
    row = AT_ONCE * np.linalg.norm(A, axis=0).max()
    return nnls(np.vstack([A, np.full(A.shape[1], row)]), np.append(b, row * most))[0]
