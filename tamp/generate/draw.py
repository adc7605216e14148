"""Drawing scene graphs: goals from the patterns of a family, starts at random, and places that are in the way."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from tamp.generate.features import TURNED_OVER
from tamp.generate.graph import CARRIED, SAME, TABLE, Node, Pattern, SceneGraph
from tamp.generate.levels import Level
from tamp.generate.placement.fitting import fits
from tamp.generate.placement.object_model import Thing, thing
from tamp.scenarios.library.model import Model

if TYPE_CHECKING:
    from tamp.generate.layout import Place
    from tamp.generate.scene import Scene

TRIES = 40
GRIP = 0.075
"""A thing that lies tipped must be no wider than this one way, so that the hand can take it [m]."""
UNTIDY = ("beside", "on", "in", "stacked", "leaning")
"""Relations of starts that nobody tidied up; the first one has nothing carry another."""
TIPPED = 3
"""The most objects that lie tipped at the start."""


def draw_goal(
    patterns: Sequence[Pattern], models: Sequence[Model], level: Level, rng: np.random.Generator
) -> tuple[dict[str, Thing], SceneGraph]:
    """Objects and how they shall stand: patterns of the family until the level's number is reached.

    Args:
        patterns: the family's scene graphs.
        models: what objects may be drawn from.
        level: gives how many.
        rng: source of everything that is drawn.
    """
    count = int(rng.integers(level.objects[0], level.objects[1] + 1))
    things: dict[str, Thing] = {}
    nodes: list[Node] = []
    fitting = [pattern for pattern in patterns if pattern.first_level <= level.number]
    for _ in range(TRIES):
        room = [pattern for pattern in fitting if len(pattern.slots) <= count - len(nodes)]
        if not room:
            break
        stacked = [p for p in room if any(slot.relation in CARRIED for slot in p.slots)]
        if level.stacked[0] > sum(node.relation in CARRIED for node in nodes) and stacked:
            room = stacked
        drawn = _filled(room[int(rng.integers(len(room)))], models, things, rng)
        if drawn is not None:
            found, added = drawn
            things |= found
            nodes += added
    return things, SceneGraph(tuple(nodes))


def _filled(
    pattern: Pattern, models: Sequence[Model], taken: Mapping[str, Thing], rng: np.random.Generator
) -> tuple[dict[str, Thing], list[Node]] | None:
    """A pattern with models in its roles; None where one of them finds none that fits."""
    library = tuple(models)
    roles: dict[str, str] = {}
    things: dict[str, Thing] = {}
    nodes = []
    for slot in pattern.slots:
        parent = things[roles[slot.parent]] if slot.parent is not None else None
        if slot.kinds == (SAME,):
            assert parent is not None
            choice = [parent.model]
        else:
            choice = [model for model in library if slot.admits(model, library)]
        choice = [model for model in choice if parent is None or fits(slot.relation, thing(model), parent)]
        if not choice:
            return None
        model = choice[int(rng.integers(len(choice)))]
        name = _free_name(model.name, {*taken, *things})
        roles[slot.role], things[name] = name, thing(model)
        nodes.append(Node(name, slot.relation, None if slot.parent is None else roles[slot.parent]))
    return things, nodes


def _free_name(name: str, taken: set[str]) -> str:
    """The model's name, numbered from the second copy on."""
    copy = 2
    found = name
    while found in taken:
        found = f"{name}-{copy}"
        copy += 1
    return found


def draw_start(things: Mapping[str, Thing], goal: SceneGraph, level: Level, rng: np.random.Generator) -> SceneGraph:
    """How the objects stand before anybody has tidied up: scattered, some on, in or against each other, some tipped."""
    nodes = {name: Node(name) for name in sorted(things)}
    if level.reoriented[1] > 0:
        _tip(nodes, things, rng)
    relations = UNTIDY if level.stacked_start else UNTIDY[:1]
    for _ in range(int(rng.integers(level.untidy + 1))):
        relation = relations[int(rng.integers(len(relations)))]
        pairs = [
            (child, parent)
            for child in nodes
            for parent in nodes
            if _may_be_related(nodes[child], nodes[parent], nodes, goal)
            and fits(relation, things[child], things[parent])
        ]
        if pairs:
            child, parent = pairs[int(rng.integers(len(pairs)))]
            nodes[child] = Node(child, relation, parent)
    return SceneGraph(tuple(sorted(nodes.values(), key=lambda node: (node.parent is not None, node.name))))


def _may_be_related(child: Node, parent: Node, nodes: Mapping[str, Node], goal: SceneGraph) -> bool:
    """Whether a start may relate a child to a parent: both upright on the table, and not related in the goal."""
    free = child.name != parent.name and child.relation == parent.relation == TABLE
    upright = not child.resting and not parent.resting
    bare = all(node.parent != child.name for node in nodes.values())
    return free and upright and bare and goal.node(child.name).parent != parent.name


def _tip(nodes: dict[str, Node], things: Mapping[str, Thing], rng: np.random.Generator) -> None:
    """Turn over some of the objects that the hand can still take then."""
    ways = {name: ways for name in nodes if (ways := _tipped_ways(things[name]))}
    for name in rng.permutation(sorted(ways))[: int(rng.integers(1, TIPPED + 1))]:
        choice = ways[str(name)]
        nodes[str(name)] = Node(str(name), resting=choice[int(rng.integers(len(choice)))])


def _tipped_ways(item: Thing) -> list[int]:
    upright = item.resting[0][2]
    return [
        way
        for way, R in enumerate(item.resting)
        if item.tilt(R[2], upright) > TURNED_OVER and item.outline(R)[:2].min() <= GRIP
    ]


def draw_wanted(start: Scene, goal: SceneGraph, level: Level, rng: np.random.Generator) -> dict[str, Place]:
    """Roots of goal groups -> the place of another object's start, so many as the level wants goals occupied."""
    spots = {node.name: start.poses[node.name].xyz[:2] for node in start.graph.nodes if node.parent is None}
    roots = [str(name) for name in rng.permutation(sorted(group[0].name for group in goal.groups()))]
    wanted: dict[str, Place] = {}
    if level.cycles[0]:
        ring = [name for name in roots if name in spots][: int(rng.integers(2, 4))]
        wanted |= {
            name: spots[other] for name, other in zip(ring, [*ring[1:], *ring[:1]], strict=True) if name != other
        }
    for name in roots:
        taken = set(wanted.values())
        free = sorted(other for other, spot in spots.items() if other != name and spot not in taken)
        if len(wanted) < level.occupied[0] and name not in wanted and free:
            wanted[name] = spots[free[int(rng.integers(len(free)))]]
    return wanted
