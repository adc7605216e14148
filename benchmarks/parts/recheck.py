"""The independent word on a path: the plan checker's continuous sweep, with python-fcl and kinematics of its own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tamp.checking.actions.arm_motion import look, pressing, sentence_of
from tamp.checking.robot.links import read_links
from tamp.checking.robot.sweep import touches
from tamp.checking.scene import Scene, State
from tamp.checking.tolerances import Tolerances
from tamp.task import Attachment, Move, Pose, RobotSpec, Task, Trajectory

Array = NDArray[np.float64]

TOLERANCES = Tolerances()


class Judge:
    """Rechecks paths of an arm in one scene; `held`, if any, sits in the gripper with its origin at the tool's."""

    def __init__(self, task: Task, *, opening: float, held: str | None = None, robot: RobotSpec | None = None) -> None:
        scene = Scene.of(task)
        self._scene = scene if robot is None else replace(scene, links=read_links(robot))
        self._held = None if held is None else Attachment(held, Pose())
        self._opening = opening
        self._poses = {o.name: o.pose.matrix for o in task.objects}

    def touch(self, trajectory: Trajectory) -> str | None:
        """The first pair that interpenetrates by over 1 mm, in words, or None."""
        state = State(self._poses, trajectory.positions[0], self._opening, self._held)
        phase = "transit" if self._held is None else "transfer"
        move = Move(phase, trajectory, self._opening, self._held)
        still = {*self._scene.links.fixed, *self._poses, "table"}
        seen = look(self._scene, move, self._held, TOLERANCES.step)
        if seen is None:
            raise ValueError("the path is too long to be looked at")
        for found in touches(pressing(self._scene, state, move, seen, TOLERANCES), seen.swing):
            moving = self._held is not None and self._held.object in found.bodies
            if moving or not still.issuperset(found.bodies):
                return sentence_of(found)
        return None


def traced(path: Array) -> Trajectory:
    """A trajectory that follows the polyline exactly: it rests at every waypoint. Its limits mean nothing."""
    arc = np.concatenate([[0.0], np.cumsum(np.maximum(np.linalg.norm(np.diff(path, axis=0), axis=1), 1e-6))])
    return Trajectory(arc, path.copy(), np.zeros_like(path))
