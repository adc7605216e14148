"""Heaps as in `heaps`, of cups, mugs, pails, jars, plates and bowls, which are of several convex pieces that bulge."""

from __future__ import annotations

from pathlib import Path

from tamp.task import Box, Mesh
from tests.checking.physics.heaps import body

OBJECTS = Path(__file__).parents[3] / "scenarios" / "objects"


def hollow(kind: str, scale: float = 1.0) -> Mesh:
    return Mesh(OBJECTS / kind / "collision.obj", scale)


TAKEN_FROM_HOLLOW = {
    "jar that leans on a cup which lies, and on the jar that is taken": (
        body("a", hollow("cup"), (0.06098, -0.12401, 0.05007), (3.1416, 0.0, 1.57), 0.15, 0.2),
        body("b", Box((0.2185, 0.0556, 0.0209)), (0.0764, 0.05024, 0.01044), (0.0, 0.0, 0.0001), 1.29, 1.5),
        body("it", hollow("jar"), (0.00553, -0.019, 0.05082), (-2.7912, -0.0109, 0.0012), 0.56, 1.0),
        body("c", hollow("jar", 0.8), (0.02457, -0.08116, 0.1066), (-0.8388, -0.3158, -3.0972), 0.2, 1.0),
    ),
    "mug that leans on a lesser one": (
        body("it", hollow("mug", 0.6), (-0.04604, -0.09607, 0.02709), (0.0, 0.0, 1.5707), 0.26, 0.2),
        body("a", hollow("mug"), (0.03672, -0.10457, 0.04896), (0.0609, 0.9158, 0.0609), 0.04, 0.4),
    ),
}
"""What is left came to rest on something else within millimetres, where it would have stayed from rest."""

PUT_ON_HOLLOW = {
    "plate aslant on the foot of a bowl that lies upside down over a pail": (
        body("a", hollow("mug"), (-0.00291, 0.07726, 0.04499), (-3.1416, 0.0, 1.5708), 1.12, 0.6),
        body("b", hollow("pail"), (0.10427, 0.05818, 0.04999), (1.5708, 0.0001, 1.5523), 0.04, 1.5),
        body("c", hollow("bowl", 0.8), (0.11506, 0.07857, 0.12252), (3.1416, 0.0, 1.5708), 0.19, 0.6),
        body("it", hollow("plate", 0.6), (0.09399, 0.14023, 0.16602), (0.0, -0.6777, 0.3827), 0.95, 0.6),
    ),
    "pail half beside a slab on a plate": (
        body("a", hollow("plate"), (0.01152, 0.0004, 0.01248), (0.0001, -0.0001, 1.5708), 0.09, 0.4),
        body("b", Box((0.2067, 0.0814, 0.0226)), (0.03308, -0.02076, 0.03609), (0.0, -0.0001, 1.5708), 0.04, 0.6),
        body("it", hollow("pail"), (0.01542, 0.04065, 0.1175), (0.0, 0.0, 0.4065), 0.55, 0.4),
    ),
    "cup on a bowl that leans on a jar, upside down": (
        body("a", hollow("jar", 0.6), (0.05271, -0.00681, 0.02549), (0.0, 0.0, 1.5684), 1.3, 1.5),
        body("b", hollow("bowl", 0.8), (-0.01121, -0.0223, 0.04681), (2.7223, -0.0945, 1.6056), 0.09, 1.5),
        body("it", hollow("cup", 0.6), (-0.05335, 0.00969, 0.09322), (0.0, 0.0, 1.5708), 0.09, 0.2),
    ),
}
"""What is put there was held by pieces that pinch it harder than its weight can press."""
