"""Our own household objects: `python -m tamp.scenarios.make_objects` writes scenarios/objects/NAME/collision.obj.

Every object is a list of closed convex parts, one `o part_k` group each, in metres. The origin is the centre of the
bounding box and z points up as the object is used. Hollow things are hollow: their walls are rings of convex wedges.
The radius of a round thing is that of its flat facets, two of which face along x and two along y, so that a cylinder
is as wide as its radius says and lies still on its side.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import cos, pi, sin
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]
Profile = Sequence[tuple[float, float]]
Range = tuple[float, float]


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
    corners = [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])]
    bottom, top = (np.array([(px, py, height) for px, py in corners]) for height in z)
    return loft(bottom, top)


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


def _on_circle(apothem: float, z: float, i: int, sides: int) -> tuple[float, float, float]:
    radius, angle = apothem / cos(pi / sides), (2 * i + 1) * pi / sides
    return radius * cos(angle), radius * sin(angle), z


def bottle() -> list[Part]:
    """A closed bottle with a neck and a cap, 6.4 cm wide and 18.5 cm tall."""
    return [
        disc(0.032, (0.0, 0.115)),
        disc((0.032, 0.013), (0.115, 0.145)),
        disc(0.013, (0.145, 0.167)),
        disc(0.0155, (0.167, 0.185)),
    ]


def can() -> list[Part]:
    """A can, 6.6 cm wide and 12 cm tall."""
    return [disc(0.033, (0.0, 0.12))]


def jar() -> list[Part]:
    """A jar with a wider lid, 8.5 cm tall."""
    return [disc(0.030, (0.0, 0.068)), disc(0.0325, (0.068, 0.085))]


def marker() -> list[Part]:
    """A thick felt pen, 2.5 cm wide and 14 cm long; eight-sided, so that it does not roll."""
    return [disc(0.0125, (0.0, 0.125), 8), disc((0.0125, 0.006), (0.125, 0.14), 8)]


def cup() -> list[Part]:
    """A conical cup without a handle, 10 cm tall, wall 3.5 mm."""
    wall = [(0.028, 0.0), (0.0365, 0.1), (0.033, 0.1), (0.0245, 0.0)]
    return [disc(0.0245, (0.0, 0.005), 16), *ring(wall, 16)]


def mug() -> list[Part]:
    """A mug, 7.4 cm wide and 9 cm tall, wall 4 mm, with a handle towards +x."""
    wall = [(0.037, 0.0), (0.037, 0.09), (0.033, 0.09), (0.033, 0.0)]
    outer = [(0.036, 0.078), (0.059, 0.073), (0.067, 0.047), (0.059, 0.022), (0.036, 0.017)]
    inner = [(0.036, 0.068), (0.053, 0.065), (0.058, 0.047), (0.053, 0.030), (0.036, 0.027)]
    handle = []
    for i in range(len(outer) - 1):
        profile = [outer[i], outer[i + 1], inner[i + 1], inner[i]]
        left, right = (np.array([(x, y, z) for x, z in profile]) for y in (-0.006, 0.006))
        handle.append(loft(left, right))
    return [disc(0.033, (0.0, 0.006), 16), *ring(wall, 16), *handle]


def bowl() -> list[Part]:
    """A bowl, 16 cm wide and 5.5 cm deep, with a wall of about 3.5 mm."""
    wall = [(0.045, 0.0), (0.08, 0.055), (0.0755, 0.055), (0.045, 0.006)]
    return [disc(0.045, (0.0, 0.006)), *ring(wall)]


def plate() -> list[Part]:
    """A plate, 19 cm wide and 2.5 cm tall."""
    rim = [(0.065, 0.0), (0.095, 0.0215), (0.093, 0.025), (0.065, 0.006)]
    return [disc(0.065, (0.0, 0.006)), *ring(rim)]


def book() -> list[Part]:
    """A book lying flat, 12 x 16 x 3.5 cm, its spine towards -y: two covers, the spine, the pages."""
    x, y = (-0.06, 0.06), (-0.08, 0.08)
    covers = [block(x, y, (0.0, 0.003)), block(x, y, (0.032, 0.035))]
    spine = block(x, (-0.08, -0.077), (0.003, 0.032))
    return [*covers, spine, block((-0.057, 0.057), (-0.077, 0.077), (0.003, 0.032))]


def tray() -> list[Part]:
    """A tray, 20 x 30 cm, with a rim 2.5 cm high and 5 mm thick."""
    return _open_crate((0.20, 0.30, 0.025), 0.005)


def open_box() -> list[Part]:
    """A box without a lid, 16 x 22 x 6 cm, wall 4 mm."""
    return _open_crate((0.16, 0.22, 0.06), 0.004)


def rack() -> list[Part]:
    """A rack: a base of 14 cm and four dividers across x, 8 mm thick, with slots of 4.5 cm between them."""
    pitch, half = 0.053, 0.0835
    dividers = [block((x, x + 0.008), (-0.07, 0.07), (0.01, 0.09)) for x in (-half + i * pitch for i in range(4))]
    return [block((-half, half), (-0.07, 0.07), (0.0, 0.01)), *dividers]


def _open_crate(size: tuple[float, float, float], wall: float) -> list[Part]:
    """A floor and four upright walls of one thickness around it."""
    x, y, height = size[0] / 2, size[1] / 2, size[2]
    inside = y - wall
    return [
        block((-x, x), (-y, y), (0.0, wall)),
        block((-x, x), (-y, -inside), (wall, height)),
        block((-x, x), (inside, y), (wall, height)),
        block((-x, wall - x), (-inside, inside), (wall, height)),
        block((x - wall, x), (-inside, inside), (wall, height)),
    ]


OBJECTS: Mapping[str, Callable[[], list[Part]]] = MappingProxyType(
    {f.__name__: f for f in (book, bottle, bowl, can, cup, jar, marker, mug, open_box, plate, rack, tray)}
)


def centred(parts: Sequence[Part]) -> list[Part]:
    """The parts moved so that the centre of their common bounding box is the origin."""
    points = np.vstack([part.vertices for part in parts])
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    return [Part(part.vertices - middle, part.triangles) for part in parts]


def obj_text(name: str) -> str:
    """The OBJ file of an object: one group a part, six decimals, the same bytes at each call."""
    lines = [f"# {name}, in metres; written by scenarios/make_objects.py"]
    first = 1
    for k, part in enumerate(centred(OBJECTS[name]())):
        lines.append(f"o part_{k}")
        lines += ["v " + " ".join(f"{float(v) + 0.0:.6f}" for v in np.round(vertex, 6)) for vertex in part.vertices]
        lines += ["f " + " ".join(str(first + i) for i in triangle) for triangle in part.triangles]
        first += len(part.vertices)
    return "\n".join(lines) + "\n"


def main() -> None:
    """Write every object's file beside this one."""
    root = Path(__file__).resolve().parent / "objects"
    for name in OBJECTS:
        path = root / name / "collision.obj"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(obj_text(name), encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
