"""Turns that map a shape onto itself: no depth picture can tell a pose from its turned ones."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial import cKDTree

from tamp.world.transforms import rotation

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

ALIKE_MEAN, ALIKE_WORST = 0.0025, 0.006
"""A turn maps a shape onto itself if points come this near to the shape on average, and 95 % of them that near [m]."""

DENSE = 0.005
"""What a large shape's points lie farther apart than this along its surface is no difference between shapes [m]."""

FACING = 0.004
"""Metres that opposite normals are worth, halved."""

PROBED = 300
"""Points that a turn is judged by."""

ROUNDS, FITTED, REACH = 6, 600, 0.010
"""Times that an axis is moved, by so many points, and how far from the surface those may be [m]."""

NEARLY = 3.0
"""An axis about which half a turn misses by more than so many times what is allowed is not moved."""

FOLDS = (2, 3, 4, 5, 6, 8)
ANY = 36
"""Turns that stand for a body of revolution."""


@dataclass(frozen=True, eq=False)
class _Shape:
    """Oriented points of a shape, and how far from each other they may be found for chance alone.

    Attributes:
        points, normals: evenly on the surface, shape (n, 3).
        tree: search among them, by place and, weighed by `FACING`, normal.
        spacing: twice the mean distance of neighbours [m].
    """

    points: Array
    normals: Array
    tree: Any
    spacing: float

    @staticmethod
    def of(points: Array, normals: Array) -> _Shape:
        oriented = np.column_stack([points, FACING * normals])
        tree = cKDTree(oriented)
        # Points never fall on points: what an identity would measure is the distance between neighbours.
        neighbours = tree.query(oriented[:PROBED], k=2)[0][:, 1]
        return _Shape(points, normals, tree, 2 * float(neighbours.mean()))

    def holds(self, T: Array) -> bool:
        """Whether a motion (4, 4) maps the shape onto itself."""
        distance = self._missed(T)
        return bool(distance.mean() < self._least + ALIKE_MEAN and np.percentile(distance, 95) < ALIKE_WORST)

    @property
    def _least(self) -> float:
        """What the best motion misses by on average, for chance alone [m]."""
        return min(self.spacing, DENSE) / 4

    def _missed(self, T: Array) -> Array:
        """How far some of the shape's points, moved by T (4, 4), are from the shape, normals counted [m]."""
        turned, facing = self._moved(T, PROBED)
        distance, index = self.tree.query(np.column_stack([turned, FACING * facing]))
        if self.spacing > DENSE:
            away = self.points[index] - turned
            gap = np.einsum("ij,ij->i", away, self.normals[index])
            along = np.linalg.norm(away - gap[:, None] * self.normals[index], axis=1)
            turn = FACING * np.linalg.norm(facing - self.normals[index], axis=1)
            distance = np.sqrt(gap**2 + turn**2 + np.maximum(0.0, along - (self.spacing - DENSE)) ** 2)
        return np.asarray(distance)

    def mended(self, axis: Array, center: Array) -> tuple[Array, Array]:
        """An axis through a point, both moved to where half a turn about it maps the shape onto itself best.

        The centre and the principal axes of a sample are off by a millimetre and a degree; over a large shape that is
        more than what shapes are told apart by. Where half a turn maps nothing onto itself the axis stays.
        """
        turn = about(rotation(axis, np.pi), center)
        before = self._missed(turn).mean()
        if before > NEARLY * (self._least + ALIKE_MEAN):
            return axis, center
        frame = np.eye(4)
        for _ in range(ROUNDS):
            frame = self._step(frame @ turn @ np.linalg.inv(frame), center) @ frame
        if self._missed(frame @ turn @ np.linalg.inv(frame)).mean() >= before:
            return axis, center
        return frame[:3, :3] @ axis, frame[:3, :3] @ center + frame[:3, 3]

    def _step(self, turn: Array, center: Array) -> Array:
        """The motion (4, 4) of a turn's axis after which turned points lie better on the shape: point-to-plane ICP."""
        own = self.points[:FITTED]
        turned, facing = self._moved(turn, FITTED)
        _, index = self.tree.query(np.column_stack([turned, FACING * facing]))
        normals = self.normals[index]
        gap = np.einsum("ij,ij->i", self.points[index] - turned, normals)
        weight = np.maximum(0.0, 1 - (gap / REACH) ** 2) ** 2 * (np.einsum("ij,ij->i", facing, normals) > 0.5)
        # A motion of the axis moves where a point is turned to, and first, the other way, the point that is turned.
        back = normals @ turn[:3, :3]
        arms = np.cross(turned - center, normals) - np.cross(own - center, back)
        rows = np.column_stack([arms, normals - back])
        # What leaves the axis where it is would be free.
        ridge = 1e-3 * max(1.0, weight.sum()) * np.diag([float(np.var(own))] * 3 + [1.0] * 3)
        step = np.linalg.solve((rows * weight[:, None]).T @ rows + ridge, rows.T @ (weight * gap))
        angle = float(np.linalg.norm(step[:3]))
        motion = about(rotation(step[:3] / angle, angle), center) if angle > 1e-12 else np.eye(4)
        motion[:3, 3] += step[3:]
        return motion

    def _moved(self, T: Array, count: int) -> tuple[Array, Array]:
        return self.points[:count] @ T[:3, :3].T + T[:3, 3], self.normals[:count] @ T[:3, :3].T


def symmetries(points: Array, normals: Array, center: Array) -> Array:
    """Turns that leave a shape where it is, shape (k, 4, 4); the identity is the first.

    Looked for about the principal axes of the surface and, where two of them are alike, about axes between them; each
    axis is moved first to where the shape is most symmetrical about it.

    Args:
        points: evenly on the surface, shape (n, 3).
        normals: at the points, shape (n, 3).
        center: their mean, shape (3,).
    """
    shape = _Shape.of(points, normals)
    main, others = _axes(points - center)
    around = max((_turns_about(*line, shape.holds) for line in _lines(shape, main, center)), key=len)
    if len(around) == ANY - 1 and all(
        shape.holds(about(rotation(axis, angle), center)) for axis in others[::9] for angle in (1.0, 2.2)
    ):
        return np.stack([about(R, center) for R in _all_turns(main, others)])
    found = [np.eye(4), *around]
    halves = (about(rotation(axis, np.pi), point) for a in others for axis, point in _lines(shape, a, center))
    flip = next((T for T in halves if shape.holds(T)), None)
    if flip is not None:
        found += [flip @ T for T in found]
    elif not around:
        found += [T for axis in others for T in _turns_about(axis, center, shape.holds)]
    return np.stack(found)


def _lines(shape: _Shape, axis: Array, center: Array) -> list[tuple[Array, Array]]:
    """An axis through the centre as it was mended, and as it was: what is nearly symmetrical may be so about either."""
    return [shape.mended(axis, center), (axis, center)]


def round_axes(turns: Array) -> Array:
    """Axes about which any turn maps a shape onto itself, told by its `symmetries` (k, 4, 4): none, one, or three."""
    if len(turns) < ANY:
        return np.empty((0, 3))
    if len(turns) > 2 * ANY:
        return np.eye(3)
    R = turns[1, :3, :3]  # about the main axis, see `symmetries`
    axis = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    return np.asarray(axis[None] / np.linalg.norm(axis))


def _axes(local: Array) -> tuple[Array, list[Array]]:
    """The axis most likely to have many turns, and others perpendicular to it."""
    values, vectors = np.linalg.eigh(np.cov(local.T))
    gaps = np.abs(np.diff(values))
    single = 0 if gaps[0] > gaps[1] else 2
    main = vectors[:, single]
    a, b = (vectors[:, i] for i in range(3) if i != single)
    angles = np.arange(0, np.pi, np.pi / ANY)
    return main, [np.cos(t) * a + np.sin(t) * b for t in angles]


def _turns_about(axis: Array, center: Array, holds: Callable[[Array], bool]) -> list[Array]:
    """All turns (4, 4) about an axis that hold, without the identity."""

    def turn(angle: float) -> Array:
        return about(rotation(axis, angle), center)

    if holds(turn(1.0)) and holds(turn(2.2)):
        return [turn(2 * np.pi * i / ANY) for i in range(1, ANY)]
    fold = max((n for n in FOLDS if holds(turn(2 * np.pi / n))), default=1)
    return [turn(2 * np.pi * i / fold) for i in range(1, fold)]


def _all_turns(main: Array, others: list[Array]) -> list[Array]:
    """Turns that stand for those of a ball, 20 degrees apart: tilts in all directions, then about the axis."""
    own = [rotation(main, np.radians(20) * i) for i in range(18)]
    tilts = [np.eye(3)]
    for tilt in np.radians(np.arange(20, 181, 20)):
        count = max(1, round(18 * np.sin(tilt)))
        ways = [others[(2 * ANY * k // count) % ANY] * (1 if 2 * k < count else -1) for k in range(count)]
        tilts += [rotation(way, tilt) for way in ways]
    return [T @ R for T in tilts for R in own]


def about(R: Array, center: Array) -> Array:
    """A rotation (3, 3) about a point (3,), shape (4, 4)."""
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = R, center - R @ center
    return T
