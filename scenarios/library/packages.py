"""What things come in: boxes, books, cans, bottles."""

from __future__ import annotations

from tamp.scenarios.library.kinds import BARREL, BRICK, CROSS, HALF, PLAIN, ROUND, Body, Kind
from tamp.scenarios.parts import Part, block, crate, disc, tapered


def carton(length: float, width: float, height: float) -> Body:
    """A closed box."""
    return Body([_block(length, width, height)], top=(length, width))


def book(thickness: float, length: float, height: float) -> Body:
    """A book that stands on its long side, its spine down: two covers, the spine, the pages."""
    x, y, cover = thickness / 2, length / 2, 0.003
    covers = [block((-x, cover - x), (-y, y), (0.0, height)), block((x - cover, x), (-y, y), (0.0, height))]
    spine = block((cover - x, x - cover), (-y, y), (0.0, cover))
    pages = block((cover - x, x - cover), (0.003 - y, y - 0.003), (cover, height - 0.003))
    return Body([*covers, spine, pages])


def notebook(length: float, width: float, height: float) -> Body:
    """A small book that lies flat, narrow enough for the hand."""
    return Body([_block(length, width, height)], top=(length, width))


def basket(length: float, width: float, height: float) -> Body:
    """A box without a lid, wall 5 mm."""
    return Body(crate((length, width, height), 0.005), hollow=(length - 0.012, width - 0.012))


def penholder(side: float, height: float) -> Body:
    """A tall square box without a lid, wall 4 mm."""
    return Body(crate((side, side, height), 0.004), hollow=(side - 0.01, side - 0.01))


def can(radius: float, height: float) -> Body:
    """A can."""
    return Body([disc(radius, (0.0, height))], top=(2 * radius, 2 * radius))


def bottle(radius: float, height: float) -> Body:
    """A closed round bottle with a neck and a cap."""
    shoulder, neck = 0.62 * height, 0.78 * height
    return Body(
        [
            disc(radius, (0.0, shoulder), 20),
            disc((radius, 0.012), (shoulder, neck), 20),
            disc(0.012, (neck, 0.9 * height), 12),
            disc(0.0145, (0.9 * height, height), 12),
        ]
    )


def flask(width: float, depth: float, height: float) -> Body:
    """A flat bottle with a round cap."""
    x, y, shoulder = width / 2, depth / 2, 0.75 * height
    body = block((-x, x), (-y, y), (0.0, shoulder))
    neck = tapered((-x, x), (-y, y), (-0.011, 0.011), (-0.011, 0.011), (shoulder, 0.87 * height))
    return Body([body, neck, disc(0.013, (0.87 * height, height), 12)])


def jar(radius: float, height: float) -> Body:
    """A jar with a lid wider than itself."""
    glass, lid = disc(radius, (0.0, 0.8 * height), 20), disc(radius + 0.002, (0.8 * height, height), 20)
    return Body([glass, lid], top=(2 * radius, 2 * radius))


def _block(length: float, width: float, height: float) -> Part:
    return block((-length / 2, length / 2), (-width / 2, width / 2), (0.0, height))


KINDS = (
    Kind(
        "carton", "box", carton, {"length": (0.07, 0.11), "width": (0.045, 0.07), "height": (0.09, 0.14)}, 250.0, BRICK
    ),
    Kind(
        "packet",
        "box",
        carton,
        {"length": (0.08, 0.12), "width": (0.055, 0.072), "height": (0.025, 0.04)},
        350.0,
        BRICK,
    ),
    Kind(
        "book", "box", book, {"thickness": (0.028, 0.038), "length": (0.13, 0.16), "height": (0.1, 0.12)}, 400.0, PLAIN
    ),
    Kind(
        "notebook",
        "box",
        notebook,
        {"length": (0.1, 0.13), "width": (0.062, 0.074), "height": (0.014, 0.022)},
        600.0,
        BRICK,
    ),
    Kind(
        "basket", "box", basket, {"length": (0.16, 0.19), "width": (0.2, 0.23), "height": (0.034, 0.042)}, 600.0, HALF
    ),
    Kind("penholder", "box", penholder, {"side": (0.068, 0.076), "height": (0.08, 0.095)}, 1000.0, CROSS),
    Kind("can", "can", can, {"radius": (0.026, 0.036), "height": (0.085, 0.12)}, 500.0, BARREL),
    Kind("tin", "can", can, {"radius": (0.032, 0.037), "height": (0.034, 0.046)}, 700.0, BARREL),
    Kind("bottle", "bottle", bottle, {"radius": (0.027, 0.035), "height": (0.15, 0.19)}, 400.0, ROUND),
    Kind(
        "flask",
        "bottle",
        flask,
        {"width": (0.055, 0.07), "depth": (0.036, 0.046), "height": (0.13, 0.165)},
        400.0,
        HALF,
    ),
    Kind("jar", "bottle", jar, {"radius": (0.027, 0.034), "height": (0.075, 0.1)}, 500.0, ROUND),
)
