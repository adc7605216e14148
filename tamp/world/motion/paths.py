"""Paths: polylines in configuration space, shape (n, dof) [rad]. Length, densifying, shortening; no time, no robot."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

RESOLUTION = 0.05
"""Distance between the configurations at which an edge is tested [rad]."""


class Touching(Protocol):
    """Two bodies that come too close; its text says which and how near."""

    @property
    def a(self) -> str:
        """Name of the one."""

    @property
    def b(self) -> str:
        """Name of the other."""


class StateChecker(Protocol):
    """What a motion needs to know of the world; `tamp.world.collision.checker.CollisionChecker` is one."""

    def free(self, q: Array, /) -> bool:
        """Whether the configuration, shape (dof,), is free of collision."""

    def edge_free(self, q0: Array, q1: Array, /, resolution: float = RESOLUTION) -> bool:
        """Whether the straight edge is free, its ends included, tested every `resolution` [rad]."""

    def contact(self, q: Array, /) -> Touching | None:
        """Two bodies in contact, or None where the configuration is free."""


def length(path: Array) -> float:
    """Sum of the Euclidean lengths of the edges [rad]."""
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def without_duplicates(path: Array, tolerance: float = 1e-6) -> Array:
    """The path without waypoints nearer than `tolerance` [rad] to the one kept before; both ends stay exact.

    A path of no length becomes a single waypoint.
    """
    kept = [path[0]]
    for q in path[1:-1]:
        if np.linalg.norm(q - kept[-1]) > tolerance:
            kept.append(q)
    if len(path) > 1:
        while len(kept) > 1 and np.linalg.norm(path[-1] - kept[-1]) <= tolerance:
            kept.pop()
        if np.linalg.norm(path[-1] - kept[-1]) > tolerance:
            kept.append(path[-1])
    return np.array(kept)


def densify(path: Array, step: float = RESOLUTION) -> Array:
    """The path with waypoints at most `step` [rad] apart; every given waypoint is kept."""
    edges = np.diff(path, axis=0)
    counts = np.maximum(1, np.ceil(np.linalg.norm(edges, axis=1) / step - 1e-9).astype(int))
    edge = np.repeat(np.arange(len(edges)), counts)
    first = np.cumsum(counts) - counts
    share = (np.arange(len(edge)) - first[edge]) / counts[edge]
    return np.vstack([path[:-1][edge] + share[:, None] * edges[edge], path[-1:]])


def deviation(points: Array, path: Array) -> Array:
    """Euclidean distance of each point, shape (n, dof), to the polyline: shape (n,) [rad]."""
    if len(path) == 1:
        return np.asarray(np.linalg.norm(points - path[0], axis=1))
    starts, edges = path[:-1], np.diff(path, axis=0)
    squares = np.maximum((edges * edges).sum(axis=1), 1e-18)
    nearest = np.full(len(points), np.inf)
    for start, edge, square in zip(starts, edges, squares, strict=True):
        offset = points - start
        share = np.clip(offset @ edge / square, 0.0, 1.0)
        nearest = np.minimum(nearest, np.linalg.norm(offset - share[:, None] * edge, axis=1))
    return nearest


def shortcut(
    path: Array, checker: StateChecker, rng: np.random.Generator, *, attempts: int = 60, resolution: float = RESOLUTION
) -> Array:
    """Shorten a free path by straight edges between random points of it (Geraerts and Overmars, 2007).

    First every corner that can be skipped is skipped, from both ends; then `attempts` random pairs of points are
    tried. The number of attempts, not a clock, bounds the work, so that the result depends on the generator alone.
    """
    path = _skip_corners(path, checker, resolution)
    failures = 0
    for _ in range(attempts):
        if len(path) == 2 or failures == 2 * len(path) + 10:
            break
        shorter = _random_shortcut(path, checker, rng, resolution)
        failures = failures + 1 if shorter is None else 0
        path = path if shorter is None else shorter
    return path


def _skip_corners(path: Array, checker: StateChecker, resolution: float) -> Array:
    """From each waypoint on, go straight to the farthest one that an edge reaches, trying far ones first."""
    kept, i = [path[0]], 0
    while i < len(path) - 1:
        j = len(path) - 1
        while j > i + 1 and not checker.edge_free(path[i], path[j], resolution):
            j = i + 1 + (j - i - 1) // 2
        kept.append(path[j])
        i = j
    return np.array(kept)


def _random_shortcut(path: Array, checker: StateChecker, rng: np.random.Generator, resolution: float) -> Array | None:
    """The path with one random stretch replaced by an edge, or None where the edge is not free or gains nothing."""
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    s0, s1 = np.sort(rng.uniform(0.0, arc[-1], 2))
    i, j = (int(k) for k in np.searchsorted(arc, (s0, s1), side="right") - 1)
    i, j = min(i, len(path) - 2), min(j, len(path) - 2)
    if i == j:
        return None
    q0 = path[i] + (s0 - arc[i]) / (arc[i + 1] - arc[i]) * (path[i + 1] - path[i])
    q1 = path[j] + (s1 - arc[j]) / (arc[j + 1] - arc[j]) * (path[j + 1] - path[j])
    if np.linalg.norm(q1 - q0) > 0.98 * (s1 - s0) or not checker.edge_free(q0, q1, resolution):
        return None
    return np.vstack([path[: i + 1], q0, q1, path[j + 1 :]])
