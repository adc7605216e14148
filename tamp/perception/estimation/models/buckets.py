"""The nearest of many oriented points that faces the same way, found by cells; compiled."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tamp.compiled import compiled

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

EDGE = 0.008
"""Edge of a cell [m]."""

NEAR = 0.004
"""The nearest point is sought within this first, and then within twice as much, up to what is asked [m]."""


@dataclass(frozen=True, eq=False)
class Buckets:
    """Oriented points sorted by the cell that they lie in.

    Attributes:
        places: of the points and, weighed by what opposite normals are worth, their normals; shape (n, 6), sorted [m].
        index: of each of them among the points that were given, shape (n,).
        first: of each cell's points among the sorted ones, and behind the last cell their number, shape (cells + 1,).
        origin: corner of the first cell, shape (3,) [m].
        shape: cells along each axis, shape (3,).
    """

    places: Array
    index: NDArray[np.int64]
    first: NDArray[np.int64]
    origin: Array
    shape: NDArray[np.int64]

    @staticmethod
    def of(points: Array, normals: Array, facing: float) -> Buckets:
        """Of points and unit normals, shape (n, 3) each; opposite normals are worth 2 * facing [m]."""
        origin = points.min(axis=0)
        cells = np.floor((points - origin) / EDGE).astype(np.int64)
        shape = cells.max(axis=0) + 1
        number = np.ravel_multi_index(tuple(cells.T), tuple(shape))
        index = np.argsort(number, kind="stable")
        first = np.searchsorted(number[index], np.arange(shape.prod() + 1))
        places = np.column_stack([points, facing * normals])[index]
        return Buckets(places, index, first, origin, shape)

    def nearest(self, places: Array, reach: float) -> NDArray[np.int64]:
        """For places and weighed normals, shape (m, 6), the index of the nearest point within reach [m]; -1: none."""
        return _nearest(places, self.places, self.index, self.first, self.origin, self.shape, reach)


@compiled
def _nearest(
    wanted: Array,
    places: Array,
    index: NDArray[np.int64],
    first: NDArray[np.int64],
    origin: Array,
    shape: NDArray[np.int64],
    reach: float,
) -> NDArray[np.int64]:
    found = np.full(len(wanted), -1, dtype=np.int64)
    low, high = np.empty(3, dtype=np.int64), np.empty(3, dtype=np.int64)
    for n in range(len(wanted)):
        # What is nearer than the cells that were looked at reach is the nearest: most points lie on the surface.
        within = min(NEAR, reach)
        while found[n] < 0:
            for axis in range(3):
                low[axis] = max(0, math.floor((wanted[n, axis] - within - origin[axis]) / EDGE))
                high[axis] = min(shape[axis] - 1, math.floor((wanted[n, axis] + within - origin[axis]) / EDGE))
            best = within * within
            for i in range(low[0], high[0] + 1):
                for j in range(low[1], high[1] + 1):
                    row = (i * shape[1] + j) * shape[2]
                    if low[2] > high[2]:
                        continue
                    # Cells along the last axis follow each other.
                    for p in range(first[row + low[2]], first[row + high[2] + 1]):
                        off = 0.0
                        for axis in range(3):
                            off += (wanted[n, axis] - places[p, axis]) ** 2
                        if off >= best:
                            continue
                        for axis in range(3, 6):
                            off += (wanted[n, axis] - places[p, axis]) ** 2
                        if off < best:
                            best, found[n] = off, index[p]
            if within >= reach:
                break
            within = min(2 * within, reach)
    return found
