"""The exact collision check: one configuration, an edge, a path; and which two bodies were in the way."""

from __future__ import annotations

import hashlib
import itertools
import math
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from tamp.world.collision.broadphase import Arena, Setting
from tamp.world.collision.motion_bound import travel
from tamp.world.robot.model import RobotModel

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Vector = NDArray[np.float64]
    Matrix = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Contact:
    """Two bodies that come too close.

    Attributes:
        a, b: a robot link's name, an object's name, or "table".
        distance: signed distance [m]; negative where they penetrate.
    """

    a: str
    b: str
    distance: float

    def __str__(self) -> str:
        gap = f"{abs(self.distance) * 1000:.1f} mm"
        return f"{self.a} {'penetrates' if self.distance < 0 else 'comes too close to'} {self.b} ({gap})"


class CollisionChecker:
    """Says whether the robot, and what it holds, is free of collision in one scene.

    Checkers are cheap and share their world's collision structures; they may be used in turns, by one thread.
    """

    def __init__(self, robot: RobotModel, arena: Arena, setting: Setting, opening: float) -> None:
        self.robot = robot
        self._arena = arena
        self._setting = setting
        self._opening = opening
        self._full = robot.full(robot.home, opening)
        self._arm = robot.arm

    @property
    def fingerprint(self) -> bytes:
        """Equal for checkers that answer every question alike, in one process or another."""
        setting = self._setting
        touch = sorted(setting.touch.items()), sorted(setting.held_touch.items())
        margins = (setting.margin, setting.held_margin, *touch, self._opening)
        digest = hashlib.blake2b(repr((self.robot.spec.name, self._arena.names, margins)).encode(), digest_size=16)
        for name in sorted(setting.poses):
            digest.update(name.encode() + setting.poses[name].tobytes())
        digest.update(b"" if setting.T_tool_held is None else setting.T_tool_held.tobytes())
        return digest.digest()

    def travel(self, configurations: Matrix) -> Vector:
        """Metres that no point of robot and held object moves beyond between each two configurations, (n, dof)."""
        return travel(self.robot, configurations, self._arena.held_radius(self._setting))

    def free(self, q: Vector) -> bool:
        """Whether every body keeps its margin at configuration `q`, shape (dof,) [rad]."""
        self._arena.install(self._setting)
        self._full[self._arm] = q
        return self._arena.hit(self._full) is None

    def edge_free(self, q0: Vector, q1: Vector, resolution: float = 0.05) -> bool:
        """Whether the straight segment is free, both ends included, at states at most `resolution` [rad] apart.

        The states are visited by repeated bisection, so that a blocked segment is recognised early.
        """
        q0, q1 = np.asarray(q0, dtype=np.float64), np.asarray(q1, dtype=np.float64)
        steps = max(1, math.ceil(float(np.linalg.norm(q1 - q0)) / resolution))
        return self._states_free(q0, q1, _bisection(steps))

    def path_free(self, path: Matrix, resolution: float = 0.05) -> bool:
        """Whether the polyline through `path`, shape (n, dof), is free at `resolution` [rad]."""
        path = np.asarray(path, dtype=np.float64)
        if not self.free(path[0]):
            return False
        for q0, q1 in itertools.pairwise(path):
            steps = max(1, math.ceil(float(np.linalg.norm(q1 - q0)) / resolution))
            if not self._states_free(q0, q1, _bisection(steps)[:-1]):
                return False
        return True

    def _states_free(self, q0: Vector, q1: Vector, order: Vector) -> bool:
        self._arena.install(self._setting)
        hit = self._arena.hit
        full = np.tile(self._full, (len(order), 1))
        full[:, self._arm] = q0 + order[:, None] * (q1 - q0)
        return all(hit(q) is None for q in full)

    def contact(self, q: Vector) -> Contact | None:
        """Two bodies that come too close at `q`, or None where it is free."""
        self._arena.install(self._setting)
        self._full[self._arm] = q
        pair = self._arena.hit(self._full)
        return None if pair is None else self._contact(pair, self._arena.separation(pair))

    def first_contact(self, path: Matrix, resolution: float = 0.05) -> Contact | None:
        """The first contact along the polyline through `path`, shape (n, dof), or None where it is free."""
        path = np.asarray(path, dtype=np.float64)
        if (contact := self.contact(path[0])) is not None:
            return contact
        for q0, q1 in itertools.pairwise(path):
            steps = max(1, math.ceil(float(np.linalg.norm(q1 - q0)) / resolution))
            for k in range(1, steps + 1):
                if (contact := self.contact(q0 + (k / steps) * (q1 - q0))) is not None:
                    return contact
        return None

    def nearest(self, q: Vector) -> Contact:
        """The two bodies nearest to each other at `q` and their signed distance [m]; margins play no role."""
        self._arena.install(self._setting)
        self._full[self._arm] = q
        return self._contact(*self._arena.nearest(self._full))

    def distance(self, q: Vector) -> float:
        """The smallest signed distance of any two bodies that may collide, at `q` [m]."""
        return self.nearest(q).distance

    def _contact(self, pair: int, distance: float) -> Contact:
        a, b = self._arena.pairs[pair]
        return Contact(self._arena.names[a], self._arena.names[b], distance)


@cache
def _bisection(steps: int) -> Vector:
    """The fractions 0, 1/steps, ..., 1 by bisection: 1, the middle, the quarters, ...; 0, where one has been, last."""
    order, ranges = [steps], [(0, steps)]
    while ranges:
        halves = []
        for low, high in ranges:
            if high - low > 1:
                middle = (low + high) // 2
                order.append(middle)
                halves += [(low, middle), (middle, high)]
        ranges = halves
    fractions = np.array([*order, 0], dtype=np.float64) / steps
    fractions.setflags(write=False)
    return fractions
