"""A plan as data: timed arm motions and gripper commands, grouped by action. Planner, checker and executor share it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from tamp.errors import PlanError
from tamp.frozen import FrozenDict
from tamp.task.pose import Pose

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Trajectory:
    """A timed arm motion; between samples it is the cubic Hermite curve through positions and velocities.

    Attributes:
        times: shape (n,), strictly increasing from 0 [s].
        positions: shape (n, joints) [rad].
        velocities: shape (n, joints) [rad/s]; zero at both ends.

    Raises:
        PlanError: where one of them is no array of real numbers.
    """

    times: NDArray[np.float64]
    positions: NDArray[np.float64]
    velocities: NDArray[np.float64]

    def __post_init__(self) -> None:
        import numpy as np

        for name in ("times", "positions", "velocities"):
            given = getattr(self, name)
            if not isinstance(given, np.ndarray) or given.dtype.kind not in "iuf":
                found = f"of {given.dtype}" if isinstance(given, np.ndarray) else f"but a {type(given).__name__}"
                raise PlanError(f"the {name} of a trajectory are an array of real numbers, not {found}")
            array = np.ascontiguousarray(given, np.float64)
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Trajectory) and self._content == other._content

    def __hash__(self) -> int:
        return hash(self._content)

    def __reduce__(self) -> tuple[Any, ...]:
        """By its arrays, which a copy makes read-only too."""
        return Trajectory, (self.times, self.positions, self.velocities)

    @property
    def _content(self) -> tuple[tuple[tuple[int, ...], bytes], ...]:
        return tuple((array.shape, array.tobytes()) for array in (self.times, self.positions, self.velocities))

    @property
    def duration(self) -> float:
        """Length in time [s]."""
        return float(self.times[-1])


@dataclass(frozen=True, slots=True)
class Attachment:
    """An object at rest in the tool frame: a held one from grasp to release, a pushed one while it is pushed."""

    object: str
    T_tool_object: Pose


@dataclass(frozen=True)
class Move:
    """The arm follows a trajectory while the fingers stand still.

    Attributes:
        phase: "transit" (empty hand, free), "transfer" (holding, free), "approach" (empty hand to the grasp),
            "lift" (holding, away from the support), "lower" (holding, onto the support), "retreat" (empty hand away),
            "push" (empty hand, with an object before it).
        trajectory: the motion.
        opening: distance between the finger pads [m].
        held: what the gripper holds, or None.
        contacts: pairs of bodies that may touch during this motion, such as the held object and its support;
            every other contact is a collision. The table is "table", the robot "robot".
        pushed: what the empty hand pushes along the table or over, at rest in the tool frame while it does, or None.
    """

    phase: str
    trajectory: Trajectory
    opening: float
    held: Attachment | None = None
    contacts: frozenset[tuple[str, str]] = frozenset()
    pushed: Attachment | None = None


@dataclass(frozen=True, slots=True)
class Grip:
    """The fingers close on an object; from here it is held.

    Attributes:
        attachment: object and where it lies in the tool frame.
        width: distance between the finger pads when they touch the object [m].
        force: what each finger presses with from when they have closed until it is put down [N]; None, or less, stands
            for what they close with.
    """

    attachment: Attachment
    width: float
    force: float | None = None


@dataclass(frozen=True, slots=True)
class Release:
    """The fingers open to `opening` [m] and the object stays behind at `pose` (world frame)."""

    object: str
    pose: Pose
    opening: float


@dataclass(frozen=True, slots=True)
class Fall:
    """An object that was let go falls and comes to rest: flat from a tilt, or straight down; nothing drives it.

    At the end of an action that is about another object: it has given way to what the plan did, and come to rest here.

    Attributes:
        object: its name.
        pose: where it comes to rest (world frame).
    """

    object: str
    pose: Pose


Step = Move | Grip | Release | Fall


@dataclass(frozen=True)
class Action:
    """One symbolic action and the steps that carry it out.

    Attributes:
        name: the action's name in the domain: "pick", "unstack", "place", "stack", "lay", "lay-on", "slide",
            "topple", "nudge", "move".
        arguments: names of the objects and regions it is about, the moved object first.
        steps: what the robot does, in order.
    """

    name: str
    arguments: tuple[str, ...]
    steps: tuple[Step, ...]

    def __str__(self) -> str:
        return f"{self.name}({', '.join(self.arguments)})"


@dataclass(frozen=True)
class Plan:
    """Actions that bring a task from `start` to its goals.

    Attributes:
        task: the task's name.
        robot: the robot's name.
        seed: the seed it was planned with.
        start: object -> pose (world frame) the plan starts from: the settled scene.
        home: arm configuration the plan starts from [rad].
        goals: object -> the settled pose that its goal means (world frame); objects without a goal are absent.
        actions: in order.
        report: what planning cost and tried, JSON-like; no part of the plan's identity.
    """

    task: str
    robot: str
    seed: int
    start: Mapping[str, Pose]
    home: tuple[float, ...]
    goals: Mapping[str, Pose]
    actions: tuple[Action, ...]
    report: Mapping[str, Any] = field(default_factory=dict, compare=False)

    def __post_init__(self) -> None:
        for name in ("start", "goals", "report"):
            object.__setattr__(self, name, FrozenDict(getattr(self, name)))
        for name, pose in (*self.start.items(), *self.goals.items()):
            if not isinstance(pose, Pose):
                raise PlanError(f"a plan needs a tamp.Pose for {name}, not a {type(pose).__name__}")

    @property
    def steps(self) -> tuple[Step, ...]:
        """All steps of all actions, in order."""
        return tuple(step for action in self.actions for step in action.steps)

    @property
    def duration(self) -> float:
        """Time of all arm motions together [s]; fingers not counted."""
        return sum(step.trajectory.duration for step in self.steps if isinstance(step, Move))
