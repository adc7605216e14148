"""Does what leant on something lie down when that is taken? By brute force: boxes on springs and dampers, let go."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import permutations

import numpy as np
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from tamp.task import Box
from tamp.task.model import TABLE_FRICTION
from tests.checking.oracle.bearing import leans
from tests.checking.oracle.bodies import depth
from tests.checking.oracle.world import World

NEAR = 0.05  # bodies whose spheres are no farther apart may come to touch [m]
TOUCHES = 0.001  # what meets another body when it is shifted so far touches it [m]
SPACING = 0.006  # of the points along edges [m]
STICKIER = 1.3  # times the friction that is given
STIFF, DAMPED = 4e3, 4.0  # each point in a body [N/m], [N s/m]
CREEPS = 2e-3  # what slides slower is not held by all of its friction [m/s]
STEP, LASTS = 2e-4, 0.2  # [s]
FAR = 0.025  # what has moved so far lies down [m]
G = 9.81


@dataclass
class _Bodily:
    """A body on its way: its pose, its velocities [m/s], [rad/s], and what acts on it [N], [N m]."""

    T: np.ndarray
    planes: np.ndarray
    edges: np.ndarray
    friction: float
    mass: float
    moments: np.ndarray
    way: np.ndarray = field(default_factory=lambda: np.zeros(3))
    turn: np.ndarray = field(default_factory=lambda: np.zeros(3))
    force: np.ndarray = field(default_factory=lambda: np.zeros(3))
    moment: np.ndarray = field(default_factory=lambda: np.zeros(3))

    def speeds(self, points: np.ndarray) -> np.ndarray:
        x, y, z = self.turn
        return self.way + (points - self.T[:3, 3]) @ np.array([(0.0, z, -y), (-z, 0.0, x), (y, -x, 0.0)])

    def pushed(self, points: np.ndarray, forces: np.ndarray) -> None:
        self.force += forces.sum(axis=0)
        M = (points - self.T[:3, 3]).T @ forces
        self.moment += (M[1, 2] - M[2, 1], M[2, 0] - M[0, 2], M[0, 1] - M[1, 0])

    def goes_on(self) -> None:
        R = self.T[:3, :3]
        self.way += STEP * (self.force / self.mass + (0.0, 0.0, -G))
        self.turn += STEP * (R @ ((R.T @ self.moment) / self.moments))
        self.T[:3, :3] = Rotation.from_rotvec(STEP * self.turn).as_matrix() @ R
        self.T[:3, 3] += STEP * self.way
        self.force, self.moment = np.zeros(3), np.zeros(3)


def lets_down(world: World, name: str) -> str | None:
    """Which box that leans on an object goes far once that is not there, and does not while it is; or None."""
    leant = [o for o in world.others(name, "table") if leans(world, o) and _touches(world, name, o)]
    loose = set(leant)
    while more := {o for o in world.others(name, *loose, "table") if any(_near(world, o, one) for one in loose)}:
        loose |= more
    if not leant or not all(isinstance(world.task.object(o).shape, Box) for o in loose):
        return None
    gone = _gone(world, sorted(loose), "table")
    if gone is None or _gone(world, sorted(loose), "table", name) is not None:
        return None
    return f"{gone} lies down without {name}"


def _touches(world: World, one: str, other: str) -> bool:
    for shift in TOUCHES * np.vstack([np.eye(3), -np.eye(3)]):
        T = world.poses[one].copy()
        T[:3, 3] += shift
        if depth(world.bodies[one], T, world.bodies[other], world.poses[other]) > 0.0:
            return True
    return False


def _near(world: World, one: str, other: str) -> bool:
    apart = np.linalg.norm(world.poses[one][:3, 3] - world.poses[other][:3, 3])
    return bool(apart < world.bodies[one].radius + world.bodies[other].radius + NEAR)


def _gone(world: World, loose: list[str], *firm: str) -> str | None:
    """Which of some boxes that are let go, among what is firm, goes far; or None."""
    bodies = {name: _bodily(world, name) for name in (*loose, *firm)}
    pairs = [(one, other) for one, other in permutations(bodies, 2) if {one, other} & set(loose) and one != "table"]
    for _ in range(round(LASTS / STEP)):
        for one, other in pairs:
            _press(bodies[one], bodies[other])
        for name in loose:
            bodies[name].goes_on()
            if np.linalg.norm(bodies[name].T[:3, 3] - world.poses[name][:3, 3]) > FAR:
                return name
    return None


def _press(one: _Bodily, other: _Bodily) -> None:
    """The points of one body that are in another are pressed out of it, and rub along it."""
    points = one.edges @ one.T[:3, :3].T + one.T[:3, 3]
    heights = (points - other.T[:3, 3]) @ other.T[:3, :3] @ other.planes[:, :3].T + other.planes[:, 3]
    inside = (heights < 0.0).all(axis=1)
    if not inside.any():
        return
    points, heights = points[inside], heights[inside]
    ways = other.planes[heights.argmax(axis=1), :3] @ other.T[:3, :3].T
    speeds = one.speeds(points) - other.speeds(points)
    out = (speeds * ways).sum(axis=1)
    presses = np.maximum(-STIFF * heights.max(axis=1) - DAMPED * out, 0.0)
    along = speeds - out[:, None] * ways
    rubs = STICKIER * one.friction * other.friction * presses / np.maximum(np.linalg.norm(along, axis=1), CREEPS)
    forces = presses[:, None] * ways - rubs[:, None] * along
    one.pushed(points, forces)
    other.pushed(points, -forces)


def _bodily(world: World, name: str) -> _Bodily:
    body, T = world.bodies[name], world.poses[name].copy()
    planes = np.vstack(body.planes)
    if name == "table":
        return _Bodily(T, planes, np.zeros((0, 3)), TABLE_FRICTION, np.inf, np.full(3, np.inf))
    thing, hull = world.task.object(name), ConvexHull(body.points)
    ends = body.points[np.vstack([hull.simplices[:, pair] for pair in ([0, 1], [1, 2], [2, 0])])]
    edges = [np.linspace(a, b, int(np.linalg.norm(b - a) / SPACING) + 2) for a, b in ends]
    size = np.ptp(body.points, axis=0)
    moments = thing.mass / 12 * (size @ size - size**2)
    return _Bodily(T, planes, np.unique(np.round(np.vstack(edges), 6), axis=0), thing.friction, thing.mass, moments)
