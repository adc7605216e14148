"""Poses for a scene graph: each group laid out round its root, then put somewhere on the table."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from tamp.generate.graph import CARRIED, Node, SceneGraph
from tamp.generate.placement.contact import hits, on_table
from tamp.generate.placement.object_model import Thing, transform, yawed
from tamp.generate.placement.relations import draw_place
from tamp.generate.placement.request import Wish
from tamp.generate.reach import FAR, base, reachable
from tamp.task import Table

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Matrix = NDArray[np.float64]

Standing = dict[str, "Matrix"]
"""Object -> its pose, shape (4, 4)."""

GROUP_TRIES = 12
"""Draws of a group's inner layout."""
PLACE_TRIES = 80
"""Draws of a group's place on the table."""
GAP = 0.03
"""Least room between groups [m]."""
INNER_GAP = 0.01
"""Least room between members of a group that do not rest on each other [m]."""
EDGE = 0.01
"""Least distance from the table's edge [m]."""
NEARBY = 0.012
"""How far a group's root may be off a place it is asked for [m]."""

Place = tuple[float, float]


def lay_out(
    graph: SceneGraph,
    things: Mapping[str, Thing],
    rng: np.random.Generator,
    *,
    wanted: Mapping[str, Place] | None = None,
    clear_of: Mapping[str, Matrix] | None = None,
) -> Standing | None:
    """Draw poses for all objects of a graph: in their relations, on the table, apart, within reach.

    Args:
        graph: the scene.
        things: object -> its geometry.
        rng: source of everything that is drawn.
        wanted: object -> where on the table it is to stand, for some roots of groups [m].
        clear_of: object -> pose, shape (4, 4), of things that groups stay clear of where nothing else is wanted.

    Returns:
        Object -> pose, shape (4, 4); None where no place was found for some group.
    """
    wanted = wanted or {}
    standing: Standing = {}
    blocked = [(things[name], T) for name, T in (clear_of or {}).items()]
    groups = graph.groups()
    # Those that know where they belong first, then the largest: it is hardest to find room for.
    for group in sorted(groups, key=lambda nodes: (nodes[0].name not in wanted, -len(nodes))):
        inner = _inner_layout(group, things, rng)
        if inner is None:
            return None
        place = wanted.get(group[0].name)
        others = [(things[name], T) for name, T in standing.items()]
        placed = _put(inner, things, others if place else [*blocked, *others], place, rng)
        if placed is None:
            return None
        standing.update(placed)
    return standing


def _inner_layout(group: Sequence[Node], things: Mapping[str, Thing], rng: np.random.Generator) -> Standing | None:
    """The group with its root at the origin; None where its members would not fit together."""
    for _ in range(GROUP_TRIES):
        standing: Standing = {}
        for node in group:
            T = _member(node, group, things, standing, rng)
            if T is None or not _apart(node, T, things, standing):
                break
            standing[node.name] = T
        else:
            return standing
    return None


def _member(
    node: Node, group: Sequence[Node], things: Mapping[str, Thing], standing: Standing, rng: np.random.Generator
) -> Matrix | None:
    thing = things[node.name]
    if node.parent is None:
        return on_table(thing, thing.resting[node.resting])
    siblings = [n.name for n in group if (n.relation, n.parent) == (node.relation, node.parent)]
    wish = Wish(
        thing=thing,
        parent=things[node.parent],
        T_parent=standing[node.parent],
        others=[(things[name], T) for name, T in standing.items()],
        index=siblings.index(node.name),
        count=len(siblings),
        rng=rng,
    )
    return draw_place(node.relation, wish)


def _apart(node: Node, T: Matrix, things: Mapping[str, Thing], standing: Standing) -> bool:
    """Whether a member keeps its distance from all others, where its relation is not to touch them."""
    touching = node.relation in (*CARRIED, "leaning")
    others = [(things[name], T_other) for name, T_other in standing.items()]
    return not hits(things[node.name], T, others, 0.0 if touching else INNER_GAP)


def _put(
    inner: Standing,
    things: Mapping[str, Thing],
    others: Sequence[tuple[Thing, Matrix]],
    wanted: Place | None,
    rng: np.random.Generator,
) -> Standing | None:
    """A group somewhere on the table, or about the place wanted; None where there is no room."""
    for _ in range(PLACE_TRIES):
        if wanted is None:
            x, y = _draw_place(rng)
        else:
            x, y = np.array(wanted) + rng.uniform(-NEARBY, NEARBY, 2)
        T_world_root = transform(yawed(np.eye(3), rng.uniform(-math.pi, math.pi)), (x, y, 0.0))
        placed = {name: T_world_root @ T for name, T in inner.items()}
        if (
            all(_on_table(things[name], T) for name, T in placed.items())
            and not any(hits(things[name], T, _near(things[name], T, others), GAP) for name, T in placed.items())
            and all(reachable(things[name], T) for name, T in placed.items())
        ):
            return placed
    return None


def _draw_place(rng: np.random.Generator) -> Place:
    """A point in the rectangle round what the robot reaches."""
    x, y = base()
    return x + float(rng.uniform(0.0, FAR)), y + float(rng.uniform(-FAR, FAR))


def _on_table(thing: Thing, T: Matrix) -> bool:
    points = thing.points @ T[:2, :3].T + T[:2, 3]
    table = Table()
    inside = np.abs(points - table.center).max(axis=0) <= np.array(table.size) / 2 - EDGE
    return bool(inside.all())


def _near(thing: Thing, T: Matrix, others: Sequence[tuple[Thing, Matrix]]) -> list[tuple[Thing, Matrix]]:
    """Those of the others whose bounding balls come within the gap."""
    return [
        (other, T_other)
        for other, T_other in others
        if float(np.linalg.norm(T[:3, 3] - T_other[:3, 3])) < thing.radius + other.radius + GAP
    ]
