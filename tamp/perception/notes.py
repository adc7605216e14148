"""Words on a picture: notes that point at pixels, beside each other and beside what is shown, where there is room."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

LETTERS = 12
"""Height of the letters [pixels]."""

MARGIN = 3
"""Of a note around its letters [pixels]."""

STEP = 4
"""How far apart the places are that are tried for a note [pixels]."""

GROUND = (0, 0, 0, 190)
"""What letters stand on: red, green, blue, opacity."""

WHITE = np.full(3, 255.0)


@dataclass(frozen=True, eq=False)
class Note:
    """Words that belong to a pixel.

    Attributes:
        text: one line or several.
        spot: (u, v), to which a line leads [pixels].
        color: red, green, blue of the letters, 0 to 255; darker ones are made lighter.
    """

    text: str
    spot: tuple[float, float]
    color: NDArray[np.float64]


def written(
    image: NDArray[np.uint8], notes: Sequence[Note], shown: NDArray[np.bool_], corner: str = ""
) -> NDArray[np.uint8]:
    """A picture with notes on it, shape (height, width, 3).

    Args:
        image: the picture; it stays as it is.
        notes: each is put as near to its pixel as there is room beside other notes and, where possible, beside objects.
        shown: where objects are, which notes had better not cover; shape (height, width).
        corner: what stands in the upper left corner.
    """
    from PIL import Image, ImageDraw, ImageFont

    picture = Image.fromarray(image)
    draw, font = ImageDraw.Draw(picture, "RGBA"), ImageFont.load_default(LETTERS)
    taken = np.zeros(image.shape[:2], dtype=np.bool_)
    first = [Note(corner, (0.0, 0.0), WHITE)] if corner else []
    for note in [*first, *sorted(notes, key=lambda note: note.spot[1])]:
        box = draw.multiline_textbbox((0, 0), note.text, font=font)
        width, height = int(box[2]) + 2 * MARGIN, int(box[3]) + 2 * MARGIN
        u, v = (0, 0) if note in first else _place(note.spot, (width, height), taken, shown)
        taken[v : v + height, u : u + width] = True
        color = _light(note.color)
        if note not in first:
            draw.line([note.spot, _nearest(note.spot, (u, v, u + width, v + height))], fill=color)
        draw.rectangle((u, v, u + width - 1, v + height - 1), fill=GROUND)
        draw.multiline_text((u + MARGIN, v + MARGIN), note.text, font=font, fill=color)
    return np.asarray(picture)


def _place(
    spot: tuple[float, float], size: tuple[int, int], taken: NDArray[np.bool_], shown: NDArray[np.bool_]
) -> tuple[int, int]:
    """The upper left pixel of a note: the free place next to its spot; where none is, one that covers an object."""
    (width, height), (rows, columns) = size, taken.shape
    lefts, tops = (range(0, max(1, most), STEP) for most in (columns - width, rows - height))
    middle = np.array(spot) - (width / 2, height / 2)
    places = sorted(itertools.product(lefts, tops), key=lambda place: float(np.abs(place - middle).sum()))
    for covered in (taken | shown, taken):
        sums = np.pad(covered.cumsum(0).cumsum(1), ((1, 0), (1, 0)))
        for u, v in places:
            right, low = min(u + width, columns), min(v + height, rows)
            if not sums[low, right] - sums[v, right] - sums[low, u] + sums[v, u]:
                return u, v
    return places[0]


def _nearest(spot: tuple[float, float], box: tuple[int, int, int, int]) -> tuple[float, float]:
    """The point of a rectangle (left, top, right, bottom) that is next to a spot."""
    return min(max(spot[0], box[0]), box[2]), min(max(spot[1], box[1]), box[3])


def _light(color: NDArray[np.float64]) -> tuple[int, int, int]:
    """A colour as it is read on black."""
    red, green, blue = (round(255 - 0.6 * (255 - value)) for value in color)
    return red, green, blue
