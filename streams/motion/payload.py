"""Do arm and fingers bear what they carry? Asked of objects so heavy that not every configuration does."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.hand.hand_boxes import hand_boxes
from tamp.streams.workspace import Workspace
from tamp.task import Trajectory
from tamp.task.robot import PAD_FRICTION
from tamp.world.motion.paths import RESOLUTION, densify
from tamp.world.robot.chain import chain
from tamp.world.robot.payload import GRAVITY, always_borne, overloaded
from tamp.world.timing.trajectory import positions_at

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.world.collision.checker import CollisionChecker
    from tamp.world.motion.paths import Touching
    from tamp.world.motion.planner import KnownChecker
    from tamp.world.scene import Scene

    Array = NDArray[np.float64]

SURELY = 0.9  # share of the friction of pads that is counted on
PERIOD = 0.01  # between two looks at how fast something moves [s]


class Carried:
    """An object in the hand, as a weight that arm and fingers bear or do not."""

    def __init__(self, workspace: Workspace, obj: str, T_tool_object: Array, width: float) -> None:
        """`T_tool_object`, shape (4, 4), says where the object is in fingers that are `width` [m] apart."""
        item, gripper = workspace.task.object(obj), workspace.world.robot.spec.gripper
        self._robot, self._name, self._mass = workspace.world.robot, obj, item.mass
        self._center = T_tool_object[:3, :3] @ workspace.world.geometries[obj].center_of_mass + T_tool_object[:3, 3]
        self._axis = np.array(gripper.axis)
        self._lever = self._center - (0.0, 0.0, float(self._robot.linkage.depth(width)))
        self._held = SURELY * 2 * PAD_FRICTION * item.friction * gripper.force
        self._resists = self._held * _mean_radius(*gripper.pad[1:])

    @property
    def fingerprint(self) -> bytes:
        """Equal for weights that are borne alike."""
        return b"".join(np.float64(part).tobytes() for part in (self._center, self._lever, self._mass, self._resists))

    @property
    def light(self) -> bool:
        """Whether it is borne wherever it goes."""
        weight = GRAVITY * self._mass
        at_most = np.hypot(weight / self._held, weight * float(np.linalg.norm(self._lever)) / self._resists)
        return bool(at_most <= 1.0) and always_borne(self._robot, weight, float(np.linalg.norm(self._center)))

    def too_heavy(self, path: Array) -> str | None:
        """Why it is not carried along a path, shape (n, joints), in words; None where it is."""
        q = densify(path)
        R, t = chain(self._robot).forward(q)
        weight = np.array([0.0, 0.0, -GRAVITY * self._mass])
        asked = overloaded(self._robot, q, R @ self._center + t, weight)
        if asked is not None:
            return f"the weight of {self._name} asks {asked}"
        if self._strain(R, weight).max() > 1.0:
            return f"{self._name} would slip or swing down in the fingers"
        return None

    def held_throughout(self, trajectory: Trajectory) -> bool:
        """Whether the fingers hold it, against its weight and what speeds it up and slows it down."""
        times = np.linspace(0.0, trajectory.duration, max(4, int(trajectory.duration / PERIOD) + 1))
        R, t = chain(self._robot).forward(positions_at(trajectory, times))
        rates = np.diff(R @ self._center + t, axis=0) / times[1]
        still = np.zeros((1, 3))
        speeding = np.diff(np.concatenate([still, rates, still]), axis=0) / times[1]
        forces = self._mass * (speeding + np.array([0.0, 0.0, GRAVITY]))
        return bool(self._strain(R, forces).max() <= 1.0)

    def _strain(self, R: Array, forces: Array) -> Array:
        """What forces at the centre of mass ask of friction with the tool at R (n, 3, 3), as a share, shape (n,).

        Force and moment that it holds at once lie within an ellipsoid about (Howe and Cutkosky, International Journal
        of Robotics Research 15(6), 1996). Pads are taken to press evenly.
        """
        axes = R @ self._axis
        pulled = np.linalg.norm(forces - (forces * axes).sum(axis=1)[:, None] * axes, axis=1)
        turned = ((R @ np.cross(self._axis, self._lever)) * forces).sum(axis=1)
        strain: Array = np.hypot(pulled / self._held, turned / self._resists)
        return strain


def _mean_radius(a: float, b: float) -> float:
    """Mean distance of the points of a rectangle from its centre, by its sides [m]."""
    across = math.hypot(a, b)
    return (2 * across + a * a / b * math.asinh(b / a) + b * b / a * math.asinh(a / b)) / 12


def lift_too_heavy(workspace: Workspace, obj: str, T_tool_object: Array, width: float, path: Array) -> str | None:
    """Why arm and fingers do not carry an object along a path, shape (n, joints), in words; None where they do."""
    carried = Carried(workspace, obj, T_tool_object, width)
    return None if carried.light else carried.too_heavy(path)


class LoadedChecker:
    """A collision check to which configurations in which the arm does not bear what it holds are not free either."""

    def __init__(self, checker: CollisionChecker, carried: Carried) -> None:
        self._checker, self._carried = checker, carried
        self.robot = checker.robot

    @property
    def fingerprint(self) -> bytes:
        """Equal for checkers that answer every question alike."""
        return self._checker.fingerprint + self._carried.fingerprint

    def free(self, q: Array) -> bool:
        """Whether a configuration, shape (dof,), is free and borne."""
        return self._carried.too_heavy(q[None]) is None and self._checker.free(q)

    def edge_free(self, q0: Array, q1: Array, resolution: float = RESOLUTION) -> bool:
        """The same of all of a straight edge."""
        edge = np.array([q0, q1])
        return self._carried.too_heavy(edge) is None and self._checker.edge_free(q0, q1, resolution)

    def contact(self, q: Array) -> Touching | None:
        """Two bodies in contact, or None where there are none."""
        return self._checker.contact(q)


def push_too_heavy(
    workspace: Workspace, obj: str, ahead: Array, opening: float, path: Array, share: float
) -> str | None:
    """Why the arm does not push an object along, or over its edge, in words; None where it does.

    Args:
        workspace: where it is.
        obj: the object.
        ahead: where it goes, shape (3,); its length and what is not level of it do not matter.
        opening: distance between the pads [m].
        path: the arm's configurations as it pushes, shape (n, joints).
        share: of the object's weight that it takes.
    """
    robot = workspace.world.robot
    push = share * GRAVITY * workspace.task.object(obj).mass
    tip = np.array([0.0, 0.0, hand_boxes(robot).tip(opening)])
    if always_borne(robot, push, float(np.linalg.norm(tip))):
        return None
    R, t = chain(robot).forward(path)
    back = -ahead * (1.0, 1.0, 0.0)
    asked = overloaded(robot, path, R @ tip + t, push * back / max(float(np.linalg.norm(back)), 1e-9))
    return None if asked is None else f"to push {obj} asks {asked}"


def load_aware(workspace: Workspace, scene: Scene, checker: CollisionChecker) -> KnownChecker:
    """The collision check of a scene, which also asks whether the arm bears what it holds where that is in question."""
    if scene.held is None or (carried := Carried(workspace, *scene.held, scene.opening)).light:
        return checker
    return LoadedChecker(checker, carried)
