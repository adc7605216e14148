"""A scene at rest: physics has the last word on whether a layout stands, and whether its relations hold."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from tamp.execution.settling.settle import Settled, settle
from tamp.generate.graph import Node, SceneGraph
from tamp.generate.placement.contact import hits
from tamp.generate.placement.object_model import Thing
from tamp.generate.reach import reachable
from tamp.scoring.ede import ede, mean_edge
from tamp.task import Pose, Task

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Matrix = NDArray[np.float64]

SETTLE_S, AGAIN_S = 2.5, 1.5
"""How long a layout is given to come to rest, and how long it is watched after that [simulated s].

What counts is that it stays: light thin things tremble where they lie and never come to rest for physics.
"""
CREEP, LONG_S = 0.0003, 6.0
"""What moves farther than this meanwhile (EDE) [m] may be rolling slowly and is watched for longer [simulated s]."""
DRIFT = 0.002
"""How far anything in an accepted scene may move (EDE) when it is settled once more [m]."""
MOVED = 0.012
"""How far settling may move what stands beside others or on them [m]."""
SAME_WAY = 0.1
"""How far it may turn it over [rad]."""
LEANING = (0.1, 0.7)
"""How far what leans is tilted in the end [rad]."""
INSIDE = 0.003
"""How deep two objects may be in each other: what physics itself lets happen [m]."""
RIM = 0.01
"""How deep under the rim of what it is in a thing must reach [m]."""
DECIMALS = 6


@dataclass(frozen=True, eq=False)
class Scene:
    """Objects at rest in their relations.

    Attributes:
        graph: what stands how.
        poses: object -> pose (world frame), rounded as a file has it.
        supports: pairs (above, below) of bodies of which one carries the other; "table" may be below.
        drift: how far each object moves (EDE) when the scene is settled once more [m].
    """

    graph: SceneGraph
    poses: Mapping[str, Pose]
    supports: tuple[tuple[str, str], ...]
    drift: Mapping[str, float]


def settled_scene(
    graph: SceneGraph, things: Mapping[str, Thing], layout: Mapping[str, Matrix]
) -> tuple[Scene | None, str]:
    """Let a layout come to rest and judge it.

    Args:
        graph: what stands how.
        things: object -> its geometry.
        layout: object -> pose, shape (4, 4).

    Returns:
        The scene and "", or None and why it is rejected: "fell apart", "overlap", "out of reach", "drift".
    """
    drawn = {name: Pose.from_matrix(T) for name, T in layout.items()}
    # In the order that the task will have: physics gives each order another creeping.
    task = Task("scene", tuple(things[name].object(name, pose) for name, pose in sorted(drawn.items())))
    first = settle(task, limit_s=SETTLE_S)
    poses = {name: rounded(pose) for name, pose in first.poses.items()}
    matrices = {name: pose.matrix for name, pose in poses.items()}
    if not all(_holds(node, things, layout, matrices, first) for node in graph.nodes):
        return None, "fell apart"
    if any(hits(things[a], matrices[a], [(things[b], matrices[b])], -INSIDE) for a, b in combinations(poses, 2)):
        return None, "overlap"
    if not all(reachable(things[name], T) for name, T in matrices.items()):
        return None, "out of reach"
    drift = _drift(task, things, poses, AGAIN_S)
    if max(drift.values()) > CREEP:
        drift = _drift(task, things, poses, LONG_S)
    if max(drift.values()) > DRIFT:
        return None, "drift"
    return Scene(graph, poses, first.supports, drift), ""


def _drift(task: Task, things: Mapping[str, Thing], poses: Mapping[str, Pose], limit_s: float) -> dict[str, float]:
    """How far each object moves (EDE) when it is let go where it stands [m]."""
    again = settle(task, poses, limit_s=limit_s).poses
    return {name: ede(mean_edge(things[name].model.shape), again[name], pose) for name, pose in poses.items()}


def rounded(pose: Pose) -> Pose:
    """The pose as a file with six decimals has it."""
    x, y, z = (round(value, DECIMALS) for value in pose.xyz)
    a, b, c, d = (round(value, DECIMALS) for value in pose.quat)
    return Pose((x, y, z), (a, b, c, d))


def _holds(
    node: Node,
    things: Mapping[str, Thing],
    layout: Mapping[str, Matrix],
    settled: Mapping[str, Matrix],
    rest: Settled,
) -> bool:
    """Whether an object still has its relation after settling."""
    thing, was, now = things[node.name], layout[node.name], settled[node.name]
    if node.parent is None:
        return _stayed(was, now)
    T_parent = settled[node.parent]
    match node.relation:
        case "in" | "standing":
            return _inside(thing, now, things[node.parent], T_parent, upright=node.relation == "standing")
        case "on" | "stacked":
            return _stayed(was, now) and (node.name, node.parent) in rest.supports
        case "leaning":
            tilt = _angle(now[2, :3], thing.resting[0][2])
            touching = hits(thing, now, [(things[node.parent], T_parent)], 0.003)
            return touching and LEANING[0] < tilt < LEANING[1]
        case _:
            return _stayed(was, now)


def _stayed(was: Matrix, now: Matrix) -> bool:
    """Whether a body stands about where it was put, the same way up."""
    return float(np.linalg.norm(now[:3, 3] - was[:3, 3])) < MOVED and _angle(now[2, :3], was[2, :3]) < SAME_WAY


def _inside(thing: Thing, T: Matrix, parent: Thing, T_parent: Matrix, *, upright: bool) -> bool:
    """Whether the lowest point of a thing lies within its parent's outline and under its rim.

    Where it is to stand upright, its long axis must still be closer to the vertical than to the horizontal.
    """
    points = thing.points @ T[:3, :3].T + T[:3, 3]
    lowest = (points[np.argmin(points[:, 2])] - T_parent[:3, 3]) @ T_parent[:3, :3]
    lower, upper = parent.points.min(axis=0), parent.points.max(axis=0) - (0.0, 0.0, RIM)
    within = bool((lower < lowest).all() and (lowest < upper).all())
    middle = (T[:3, 3] - T_parent[:3, 3]) @ T_parent[:3, :3]
    over = bool((np.abs(middle[:2]) < upper[:2]).all())
    long_axis = int(np.argmax(np.ptp(thing.points, axis=0)))
    return within and over and (not upright or abs(float(T[2, long_axis])) > math.sqrt(0.5))


def _angle(a: Matrix, b: Matrix) -> float:
    """Between two unit vectors [rad]."""
    return math.acos(float(np.clip(a @ b, -1.0, 1.0)))
