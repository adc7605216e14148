"""Hollow round things: plates, cups, bowls, kettles."""

from __future__ import annotations

from tamp.scenarios.library.kinds import CROSS, HALF, PLAIN, ROUND, Body, Kind
from tamp.scenarios.parts import Part, block, crate, disc, loft, ring, strip, tapered

SIDES = 16
SQUARE_IN_CIRCLE = 1.4
"""Side of the largest square in a circle, in radii, rounded down: what goes into a round hollow for certain."""
FOOT = 0.002
"""How far walls end above the foot: on the table a thing rests on its foot alone, which physics is quicker with [m]."""

RIM = 0.004
"""Thickness of the rim of a square plate [m]."""


def plate(radius: float, height: float) -> Body:
    """A plate with a flat foot and a rising rim 4 mm thick."""
    foot = 0.76 * radius
    rim = [(foot, FOOT), (radius, height - 0.0035), (radius - 0.002, height), (foot, 0.005)]
    return Body([disc(foot, (0.0, 0.005), SIDES), *ring(rim, SIDES)], top=(2 * foot, 2 * foot))


def square_plate(side: float, height: float) -> Body:
    """A square plate, its rim leaning outwards."""
    foot, half = 0.36 * side, side / 2
    narrow, wide = (-foot - RIM, foot + RIM), (-half, half)
    rim = []
    for sign in (-1.0, 1.0):
        low, high = _band(sign, foot), _band(sign, half - RIM)
        rim.append(tapered(narrow, low, wide, high, (FOOT, height)))
        rim.append(tapered(low, narrow, high, wide, (FOOT, height)))
    floor = block((-foot, foot), (-foot, foot), (0.0, 0.005))
    return Body([floor, *rim], top=(1.9 * foot, 1.9 * foot))


def _band(sign: float, inner: float) -> tuple[float, float]:
    low, high = sorted((sign * inner, sign * (inner + RIM)))
    return low, high


def cup(radius: float, height: float) -> Body:
    """A conical cup without a handle, wall 3.5 mm."""
    foot, wall = 0.78 * radius, 0.0035
    profile = [(foot, FOOT), (radius, height), (radius - wall, height), (foot - wall, FOOT)]
    return Body([disc(foot - wall, (0.0, 0.005), SIDES), *ring(profile, SIDES)], hollow=_square(foot - wall))


def mug(radius: float, height: float) -> Body:
    """A mug, wall 4 mm, with a handle towards +x."""
    inner = radius - 0.004
    wall = [(radius, FOOT), (radius, height), (inner, height), (inner, FOOT)]
    handle = _ear(radius - 0.001, 0.18 * height, 0.85 * height)
    return Body([disc(inner, (0.0, 0.006), SIDES), *ring(wall, SIDES), *handle], hollow=_square(inner))


def _ear(x: float, low: float, high: float) -> list[Part]:
    """A handle that leaves a wall at x between two heights, 12 mm wide and about 9 mm thick."""
    middle = (low + high) / 2
    outer = [(x, high), (x + 0.023, high - 0.005), (x + 0.031, middle), (x + 0.023, low + 0.005), (x, low)]
    inner = [
        (x, high - 0.01),
        (x + 0.017, high - 0.013),
        (x + 0.022, middle),
        (x + 0.017, low + 0.013),
        (x, low + 0.01),
    ]
    return strip(outer, inner, (-0.006, 0.006))


def bowl(radius: float, height: float) -> Body:
    """A round bowl with a wall of about 4 mm."""
    foot = 0.56 * radius
    wall = [(foot, FOOT), (radius, height), (radius - 0.0045, height), (foot, 0.006)]
    return Body([disc(foot, (0.0, 0.006), SIDES), *ring(wall, SIDES)], hollow=_square(1.15 * foot))


def dish(length: float, width: float, height: float) -> Body:
    """A rectangular bowl, wall 5 mm."""
    return Body(crate((length, width, height), 0.005), hollow=(length - 0.012, width - 0.012))


def kettle(radius: float, height: float) -> Body:
    """A kettle with a spout towards +x and a bail over its lid, by which it is carried."""
    top, bail = 0.8 * radius, height + 0.05
    belly = [disc((radius, top), (0.0, height), SIDES), disc(0.009, (height, height + 0.012), SIDES)]
    spout = tapered(
        (0.7 * radius, 0.95 * radius), (-0.01, 0.01), (radius + 0.016, radius + 0.028), (-0.006, 0.006),
        (0.4 * height, 0.95 * height),
    )  # fmt: skip
    outer = [(-top, height - 0.004), (-0.8 * top, bail - 0.01), (-0.4 * top, bail), (0.4 * top, bail)]
    outer += [(0.8 * top, bail - 0.01), (top, height - 0.004)]
    inner = [(0.86 * x, z - 0.011) for x, z in outer]
    return Body([*belly, spout, *strip(outer, inner, (-0.007, 0.007))])


def teapot(radius: float, height: float) -> Body:
    """A pot with a handle towards -x, a spout towards +x and a knob on its lid."""
    body = [disc((0.85 * radius, radius), (0.0, 0.5 * height), SIDES)]
    body += [disc((radius, 0.7 * radius), (0.5 * height, height), SIDES), disc(0.009, (height, height + 0.016), SIDES)]
    spout = tapered(
        (0.7 * radius, 0.95 * radius), (-0.009, 0.009), (radius + 0.018, radius + 0.028), (-0.006, 0.006),
        (0.3 * height, 0.95 * height),
    )  # fmt: skip
    ear = [_mirrored(part) for part in _ear(0.82 * radius, 0.2 * height, 0.9 * height)]
    return Body([*body, spout, *ear])


def _mirrored(part: Part) -> Part:
    """The part with x turned round."""
    half = len(part.vertices) // 2
    flipped = part.vertices * (-1.0, 1.0, 1.0)
    return loft(flipped[:half], flipped[half:])


def saucepan(radius: float, height: float) -> Body:
    """A small pot, wall 4 mm, with a straight handle towards +x."""
    inner = radius - 0.004
    wall = [(radius, FOOT), (radius, height), (inner, height), (inner, FOOT)]
    handle = block((radius - 0.001, radius + 0.07), (-0.008, 0.008), (height - 0.012, height))
    return Body([disc(inner, (0.0, 0.006), SIDES), *ring(wall, SIDES), handle], hollow=_square(inner))


def _square(radius: float) -> tuple[float, float]:
    return SQUARE_IN_CIRCLE * radius, SQUARE_IN_CIRCLE * radius


KINDS = (
    Kind("plate", "plate", plate, {"radius": (0.078, 0.095), "height": (0.026, 0.032)}, 900.0, ROUND),
    Kind("saucer", "plate", plate, {"radius": (0.06, 0.07), "height": (0.024, 0.028)}, 900.0, ROUND),
    Kind("square_plate", "plate", square_plate, {"side": (0.14, 0.18), "height": (0.02, 0.026)}, 700.0, CROSS),
    Kind("cup", "cup", cup, {"radius": (0.032, 0.038), "height": (0.075, 0.1)}, 1400.0, ROUND),
    Kind("mug", "cup", mug, {"radius": (0.033, 0.038), "height": (0.075, 0.095)}, 1400.0, PLAIN),
    Kind("bowl", "bowl", bowl, {"radius": (0.06, 0.08), "height": (0.045, 0.06)}, 1100.0, ROUND),
    Kind("dish", "bowl", dish, {"length": (0.14, 0.17), "width": (0.1, 0.12), "height": (0.034, 0.042)}, 800.0, HALF),
    Kind("saucepan", "kettle", saucepan, {"radius": (0.055, 0.065), "height": (0.05, 0.065)}, 1100.0, PLAIN),
    Kind("kettle", "kettle", kettle, {"radius": (0.042, 0.052), "height": (0.07, 0.085)}, 350.0, PLAIN),
    Kind("teapot", "kettle", teapot, {"radius": (0.034, 0.0375), "height": (0.075, 0.09)}, 500.0, PLAIN),
)
