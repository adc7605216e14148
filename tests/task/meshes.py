"""Meshes of several convex parts, as text."""

from __future__ import annotations

from collections.abc import Sequence

from tamp.formats.obj import box_obj

Corner = tuple[float, float, float]


def parts_obj(boxes: Sequence[tuple[Corner, Corner]]) -> str:
    """An OBJ file whose groups are boxes, each given by its lower and upper corner [m]."""
    lines = list[str]()
    for index, (lower, upper) in enumerate(boxes):
        before = sum(line.startswith("v ") for line in lines)
        for line in box_obj(f"part{index}", lower, upper).splitlines():
            face = line.startswith("f ")
            lines.append("f " + " ".join(str(int(v) + before) for v in line.split()[1:]) if face else line)
    return "\n".join(lines) + "\n"
