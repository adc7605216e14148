"""What one works with: cutlery, scissors, pens, tools. All lie flat, along x."""

from __future__ import annotations

from tamp.scenarios.library.kinds import FLIP, PLAIN, Body, Kind
from tamp.scenarios.parts import Part, block, disc, laid, moved, ring, tapered
from tamp.task.model import Symmetry

Y = tuple[float, float]


def knife(length: float, width: float, height: float) -> Body:
    """A table knife: a handle and a blade that narrows to its tip."""
    bend, half = 0.45 * length, width / 2
    blade = _along((bend, length), (-half, half), (-half, 0.0), (0.0, 0.8 * height))
    return Body([_bar((0.0, bend), 0.9 * width, height), blade])


def fork(length: float, width: float, height: float) -> Body:
    """A fork: handle, shoulder and three tines."""
    neck, tines, half = 0.68 * length, 0.78 * length, 0.75 * width
    pitch = (2 * half - 0.006) / 2
    edges = [i * pitch - half for i in range(3)]
    prongs = [block((tines, length), (y, y + 0.006), (0.0, 0.8 * height)) for y in edges]
    shoulder = block((neck, tines), (-half, half), (0.0, 0.9 * height))
    return Body([_bar((0.0, neck), width, height), shoulder, *prongs])


def spoon(length: float, width: float, height: float) -> Body:
    """A spoon: a handle and a round shallow bowl."""
    radius = 0.95 * width
    handle = _bar((0.0, length - 2 * radius + 0.002), width, height)
    wall = [(0.8 * radius, 0.002), (radius, height), (radius - 0.003, height), (0.8 * radius, 0.004)]
    hollow = [disc(0.8 * radius, (0.0, 0.004), 12), *ring(wall, 12)]
    return Body([handle, *moved(hollow, (length - radius, 0.0, 0.0))])


def scissors(length: float, height: float) -> Body:
    """A closed pair of scissors with two round eyes."""
    eye, half = 0.019, 0.009
    start = 2 * eye
    eyes = [p for side in (-1.0, 1.0) for p in moved(_eye(eye, height), (eye, side * (eye - 0.002), 0.0))]
    shank = block((start - 0.002, start + 0.03), (-half, half), (0.0, height))
    return Body([*eyes, shank, _along((start + 0.03, length), (-half, half), (-0.003, 0.003), (0.0, height))])


def _eye(radius: float, height: float) -> list[Part]:
    return ring([(radius - 0.006, 0.0), (radius, 0.0), (radius, height), (radius - 0.006, height)], 10)


def shears(length: float, height: float) -> Body:
    """A pair of shears: two straight grips that spread, and a closed blade."""
    joint, half = 0.5 * length, 0.01
    grips = [
        _along((0.0, joint), (middle - 0.006, middle + 0.006), (foot - 0.005, foot + 0.005), (0.0, height))
        for middle, foot in ((-0.022, -0.005), (0.022, 0.005))
    ]
    return Body([*grips, _along((joint, length), (-half, half), (-0.003, 0.003), (0.0, height))])


def pen(radius: float, length: float) -> Body:
    """A pen with a point; eight-sided, so that it does not roll and fingers find two upright sides."""
    return Body(laid([disc(radius, (0.0, 0.88 * length), 8), disc((radius, 0.002), (0.88 * length, length), 8)]))


def marker(radius: float, length: float) -> Body:
    """A thick eight-sided felt pen with a cap."""
    return Body(laid([disc(radius, (0.0, 0.9 * length), 8), disc((radius, 0.5 * radius), (0.9 * length, length), 8)]))


def screwdriver(radius: float, length: float) -> Body:
    """A screwdriver: a six-sided grip and a shaft 9 mm thick."""
    grip = 0.5 * length
    return Body(laid([disc(radius, (0.0, grip), 6), disc(0.0045, (grip, length), 6)]))


def hammer(length: float, head: float) -> Body:
    """A hammer lying on its side."""
    return Body(
        [_bar((0.0, length), 0.022, 0.02), block((length, length + 0.028), (-head / 2, head / 2), (0.0, 0.026))]
    )


def wrench(length: float, width: float, height: float) -> Body:
    """An open-ended wrench."""
    inner, outer, neck = 0.5 * width, 1.1 * width, length - 0.012
    jaws = [block((length, length + 0.024), y, (0.0, height)) for y in ((-outer, -inner), (inner, outer))]
    root = block((neck, length), (-outer, outer), (0.0, height))
    return Body([_bar((0.0, neck), width, height), root, *jaws])


def clamp(length: float, width: float) -> Body:
    """A clamp: a back and two jaws."""
    back = block((0.0, length), (0.0, 0.016), (0.0, 0.016))
    ends = [block(x, (0.016, width), (0.0, 0.016)) for x in ((0.0, 0.016), (length - 0.016, length))]
    return Body([back, *ends])


def _bar(x: Y, width: float, height: float) -> Part:
    return block(x, (-width / 2, width / 2), (0.0, height))


def _along(x: Y, near: Y, far: Y, z: Y) -> Part:
    """A bar along x, as wide as `near` at its start and as `far` at its end."""
    # tapered() narrows along z: build it upright, with x for height, and lay it down.
    upright = tapered((-z[1], -z[0]), near, (-z[1], -z[0]), far, x)
    (part,) = laid([upright])
    return part


KINDS = (
    Kind(
        "knife",
        "cutlery",
        knife,
        {"length": (0.17, 0.2), "width": (0.018, 0.022), "height": (0.011, 0.014)},
        1500.0,
        PLAIN,
    ),
    Kind(
        "fork",
        "cutlery",
        fork,
        {"length": (0.16, 0.185), "width": (0.014, 0.018), "height": (0.011, 0.014)},
        1500.0,
        PLAIN,
    ),
    Kind(
        "spoon",
        "cutlery",
        spoon,
        {"length": (0.15, 0.18), "width": (0.016, 0.02), "height": (0.012, 0.015)},
        1500.0,
        PLAIN,
    ),
    Kind("scissors", "scissor", scissors, {"length": (0.13, 0.16), "height": (0.011, 0.015)}, 1500.0, FLIP),
    Kind("shears", "scissor", shears, {"length": (0.15, 0.18), "height": (0.012, 0.016)}, 1500.0, FLIP),
    Kind("pen", "pen", pen, {"radius": (0.0058, 0.0072), "length": (0.125, 0.145)}, 1200.0, Symmetry(x=8)),
    Kind("marker", "pen", marker, {"radius": (0.009, 0.0125), "length": (0.11, 0.14)}, 800.0, Symmetry(x=8)),
    Kind(
        "screwdriver", "tool", screwdriver, {"radius": (0.0115, 0.014), "length": (0.15, 0.19)}, 1200.0, Symmetry(x=6)
    ),
    Kind("hammer", "tool", hammer, {"length": (0.15, 0.18), "head": (0.07, 0.09)}, 1500.0, PLAIN),
    Kind(
        "wrench",
        "tool",
        wrench,
        {"length": (0.11, 0.14), "width": (0.015, 0.019), "height": (0.012, 0.016)},
        1500.0,
        FLIP,
    ),
    Kind("clamp", "tool", clamp, {"length": (0.08, 0.11), "width": (0.045, 0.06)}, 1500.0, PLAIN),
)
