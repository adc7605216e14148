"""What the tabletop streams hand to each other: grasps, placements, handlings and paths. All immutable."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tamp.task import Pose

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

CLEARANCE = 0.008  # beside an object on each side before the fingers close on it, where there is room [m]


@dataclass(frozen=True, slots=True)
class Configuration:
    """Where the arm and the fingers are.

    Attributes:
        q: joint positions in the robot's order [rad].
        opening: distance between the pads [m].

    Raises:
        TypeError: where these are no finite numbers.
    """

    q: tuple[float, ...]
    opening: float

    def __post_init__(self) -> None:
        if not isinstance(self.q, tuple) or not math.isfinite(sum(self.q) + self.opening):
            found = f"{self.q!r} and {self.opening!r}"
            raise TypeError(f"a Configuration is a tuple of finite joint positions and a finite opening, found {found}")


@dataclass(frozen=True, slots=True)
class Grasp:
    """Where the tool stands when it holds an object.

    Attributes:
        T_object_tool: tool frame in the object's frame; the tool's z approaches, the gripper's axis closes.
        width: distance between the pads when they touch the object [m].
        clearance: beside the object on each side before closing and after opening [m].
    """

    T_object_tool: Pose
    width: float
    clearance: float = CLEARANCE


@dataclass(frozen=True, slots=True)
class Placement:
    """Where an object stands, and on what.

    Attributes:
        pose: T_world_object.
        on: names of what it rests on: "table" or objects, sorted.

    Raises:
        TypeError: where these are something else; a text would be taken for the names of its letters.
    """

    pose: Pose
    on: tuple[str, ...]

    def __post_init__(self) -> None:
        if not (isinstance(self.pose, Pose) and isinstance(self.on, tuple)):
            found = f"{self.pose!r} and {self.on!r}"
            raise TypeError(f"a Placement is a Pose and a tuple of names such as ('table',), found {found}")


@dataclass(frozen=True, slots=True)
class Balance:
    """What an object stands among stays at rest as it is taken from a placement, or put there."""

    object: str
    placement: Placement


def falls_straight(let_go: Pose, end: Pose) -> bool:
    """Whether what falls from one pose to another does so without a turn."""
    return let_go.quat == end.quat


LEVEL, TURN = 0.002, 0.01  # placements that differ by less differ by a level shift alone [m], [rad]


def shifted_alone(start: Placement, end: Placement) -> bool:
    """Whether two placements, on the same things, differ by a level shift alone."""
    alike = start.on == end.on and abs(end.pose.xyz[2] - start.pose.xyz[2]) < LEVEL
    dot = sum(a * b for a, b in zip(start.pose.quat, end.pose.quat, strict=True))
    return alike and abs(dot) > math.cos(TURN / 2)


@dataclass(frozen=True, eq=False)
class Handling:
    """The arm's way to an object and away with it; read backwards, it puts the object down.

    Attributes:
        object: the object's name.
        placement: where it stands.
        grasp: how it is held.
        opening: distance between the pads before closing and after opening [m].
        approach: empty hand, from clear of the object to the grasp; shape (n, joints) [rad].
        lift: holding, from the grasp to clear of the support; shape (m, joints) [rad].
        fall: poses that the object passes after it was let go tilted or higher up, `placement.pose` the last; empty
            where it is let go at its placement.
    """

    object: str
    placement: Placement
    grasp: Grasp
    opening: float
    approach: NDArray[np.float64]
    lift: NDArray[np.float64]
    fall: tuple[Pose, ...] = ()

    @property
    def let_go(self) -> Pose:
        """Where the object is while the hand comes to it or leaves it."""
        return self.fall[0] if self.fall else self.placement.pose

    @property
    def dropped(self) -> bool:
        """Whether the object falls straight down while the hand is still there."""
        return bool(self.fall) and falls_straight(self.let_go, self.placement.pose)

    @property
    def laid(self) -> bool:
        """Whether the object is let go tilted, and falls flat once the hand is away."""
        return bool(self.fall) and not self.dropped

    def __str__(self) -> str:
        return f"handling of {self.object}"


@dataclass(frozen=True, eq=False)
class Slide:
    """The arm's way behind an object, the push along what it stands on or over one of its edges, and the way back.

    Attributes:
        object: the object's name.
        start, end: where it stands before and after.
        opening: distance between the pads [m].
        approach: empty hand, from above to the side that is pushed; shape (n, joints) [rad].
        push: the object before the hand, straight ahead or turning about its edge; shape (m, joints) [rad].
        retreat: empty hand, from the object to above; shape (k, joints) [rad].
        T_tool_object: where the object is while it is pushed.
        fall: poses that it passes after it was pushed over its edge, `end.pose` the last; empty where it was not.
    """

    object: str
    start: Placement
    end: Placement
    opening: float
    approach: NDArray[np.float64]
    push: NDArray[np.float64]
    retreat: NDArray[np.float64]
    T_tool_object: Pose
    fall: tuple[Pose, ...] = ()

    def __str__(self) -> str:
        return f"slide of {self.object}"


@dataclass(frozen=True, eq=False)
class ArmPath:
    """A collision-free path between two configurations; shape (n, joints) [rad], straight between its points.

    Raises:
        TypeError: for another shape.
    """

    points: NDArray[np.float64]

    def __post_init__(self) -> None:
        if (shape := getattr(self.points, "shape", None)) is None or len(shape) != 2 or shape[0] < 2:
            found = type(self.points).__name__ if shape is None else f"shape {shape}"
            raise TypeError(f"an ArmPath is an array of shape (n, joints) with two points at least, found {found}")
