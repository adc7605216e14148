"""What keeps from tipping over what would not stand by itself: books that lean on each other or on their holder."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from tamp.execution.simulator import Touch
from tamp.task import Object, Pose
from tamp.world.geometry import load_geometry

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

BESIDE = 0.001
"""What has its centre of mass farther than this beside what carries it would tip over by itself [m]."""

LOW = 0.002
"""Vertices so little above the lowest are over what carries a body too: the simulator names a few contacts only [m]."""

AGAINST = 0.5
"""Least cosine between the way in which a body would tip and the push that keeps it from that."""


def leaning(
    objects: Iterable[Object], poses: Mapping[str, Pose], touches: Iterable[Touch], upright: float
) -> Iterator[tuple[str, str]]:
    """Yield pairs (what leans, on what) of bodies, "table" among the latter.

    Of two that push each other, that leans whose centre of mass is farther beside what carries it.

    Args:
        objects: the bodies.
        poses: object -> where it is at rest (world frame).
        touches: the contacts of all of them.
        upright: vertical share of a contact's normal from which it carries.
    """
    seen = [*touches]
    seen += [Touch(t.b, t.a, (-t.normal[0], -t.normal[1], -t.normal[2]), t.depth, t.force, t.point) for t in seen]
    beside: dict[tuple[str, str], float] = {}
    for item in objects:
        mine = [touch for touch in seen if touch.a == item.name]
        carrying = np.array([touch.point for touch in mine if touch.normal[2] > upright]).reshape(-1, 3)
        far, way = _tipping(item, poses[item.name], carrying) if len(carrying) else (0.0, np.zeros(2))
        for touch in mine if far > BESIDE else ():
            if touch.force > 0.0 and touch.normal[2] <= upright and np.array(touch.normal[:2]) @ way < -AGAINST:
                beside[item.name, touch.b] = far
    yield from (pair for pair, far in beside.items() if far > beside.get(pair[::-1], 0.0))


def _tipping(item: Object, pose: Pose, carrying: Array) -> tuple[float, Array]:
    """How far a body's centre of mass is beside what carries it, (n, 3) [m], and in which level direction (2,)."""
    geometry, T = load_geometry(item.shape), pose.matrix
    points = np.vstack([part.vertices for part in geometry.parts]) @ T[:3, :3].T + T[:3, 3]
    low = np.vstack([points[points[:, 2] < points[:, 2].min() + LOW], carrying])
    angles = np.linspace(0.0, 2 * np.pi, 90, endpoint=False)
    ways = np.column_stack([np.cos(angles), np.sin(angles)])
    center = T[:3, :3] @ geometry.center_of_mass + T[:3, 3]
    reach = ((low - center)[:, :2] @ ways.T).max(axis=0)
    worst = int(reach.argmin())
    return -float(reach[worst]), ways[worst]
