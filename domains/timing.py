"""What the timed steps of a skill are made with: motions under the robot's limits, clear of everything they must be."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.affordances.friction_cones import sliding_share
from tamp.streams.affordances.slide_path import tipping_rate
from tamp.streams.collisions import CONTACT_DEPTH
from tamp.streams.hand.hand_boxes import hand_boxes
from tamp.streams.motion.handling_contacts import touched
from tamp.streams.motion.paths import kept_from
from tamp.streams.motion.payload import Carried
from tamp.streams.values import Grasp, Placement
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import Attachment, Move, Pose, Trajectory
from tamp.world.robot.chain import chain
from tamp.world.robot.payload import GRAVITY
from tamp.world.scene import Scene
from tamp.world.timing.time_parametrization import stretched, time_free_path

if TYPE_CHECKING:
    from numpy.typing import NDArray

SLOWER = (1.3, 1.6, 2.0, 3.0, 5.0)  # times as long a motion takes where fingers would not hold what they carry
SPARED = 0.9  # share of what slows down what slides that the hand that pushes it may slow down by
TURNED = 0.01  # what is pushed and turns by more is meant to [rad]
CLEARANCE = 0.0005  # least distance along the timed curve; the path under it kept more [m]


@dataclass(frozen=True)
class Speeds:
    """How fast the arm moves, as shares of its joints' limits.

    Attributes:
        carrying: while holding an object: friction alone keeps it from turning in the fingers.
        gentle: near an object.
        pushing: while pushing one: it must not slide on where the hand slows down.
    """

    carrying: float = 0.5
    gentle: float = 0.4
    pushing: float = 0.2


DEFAULT_SPEEDS = Speeds()


class NotFree(Exception):  # noqa: N818  an outcome of timing, for the caller to plan again
    """A timed motion cannot keep clear, however closely it follows its path."""


class Timing:
    """Times the motions of one action; knows where everything stands meanwhile.

    Args:
        workspace: what it happens in; an attribute, too.
        poses: object -> T_world_object, shape (4, 4), where objects stand when the action begins; what is held absent.
        speeds: how fast the arm moves.
    """

    def __init__(
        self, workspace: Workspace, poses: Mapping[str, NDArray[np.float64]], speeds: Speeds = DEFAULT_SPEEDS
    ) -> None:
        self._speeds = speeds
        self.workspace, self._world = workspace, workspace.world
        self._poses = dict(poses)

    def put(self, name: str, T_world_object: NDArray[np.float64] | None) -> None:
        """Say where an object stands from here on; None is in the hand."""
        if T_world_object is None:
            self._poses.pop(name, None)
        else:
            self._poses[name] = T_world_object

    def still_below(self, obj: str, placement: Placement) -> tuple[str, ...]:
        """What an object rests on, but for what it rested on at the start and what has been taken away since."""
        start = self.workspace.start

        def stays(lower: str) -> bool:
            return lower == TABLE or (
                lower in self._poses and np.allclose(self._poses[lower], start[lower].pose.matrix)
            )

        return placement.on if placement != start[obj] else tuple(filter(stays, placement.on))

    def move(
        self,
        phase: str,
        path: NDArray[np.float64],
        opening: float,
        held: Attachment | None = None,
        touching: str | None = None,
    ) -> Move:
        """A motion along a path.

        Args:
            phase: as `tamp.task.Move` has it; decides the speed and what may be touched.
            path: shape (n, joints) [rad].
            opening: distance between the pads meanwhile [m].
            held: what is in the hand.
            touching: an object that the hand may touch.

        Raises:
            NotFree: where it cannot keep clear.
        """
        near_support = phase in ("lift", "lower")
        scene = Scene(self._poses, opening=opening)
        if held is not None:
            scene = scene.attached(held.object, held.T_tool_object.matrix, opening)
        beside = self._beside(phase, path, held) if near_support and held is not None else {}
        checker = self._world.checker(
            scene,
            margin=kept_from(self._world, scene, path[0], CLEARANCE) if phase == "transit" else CLEARANCE,
            held_margin=-CLEARANCE if near_support else CLEARANCE,
            touch={} if touching is None else {touching: -2 * CLEARANCE},
            held_touch=beside,
        )
        speed = {"transit": 1.0, "transfer": self._speeds.carrying}.get(phase, self._speeds.gentle)
        timed = time_free_path(path, self._world.robot.spec, checker, speed=speed)
        if timed.trajectory is None:
            raise NotFree(f"{phase}: {timed.reason}")
        trajectory = timed.trajectory if held is None else self._gently(timed.trajectory, held, opening)
        contacts = {("robot", touching)} if touching is not None else set()
        if near_support and held is not None:
            contacts |= {(held.object, other) for other in (TABLE, *self._poses)}
        return Move(phase, trajectory, opening, held, frozenset(contacts))

    def _gently(self, trajectory: Trajectory, held: Attachment, opening: float) -> Trajectory:
        """The motion, so slow that what is held does not slip or swing in the fingers, if that helps."""
        carried = Carried(self.workspace, held.object, held.T_tool_object.matrix, opening)
        for slower in (1.0, *SLOWER):
            if carried.held_throughout(motion := stretched(trajectory, slower)):
                return motion
        return trajectory

    def _beside(self, phase: str, path: NDArray[np.float64], held: Attachment) -> dict[str, float]:
        """How near what is lifted or lowered may come to what it touches where it rests [m]."""
        T = self._world.robot.forward(path[0 if phase == "lift" else -1]) @ held.T_tool_object.matrix
        near = touched(self._world, held.object, T, self._poses)
        return {name: least - CLEARANCE for name, least in near.items()}

    def push(self, pushed: Attachment, path: NDArray[np.float64], opening: float, below: tuple[str, ...]) -> Move:
        """A motion with an object before the hand, which does not slide on where that slows down.

        Args:
            pushed: the object, at rest in the tool frame.
            path: shape (n, joints) [rad].
            opening: distance between the pads meanwhile [m].
            below: what the object slides on.

        Raises:
            NotFree: where it cannot keep clear.
        """
        scene = Scene(self._poses).attached(pushed.object, pushed.T_tool_object.matrix, opening)
        checker = self._world.checker(scene, margin=CLEARANCE, held_margin=-CONTACT_DEPTH - CLEARANCE)
        timed = time_free_path(path, self._world.robot.spec, checker, speed=self._speeds.pushing)
        if (trajectory := timed.trajectory) is None:
            raise NotFree(f"push: {timed.reason}")
        share, rates = sliding_share(self.workspace, pushed.object, below), self._rates(trajectory)
        hasty = max(
            -rates.min() / max(SPARED * GRAVITY * share, 1e-9),
            np.abs(rates).max() / self._tipping_rate(pushed, path, opening, below),
        )
        if hasty > 1.0:
            trajectory = stretched(trajectory, math.sqrt(hasty))
        contacts = frozenset({("robot", pushed.object), *((pushed.object, other) for other in below)})
        return Move("push", trajectory, opening, None, contacts, pushed)

    def _tipping_rate(
        self, pushed: Attachment, path: NDArray[np.float64], opening: float, below: tuple[str, ...]
    ) -> float:
        """How much faster or slower what is pushed ahead may become in a second and not tip over its foot [m/s^2].

        No end to it where it is pushed over.
        """
        first, last = (self._world.robot.forward(q) @ pushed.T_tool_object.matrix for q in path[[0, -1]])
        if np.abs(last[:3, :3] - first[:3, :3]).max() > TURNED:
            return math.inf
        start, end = (Placement(Pose.from_matrix(T), below) for T in (first, last))
        shift, foot = last[:3, 3] - first[:3, 3], self.workspace.bounds(pushed.object, start.pose)[0][2]
        tip = float(self._world.robot.forward(path[0])[2, 3] - hand_boxes(self._world.robot).tip(opening) - foot)
        ahead = shift / max(float(np.linalg.norm(shift)), 1e-9)
        # At the end it may hang over an edge of the table: what tips about that comes to lie on the fingertips first.
        return min(
            tipping_rate(self.workspace, pushed.object, start, ahead, tip),
            tipping_rate(self.workspace, pushed.object, end, ahead, tip, highest=tip),
        )

    def _rates(self, trajectory: Trajectory) -> NDArray[np.float64]:
        """How much faster or slower the tool becomes on a straight way, from rest to rest, shape (n,) [m/s^2]."""
        at = chain(self._world.robot).forward(trajectory.positions)[1]
        gone = np.linalg.norm(np.diff(at, axis=0), axis=1)
        speeds = np.concatenate([[0.0], gone / np.diff(trajectory.times), [0.0]])
        middles = (trajectory.times[1:] + trajectory.times[:-1]) / 2
        moments = np.concatenate([trajectory.times[:1], middles, trajectory.times[-1:]])
        rates: NDArray[np.float64] = np.diff(speeds) / np.diff(moments)
        return rates


def held(obj: str, grasp: Grasp) -> Attachment:
    """An object as a grasp holds it."""
    return Attachment(obj, grasp.T_object_tool.inverse())
