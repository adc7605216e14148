"""A body that rolls on a plane over its edges, without slipping."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.poses import rotation, turned_about

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

ROLL = np.radians(2.5)  # between two poses
TOUCHING = 5e-4  # what is so near to the plane touches it [m]


def rolls(vertices: Array, T: Array, outward: Array) -> Iterator[tuple[Array, Array]]:
    """Yield where a body is as it rolls on, without end, and how far out it touches the plane there.

    It turns by ROLL at a time, about the outermost of its points that touch.

    Args:
        vertices: of its hull in its own frame, shape (n, 3) [m].
        T: where it rests on the plane, T_world_body, shape (4, 4).
        outward: level unit vector in which it rolls, shape (2,).

    Yields:
        T_world_body, shape (4, 4), and the touching points along `outward`, shape (m,) [m].
    """
    ground = float((vertices @ T[2, :3] + T[2, 3]).min())
    turn = rotation(np.array([-outward[1], outward[0], 0.0]), ROLL)
    while True:
        world = vertices @ T[:3, :3].T + T[:3, 3]
        low = world[world[:, 2] < ground + TOUCHING]
        T = turned_about(low[np.argmax(low[:, :2] @ outward)], turn, T)
        world = vertices @ T[:3, :3].T + T[:3, 3]
        T[2, 3] += ground - world[:, 2].min()
        yield T, world[world[:, 2] < world[:, 2].min() + TOUCHING, :2] @ outward
