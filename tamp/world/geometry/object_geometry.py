"""What an object is made of: convex parts, and what follows from them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from tamp.task.mesh.parts import Part, bounds, convex_hull, parts, watertight
from tamp.task.model import Object, Shape
from tamp.world.geometry.stable_poses import StablePose, resting_poses

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Vector = NDArray[np.float64]
    Matrix = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Geometry:
    """A rigid body of uniform density in its own frame. Arrays are read-only.

    Volume, centre of mass and inertia are sums over the convex parts: where parts overlap, the overlap counts twice.

    Attributes:
        parts: the convex parts; the hollow of a bowl stays hollow.
        lower, upper: corners of the bounding box of the original shape, shape (3,) [m].
        volume: [m^3].
        center_of_mass: shape (3,) [m].
        inertia: about the centre of mass for a mass of one kilogram, shape (3, 3) [m^2].
        watertight: whether the original surface is closed.
    """

    parts: tuple[Part, ...]
    lower: Vector
    upper: Vector
    volume: float
    center_of_mass: Vector
    inertia: Matrix
    watertight: bool = True

    def __post_init__(self) -> None:
        for array in (self.lower, self.upper, self.center_of_mass, self.inertia):
            array.setflags(write=False)

    @property
    def hull(self) -> Part:
        """The convex hull of all parts."""
        return _hull(self)


def load_geometry(shape: Shape) -> Geometry:
    """The geometry of a shape; the same object as long as the shape's file does not change.

    Raises:
        TaskError: where the shape's mesh cannot be used.
    """
    return _geometry(shape, parts(shape))


def geometry_of_object(item: Object) -> Geometry:
    """The geometry of an object's shape, with the centre of mass that its task gives it, if it does.

    Raises:
        TaskError: where the object's mesh cannot be used.
    """
    geometry = load_geometry(item.shape)
    return geometry if item.inertia is None else _weighted(geometry, item.inertia.frame.xyz)


@lru_cache(maxsize=512)
def _weighted(geometry: Geometry, center: tuple[float, float, float]) -> Geometry:
    return replace(geometry, center_of_mass=np.array(center))


@lru_cache(maxsize=512)
def _geometry(shape: Shape, pieces: tuple[Part, ...]) -> Geometry:
    lower, upper = bounds(shape)
    return geometry_of(pieces, lower, upper, watertight(shape))


@lru_cache(maxsize=512)
def stable_poses(geometry: Geometry) -> tuple[StablePose, ...]:
    """All ways for the body to rest on a plane, the most probable first."""
    return resting_poses(geometry.hull, geometry.center_of_mass)


def geometry_of(
    pieces: Sequence[Part], lower: Vector | None = None, upper: Vector | None = None, closed: bool = True
) -> Geometry:
    """The geometry of convex parts; the bounding box is theirs unless given."""
    volume, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
    for part in pieces:
        v, f, s = _moments(part)
        volume, first, second = volume + v, first + f, second + s
    center = first / volume
    covariance = second / volume - np.outer(center, center)
    points = np.concatenate([part.vertices for part in pieces])
    return Geometry(
        parts=tuple(pieces),
        lower=points.min(axis=0) if lower is None else lower,
        upper=points.max(axis=0) if upper is None else upper,
        volume=volume,
        center_of_mass=center,
        inertia=np.trace(covariance) * np.eye(3) - covariance,
        watertight=closed,
    )


def _moments(part: Part) -> tuple[float, Vector, Matrix]:
    """Integrals of 1, x and x x^T over a closed polytope, by tetrahedra that share the origin."""
    corners = part.vertices[part.faces]
    volumes = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    total = corners.sum(axis=1)
    first = volumes @ total / 4
    # The second moment of a tetrahedron with one corner at the origin: (sum of x_i x_i^T + s s^T) V / 20.
    second = np.einsum("n,nij,nik->jk", volumes, corners, corners) + np.einsum("n,nj,nk->jk", volumes, total, total)
    return float(volumes.sum()), first, second / 20


@lru_cache(maxsize=512)
def _hull(geometry: Geometry) -> Part:
    return convex_hull(np.concatenate([part.vertices for part in geometry.parts]))
