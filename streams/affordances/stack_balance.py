"""Does a pile stay at rest when something is taken off it or put on it? The whole of it, not each body by itself.

A body that carries others tips where all that weighs on it has its centre beside what carries it: a plank on a block,
when one of two counterweights leaves. Each contact pushes straight up, and the pushes must balance every body's weight
and its moments: a linear program, the support polygon of one body for many. Where it does not stand by such pushes,
walls and friction may still hold it (`friction_cones`); a pile that never stood by straight ones is not judged.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from tamp.execution.settling.settle import settle
from tamp.streams.affordances.friction_cones import around, center_at, in_equilibrium, least
from tamp.streams.affordances.stable_poses import base, inside_by, outline
from tamp.streams.affordances.support import inside_support
from tamp.streams.context import Context
from tamp.streams.hand.finger_closing import felt
from tamp.streams.values import Balance, Placement
from tamp.streams.workspace import TABLE, Workspace, standing
from tamp.task import Pose
from tamp.world.geometry.half_spaces import half_spaces

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

NEAR = 0.004  # surface this near to another body may rest on it [m]
UPWARD = 0.7  # what carries without friction has about this vertical share of its normal
SLUMP = 0.01  # so far what is left of a pile may move: the checker grants little more [m]
STILL = 0.002  # what moves by less stays where it is [m]
SLUMPING_S = 2.0  # what moves longer than this rolls [s]
GIVEN = 5e-4  # how far elsewhere the centres of mass may lie, all together [m]


def balance_without(context: Context, obj: str, placement: Placement) -> Iterator[Balance]:
    """Yield once where what an object stands among stays at rest when it is taken; all is as in `context.fluents`."""
    if not _upset(context, obj, placement, put=False):
        yield Balance(obj, placement)


def balance_with(context: Context, obj: str, placement: Placement) -> Iterator[Balance]:
    """Yield once where what an object is put on stays at rest under it; all else is as in `context.fluents`."""
    if not _upset(context, obj, placement, put=True):
        yield Balance(obj, placement)


def _upset(context: Context, obj: str, placement: Placement, *, put: bool) -> bool:
    """Whether the pile that an object joins is upset as it is put there, or taken; says so, and because of what."""
    around = {**standing(context.fluents), obj: placement}
    if len(around) < len(context.scene.task.objects):
        return False  # a question about a part of the scene: what is left out may hold the rest down
    if not _tips(context.scene, obj, around, put=put):
        return False
    others = pile_of(obj, around) - {obj}
    because = [fact for fact in context.fluents if fact[1] in others]
    context.fail(f"{', '.join(sorted(others))} would tip", because=because)
    return True


def tips_with(workspace: Workspace, obj: str, placement: Placement) -> bool:
    """Whether what an object is put on does not stay at rest under it, with all others where they stand now."""
    return _tips(workspace, obj, {**workspace.start, obj: placement}, put=True)


def _tips(workspace: Workspace, obj: str, around: Mapping[str, Placement], *, put: bool) -> bool:
    """Whether a pile that stood does not as an object, which stands `around` with the others, is put there or taken."""

    def found() -> bool:
        joined = dict(pile_at(obj, around))
        apart = {name: place for name, place in joined.items() if name != obj}
        stood, stands = (apart, joined) if put else (joined, apart)
        if at_rest(workspace, stands) or not at_rest(workspace, stood) or in_equilibrium(workspace, stands):
            return False
        return put or not _settles(workspace, stands, SLUMP)

    return workspace.cache.value(("upset", obj, put, pile_at(obj, around)), found)


def needed_below(workspace: Workspace, obj: str, leaving: Iterable[str]) -> tuple[str, ...]:
    """What an object rests on, but for what may leave, all of it at once, while nothing else moves.

    It touches that and does not need it, as what lies beside another in a box does. Physics tells: in a jam pushes have
    no one solution.

    Args:
        workspace: where all stand at the start.
        obj: the object.
        leaving: of what it rests on, what may leave, in the order in which it is tried.
    """
    on, gone = workspace.start[obj].on, set[str]()
    for lower in leaving if len(on) > 1 else ():
        if lower != TABLE and _stays_without(workspace, obj, gone | {lower}):
            gone.add(lower)
    return tuple(lower for lower in on if lower not in gone)


def _stays_without(workspace: Workspace, obj: str, gone: Collection[str]) -> bool:
    """Whether an object stays where it is, and all of its pile does, when some of what it rests on is taken away."""
    start = workspace.start
    rest = {name: place for name, place in pile_at(obj, start) if name not in gone}
    below = {name: start[name] for name in start[obj].on if name in rest}
    if inside_support(workspace, obj, start[obj], below) <= 0.0:
        return False
    return workspace.cache.value(("stays", tuple(rest.items())), lambda: _settles(workspace, rest, STILL))


def _settles(workspace: Workspace, places: Mapping[str, Placement], within: float) -> bool:
    """Whether the rest of a pile comes to rest within so far [m] of where it is, as something has been taken from it.

    Physics tells: what lies on a round handle rolls with that until both lie.
    """
    poses = {name: place.pose for name, place in places.items()}
    rest = settle(workspace.task, poses, limit_s=SLUMPING_S, simulator=workspace.settling)
    return rest.resting and all(_moved(workspace, name, poses[name], rest.poses[name]) < within for name in poses)


def _moved(workspace: Workspace, name: str, before: Pose, after: Pose) -> float:
    """How far an object is from one pose at another, in the mean over its corners [m]."""
    points = workspace.points(name)
    way = points @ (after.matrix - before.matrix)[:3, :3].T + np.subtract(after.xyz, before.xyz)
    return float(np.linalg.norm(way, axis=1).mean())


def learn_upset(workspace: Workspace, obj: str, around: Mapping[str, Placement], *, put: bool = True) -> None:
    """Have the pile that an object is put on, or taken from, count as upset by that; `around` is where all stand."""
    workspace.cache.learn(("upset", obj, put, pile_at(obj, around)), True)


def pile_at(obj: str, around: Mapping[str, Placement]) -> tuple[tuple[str, Placement], ...]:
    """The pile that an object belongs to, and where each of it stands, in the order of their names."""
    return tuple((name, around[name]) for name in sorted(pile_of(obj, around)))


def pile_of(obj: str, around: Mapping[str, Placement]) -> set[str]:
    """An object, what carries it and what that carries, and so on; the table holds nothing together."""
    found, waiting = {obj}, [obj]
    while waiting:
        name = waiting.pop()
        beside = {other for other, place in around.items() if name in place.on} | {*around[name].on}
        beside = (beside & around.keys()) - found
        found |= beside
        waiting += sorted(beside)
    return found


def at_rest(workspace: Workspace, places: Mapping[str, Placement]) -> bool:
    """Whether pushes straight up at all contacts balance the weights of bodies at these placements.

    Bodies that rest on something of which no contact is found are taken to be at rest.
    """
    pairs = [(name, lower) for name, place in places.items() for lower in place.on if lower in places or lower == TABLE]
    points = [contacts(workspace, name, places[name], lower, places.get(lower)) for name, lower in pairs]
    if not places or any(not len(found) for found in points):
        return True
    touching = dict(zip(pairs, points, strict=True))
    if sorted(name for name, _ in pairs) == sorted(places):
        return _each_on_one(workspace, places, touching)
    return least(*_program(workspace, places, touching)) <= GIVEN


def _each_on_one(
    workspace: Workspace, places: Mapping[str, Placement], touching: Mapping[tuple[str, str], Array]
) -> bool:
    """The same where each body rests on one other: the centre of all that it carries is over what carries it."""
    load = {name: [workspace.task.object(name).mass] for name in places}
    middle = {name: load[name][0] * center_at(workspace, name, places[name])[:2] for name in places}
    waiting = dict(touching)
    while waiting:
        free = sorted(pair for pair in waiting if all(lower != pair[0] for _, lower in waiting))
        if not free:
            return True  # they carry each other in a circle
        for name, lower in free:
            corners = outline(waiting.pop((name, lower)))
            mass = sum(load[name])
            if len(corners) < 3 or inside_by(corners, middle[name] / mass) < -GIVEN:
                return False
            if lower in places:
                load[lower] += load[name]
                middle[lower] = middle[lower] + middle[name]
    return True


def _program(
    workspace: Workspace, places: Mapping[str, Placement], touching: Mapping[tuple[str, str], Array]
) -> tuple[Array, Array, Array]:
    """Costs, columns and wanted sums: pushes at all contacts, and shifts of the centres of mass, which cost."""
    row = {name: 3 * index for index, name in enumerate(places)}
    mass = np.array([workspace.task.object(name).mass for name in places])
    columns = np.zeros((3 * len(row), sum(map(len, touching.values())) + 4 * len(row)))
    wanted, cost, first = np.zeros(3 * len(row)), np.zeros(columns.shape[1]), 0
    for (name, lower), found in touching.items():
        for body, sign in ((name, 1.0), (lower, -1.0)):
            if body in row:
                lever = found - center_at(workspace, body, places[body])[:2]
                block = np.vstack([np.ones(len(found)), lever.T])
                columns[row[body] : row[body] + 3, first : first + len(found)] = sign * block
        first += len(found)
    for index, start in enumerate(row.values()):
        wanted[start] = mass[index] / mass.mean()
        shifts = slice(first + 4 * index, first + 4 * index + 4)
        columns[start + 1 : start + 3, shifts] = [[1.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0]]
        cost[shifts] = mass.mean() / mass[index]
    return cost, columns, wanted


def contacts(workspace: Workspace, name: str, placement: Placement, lower: str, below: Placement | None) -> Array:
    """Where a body rests on another one, or on the table where `below` is None, from above, shape (n, 2)."""

    def found() -> Array:
        if below is None:
            T = placement.pose.matrix
            return base(workspace.points(name) @ T[:3, :3].T + T[:3, 3])
        onto = _near(workspace, name, placement, lower, below, 1.0)
        under = _near(workspace, lower, below, name, placement, -1.0)
        return np.vstack([onto, under])

    return workspace.cache.value(("rests at", name, placement, lower, below), found)


def _near(workspace: Workspace, one: str, at: Placement, other: str, there: Placement, upward: float) -> Array:
    """Points of a body near faces of another that look up, or down for an `upward` of -1, from above, shape (n, 2)."""
    T, T_other = at.pose.matrix, there.pose.matrix
    points = np.vstack([workspace.points(one), felt(workspace, one)]) @ T[:3, :3].T + T[:3, 3]
    local = (points - T_other[:3, 3]) @ T_other[:3, :3]
    kept = np.zeros(len(points), dtype=bool)
    for part in workspace.world.geometries[other].parts:
        A, b = half_spaces(part)
        beside = np.flatnonzero(around(part, local))
        outside = local[beside] @ A.T - b
        face = outside.argmax(axis=1)
        facing = upward * (A @ T_other[2, :3])[face] > UPWARD
        kept[beside[facing & (np.abs(outside[np.arange(len(beside)), face]) < NEAR)]] = True
    near: Array = points[kept, :2]
    return near
