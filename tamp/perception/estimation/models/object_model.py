"""An object's mesh made ready to be found: oriented points with colours, ways to rest, and its own symmetries."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial import cKDTree

from tamp.perception.estimation.models.buckets import Buckets
from tamp.perception.estimation.models.occupancy import Occupancy, occupancy_of_parts
from tamp.perception.estimation.models.symmetry import about, round_axes, symmetries
from tamp.perception.rendering.raycast import escapes
from tamp.perception.rendering.surface import Surface
from tamp.task.mesh.parts import Part, convex_hull
from tamp.world.geometry.stable_poses import StablePose, resting_poses

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

DENSE, FINE, COARSE = 2400, 320, 48
"""Points on a surface: those that stand for it, those that are fitted, and those that a first glance looks at."""

LIKELY = 0.004
"""Ways to rest less probable than this are left to the general search."""

STABLE = 12
"""Most ways to rest that are tried."""


OPEN = 0.06
"""A side of a surface is outside where at least this share of rays from it meets nothing more of the object."""

RAYS = 16

CUBE = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
"""Corners of the cube, of edge 1, by which EDE tells how far two poses are apart (OCRTOC paper, Algorithm 1)."""

FACING = 0.010
"""Metres that opposite normals are worth, halved, where oriented points are searched."""


@dataclass(frozen=True, eq=False)
class ObjectModel:
    """What is known of an object, in its own frame. Points come in an order of which any prefix covers it evenly.

    Attributes:
        points, normals: on its surface where it can be seen from outside, normals to the side that can, shape (n, 3).
        colors: at the points, shape (n, 3), 0..1.
        solid: whether there is matter behind a point; a sheet without thickness has none; shape (n,).
        area: of all that can be seen, a sheet's two sides both [m^2].
        center: mean of the surface, shape (3,).
        edge: mean edge of the bounding box, as EDE has it [m].
        colored: whether its colour differs from place to place.
        stable: ways to rest on a plane, the most probable first.
        parts: convex parts of the space that it takes up, where they are known.
    """

    points: Array
    normals: Array
    colors: Array
    solid: NDArray[np.bool_]
    area: float
    center: Array
    edge: float
    colored: bool
    stable: tuple[StablePose, ...]
    parts: tuple[Part, ...] = ()

    @cached_property
    def _buckets(self) -> Buckets:
        return Buckets.of(self.points, self.normals, FACING)

    def nearest(self, points: Array, normals: Array, reach: float) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        """For oriented points (n, 3), the model's nearest that faces the same way; whether it is within reach [m]."""
        index = self._buckets.nearest(np.column_stack([points, FACING * normals]), reach)
        return np.maximum(index, 0), index >= 0

    @cached_property
    def spacing(self) -> float:
        """Typical distance between neighbouring points [m]."""
        return float(np.sqrt(self.area / len(self.points)))

    @cached_property
    def tree(self) -> Any:
        """Nearest-neighbour search among the points."""
        return cKDTree(self.points)

    @cached_property
    def occupancy(self) -> Occupancy:
        """The space that the object takes up; without known parts, what is behind its points."""
        if self.parts:
            return occupancy_of_parts(self.parts)
        return Occupancy(self.points, self.normals, self.solid, self.area)

    @cached_property
    def diameter(self) -> float:
        """Largest distance of two points, at most [m]."""
        return float(2 * np.linalg.norm(self.points - self.center, axis=1).max())

    def apart(self, one: Array, other: Array) -> float:
        """Mean distance of the same points at two poses (4, 4), over the turns that map the shape onto itself [m]."""
        probe = self.points[:60]
        turned = np.einsum("sij,kj->ski", self.symmetries[:, :3, :3], probe) + self.symmetries[:, None, :3, 3]
        # Both are told in the frame of the first.
        T = np.linalg.inv(one) @ other
        return float(np.linalg.norm(turned - probe @ T[:3, :3].T - T[:3, 3], axis=2).mean(axis=1).min())

    def error(self, one: Array, other: Array) -> float:
        """EDE between two poses (4, 4), over the turns that map the shape onto itself: what a mistake costs [m].

        A cube of the mesh's mean edge moves more than the points of what is long and thin when that rolls.
        """
        cube = self.edge * CUBE
        T = np.linalg.inv(one) @ other
        turned = np.einsum("sij,kj->ski", self.symmetries[:, :3, :3], cube) + self.symmetries[:, None, :3, 3]
        return float(np.linalg.norm(turned - cube @ T[:3, :3].T - T[:3, 3], axis=2).mean(axis=1).min())

    @cached_property
    def symmetries(self) -> Array:
        """Rotations and shifts that map the shape onto itself, shape (k, 4, 4); the identity is the first."""
        return symmetries(self.points, self.normals, self.center)

    @cached_property
    def round_axes(self) -> Array:
        """Axes through the centre about which the shape is round, shape (0, 1 or 3, 3)."""
        return round_axes(self.symmetries)

    def about_center(self, R: Array) -> Array:
        """A rotation (3, 3) about the centre, shape (4, 4)."""
        return about(R, self.center)


@lru_cache(maxsize=256)
def object_model(surface: Surface) -> ObjectModel:
    """The model of a surface; the same for every seed.

    Raises:
        TampError: where the extra `perception` is not installed.
    """
    sample = _sampled(surface)
    vertices = surface.vertices[np.unique(surface.faces)]
    center = sample.center
    poses = [pose for pose in resting_poses(convex_hull(vertices), center) if pose.probability > LIKELY]
    return ObjectModel(
        points=sample.points,
        normals=sample.normals,
        colors=sample.colors,
        solid=sample.solid,
        area=sample.area,
        center=center,
        edge=float(np.ptp(vertices, axis=0).mean()),
        colored=surface.colored,
        stable=tuple(poses[:STABLE]),
        parts=surface.parts,
    )


@dataclass(frozen=True, eq=False)
class _Sample:
    points: Array
    normals: Array
    colors: Array
    solid: NDArray[np.bool_]
    area: float
    center: Array


def _sampled(surface: Surface) -> _Sample:
    """Points spread evenly over what can be seen of a surface.

    Scans have faces that are turned over, sheets without thickness, and walls inside: rays tell which side of a point
    is outside, or both, or none.
    """
    rng = np.random.default_rng(0)
    corners = surface.vertices[surface.faces]
    crosses = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(crosses, axis=1) / 2
    count = 4 * DENSE
    # Evenly along the summed area: means over the sample are those over the surface.
    chosen = np.searchsorted(np.cumsum(areas), areas.sum() * (np.arange(count) + rng.random()) / count)
    chosen = np.minimum(chosen, len(areas) - 1)
    u, v = rng.random((2, count))
    flipped = u + v > 1
    u, v = np.where(flipped, 1 - u, u), np.where(flipped, 1 - v, v)
    weights = np.stack([1 - u - v, u, v], axis=1)
    points = np.einsum("nij,ni->nj", corners[chosen], weights)
    normals = crosses[chosen] / np.maximum(2 * areas[chosen, None], 1e-20)
    colors = np.einsum("nij,ni->nj", surface.colors[surface.faces[chosen]].astype(np.float64), weights) / 255
    front, back = (_outside(surface, points, sign * normals, rng) for sign in (1.0, -1.0))
    sides = np.concatenate([np.flatnonzero(front), np.flatnonzero(back)])
    signs = np.repeat([1.0, -1.0], [front.sum(), back.sum()])
    points, normals, colors = points[sides], normals[sides] * signs[:, None], colors[sides]
    order = _spread(np.column_stack([points, FACING * normals]), DENSE)
    area = float(areas.sum()) * len(sides) / count
    solid = ~(front & back)[sides][order]
    return _Sample(points[order], normals[order], colors[order], solid, area, points.mean(axis=0))


def _outside(surface: Surface, points: Array, normals: Array, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Points from whose side, told by a normal, enough rays meet nothing more of the surface."""
    directions = rng.normal(size=(len(points), RAYS, 3))
    directions *= np.sign(np.einsum("nri,ni->nr", directions, normals))[..., None]
    directions /= np.linalg.norm(directions, axis=2)[..., None]
    origins = np.repeat(points + 2e-4 * normals, RAYS, axis=0)
    free = escapes(surface, origins, directions.reshape(-1, 3)).reshape(-1, RAYS)
    return np.asarray(free.mean(axis=1) > OPEN)


def _spread(points: Array, count: int) -> NDArray[np.int64]:
    """Indices of `count` points: the first few hundred by farthest-point sampling, the rest as they come."""
    distance = np.full(len(points), np.inf)
    order = [0]
    for _ in range(min(count, FINE) - 1):
        distance = np.minimum(distance, ((points - points[order[-1]]) ** 2).sum(axis=1))
        order.append(int(distance.argmax()))
    rest = np.setdiff1d(np.arange(len(points)), order)
    rest = np.random.default_rng(1).permutation(rest)
    return np.concatenate([order, rest])[:count].astype(np.int64)
