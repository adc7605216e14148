"""Toys: building blocks, animals, cars, plastic fruit."""

from __future__ import annotations

from tamp.scenarios.library.kinds import BARREL, BRICK, HALF, PLAIN, ROUND, Body, Kind
from tamp.scenarios.parts import block, disc, moved, ring, strip, tapered, tipped


def brick(length: float, width: float, height: float) -> Body:
    """A building block."""
    part = block((-length / 2, length / 2), (-width / 2, width / 2), (0.0, height))
    return Body([part], top=(length, width))


def arch(length: float, width: float, height: float) -> Body:
    """A building block with a gate through it."""
    x, y, leg = length / 2, (-width / 2, width / 2), 0.26 * length
    lintel = block((-x, x), y, (0.6 * height, height))
    legs = [block((-x, leg - x), y, (0.0, 0.6 * height)), block((x - leg, x), y, (0.0, 0.6 * height))]
    return Body([*legs, lintel], top=(length, width))


def roof(length: float, width: float, height: float) -> Body:
    """A building block with two slopes and a narrow ridge."""
    x, y = (-length / 2, length / 2), (-width / 2, width / 2)
    return Body([tapered(x, y, x, (-0.004, 0.004), (0.0, height))])


def animal(length: float, width: float, height: float) -> Body:
    """A four-legged animal that looks towards +x."""
    x, y, belly, leg = length / 2, width / 2, 0.4 * height, 0.32 * width
    body = block((-x, 0.75 * x), (-y, y), (belly, 0.78 * height))
    head = block((0.45 * x, x), (-0.7 * y, 0.7 * y), (0.78 * height, height))
    fore = (0.75 * x - leg, 0.75 * x)
    legs = [
        block(along, across, (0.0, belly))
        for along in ((-x, leg - x), fore)
        for across in ((-y, leg - y), (y - leg, y))
    ]
    return Body([body, head, *legs])


def car(length: float, width: float, height: float) -> Body:
    """A car on four wheels."""
    x, y, wheel = length / 2, width / 2, 0.2 * height
    body = block((-x, x), (-y, y), (wheel, 0.6 * height))
    cabin = tapered((-0.7 * x, 0.5 * x), (-y, y), (-0.6 * x, 0.25 * x), (-0.85 * y, 0.85 * y), (0.6 * height, height))
    hub = tipped([disc(wheel, (-0.004, 0.004), 8)])
    wheels = [
        part
        for side_x in (-0.6 * x, 0.6 * x)
        for side_y in (0.004 - y, y - 0.004)
        for part in moved(hub, (side_x, side_y, wheel))
    ]
    return Body([body, cabin, *wheels])


def apple(radius: float, height: float) -> Body:
    """A plastic apple, flattened below so that it stays where it is."""
    low, high = 0.3 * height, 0.7 * height
    belly = [disc((0.7 * radius, radius), (0.0, low), 12), disc(radius, (low, high), 12)]
    return Body([*belly, disc((radius, 0.6 * radius), (high, height), 12)])


def pear(radius: float, height: float) -> Body:
    """A plastic pear."""
    low, middle = 0.2 * height, 0.5 * height
    belly = [disc((0.75 * radius, radius), (0.0, low), 12), disc(radius, (low, middle), 12)]
    return Body([*belly, disc((radius, 0.4 * radius), (middle, height), 12)])


def banana(length: float, width: float, height: float) -> Body:
    """A plastic banana lying on its side, bent in five pieces."""
    half, bend = length / 2, 0.16 * length
    line = [(half * t, bend * (1 - t * t), width * (1 - 0.55 * t * t)) for t in (-1.0, -0.6, -0.2, 0.2, 0.6, 1.0)]
    outer = [(x, z + thick / 2) for x, z, thick in line]
    inner = [(x, z - thick / 2) for x, z, thick in line]
    return Body(tipped(strip(outer, inner, (-height, 0.0))))


def doughnut(radius: float, height: float) -> Body:
    """A ring to stack."""
    hole, edge = 0.42 * radius, 0.25 * height
    profile = [(hole, edge), (hole + edge, 0.0), (radius - edge, 0.0), (radius, edge)]
    profile += [(radius, height - edge), (radius - edge, height), (hole + edge, height), (hole, height - edge)]
    return Body(ring(profile, 12), top=(1.8 * radius, 1.8 * radius))


KINDS = (
    Kind(
        "brick", "toy", brick, {"length": (0.045, 0.075), "width": (0.04, 0.06), "height": (0.03, 0.055)}, 400.0, BRICK
    ),
    Kind("arch", "toy", arch, {"length": (0.085, 0.11), "width": (0.035, 0.05), "height": (0.045, 0.06)}, 400.0, HALF),
    Kind("roof", "toy", roof, {"length": (0.05, 0.08), "width": (0.045, 0.06), "height": (0.03, 0.045)}, 400.0, HALF),
    Kind(
        "animal", "toy", animal, {"length": (0.08, 0.11), "width": (0.04, 0.055), "height": (0.065, 0.09)}, 400.0, PLAIN
    ),
    Kind("car", "toy", car, {"length": (0.09, 0.12), "width": (0.045, 0.058), "height": (0.045, 0.06)}, 400.0, PLAIN),
    Kind("apple", "toy", apple, {"radius": (0.03, 0.036), "height": (0.055, 0.065)}, 250.0, ROUND),
    Kind("pear", "toy", pear, {"radius": (0.028, 0.034), "height": (0.075, 0.095)}, 250.0, ROUND),
    Kind(
        "banana",
        "toy",
        banana,
        {"length": (0.12, 0.15), "width": (0.03, 0.036), "height": (0.028, 0.034)},
        400.0,
        PLAIN,
    ),
    Kind("doughnut", "toy", doughnut, {"radius": (0.034, 0.038), "height": (0.022, 0.028)}, 400.0, BARREL),
)
