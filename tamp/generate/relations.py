"""What each relation means: drawing a place that fulfils it, by geometry alone.

Every place is relative to the other object's, with random freedom where the relation leaves some. What rests on
something is lowered until it touches; what leans is pushed until it touches. Physics has the last word afterwards.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from tamp.generate.thing import Thing, transform, yawed
from tamp.world.solid import overlap, relative

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Matrix = NDArray[np.float64]

Bodies = Sequence[tuple[Thing, "Matrix"]]

GAP = (0.025, 0.05)
"""Room between neighbours, so that a finger fits between them [m]."""
JITTER = 0.003
"""How far a thing may be off the middle of what it is stacked on [m]."""
SKEW = 0.12
"""How far it may be turned against its neighbour [rad]."""
LEAN = (0.2, 0.35)
"""How far what leans is tilted [rad]."""
OVERHANG = 1.05
"""How much wider than a place a thing's foot may be."""
WALL = 0.02
"""How far from the walls of a hollow a thing lies where there is room, so that a finger gets between [m]."""
CHOICE = 4
"""Of how many places in a hollow the lowest is taken."""
LIFT = 0.0005
"""Things are drawn this far above what they rest on [m]."""


def fits(relation: str, child: Thing, parent: Thing) -> bool:
    """Whether a child can stand in a relation to a parent, by their sizes."""
    R = child.resting[0]
    if relation == "in":
        return _goes_into(child.outline(R)[:2], parent.model.hollow, 1.1)
    if relation == "on":
        return _goes_into(child.foot(R), parent.model.top, OVERHANG)
    if relation == "stacked":
        return child.model == parent.model or _goes_into(child.foot(R), parent.model.top, OVERHANG)
    if relation == "standing":
        length, *across = sorted(child.outline(R), reverse=True)
        return _goes_into(np.array(across), parent.model.hollow, 0.6) and length > 0.09
    if relation == "leaning":
        thin, _, high = child.outline(R)
        return bool(thin < 0.45 * high and parent.outline(parent.resting[0])[2] > 0.6 * high)
    return True


def _goes_into(sides: Matrix, area: tuple[float, float] | None, slack: float) -> bool:
    if area is None:
        return False
    return all(side <= slack * room for side, room in zip(sorted(sides), sorted(area), strict=True))


@dataclass(frozen=True, eq=False)
class Wish:
    """What a place is drawn for.

    Attributes:
        thing: what is to be placed.
        parent: what it refers to.
        T_parent: where that stands, shape (4, 4).
        others: everything that stands there already, the parent included.
        index, count: which one it is, counted from 0, of how many with this relation to this parent.
        rng: source of what the relation leaves open.
    """

    thing: Thing
    parent: Thing
    T_parent: Matrix
    others: Bodies
    index: int
    count: int
    rng: np.random.Generator

    @property
    def heading(self) -> float:
        """Direction of the parent's x axis seen from above [rad]."""
        return math.atan2(self.T_parent[1, 0], self.T_parent[0, 0])

    def turned(self, turn: float) -> Matrix:
        """The thing upright, turned against the parent's heading by an angle [rad] and a little askew."""
        return yawed(self.thing.resting[0], self.heading + turn + self.rng.uniform(-SKEW, SKEW))

    def quarter(self) -> float:
        """One of four directions [rad]."""
        return float(self.rng.integers(4)) * math.pi / 2

    def over(self, offset: Matrix) -> Matrix:
        """A point over the parent, by its offset from the parent's origin along the parent's heading, shape (2,)."""
        point: Matrix = self.T_parent[:3, 3] + yawed(np.eye(3), self.heading)[:, :2] @ offset
        return point


def on_table(thing: Thing, R: Matrix, xy: tuple[float, float] = (0.0, 0.0)) -> Matrix:
    """The pose, shape (4, 4), of a thing turned by `R` that stands on the table at a point."""
    return transform(R, (*xy, LIFT - thing.bottom(R)))


def draw_place(relation: str, wish: Wish) -> Matrix | None:
    """A pose, shape (4, 4), in which a thing has a relation to another; None where the draw leads to none."""
    return _PLACES[relation](wish)


def _on(wish: Wish) -> Matrix | None:
    """On a flat top: anywhere that keeps its foot on it, in any of four turns and a little askew."""
    R = wish.turned(wish.quarter())
    return _within(wish, R, wish.parent.model.top, wish.thing.foot(yawed(R, -wish.heading)))


def _in(wish: Wish) -> Matrix | None:
    """In a hollow: the lowest of a few places, so that it lies on the floor where there is still room beside others."""
    places = []
    for _ in range(CHOICE):
        R = wish.turned(wish.quarter())
        sides = wish.thing.outline(yawed(R, -wish.heading))[:2] + 2 * WALL
        places.append(_within(wish, R, wish.parent.model.hollow, sides))
    return min(places, key=lambda T: float(T[2, 3]))


def _within(wish: Wish, R: Matrix, area: tuple[float, float] | None, sides: Matrix) -> Matrix:
    """Somewhere in an area of the parent's middle, for a thing turned by `R` that takes up `sides` of it [m]."""
    room = np.maximum(0.0, np.array(area) - sides) / 2
    return _lowered(wish.thing, R, wish.over(wish.rng.uniform(-room, room)), wish.others)


def _stacked(wish: Wish) -> Matrix | None:
    return _lowered(wish.thing, wish.turned(0.0), wish.over(wish.rng.uniform(-JITTER, JITTER, 2)), wish.others)


def _upright_in(wish: Wish) -> Matrix | None:
    """Its long axis upright, a little aslant, its foot somewhere in the hollow."""
    axis = int(np.argmax(np.ptp(wish.thing.points, axis=0)))
    upright = np.eye(3)[[(axis + 1) % 3, (axis + 2) % 3, axis]]
    spun = yawed(upright, wish.rng.uniform(-math.pi, math.pi))
    R = _tilt(wish.rng.uniform(-math.pi, math.pi), wish.rng.uniform(0.02, 0.1)) @ spun
    room = 0.25 * np.array(wish.parent.model.hollow)
    return _lowered(wish.thing, R, wish.over(wish.rng.uniform(-room, room)), wish.others)


def _beside(wish: Wish) -> Matrix | None:
    """On one of four sides, as far off as a finger needs, turned alike or by a quarter."""
    return _next_to(wish, wish.quarter(), wish.quarter())


def _in_row(wish: Wish) -> Matrix | None:
    """Next in a row that runs along the parent's short side, turned alike."""
    x, y, _ = wish.parent.outline(wish.parent.resting[0])
    return _next_to(wish, 0.0 if x < y - 1e-3 else math.pi / 2, 0.0)


def _around(wish: Wish) -> Matrix | None:
    """Spread evenly round the parent, long things with their side towards it."""
    side = math.pi / 2 + wish.index * math.tau / max(2, wish.count) + wish.rng.uniform(-0.15, 0.15)
    return _next_to(wish, side, side - math.pi / 2)


def _next_to(wish: Wish, side: float, turn: float) -> Matrix:
    """Beside the parent in the direction `side`, turned by `turn`, both against the parent's heading [rad]."""
    R, heading = wish.turned(turn), wish.heading + side
    direction = np.array([math.cos(heading), math.sin(heading)])
    apart = _reach(wish.parent, wish.T_parent[:3, :3], direction) + _reach(wish.thing, R, -direction)
    x, y = wish.T_parent[:2, 3] + (apart + wish.rng.uniform(*GAP)) * direction
    return on_table(wish.thing, R, (float(x), float(y)))


def _leaning(wish: Wish) -> Matrix | None:
    """Its thin side against one side of the parent, tilted, pushed until it touches."""
    heading = wish.heading + wish.quarter()
    direction = np.array([math.cos(heading), math.sin(heading)])
    R = _tilt(heading + math.pi, wish.rng.uniform(*LEAN)) @ yawed(wish.thing.resting[0], heading)
    aside = wish.T_parent[:2, 3] + wish.rng.uniform(-0.01, 0.01) * np.array([-direction[1], direction[0]])
    apart = _reach(wish.parent, wish.T_parent[:3, :3], direction) + _reach(wish.thing, R, -direction)
    found = None
    for distance in np.arange(apart + 0.002, max(0.0, apart - 0.08), -0.002):
        x, y = aside + distance * direction
        closer = on_table(wish.thing, R, (float(x), float(y)))
        if hits(wish.thing, closer, wish.others):
            return found
        found = closer
    return None


_PLACES: Mapping[str, Callable[[Wish], Matrix | None]] = MappingProxyType(
    {
        "on": _on, "in": _in, "stacked": _stacked, "standing": _upright_in, "beside": _beside,
        "row": _in_row, "around": _around, "leaning": _leaning,
    }
)  # fmt: skip


def _tilt(heading: float, angle: float) -> Matrix:
    """The rotation that makes what is upright lean towards a heading by an angle [rad]."""
    about = yawed(np.eye(3), heading)
    c, s = math.cos(angle), math.sin(angle)
    turned: Matrix = about @ np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]) @ about.T
    return turned


def _reach(thing: Thing, R: Matrix, direction: Matrix) -> float:
    """How far a thing turned by `R` reaches from its origin in a horizontal direction [m]."""
    return float((thing.points @ R[:2].T @ direction).max())


def hits(thing: Thing, T: Matrix, others: Bodies, gap: float = 0.0) -> bool:
    """Whether a thing at a pose comes nearer than `gap` [m] to any of the others."""
    return any(overlap(thing.solid, other.solid, relative(T, T_other), gap) for other, T_other in others)


def _lowered(thing: Thing, R: Matrix, over: Matrix, others: Bodies) -> Matrix:
    """The thing turned by `R`, over a point, let down until just above what it touches first."""
    top = max(float((other.points @ T[2, :3]).max() + T[2, 3]) for other, T in others)
    T = transform(R, (float(over[0]), float(over[1]), top - thing.bottom(R) + 0.01))
    floor = -thing.bottom(R)
    step = 0.008
    while step > LIFT:
        lower = T.copy()
        lower[2, 3] -= step
        if lower[2, 3] < floor or hits(thing, lower, others):
            step /= 2
        else:
            T = lower
    return T
