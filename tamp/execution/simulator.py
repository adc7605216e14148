"""What execution asks of a physics engine: a world of rigid bodies that is stepped, looked at, and acted in by a robot.

Whatever offers these two protocols is a simulator, wherever it comes from; see tamp.execution.simulators for how one
is chosen by name. A simulator's class is called with the objects, and makes a world:

    Simulator(objects, poses, table=table, robot=robot, q=q)

    objects: an iterable of tamp.task.Object, what lies on the table.
    poses: object -> pose (world frame); an object that is absent there starts at its own pose.
    table: tamp.task.Table, or None for the usual one; under it is a floor, `FLOOR_BELOW`.
    robot: tamp.task.RobotSpec, or None for a world without a robot.
    q: the arm configuration to start from [rad]; the robot's home where it is None. The fingers start open.

It raises TaskError where an object's mesh cannot be used, and RobotError where the robot cannot. The same construction
and the same commands give the same poses to the last bit, on one machine.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import TracebackType
from typing import TYPE_CHECKING, Protocol

from tamp.task import Object, Pose, RobotSpec

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Vector = NDArray[np.float64]

STEP = 1.0 / 240.0
"""Length of one simulation step [s]; an engine may divide it further."""

GRAVITY = 9.81
"""[m/s^2]."""

FLOOR_BELOW = 0.75
"""Height of the table top over the floor that catches what falls off it [m]."""

TABLE, ROBOT = "table", "robot"
"""What they are called in a touch."""


@dataclass(frozen=True)
class Touch:
    """Two bodies touch.

    Attributes:
        a, b: their names; "table" and "robot" are the names of those.
        normal: unit vector from `b` to `a` in the world frame.
        depth: how deep they are in each other [m]; negative for a gap that is about to close.
        force: normal force in the last step [N].
        point: where (world frame) [m].
    """

    a: str
    b: str
    normal: tuple[float, float, float]
    depth: float
    force: float
    point: tuple[float, float, float] = (0.0, 0.0, 0.0)


class Robot(Protocol):
    """The robot of a simulated world: an arm that follows set points and fingers that open, close and feel."""

    @property
    def spec(self) -> RobotSpec:
        """The robot as data."""

    def configuration(self) -> Vector:
        """Arm joint positions, shape (joints,) [rad]."""

    def opening(self) -> float:
        """Distance between the finger pads [m]."""

    def finger_speed(self) -> float:
        """Speed of the fastest finger [m/s]."""

    def tool(self) -> Pose:
        """`T_world_tool` as it is now."""

    def command(self, q: Sequence[float] | Vector, velocity: Sequence[float] | Vector | None = None) -> None:
        """Send the arm to `q` [rad], with `velocity` [rad/s] fed forward, until told otherwise."""

    def open_to(self, opening: float) -> None:
        """Send the fingers to `opening` [m], until told otherwise; they push gently."""

    def squeeze(self, force: float) -> None:
        """Close the fingers until told otherwise, each with `force` [N]."""

    def touching(self, name: str) -> tuple[bool, ...]:
        """For each finger, whether it touches an object."""


class Simulator(Protocol):
    """A world of rigid bodies at 240 steps a second; a context manager, since it holds an engine's memory.

    Attributes:
        on_step: called after every step, for an onlooker.
    """

    on_step: Callable[[], None] | None

    def __enter__(self) -> Simulator: ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None: ...

    @property
    def objects(self) -> Mapping[str, Object]:
        """The objects in the world, by name."""

    @property
    def robot(self) -> Robot | None:
        """The robot, None where there is none."""

    @property
    def time(self) -> float:
        """Simulated time since the start [s]."""

    def step(self, count: int = 1) -> None:
        """Let `count` steps pass."""

    def pose(self, name: str) -> Pose:
        """Where one object's frame stands now (world frame)."""

    def poses(self) -> dict[str, Pose]:
        """Object -> where its frame stands now (world frame)."""

    def place(self, name: str, pose: Pose) -> None:
        """Put an object at rest at a pose (world frame), as a hand from outside would: never what a robot should do."""

    def speeds(self) -> dict[str, tuple[float, float]]:
        """Object -> its linear [m/s] and angular [rad/s] speed."""

    def limit_speeds(self, linear: float, angular: float) -> None:
        """Slow every object that moves faster than `linear` [m/s] or turns faster than `angular` [rad/s]."""

    def touches(self) -> tuple[Touch, ...]:
        """Contacts of the last step between the table, the objects and the robot."""


def wait(simulator: Simulator, limit_s: float, until: Callable[[], bool], patience: int = 12) -> bool:
    """Step until a condition has held for `patience` steps on end; False where `limit_s` [s] ran out first."""
    held = 0
    for _ in range(round(limit_s / STEP)):
        simulator.step()
        held = held + 1 if until() else 0
        if held >= patience:
            return True
    return False
