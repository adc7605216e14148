"""How far an object turns between the pads when it is lifted.

Pads are flat: what they pinch on slanted faces turns until it lies flat between them, and what hangs beside them sags.
The object turns as long as the work of the closing fingers and its weight gain more than friction takes. It is looked
at turning about the line across the pads and about the approach axis; about the closing axis the whole face of a pad
resists.
"""

from __future__ import annotations

import itertools
import math
from functools import partial
from operator import itemgetter
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.surfaces import half_spaces
from tamp.streams.values import Grasp
from tamp.streams.workspace import Workspace
from tamp.task import Gripper, Pose
from tamp.task.robot import PAD_FRICTION

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Array = NDArray[np.float64]

STEP = 0.04  # between the angles looked at [rad]
FARTHEST = 0.7  # it is enough to know that it turns this far [rad]
GLANCES = (1, 3, 7, 19)  # steps are looked at in stretches from one of these to the next; most end in the first
RAYS = (5, 13)  # across and along a pad, at which the object is felt
BESIDE = 0.01  # parts that are farther than this from where the pads are play no role [m]
TRUSTED = 0.5  # share of the friction that is counted on: lifting shakes, and pads do not touch everywhere
GRAVITY = 9.81  # [m/s^2]


def turning(workspace: Workspace, obj: str, grasp: Grasp, *poses: Pose) -> float:
    """The angle that an object turns by, held by a grasp and lifted [rad]; 0 where it keeps still.

    Args:
        workspace: where the object is.
        obj: the object.
        grasp: what holds it.
        poses: where it is lifted from; the one at which it turns farthest counts.
    """
    item, geometry = workspace.task.object(obj), workspace.world.geometries[obj]
    gripper = workspace.world.robot.spec.gripper
    weight = item.mass * GRAVITY
    force = gripper.holding_force(weight, item.friction)
    R, t = _in_pads(gripper, grasp)
    near = [part for part in geometry.parts if _is_near(part.vertices @ R.T + t, gripper, grasp.width)]
    between = _Between([(A @ R.T, b + A @ R.T @ t) for A, b in map(half_spaces, near)], gripper, grasp.width)
    center = R @ geometry.center_of_mass + t
    resisted = TRUSTED * PAD_FRICTION * item.friction * force * grasp.width * STEP

    def energies(turns: Array, up: Array) -> Array:
        work: Array = force * between.thickness(turns) + weight * (turns @ center @ up)
        return work

    upward = np.unique(np.round([pose.matrix[2, :3] for pose in poses], 6), axis=0)
    return max(_turned(partial(energies, up=R @ up), resisted) for up in upward)


def _turned(energies: Callable[[Array], Array], resisted: float) -> float:
    """How far it turns [rad]; where it has turned about one axis, it may go on about the other."""
    ways = [(about, step) for about in (_about_side, _about_approach) for step in (STEP, -STEP)]
    turn, steps = np.eye(3), 1
    while steps and _angle(turn) < FARTHEST:
        still = float(energies(turn[None])[0])
        steps, turn = max((_slide(energies, turn, still, *way, resisted) for way in ways), key=itemgetter(0))
    return _angle(turn)


def _slide(
    energies: Callable[[Array], Array],
    turn: Array,
    still: float,
    about: Callable[[float], Array],
    step: float,
    resisted: float,
) -> tuple[int, Array]:
    """How many steps it goes on from a rotation, each setting free more energy than it takes, alone or with the next.

    Returns:
        The number of steps, and the rotation that they lead to, shape (3, 3).
    """
    reached, least = 0, still
    for first, last in itertools.pairwise(GLANCES):
        taken = energies(np.array([about(count * step) @ turn for count in range(first, last)]))
        for count, spent in enumerate(taken, first):
            if spent + count * resisted < least:
                reached, least = count, spent + count * resisted
            elif count > reached + 1:
                return reached, about(reached * step) @ turn
    return reached, about(reached * step) @ turn


def _angle(turn: Array) -> float:
    """By how much a rotation (3, 3) turns [rad]."""
    return math.acos(min(1.0, max(-1.0, (float(np.trace(turn)) - 1.0) / 2.0)))


def _in_pads(gripper: Gripper, grasp: Grasp) -> tuple[Array, Array]:
    """Rotation and translation from the object's frame to one whose axes are the pads' side, closing and approach."""
    closing = np.array(gripper.axis)
    axes = np.stack([np.cross(closing, [0.0, 0.0, 1.0]), closing, [0.0, 0.0, 1.0]])
    T = grasp.T_object_tool.inverse().matrix
    return axes @ T[:3, :3], axes @ T[:3, 3]


def _is_near(points: Array, gripper: Gripper, width: float) -> bool:
    half = np.array([gripper.pad[1], width, gripper.pad[2]]) / 2 + BESIDE
    return bool((points.min(axis=0) < half).all() and (points.max(axis=0) > -half).all())


def _about_side(angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def _about_approach(angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


class _Between:
    """What lies between the pads, felt along rays from one pad to the other."""

    def __init__(self, parts: list[tuple[Array, Array]], gripper: Gripper, width: float) -> None:
        """Parts are given as {x : A x <= b}, in the frame of the pads; `width` is how far those are apart [m]."""
        self._A = np.concatenate([A for A, _ in parts]) if parts else np.empty((0, 3))
        self._b = np.concatenate([b for _, b in parts]) if parts else np.empty(0)
        self._starts = np.cumsum([0, *(len(b) for _, b in parts)])[:-1]
        self._width = width
        sides = zip(gripper.pad[1:], RAYS, strict=True)
        across, along = (np.linspace(-side / 2, side / 2, count) for side, count in sides)
        self._origins = np.array([(x, 0.0, z) for x in across for z in along])

    def thickness(self, turns: Array) -> Array:
        """How far apart the pads stand with all of it turned, for each of the rotations (n, 3, 3); shape (n,) [m]."""
        if not len(self._b):
            return np.zeros(len(turns))
        A = self._A @ turns.transpose(0, 2, 1)
        speed, gap = A[:, :, 1:2], self._b[:, None] - A @ self._origins.T
        with np.errstate(divide="ignore", invalid="ignore"):
            t = gap / speed
        enter = np.maximum.reduceat(np.where(speed < -1e-9, t, -np.inf), self._starts, axis=1)
        leave = np.minimum.reduceat(np.where(speed > 1e-9, t, np.inf), self._starts, axis=1)
        beside = np.logical_or.reduceat((np.abs(speed) <= 1e-9) & (gap < 0), self._starts, axis=1)
        met = ~beside & (enter < leave) & (np.abs(enter + leave) < self._width + 0.002)
        low = np.where(met, enter, np.inf).min(axis=(1, 2))
        high = np.where(met, leave, -np.inf).max(axis=(1, 2))
        apart: Array = np.maximum(high - low, 0.0)
        return apart
