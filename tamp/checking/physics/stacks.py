"""Does a whole stack stay where it stands? Forces between all its bodies, within friction, that balance all weights.

What carries must itself stay: a plank on a block tips when one of two counterweights on it is taken away. Where each
body stands on one other, the weight of all that a body carries acts as one force through their common centre of mass;
else the forces are those of a linear program, whose answer is how far the centres of mass would have to lie elsewhere.
Friction makes such forces ambiguous: that some balance is what rigid bodies at rest need, and what is asked here.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.physics import equilibrium
from tamp.checking.physics.contacts import Contacts, Patch
from tamp.checking.physics.round_bodies.perching import round_axes
from tamp.checking.physics.support import patch_between
from tamp.checking.scene import GRAVITY, TABLE

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from numpy.typing import NDArray

    from tamp.checking.scene import Scene, State
    from tamp.checking.tolerances import Tolerances

    Array = NDArray[np.float64]

ENDWISE = 0.3
"""Sine of the angle between a contact normal and an axis up to which a body is touched at an end of it."""
ALIKE = 0.9
"""Cosine between contact normals from which on they are those of one round face."""
WITHIN = 1e-4
"""What is no farther than this within the edge of all that it stands on stays there by chance [m]."""


@dataclass(frozen=True, eq=False)
class Stack:
    """Bodies that touch each other, and all contacts among them and with the table.

    Attributes:
        names: the bodies, sorted.
        touching: for each pair (a, b), a in the stack, where they touch: points, and normals into a.
    """

    names: tuple[str, ...]
    touching: Mapping[tuple[str, str], Patch]

    def below(self, name: str) -> dict[str, Patch]:
        """What carries a body, from below."""
        found = {}
        for (a, b), patch in self.touching.items():
            if name in (a, b):
                normals = patch.normals if name == a else -patch.normals
                found[b if name == a else a] = Patch(patch.points, normals)
        return {other: patch for other, patch in found.items() if other in Contacts({other: patch}).bodies}


def stack_of(scene: Scene, state: State, name: str, allow: Tolerances, firm: frozenset[str] = frozenset()) -> Stack:
    """The bodies that a body touches, those that they touch, and so on; the table, and what is firm, holds none."""
    standing = state.standing(scene)
    waiting, seen, touching = [name], {name}, {}
    while waiting:
        a = waiting.pop()
        for b in sorted(standing):
            if b == a or (b, a) in touching or (a, b) in touching:
                continue
            patch = patch_between(scene, state, a, b, allow)
            if patch is None:
                continue
            touching[a, b] = patch
            if b != TABLE and b not in seen and b not in firm:
                seen.add(b)
                waiting.append(b)
    return Stack(tuple(sorted(seen)), touching)


def upset(
    scene: Scene, before: State, after: State, names: Iterable[str], allow: Tolerances
) -> Iterator[tuple[str, tuple[str, ...], float]]:
    """Which bodies lose their balance by a change to the stacks of certain bodies: sentence, bodies, depth [m].

    What tips by no more than `allow.slack` until something else carries it has not lost its balance. What had lost it
    before, as far as anybody can tell, is not what the change is to blame for; what had not, but for tolerances, had
    its balance, so that many small changes do not add up.
    """
    wider = replace(allow, standing=_reach(allow))
    waiting = sorted(names)
    while waiting:
        stack = stack_of(scene, after, waiting[0], allow)
        waiting = [name for name in waiting if name not in stack.names]
        wrong = {name: far for name, far in off_balance(scene, after, stack).items() if far > allow.balance}
        if wrong:
            tilted = replace(after, touching={})
            found = off_balance(scene, tilted, stack_of(scene, tilted, min(wrong), wider))
            wrong = {name: far for name, far in wrong.items() if found.get(name, 0.0) > allow.balance}
        for name, far in wrong.items():
            was = 0.0
            if name in before.poses:
                began = replace(before, touching={})
                was = off_balance(scene, began, stack_of(scene, began, name, wider)).get(name, 0.0)
            if far > (was if was > allow.balance else 0.0) + allow.balance:
                how = "slides" if np.isinf(far) else "tips over"
                yield f"{name} {how} with what it stands among ({', '.join(stack.names)})", (name,), min(far, 1.0)


@dataclass(frozen=True, eq=False)
class Pushed:
    """A body of a stack that is pushed: with a force, shape (3,) [N], at a place, shape (3,) [m], in the world."""

    name: str
    force: Array
    at: Array


def off_balance(scene: Scene, state: State, stack: Stack, pushed: Pushed | None = None) -> dict[str, float]:
    """How far elsewhere the centres of mass of a stack's bodies would have to lie to be at rest [m], where not at 0.

    Infinite for all of them where no place of the centres of mass would help: they slide. What is `pushed` and slides
    evenly is as good as at rest.
    """
    if not stack.touching:
        return {}  # what is in the air is judged by itself
    below = {name: stack.below(name) for name in stack.names}
    if pushed is None and _each_on_one(scene, state, below):
        return {}
    return _least_shifts(scene, state, stack, pushed)


def over_edge(scene: Scene, state: State, name: str, allow: Tolerances) -> list[str]:
    """Of a body and what carries it: which have all that they carry, and themselves, on the very edge of level faces.

    That is with their common centre of mass there or beyond, where each body stands on one other; else, and where
    something is near that would catch them, or something is round, it is not asked.
    """
    near, far = (_margins(scene, state, name, replace(allow, standing=gap)) for gap in (allow.firm, _reach(allow)))
    return [body for body, margin in near.items() if margin < WITHIN and far.get(body, WITHIN) < WITHIN]


def _reach(allow: Tolerances) -> float:
    return allow.standing + allow.slack


def _margins(scene: Scene, state: State, name: str, allow: Tolerances) -> dict[str, float]:
    """How far within the edge of a level face the load of a body is, and of each body that carries that [m]."""
    there = replace(state, touching={})
    stack = stack_of(scene, there, name, allow)
    below = {body: stack.below(body) for body in stack.names}
    order, found = _upwards(below), dict[str, float]()
    leans = len(stack.touching) > len(order)  # or touches something beside what carries it
    if not order or leans or any(round_axes(scene, there, body) for body in stack.names):
        return {}
    load, body = _loads(scene, there, below, order), name
    while body != TABLE:
        ((carrier, patch),) = below[body].items()
        if (patch.normals[:, 2] > equilibrium.LEVEL).all():
            friction = np.full(len(patch.points), scene.friction(body) * scene.friction(carrier))
            found[body] = equilibrium.balance(patch.points, patch.normals, friction, load[body][1], allow.balance)
        body = carrier
    return found


def _upwards(below: Mapping[str, Mapping[str, Patch]]) -> list[str]:
    """The bodies of a stack, each after the one that carries it; none where not each stands on one other."""
    above: dict[str, list[str]] = {name: [] for name in (*below, TABLE)}
    for name, carrying in below.items():
        if len(carrying) != 1:
            return []
        above[next(iter(carrying))].append(name)
    order = [TABLE]
    for name in order:
        order += above[name]
    return order[1:] if len(order) == len(above) else []  # those that carry each other in a circle are never reached


def _loads(
    scene: Scene, state: State, below: Mapping[str, Mapping[str, Patch]], order: list[str]
) -> dict[str, tuple[float, Array]]:
    """Mass and centre of mass of each body with all that it carries; `order` as in `_upwards`."""
    load = {name: _weighted(scene, state, name) for name in below}
    for name in reversed(order):
        (carrier,), (mass, center) = below[name], load[name]
        if carrier != TABLE:
            more, middle = load[carrier]
            load[carrier] = mass + more, (mass * center + more * middle) / (mass + more)
    return load


def _each_on_one(scene: Scene, state: State, below: Mapping[str, Mapping[str, Patch]]) -> bool:
    """Whether each body stands on one other, which holds up all that it carries: enough for balance, not needed."""
    order = _upwards(below)
    load = _loads(scene, state, below, order) if order else {}
    for name in reversed(order):
        ((carrier, patch),) = below[name].items()
        friction = np.full(len(patch.points), scene.friction(name) * scene.friction(carrier))
        if equilibrium.balance(patch.points, patch.normals, friction, load[name][1], 0.0) < 0.0:
            return False
    return bool(order)


def _on_line(patch: Patch, center: Array, axes: Iterable[Array]) -> Patch:
    """Where a body touches another that is round about axes through its centre of mass: pushes do not turn it there.

    A patch is of points within a tolerance of each other: of what is round it is a strip that would keep it from
    rolling, with the normals of several facets, where there is a line with one.
    """
    points, normals = patch.points, patch.normals
    for axis in axes:
        normals = (patch.normals @ patch.normals.T > ALIKE) @ patch.normals
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        along = np.cross(axis, normals)
        length = np.linalg.norm(along, axis=1, keepdims=True)
        along = np.where(length > ENDWISE, along / np.maximum(length, ENDWISE), 0.0)
        points = points - ((points - center) * along).sum(axis=1, keepdims=True) * along
    return Patch(points, normals)


def _weighted(scene: Scene, state: State, name: str) -> tuple[float, Array]:
    return scene.task.object(name).mass, scene.center_of_mass(name, state.poses[name])


def pushes_of(scene: Scene, state: State, stack: Stack, stickier: float = 1.0) -> Array:
    """What the pushes along the edges of each contact's friction cone give the bodies of a stack, shape (6 n, m).

    Each is a force and a scaled moment about the centre of mass, equal and opposite for its two bodies, in six rows for
    each of them. Friction is `stickier` times what is given.
    """
    row = {name: 6 * index for index, name in enumerate(stack.names)}
    middles = {name: scene.center_of_mass(name, state.poses[name]) for name in stack.names}
    axes = {name: round_axes(scene, state, name) for name in stack.names}
    pushes = [np.zeros((6 * len(row), 0))]
    for (a, b), patch in stack.touching.items():
        for name in (name for name in (a, b) if name in row):
            patch = _on_line(patch, middles[name], axes[name])
        kept = equilibrium.outermost(patch.points, patch.normals)
        points, normals = patch.points[kept], patch.normals[kept]
        mu = np.full(len(kept), stickier * scene.friction(a) * scene.friction(b))
        block = np.zeros((6 * len(row), len(kept) * equilibrium.EDGES))
        for name, sign in ((a, 1.0), (b, -1.0)):
            if name in row:
                wrench = equilibrium.wrenches(points - middles[name], normals, mu)
                block[row[name] : row[name] + 6] = sign * wrench
        pushes.append(block)
    return np.hstack(pushes)


def _least_shifts(scene: Scene, state: State, stack: Stack, pushed: Pushed | None) -> dict[str, float]:
    """The linear program: least shifts |x| + |y| of the centres of mass with which forces balance weights and push.

    Unknown are pushes along the edges of each contact's friction cone, and for each body the moments that shifts of its
    weight would add.
    """
    bodies = {name: _weighted(scene, state, name) for name in stack.names}
    mean = float(np.mean([mass for mass, _ in bodies.values()]))
    row = {name: 6 * index for index, name in enumerate(bodies)}
    wanted, shifts = np.zeros(6 * len(bodies)), np.zeros((6 * len(bodies), 4 * len(bodies)))
    for index, (name, (mass, _)) in enumerate(bodies.items()):
        wanted[row[name] + 2] = mass / mean
        shifts[row[name] : row[name] + 6, 4 * index : 4 * index + 4] = equilibrium.SHIFTS
    if pushed is not None:
        moment = np.cross(pushed.at - bodies[pushed.name][1], pushed.force) / equilibrium.SCALE
        wanted[row[pushed.name] : row[pushed.name] + 6] -= np.concatenate([pushed.force, moment]) / (mean * GRAVITY)
    costs = np.repeat([equilibrium.SCALE * mean / mass for mass, _ in bodies.values()], 4)
    weights = sum(mass for mass, _ in bodies.values()) / mean
    found = equilibrium.least(pushes_of(scene, state, stack), shifts, costs, wanted, equilibrium.PRESSED * weights)
    if found is None:
        return dict.fromkeys(stack.names, np.inf)
    each = (found[0] * costs).reshape(-1, 4).sum(axis=1)
    return {name: float(far) for name, far in zip(bodies, each, strict=True) if far > equilibrium.ZERO}
