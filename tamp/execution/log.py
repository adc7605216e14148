"""What an execution leaves behind: one entry an action, and how it ended."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from tamp.frozen import FrozenDict
from tamp.task import Pose

Status = Literal["done", "deviated", "timeout"]
Kind = Literal["missed", "dropped", "slipped", "misplaced", "disturbed"]


@dataclass(frozen=True, slots=True)
class Deviation:
    """An object is not where the plan has it.

    Attributes:
        object: its name.
        kind: "missed" (the fingers closed beside it), "dropped" (it left the fingers on the way), "slipped" (it moved
            between the fingers), "misplaced" (it was set down elsewhere), "disturbed" (it moved unasked).
        distance: between the origins as they are and as they were meant [m]; not a number where nobody knows.
        angle: between the orientations [rad]; likewise.
    """

    object: str
    kind: Kind
    distance: float
    angle: float

    def __str__(self) -> str:
        if math.isnan(self.distance):
            return f"{self.object} {self.kind}"
        return f"{self.object} {self.kind}: off by {self.distance * 1000:.1f} mm and {self.angle:.2f} rad"


@dataclass(frozen=True)
class ActionLog:
    """One action as it was carried out.

    Attributes:
        name: the action, such as "pick(mug)".
        sim_s: simulated time it took [s].
        grasps_attempted, grasps_succeeded: a grasp succeeds when both fingers still touch the object after the lift.
        poses: object -> pose (world frame) after the action.
        deviations: what is off by more than the monitor tolerates.
        tracking_error: largest joint error during its motions [rad].
    """

    name: str
    sim_s: float
    grasps_attempted: int
    grasps_succeeded: int
    poses: Mapping[str, Pose]
    deviations: tuple[Deviation, ...]
    tracking_error: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "poses", FrozenDict(self.poses))


@dataclass(frozen=True)
class Frame:
    """The scene at one moment, for pictures.

    Attributes:
        time: simulated time since the world was built [s].
        poses: object -> pose (world frame).
        configuration: the arm's joint positions [rad].
        opening: distance between the finger pads [m].
    """

    time: float
    poses: Mapping[str, Pose]
    configuration: tuple[float, ...]
    opening: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "poses", FrozenDict(self.poses))


@dataclass(frozen=True)
class Execution:
    """How carrying out a plan ended.

    Attributes:
        status: "done", "deviated" (stopped, the hand empty, for a new plan from here), or "timeout".
        final_poses: object -> pose (world frame) at the end, at rest.
        configuration: the arm's joint positions at the end [rad].
        log: one entry an action that was begun, in order.
        sim_s: simulated time it took [s].
        deviation: why it stopped, or None.
        frames: the scene at regular times, where recording was asked for.
    """

    status: Status
    final_poses: Mapping[str, Pose]
    configuration: tuple[float, ...]
    log: tuple[ActionLog, ...]
    sim_s: float
    deviation: Deviation | None = None
    frames: tuple[Frame, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "final_poses", FrozenDict(self.final_poses))

    @property
    def grasps_attempted(self) -> int:
        """How often the fingers closed on an object."""
        return sum(entry.grasps_attempted for entry in self.log)

    @property
    def grasps_succeeded(self) -> int:
        """How often the object was still between them after the lift."""
        return sum(entry.grasps_succeeded for entry in self.log)
