"""Does the arm bear what it carries? Asked of objects so heavy that not every configuration does."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.hand.hand_boxes import hand_boxes
from tamp.streams.values import Slide
from tamp.streams.workspace import Workspace
from tamp.world.motion.paths import RESOLUTION, densify
from tamp.world.robot.chain import chain
from tamp.world.robot.payload import GRAVITY, always_borne, overloaded

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.world.collision.checker import CollisionChecker
    from tamp.world.motion.paths import Touching
    from tamp.world.motion.planner import KnownChecker
    from tamp.world.scene import Scene

    Array = NDArray[np.float64]


class Carried:
    """An object in the hand, as a weight that the arm bears or does not."""

    def __init__(self, workspace: Workspace, obj: str, T_tool_object: Array) -> None:
        """`T_tool_object`, shape (4, 4), says where the object is in the hand."""
        self._robot, self._name = workspace.world.robot, obj
        self._center = T_tool_object[:3, :3] @ workspace.world.geometries[obj].center_of_mass + T_tool_object[:3, 3]
        self._weight = GRAVITY * workspace.task.object(obj).mass

    @property
    def fingerprint(self) -> bytes:
        """Equal for weights that the arm bears alike."""
        return self._center.tobytes() + np.float64(self._weight).tobytes()

    @property
    def light(self) -> bool:
        """Whether the arm bears it wherever it goes."""
        return always_borne(self._robot, self._weight, float(np.linalg.norm(self._center)))

    def too_heavy(self, path: Array) -> str | None:
        """Why the arm does not carry it along a path, shape (n, joints), in words; None where it does."""
        q = densify(path)
        R, t = chain(self._robot).forward(q)
        asked = overloaded(self._robot, q, R @ self._center + t, np.array([0.0, 0.0, -self._weight]))
        return None if asked is None else f"the weight of {self._name} asks {asked}"


def lift_too_heavy(workspace: Workspace, obj: str, T_tool_object: Array, path: Array) -> str | None:
    """Why the arm does not carry an object along a path, shape (n, joints), in words; None where it does."""
    carried = Carried(workspace, obj, T_tool_object)
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


def push_too_heavy(workspace: Workspace, slide: Slide, share: float) -> str | None:
    """Why the arm does not push an object along, or over its edge, in words; None where it does.

    Args:
        workspace: where it is.
        slide: the push.
        share: of the object's weight that it takes.
    """
    robot, path = workspace.world.robot, slide.push
    push = share * GRAVITY * workspace.task.object(slide.object).mass
    tip = np.array([0.0, 0.0, hand_boxes(robot).tip(slide.opening)])
    if always_borne(robot, push, float(np.linalg.norm(tip))):
        return None
    R, t = chain(robot).forward(path)
    back = np.subtract(slide.start.pose.xyz, slide.end.pose.xyz) * (1.0, 1.0, 0.0)
    asked = overloaded(robot, path, R @ tip + t, push * back / max(float(np.linalg.norm(back)), 1e-9))
    return None if asked is None else f"to push {slide.object} asks {asked}"


def load_aware(workspace: Workspace, scene: Scene, checker: CollisionChecker) -> KnownChecker:
    """The collision check of a scene, which also asks whether the arm bears what it holds where that is in question."""
    if scene.held is None or (carried := Carried(workspace, *scene.held)).light:
        return checker
    return LoadedChecker(checker, carried)
