"""A polyline with its corners rounded by parabolas: once continuously differentiable, within a known distance."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tamp.compiled import compiled
from tamp.world.motion.paths import Array


@dataclass(frozen=True, eq=False)
class RoundedPath:
    """Straight stretches and parabolic blends (Kunz and Stilman, 2012, with parabolas in place of circles).

    The parameter s is the arc length along the polyline [rad]. Between two breaks the second derivative is constant.

    Attributes:
        corners: waypoints of the polyline, shape (n, dof), no two neighbours equal.
        arc: where the waypoints lie, shape (n,).
        reach: half of the parameter's range on which each waypoint is rounded, shape (n,); 0 at both ends.
    """

    corners: Array
    arc: Array
    reach: Array

    @property
    def breaks(self) -> Array:
        """Where straight stretches and blends begin and end, increasing, shape (m,)."""
        inner = slice(1, -1)
        ends = np.stack([self.arc[inner] - self.reach[inner], self.arc[inner] + self.reach[inner]], axis=1)
        return np.concatenate([[0.0], ends.ravel(), [self.arc[-1]]])

    @cached_property
    def directions(self) -> Array:
        """Unit vectors of the edges, shape (n - 1, dof)."""
        edges = np.diff(self.corners, axis=0)
        return np.asarray(edges / np.linalg.norm(edges, axis=1)[:, None])

    def __call__(self, s: Array, order: int = 0) -> Array:
        """Position or derivative by s at parameters of shape (k,): shape (k, dof).

        At a break the second derivative is the blend's, the larger one.
        """
        return _followed(self.corners, self.directions, self.arc, self.reach, s, order)


@compiled
def _followed(corners: Array, directions: Array, arc: Array, reach: Array, s: Array, order: int) -> Array:
    """Position or derivative of a rounded path at parameters of shape (k,): shape (k, dof)."""
    dof = corners.shape[1]
    found = np.empty((len(s), dof))
    for k in range(len(s)):
        edge = min(max(np.searchsorted(arc, s[k], side="right") - 1, 0), len(directions) - 1)
        nearest = edge + 1 if s[k] - arc[edge] > (arc[edge + 1] - arc[edge]) / 2 else edge
        half, along = reach[nearest], s[k] - arc[nearest]
        blended = half > 0 and abs(along) <= half * (1 + 1e-9) + 1e-12
        into = min(max(along + half, 0.0), 2 * half)
        for i in range(dof):
            direction = directions[edge, i]
            if blended:
                before = directions[nearest - 1, i]
                bend = (directions[nearest, i] - before) / (2 * half)
                if order == 0:
                    found[k, i] = corners[nearest, i] + along * before + bend * into * into / 2
                else:
                    found[k, i] = before + bend * into if order == 1 else bend
            elif order == 0:
                found[k, i] = corners[edge, i] + (s[k] - arc[edge]) * direction
            else:
                found[k, i] = direction if order == 1 else 0.0
    return found


def rounded(path: Array, tolerance: float) -> RoundedPath:
    """Round every corner of a polyline, shape (n, dof), n >= 2, by a parabola within `tolerance` [rad] of the corner.

    A parabola over s in [-d, d] passes its corner at d |u1 - u0| / 4, u0 and u1 the directions of the edges; it takes
    at most 45 % of each of its edges.
    """
    edges = np.diff(path, axis=0)
    lengths = np.linalg.norm(edges, axis=1)
    directions = edges / lengths[:, None]
    turns = np.linalg.norm(np.diff(directions, axis=0), axis=1)
    room = 0.45 * np.minimum(lengths[:-1], lengths[1:])
    reach = np.minimum(room, 4 * tolerance / np.maximum(turns, 1e-9))
    arc = np.concatenate([[0.0], np.cumsum(lengths)])
    return RoundedPath(path, arc, np.concatenate([[0.0], reach, [0.0]]))
