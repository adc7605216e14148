"""Our own household objects: `python -m tamp.scenarios.make_objects` writes scenarios/objects/NAME/collision.obj.

Every object is a list of closed convex parts. The origin is the centre of the bounding box and z points up as the
object is used.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType

from tamp.scenarios.parts import Part, block, crate, disc, obj_text, ring, strip, write_obj


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
    handle = strip(outer, inner, (-0.006, 0.006))
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
    return crate((0.20, 0.30, 0.025), 0.005)


def open_box() -> list[Part]:
    """A box without a lid, 16 x 22 x 6 cm, wall 4 mm."""
    return crate((0.16, 0.22, 0.06), 0.004)


def pail() -> list[Part]:
    """A square pail, 10 cm wide and 14 cm tall, wall 4 mm."""
    return crate((0.10, 0.10, 0.14), 0.004)


def rack() -> list[Part]:
    """A rack: a base of 14 cm and four dividers across x, 8 mm thick, with slots of 4.5 cm between them."""
    pitch, half = 0.053, 0.0835
    dividers = [block((x, x + 0.008), (-0.07, 0.07), (0.01, 0.09)) for x in (-half + i * pitch for i in range(4))]
    return [block((-half, half), (-0.07, 0.07), (0.0, 0.01)), *dividers]


OBJECTS: Mapping[str, Callable[[], list[Part]]] = MappingProxyType(
    {f.__name__: f for f in (book, bottle, bowl, can, cup, jar, marker, mug, open_box, pail, plate, rack, tray)}
)


def text(name: str) -> str:
    """The OBJ file of an object."""
    return obj_text(f"{name}, in metres; written by scenarios/make_objects.py", OBJECTS[name]())


def main() -> None:
    """Write every object's file beside this one."""
    root = Path(__file__).resolve().parent / "objects"
    for name in OBJECTS:
        write_obj(root / name / "collision.obj", text(name))


if __name__ == "__main__":
    main()
