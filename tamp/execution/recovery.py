"""After a fault: getting the arm out of what it touches, and whether what is not as planned bars the way ahead."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from tamp.execution.controller import backwards
from tamp.task import Attachment, Grip, Move, Pose, Release, Step
from tamp.world.kinematics.inverse import straight_line
from tamp.world.robot.model import RobotModel
from tamp.world.scene import Scene
from tamp.world.world import World

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

CLEAR = 0.003
"""Distance at which a hand counts as out of what it touched; motions from there ask for a little less [m]."""

DISTANCES = (0.03, 0.06, 0.1, 0.15, 0.2)
"""How far the hand is drawn out, the shortest that frees it [m]."""

OPENINGS = 9
"""Of the fingers at which the hand must be free, as they may close from the next motion on; pads are thicker."""

UP = np.array([0.0, 0.0, 1.0])


def undone(steps: Sequence[Step], pose: Pose) -> Iterator[Step]:
    """The steps that take back an approach, a grip and a lift: the same motions backwards, the object let go between.

    Args:
        steps: the steps to take back, in the order in which they were done.
        pose: where the object stood (world frame).
    """
    opening = next(step.opening for step in steps if isinstance(step, Move))
    for step in reversed(steps):
        if isinstance(step, Move):
            phase = "retreat" if step.held is None else "lower"
            yield Move(phase, backwards(step.trajectory), step.opening, step.held, step.contacts)
        elif isinstance(step, Grip):
            yield Release(step.attachment.object, pose, opening)


def way_out(world: World, poses: Mapping[str, Pose], q: Array, tried: int = 0) -> Array | None:
    """The path that frees an arm with empty, open fingers from what it is too near to.

    What is touched already may be touched on the way, and what is between the fingers, which would close on it in the
    next motion, is left behind; of the lines back along the approach, straight up, between the two, and sideways, and
    of the way home, the one is taken that is free soonest, or another each time what leans on the hand comes after it.

    Args:
        world: robot, table and objects.
        poses: object -> pose (world frame).
        q: where the arm is, shape (dof,) [rad].
        tried: how many ways were tried in vain.

    Returns:
        Shape (n, dof) [rad], its last configuration free; None where `q` is free already, or none of these ends free.
    """
    robot = world.robot
    q = np.clip(q, robot.lower, robot.upper)
    standing = {name: pose.matrix for name, pose in poses.items()}
    openings = np.linspace(robot.spec.gripper.stroke, 0.0, OPENINGS)
    checkers = [world.checker(Scene(standing, opening=float(opening)), margin=CLEAR) for opening in openings]

    def free(q: Array) -> bool:
        return all(checker.free(q) for checker in checkers)

    if free(q):
        return None
    ways: list[Array] = []
    for lines in _lines(robot, q):
        reaching = (line[: i + 1] for line in lines for i, waypoint in enumerate(line) if free(waypoint))
        ways += itertools.islice(reaching, 1)
    return sorted(ways, key=len)[tried % len(ways)] if ways else None


def opening_out(world: World, poses: Mapping[str, Pose], q: Array, opening: float) -> float:
    """How far the hand opens as it leaves what it touches: all the way, so that nothing hangs on a finger [m].

    Where that would meet anything else it stays as it is.

    Args:
        world: robot, table and objects.
        poses: object -> pose (world frame).
        q: where the arm is, shape (dof,) [rad].
        opening: between the pads [m].
    """
    standing = {name: pose.matrix for name, pose in poses.items()}
    stroke = world.robot.spec.gripper.stroke
    untouched = {
        name: T
        for name, T in standing.items()
        if world.checker(Scene({name: T}, opening=opening), margin=CLEAR).free(q)
    }
    return stroke if world.checker(Scene(untouched, opening=stroke), margin=0.0).free(q) else opening


def _lines(robot: RobotModel, q: Array) -> Iterator[Iterator[Array]]:
    """Ways to leave, for each direction the shorter ones first, in waypoints a centimetre or less apart."""
    T = robot.forward(q)
    back, side = -T[:3, 2], T[:3, 0]
    for direction in (back, UP, back + UP, side, -side):
        length = float(np.linalg.norm(direction))
        if length > 1e-6:
            yield _straight(robot, q, T, direction / length)
    home = np.array(robot.home)
    yield iter((np.linspace(q, home, max(2, round(float(np.abs(home - q).max()) / 0.02))),))


def _straight(robot: RobotModel, q: Array, T: Array, direction: Array) -> Iterator[Array]:
    for distance in DISTANCES:
        T_goal = T.copy()
        T_goal[:3, 3] += distance * direction
        line = straight_line(robot, q, T_goal)
        if line is not None:
            yield line


STRIDE = 0.05  # between the configurations that are looked at, in the joint that moves farthest [rad]
GRAZE = 0.002  # how deep the object may come into another on its way [m]


def can_carry(world: World, poses: Mapping[str, Pose], held: Attachment, steps: Sequence[Step]) -> bool:
    """Whether a held object meets no other object until it is let go.

    The table does not count: an object that comes down on it askew turns back between the fingers.

    Args:
        world: robot and objects.
        poses: object -> pose (world frame) of all objects, as they are.
        held: the object, as it lies in the hand.
        steps: what is still to be done; it ends where nothing is held any more.
    """
    others = {name: poses[name].matrix for name in sorted(poses) if name != held.object}
    tools = (world.robot.forward(q) for q in _configurations(steps))
    ways = (tool @ held.T_tool_object.matrix for tool in tools)
    return not any(
        world.overlap(held.object, T_held, other, T_other, tolerance=GRAZE)
        for T_held in ways
        for other, T_other in others.items()
    )


def met_ahead(world: World, poses: Mapping[str, Pose], move: Move) -> str | None:
    """The first of some objects that an empty hand would meet on a motion; None where there is none.

    Args:
        world: robot and objects.
        poses: object -> pose (world frame) of the objects, as they are.
        move: the motion.
    """
    scene = Scene({name: pose.matrix for name, pose in poses.items()}, opening=move.opening)
    contact = world.checker(scene, margin=0.0).first_contact(move.trajectory.positions)
    return None if contact is None else next((name for name in (contact.a, contact.b) if name in poses), None)


def _configurations(steps: Sequence[Step]) -> Iterator[NDArray[np.float64]]:
    """Arm configurations on the way to where the object is let go, not far apart, each way's last among them [rad]."""
    for step in steps:
        if not isinstance(step, Move) or step.held is None:
            return
        last = step.trajectory.positions[0]
        yield last
        for q in step.trajectory.positions[1:]:
            if np.abs(q - last).max() > STRIDE:
                last = q
                yield q
        yield step.trajectory.positions[-1]
