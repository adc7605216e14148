"""What each relation means: drawing a place that fulfils it, by geometry alone.

Every place is relative to the other object's, with random freedom where the relation leaves some. What rests on
something is lowered until it touches; what leans is pushed until it touches. Physics has the last word afterwards.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from tamp.generate.placement.contact import hits, lowered, on_table
from tamp.generate.placement.object_model import Thing, yawed
from tamp.generate.placement.request import Wish

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Matrix = NDArray[np.float64]

GAP = (0.025, 0.05)
"""Room between neighbours, so that a finger fits between them [m]."""
JITTER = 0.003
"""How far a thing may be off the middle of what it is stacked on [m]."""
LEAN = (0.2, 0.35)
"""How far what leans is tilted [rad]."""
WALL = 0.02
"""How far from the walls of a hollow a thing lies where there is room, so that a finger gets between [m]."""
CHOICE = 4
"""Of how many places in a hollow the lowest is taken."""


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
    return lowered(wish.thing, R, wish.over(wish.rng.uniform(-room, room)), wish.others)


def _stacked(wish: Wish) -> Matrix | None:
    return lowered(wish.thing, wish.turned(0.0), wish.over(wish.rng.uniform(-JITTER, JITTER, 2)), wish.others)


def _upright_in(wish: Wish) -> Matrix | None:
    """Its long axis upright, a little aslant, its foot somewhere in the hollow."""
    axis = int(np.argmax(np.ptp(wish.thing.points, axis=0)))
    upright = np.eye(3)[[(axis + 1) % 3, (axis + 2) % 3, axis]]
    spun = yawed(upright, wish.rng.uniform(-math.pi, math.pi))
    R = _tilt(wish.rng.uniform(-math.pi, math.pi), wish.rng.uniform(0.02, 0.1)) @ spun
    room = 0.25 * np.array(wish.parent.model.hollow)
    return lowered(wish.thing, R, wish.over(wish.rng.uniform(-room, room)), wish.others)


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
