"""Antipodal contacts on any union of convex parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from tamp.compiled import compiled
from tamp.streams.surfaces import SurfacePoints
from tamp.world.geometry.half_spaces import half_spaces, joined

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.task.mesh.parts import Part
    from tamp.world.geometry.half_spaces import Planes

    Array = NDArray[Any]

PERTURBED_SHARE = 0.5  # of the rays leave the normal by a random tilt, to find pairs on curved and slanted faces
TILT = 0.25
THINNEST = 1e-3  # between two contacts [m]
SEAM = 5e-4  # gaps between parts thinner than this are modelling seams, not hollows [m]


@dataclass(frozen=True, eq=False)
class Contacts:
    """Pairs of opposite contacts, in the object's frame.

    Attributes:
        centers: midpoints, shape (n, 3) [m].
        axes: unit vectors from the first contact to the second, shape (n, 3).
        widths: distances between the two contacts, shape (n,) [m].
        slants: the larger angle between the axis and either surface normal, shape (n,) [rad].
    """

    centers: NDArray[np.float64]
    axes: NDArray[np.float64]
    widths: NDArray[np.float64]
    slants: NDArray[np.float64]

    @staticmethod
    def joined(*several: Contacts) -> Contacts:
        """All of them, in order."""
        columns = zip(*((c.centers, c.axes, c.widths, c.slants) for c in several), strict=True)
        return Contacts(*(np.concatenate(column) for column in columns))

    def at(self, index: NDArray[Any]) -> Contacts:
        """Those at the given indices, or where a mask holds."""
        return Contacts(self.centers[index], self.axes[index], self.widths[index], self.slants[index])


def antipodal_contacts(
    parts: Sequence[Part], surface: SurfacePoints, *, max_width: float, friction_angle: float, rng: np.random.Generator
) -> Contacts:
    """Pair every surface point with each later exit of its inward ray.

    Args:
        parts: the convex parts of the object.
        surface: where the rays start.
        max_width: the widest pair kept [m].
        friction_angle: the widest angle between the line and either normal [rad].
        rng: source of the tilts.
    """
    count = len(surface.points)
    tilt = TILT * rng.normal(size=(count, 3)) * (rng.random(count) < PERTURBED_SHARE)[:, None]
    rays = _Rays(surface.points, surface.normals, _unit(tilt - surface.normals))
    contacts, exits = _pairs(parts, rays, max_width, friction_angle)
    between, _ = _pairs(parts, _aimed(rays, exits, friction_angle), max_width, friction_angle)
    return Contacts.joined(contacts, between)


@dataclass(frozen=True, eq=False)
class _Rays:
    """Lines into an object: origins on its surface [m], outward normals there, unit directions; each (n, 3)."""

    origins: NDArray[np.float64]
    normals: NDArray[np.float64]
    directions: NDArray[np.float64]


def _pairs(
    parts: Sequence[Part], rays: _Rays, max_width: float, friction_angle: float
) -> tuple[Contacts, tuple[NDArray[np.int64], NDArray[np.float64]]]:
    """The pairs that rays find, and all their exits within reach: which ray (m,) left with which normal (m, 3)."""
    planes = joined(map(half_spaces, parts))
    index, face, widths = _exits(planes, np.ascontiguousarray(rays.origins), np.ascontiguousarray(rays.directions))
    within = (widths > THINNEST) & (widths <= max_width)
    index, widths, exits = index[within], widths[within], planes[0][face[within]]
    axes, entries = rays.directions[index], rays.normals[index]
    slants = np.maximum(_angle(axes, -entries), _angle(axes, exits))
    kept = slants < friction_angle
    centers = rays.origins[index] + 0.5 * widths[:, None] * axes
    return Contacts(centers[kept], axes[kept], widths[kept], slants[kept]), (index, exits)


def _aimed(rays: _Rays, exits: tuple[NDArray[np.int64], NDArray[np.float64]], friction_angle: float) -> _Rays:
    """Rays between two faces that taper: from where a ray began, along the line that meets both at the same slant.

    Pads hold a taper only close to that line, which rays along normals never take and tilted ones hardly ever do.
    """
    index, normals = exits
    apart = _angle(-rays.normals[index], normals)
    aimed = (apart > friction_angle) & (apart < 2 * friction_angle)
    index, normals = index[aimed], normals[aimed]
    return _Rays(rays.origins[index], rays.normals[index], _unit(normals - rays.normals[index]))


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    unit: NDArray[np.float64] = vectors / np.linalg.norm(vectors, axis=1)[:, None]
    return unit


def _angle(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    angles: NDArray[np.float64] = np.arccos(np.clip(np.einsum("ij,ij->i", a, b), -1.0, 1.0))
    return angles


@compiled
def _exits(planes: Planes, origins: Array, directions: Array) -> tuple[Array, Array, Array]:
    """Where rays leave a union of convex parts, first exits first: which ray, through which plane, how far on [m]."""
    A, b, ends = planes
    rays, planes_left, ways = [0], [0], [0.0]  # typed by what is taken away again
    enter, leave, through = np.empty(len(ends)), np.empty(len(ends)), np.empty(len(ends), np.int64)
    for ray in range(len(origins)):
        met, first = 0, 0
        for end in ends:
            t_in, t_out, face = _crossed(A[first:end], b[first:end], origins[ray], directions[ray])
            if t_in < t_out and t_out > 0.0:
                k = met  # sorted by where the ray enters
                while k > 0 and enter[k - 1] > t_in:
                    enter[k], leave[k], through[k] = enter[k - 1], leave[k - 1], through[k - 1]
                    k -= 1
                enter[k], leave[k], through[k] = t_in, t_out, first + face
                met += 1
            first = end
        for k in range(met):
            if k > 0 and rays[-1] == ray and enter[k] <= ways[-1] + SEAM:
                if leave[k] > ways[-1]:
                    planes_left[-1], ways[-1] = through[k], leave[k]
            else:
                rays.append(ray)
                planes_left.append(through[k])
                ways.append(leave[k])
    return np.array(rays[1:], np.int64), np.array(planes_left[1:], np.int64), np.array(ways[1:])


@compiled
def _crossed(A: Array, b: Array, origin: Array, way: Array) -> tuple[float, float, int]:
    """Where a ray enters and leaves the body A x <= b [m], and through which plane; it leaves first where it misses."""
    enter, leave, face = -np.inf, np.inf, 0
    for m in range(len(A)):
        speed = A[m, 0] * way[0] + A[m, 1] * way[1] + A[m, 2] * way[2]
        gap = b[m] - A[m, 0] * origin[0] - A[m, 1] * origin[1] - A[m, 2] * origin[2]
        if speed < -1e-12:
            enter = max(enter, gap / speed)
        elif speed > 1e-12:
            if gap / speed < leave:
                leave, face = gap / speed, m
        elif gap < -1e-9:
            return np.inf, -np.inf, 0
    return enter, leave, face
