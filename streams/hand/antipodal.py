"""Antipodal contacts on any union of convex parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from tamp.streams.surfaces import SurfacePoints, half_spaces

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.task.mesh.parts import Part

PERTURBED_SHARE = 0.5  # of the rays leave the normal by a random tilt, to find pairs on curved and slanted faces
TILT = 0.25
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
    enter, leave, normals = _crossings(parts, rays.origins, rays.directions)
    found = [
        (ray, part)
        for ray in range(len(rays.origins))
        for part in _exits(enter[:, ray], leave[:, ray])
        if 1e-3 < leave[part, ray] <= max_width
    ]
    index, part = np.array(found, dtype=np.int64).reshape(-1, 2).T
    widths, exits = leave[part, index], normals[part, index]
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


def _crossings(
    parts: Sequence[Part], origins: NDArray[np.float64], directions: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Where each ray enters and leaves each part, (parts, rays) [m]; the normal where it leaves, (parts, rays, 3)."""
    enter, leave, normals = [], [], []
    for part in parts:
        A, b = half_spaces(part)
        speed = directions @ A.T
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (b - origins @ A.T) / speed
        outside = (np.abs(speed) < 1e-12) & (origins @ A.T > b + 1e-9)
        t_in = np.where(speed < -1e-12, t, -np.inf).max(axis=1)
        exits = np.where(speed > 1e-12, t, np.inf)
        face = exits.argmin(axis=1)
        t_out = exits[np.arange(len(t)), face]
        missed = (t_in >= t_out) | outside.any(axis=1) | (t_out <= 0)
        enter.append(np.where(missed, np.inf, t_in))
        leave.append(np.where(missed, -np.inf, t_out))
        normals.append(A[face])
    return np.array(enter), np.array(leave), np.array(normals)


def _exits(enter: NDArray[np.float64], leave: NDArray[np.float64]) -> list[int]:
    """Parts whose far side is a far side of the union, along one ray."""
    exits: list[int] = []
    for part in np.argsort(enter, kind="stable"):
        if enter[part] == np.inf:
            break
        if exits and enter[part] <= leave[exits[-1]] + SEAM:
            if leave[part] > leave[exits[-1]]:
                exits[-1] = int(part)
        else:
            exits.append(int(part))
    return exits
