"""Do the pads really close on the object? What of it lies in the region between them, clipped polygon by polygon."""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.geometry.transforms import rotation

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.checking.geometry.solids import Solid
    from tamp.task.robot import Gripper

    Array = NDArray[np.float64]

EDGE = 0.001
"""The outermost part of a pad that is not trusted to hold anything [m]."""
NEAR = 2e-4
"""What lies so little within the outermost point between the pads is touched with it [m]."""

TURN = 0.02
"""How far what is gripped turns between two looks at how wide it is [rad]."""
LARGEST = 0.6
"""No farther do pads turn what they close on [rad]."""
STEEPEST = 1e6
"""The tangent of a slope on which nothing presses."""
STICKS = 0.6
"""Share of friction that holds what pads would turn: they turn it as they close, while they still slip along it."""


def between_pads(
    solid: Solid, T_tool_object: Array, gripper: Gripper, opening: float, depth: float = 0.0
) -> tuple[float, float] | None:
    """What of an object lies between the pads, along the closing axis.

    Args:
        solid: the object.
        T_tool_object: where it lies in the tool frame, shape (4, 4).
        gripper: whose pads' centres close along `gripper.axis`.
        opening: distance between the pads [m].
        depth: where the pads' middle is along the tool's z [m].

    Returns:
        Least and largest coordinate along the closing axis [m], or None where nothing lies between the pads.
    """
    R = _pad_frame(gripper)
    half = (opening / 2, gripper.pad[1] / 2 - EDGE, gripper.pad[2] / 2 - EDGE)
    found: list[float] = []
    for piece in solid.pieces:
        points = (piece.part.vertices @ T_tool_object[:3, :3].T + T_tool_object[:3, 3] - (0.0, 0.0, depth)) @ R.T
        if (points.min(axis=0) >= half).any() or (points.max(axis=0) <= np.negative(half)).any():
            continue
        for triangle in _meeting(points[piece.part.faces], half):
            found += [float(corner[0]) for corner in _clipped(triangle, half)]
    return (min(found), max(found)) if found else None


def squeezed_out(
    solid: Solid, T_tool_object: Array, gripper: Gripper, opening: float, friction: float, depth: float = 0.0
) -> float | None:
    """The slope of an object where pads slip off it, or None where they do not: steeper than the cone of friction.

    Args:
        solid: the object.
        T_tool_object: where it lies in the tool frame, shape (4, 4).
        gripper: whose pads close on it.
        opening: distance between the pads [m].
        friction: coefficient between pads and object.
        depth: where the pads' middle is along the tool's z [m].

    Returns:
        The angle between the closing axis and the least steep of the faces that a pad's rim presses on [rad].
    """
    return slips_out(pressed_slopes(solid, T_tool_object, gripper, opening, depth), friction)


def slips_out(slopes: tuple[Array, Array], friction: float) -> float | None:
    """The same of `pressed_slopes` that are known."""
    steepest = max(float(np.arctan(np.linalg.norm(slope))) for slope in slopes)
    return steepest if steepest > np.arctan(friction) else None


def pressed_slopes(
    solid: Solid, T_tool_object: Array, gripper: Gripper, opening: float, depth: float = 0.0
) -> tuple[Array, Array]:
    """The slopes that the rims of either pad press on, each of shape (3,), zero where a pad presses straight on.

    What bulges between the pads, or lies across them as a ridge does, touches their faces, which press straight on it.
    Where it grows wider beyond a pad's rim the rim presses on a slope.

    Arguments as of `squeezed_out`.

    Returns:
        For each pad the way in which it pushes the object out, in the tool frame, as long as the tangent of the angle
        between the closing axis and the least steep of the faces that its rim presses on.
    """
    R = _pad_frame(gripper)
    half = (opening / 2, gripper.pad[1] / 2 - EDGE, gripper.pad[2] / 2 - EDGE)
    touched: list[tuple[Array, Array]] = []  # a corner of what is between the pads, and the normal of its face
    for piece in solid.pieces:
        points = (piece.part.vertices @ T_tool_object[:3, :3].T + T_tool_object[:3, 3] - (0.0, 0.0, depth)) @ R.T
        if (points.min(axis=0) >= half).any() or (points.max(axis=0) <= np.negative(half)).any():
            continue
        for triangle in _meeting(points[piece.part.faces], half):
            normal = np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
            normal /= max(float(np.linalg.norm(normal)), 1e-14)
            touched += [(corner, normal) for corner in _clipped(triangle, half)]

    def slope(side: float) -> Array:
        outermost = max((side * corner[0] for corner, _ in touched), default=0.0)
        faces: dict[bytes, list[tuple[Array, Array]]] = {}  # those that meet in a corner
        for corner, normal in touched:
            if side * corner[0] > outermost - NEAR:
                faces.setdefault((np.round(corner, 6) + 0.0).tobytes(), []).append((corner, normal))
        slopes = [_slope(met[0][0], np.stack([normal for _, normal in met]), side, half) for met in faces.values()]
        least: Array = min(slopes, key=lambda each: float(np.linalg.norm(each)), default=np.zeros(3)) @ R
        return least

    return slope(1.0), slope(-1.0)


def laid_flush(
    solid: Solid, T_tool_object: Array, gripper: Gripper, opening: float, friction: float, depth: float = 0.0
) -> Array:
    """Where in the tool frame pads turn what they close on, shape (4, 4).

    Pads that touch it at places which are not across from each other turn it until it is narrower no other way, or as
    far as friction lets them: a turn about the pads' middle by an angle closes them by that times the distance of the
    places along the pads, and friction works against it on half of the width at each of them.

    Args:
        solid: the object.
        T_tool_object: where it lies in the tool frame, shape (4, 4).
        gripper: whose pads close on it.
        opening: distance between the pads [m].
        friction: coefficient between pads and object.
        depth: where the pads' middle is along the tool's z [m].
    """
    found = between_pads(solid, T_tool_object, gripper, opening, depth)
    best, T = 0.0, T_tool_object
    middle = np.array([0.0, 0.0, depth])
    for axis in (side * across for across in _pad_frame(gripper)[1:] for side in (1.0, -1.0)):
        at, wide = T_tool_object, found
        for angle in np.arange(TURN, LARGEST, TURN):
            R = rotation(axis, float(angle))
            turned = T_tool_object.copy()
            turned[:3] = R @ T_tool_object[:3]
            turned[:3, 3] += middle - R @ middle
            narrower = between_pads(solid, turned, gripper, opening, depth)
            if wide is None or narrower is None:
                break
            closed = (wide[1] - wide[0]) - (narrower[1] - narrower[0])
            if closed < STICKS * friction * (wide[1] - wide[0]) * TURN:
                break
            at, wide = turned, narrower
            if angle > best:
                best, T = float(angle), at
    return T


def _slope(corner: Array, normals: Array, side: float, half: tuple[float, float, float]) -> Array:
    """The way out in which a pad pushes the faces that meet in a corner, shape (3,), in the frame of the pads.

    It is as long as the tangent of the angle between the closing axis and the line along which the two press. A pad's
    face presses along the axis. A rim presses across itself, along what lies between the faces' normals; the end of a
    rim along any of these.
    """
    rims = np.flatnonzero(np.abs(np.abs(corner[1:]) - half[1:]) < 1e-9) + 1
    if not len(rims):
        return np.zeros(3)
    lines = normals
    if len(rims) == 1:
        along = normals[:, 3 - rims[0]]
        # Between a face that looks at the pad and one that does not, at an edge, a pad may press too.
        pairs = [
            abs(b) * first + abs(a) * second
            for (a, first), (b, second) in combinations(zip(along, normals, strict=True), 2)
            if a * b < 0.0
        ]
        lines = np.array([*normals[np.abs(along) < 1e-6], *pairs]).reshape(-1, 3)
    facing = lines[side * lines[:, 0] > 1e-6]
    outwards = np.zeros((len(facing) + 1, 3))
    outwards[:-1, rims] = np.maximum(-facing[:, rims] * np.sign(corner[rims]), 0.0) * np.sign(corner[rims])
    outwards[:-1] /= side * facing[:, :1]
    outwards[-1, rims[0]] = STEEPEST * np.sign(corner[rims[0]])  # where no face looks at the pad
    least: Array = outwards[np.linalg.norm(outwards, axis=1).argmin()]
    return least


def _pad_frame(gripper: Gripper) -> Array:
    """Rows: closing axis, width and approach of the pads in the tool frame; the approach is the tool's z."""
    along = np.array(gripper.axis) / np.linalg.norm(gripper.axis)
    approach = np.array([0.0, 0.0, 1.0])
    return np.stack([along, np.cross(approach, along), approach])


def _meeting(triangles: Array, half: tuple[float, float, float]) -> Array:
    """Those of triangles (n, 3, 3) whose bounding boxes meet the box |x_i| <= half_i."""
    meet: Array = triangles[
        ((triangles.min(axis=1) <= half) & (triangles.max(axis=1) >= np.negative(half))).all(axis=1)
    ]
    return meet


def _clipped(polygon: Array, half: tuple[float, float, float]) -> list[Array]:
    """A polygon cut to the box |x_i| <= half_i (Sutherland and Hodgman 1974)."""
    corners = list(polygon)
    for axis in range(3):
        for sign in (1.0, -1.0):
            kept: list[Array] = []
            for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
                da, db = half[axis] - sign * a[axis], half[axis] - sign * b[axis]
                if da >= 0.0:
                    kept.append(a)
                if da * db < 0.0:
                    kept.append(a + (b - a) * (da / (da - db)))
            corners = kept
            if not corners:
                return corners
    return corners
