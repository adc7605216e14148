"""The arena's shortcuts (broadphase, hulls before parts) against asking every pair of parts."""

from __future__ import annotations

import numpy as np

from tamp.task import Box
from tamp.world.geometry import convex_union as solids
from tamp.world.geometry.object_geometry import geometry_of, load_geometry
from tamp.world.scene import Scene
from tamp.world.world import World


def tray():
    """A floor and four walls, 16 cm wide, so that the hull is mostly air."""
    walls = []
    for size, center in [
        ((0.16, 0.16, 0.01), (0, 0, 0.005)),
        ((0.01, 0.16, 0.1), (-0.075, 0, 0.05)),
        ((0.01, 0.16, 0.1), (0.075, 0, 0.05)),
        ((0.16, 0.01, 0.1), (0, -0.075, 0.05)),
        ((0.16, 0.01, 0.1), (0, 0.075, 0.05)),
    ]:
        (part,) = load_geometry(Box(size)).parts
        walls.append(type(part)(part.vertices + np.array(center), part.faces))
    return geometry_of(walls)


def test_hulls_first_and_parts_after_is_as_exact_as_all_parts(panda):
    rng = np.random.default_rng(0)
    names = [f"tray{i}" for i in range(5)]
    world = World(panda, {name: tray() for name in names})
    poses = {}
    for name in names:
        T = np.eye(4)
        T[:3, 3] = (*rng.uniform([-0.05, -0.3], [0.2, 0.3]), rng.uniform(0.0, 0.15))
        poses[name] = T
    T_tool_tray = np.eye(4)
    T_tool_tray[:3, 3] = 0.0, 0.06, 0.0
    scene = Scene(poses).attached("tray4", T_tool_tray, 0.02)
    margin, held_margin = 0.004, -0.002
    checker = world.checker(scene, margin=margin, held_margin=held_margin, touch={"tray0": 0.0})
    low = panda.home + np.array([0, 0.5, 0, -0.5, 0, 0.3, 0])
    outcomes = {True: 0, False: 0}
    for _ in range(150):
        q = low + rng.uniform(-0.4, 0.4, 7)
        free = checker.free(q)
        assert free == _all_parts(checker, q)
        outcomes[free] += 1
    assert min(outcomes.values()) > 5


def _all_parts(checker, q):
    arena = checker._arena
    arena.hit(checker.robot.full(q, 0.02))
    for a, b in arena.pairs:
        if solids.overlap(arena._solids[a], arena._solids[b], arena._relative(a, b), arena._margins[a, b]):
            return False
    return True


def test_margins_are_looked_up_by_who_touches_what(panda):
    box = load_geometry(Box((0.05, 0.05, 0.05)))
    world = World(panda, {"a": box, "b": box})
    T = np.eye(4)
    T[:3, 3] = 0.1, 0.3, 0.025
    scene = Scene({"a": T}).attached("b", np.eye(4), 0.05)
    checker = world.checker(scene, margin=0.01, held_margin=-0.003, touch={"a": 0.001, "table": 0.004})
    checker.free(panda.home)
    arena = checker._arena
    index = {name: i for i, name in enumerate(arena.names)}
    margin = arena._margins
    assert margin[index["panda_hand"], index["a"]] == 0.001
    assert margin[index["panda_hand"], index["table"]] == 0.004
    assert margin[index["a"], index["b"]] == margin[index["table"], index["b"]] == -0.003
    assert margin[index["panda_link5"], index["panda_hand"]] == 0.002

    world.checker(scene, margin=0.01, held_margin=-0.001, held_touch={"table": -0.004, "gone": 0.0}).free(panda.home)
    assert margin[index["table"], index["b"]] == -0.004
    assert margin[index["a"], index["b"]] == -0.001
    assert margin[index["panda_hand"], index["table"]] == 0.01
