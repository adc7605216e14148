"""Solids out of closed convex parts, and the OBJ files they are kept in: one `o part_k` group a part, in metres.

Hollow things are hollow: their walls are rings of convex wedges. The radius of a round thing is that of its flat
facets, two of which face along x and two along y, so that a cylinder is as wide as its radius says and lies still on
its side.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, pi, sin
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]
Profile = Sequence[tuple[float, float]]
Range = tuple[float, float]
Size = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Part:
    """A closed convex body: vertices, shape (n, 3) [m], and triangles that turn anticlockwise seen from outside."""

    vertices: Points
    triangles: tuple[tuple[int, int, int], ...]


def loft(first: Points, second: Points) -> Part:
    """The body between two flat convex polygons of k corners each, shape (k, 3), corner i joined to corner i."""
    k = len(first)
    vertices = np.vstack([first, second])
    caps = [(0, i + 1, i) for i in range(1, k - 1)] + [(k, k + i, k + i + 1) for i in range(1, k - 1)]
    sides = [t for i in range(k) for t in ((i, (i + 1) % k, k + i), ((i + 1) % k, k + (i + 1) % k, k + i))]
    triangles = caps + sides
    corners = vertices[np.array(triangles)]
    if float(np.linalg.det(corners).sum()) < 0.0:  # six times the signed volume
        triangles = [(a, c, b) for a, b, c in triangles]
    return Part(vertices, tuple(triangles))


def block(x: Range, y: Range, z: Range) -> Part:
    """An axis-aligned box."""
    return tapered(x, y, x, y, z)


def tapered(low_x: Range, low_y: Range, high_x: Range, high_y: Range, z: Range) -> Part:
    """A frustum between two axis-aligned rectangles, the low one at z[0], the high one at z[1]."""
    low, high = (
        np.array([(x[0], y[0], height), (x[1], y[0], height), (x[1], y[1], height), (x[0], y[1], height)])
        for x, y, height in ((low_x, low_y, z[0]), (high_x, high_y, z[1]))
    )
    return loft(low, high)


def disc(radius: float | Range, z: Range, sides: int = 24) -> Part:
    """A cylinder about z, or a frustum where `radius` is a pair (at the lower, at the upper end)."""
    radii = (radius, radius) if isinstance(radius, float) else radius
    ends = zip(radii, z, strict=True)
    bottom, top = (np.array([_on_circle(r, height, i, sides) for i in range(sides)]) for r, height in ends)
    return loft(bottom, top)


def ring(profile: Profile, sides: int = 24) -> list[Part]:
    """The convex profile of corners (radius, z) turned about the z axis: one wedge a side."""
    slices = [np.array([_on_circle(r, z, i, sides) for r, z in profile]) for i in range(sides)]
    return [loft(slices[i], slices[(i + 1) % sides]) for i in range(sides)]


def strip(outer: Profile, inner: Profile, depth: Range) -> list[Part]:
    """A bent bar: the band between two lines of as many points (x, z), as thick along y as `depth` says."""
    pieces = []
    for i in range(len(outer) - 1):
        profile = [outer[i], outer[i + 1], inner[i + 1], inner[i]]
        left, right = (np.array([(x, y, z) for x, z in profile]) for y in depth)
        pieces.append(loft(left, right))
    return pieces


def crate(size: Size, wall: float) -> list[Part]:
    """A floor and four upright walls of one thickness around it, without a lid."""
    x, y, height = size[0] / 2, size[1] / 2, size[2]
    inside = y - wall
    return [
        block((-x, x), (-y, y), (0.0, wall)),
        block((-x, x), (-y, -inside), (wall, height)),
        block((-x, x), (inside, y), (wall, height)),
        block((-x, wall - x), (-inside, inside), (wall, height)),
        block((x - wall, x), (-inside, inside), (wall, height)),
    ]


def moved(pieces: Sequence[Part], xyz: Size) -> list[Part]:
    """The parts shifted by a vector [m]."""
    return [Part(part.vertices + np.array(xyz), part.triangles) for part in pieces]


def laid(pieces: Sequence[Part]) -> list[Part]:
    """The parts turned a quarter about y, so that what pointed along z points along x."""
    turn = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    return [Part(part.vertices @ turn.T, part.triangles) for part in pieces]


def tipped(pieces: Sequence[Part]) -> list[Part]:
    """The parts turned a quarter about x, so that what pointed along y points along z."""
    turn = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    return [Part(part.vertices @ turn.T, part.triangles) for part in pieces]


def centred(pieces: Sequence[Part]) -> list[Part]:
    """The parts moved so that the centre of their common bounding box is the origin."""
    points = np.vstack([part.vertices for part in pieces])
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    return [Part(part.vertices - middle, part.triangles) for part in pieces]


def volume(pieces: Sequence[Part]) -> float:
    """The sum of the parts' volumes [m^3]."""
    return sum(float(np.linalg.det(part.vertices[np.array(part.triangles)]).sum() / 6) for part in pieces)


def obj_text(title: str, pieces: Sequence[Part]) -> str:
    """The parts, centred, as an OBJ file: one group a part, six decimals, the same bytes at each call."""
    lines = [f"# {title}"]
    first = 1
    for k, part in enumerate(centred(pieces)):
        lines.append(f"o part_{k}")
        lines += ["v " + " ".join(f"{float(v) + 0.0:.6f}" for v in np.round(vertex, 6)) for vertex in part.vertices]
        lines += ["f " + " ".join(str(first + i) for i in triangle) for triangle in part.triangles]
        first += len(part.vertices)
    return "\n".join(lines) + "\n"


def write_obj(path: Path, text: str) -> None:
    """Write an OBJ file, its folders included, with the same bytes on every system."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8", newline="\n")


def _on_circle(apothem: float, z: float, i: int, sides: int) -> tuple[float, float, float]:
    radius, angle = apothem / cos(pi / sides), (2 * i + 1) * pi / sides
    return radius * cos(angle), radius * sin(angle), z
