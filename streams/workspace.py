"""What the samplers see of a task: its world, where everything stands and where it shall stand."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from tamp.streams.values import Grasp, Placement
from tamp.task import Pose, Region, Task

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.world.world import World

TABLE = "table"


class Context(Protocol):
    """What a sampler receives first. The planner's own context fits; a test may pass any object that does.

    Attributes:
        rng: a generator derived from (seed, stream, inputs), so that samples do not depend on the order of calls.
        deadline: when to stop, on the clock of time.monotonic [s].
        fluents: facts that hold where the output will be used, for streams with `:fluents`.
        bound: facts that the plan under construction has already settled.
    """

    @property
    def scene(self) -> Any: ...  # noqa: D102
    @property
    def rng(self) -> np.random.Generator: ...  # noqa: D102
    @property
    def deadline(self) -> float: ...  # noqa: D102
    @property
    def fluents(self) -> Any: ...  # noqa: D102
    @property
    def bound(self) -> Any: ...  # noqa: D102

    def fail(self, reason: str, because: Any = ()) -> None:
        """Say why nothing comes: a reason for the report and, where known, the facts that suffice for it."""


@dataclass(frozen=True, eq=False)
class Workspace:
    """A task in its world.

    Attributes:
        task: the task.
        world: collision geometry and robot.
        start: object -> where it stands now.
        goals: object -> the placement that its goal pose means; only objects whose goal is a pose.
        memory: values that samplers derive once from an object and reuse, by (sampler, key).
    """

    task: Task
    world: World
    start: Mapping[str, Placement]
    goals: Mapping[str, Placement]
    memory: dict[Any, Any] = field(default_factory=dict, repr=False)

    def placements_of(self, name: str) -> Iterator[Placement]:
        """Where the object is known to stand: its start, then its goal pose if it has one."""
        yield self.start[name]
        if name in self.goals:
            yield self.goals[name]

    def region(self, name: str) -> Region:
        """A named region; "table" is the whole table top."""
        if name == TABLE:
            return Region(TABLE, self.task.table.center, self.task.table.size)
        return next(region for region in self.task.regions if region.name == name)

    def points(self, name: str) -> NDArray[np.float64]:
        """The corners of an object's parts in its own frame, shape (n, 3) [m]."""
        return self._points[name]

    def bounds(self, name: str, pose: Pose) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Lower and upper corner of the box along the world's axes around an object at a pose, (3,) each [m]."""
        key = ("bounds", name, pose)
        if key not in self.memory:
            points = self._points[name] @ pose.matrix[:3, :3].T + pose.xyz
            self.memory[key] = (points.min(axis=0), points.max(axis=0))
        corners: tuple[NDArray[np.float64], NDArray[np.float64]] = self.memory[key]
        return corners

    @cached_property
    def _points(self) -> Mapping[str, NDArray[np.float64]]:
        parts = {name: geometry.parts for name, geometry in self.world.geometries.items()}
        return {name: np.concatenate([part.vertices for part in pieces]) for name, pieces in parts.items()}

    @cached_property
    def surface(self) -> Mapping[str, NDArray[np.float64]]:
        """Object -> points on its surface in its own frame, shape (n, 3); the same for every seed."""
        from tamp.streams.surfaces import typical_points

        return {name: typical_points(geometry.parts) for name, geometry in self.world.geometries.items()}


def at_pose(facts: Any) -> Iterator[Any]:
    """The `AtPose` facts among `facts`: (predicate, object, placement)."""
    return (fact for fact in facts if str(fact[0]).lower() == "atpose")


def standing(facts: Any) -> dict[str, Placement]:
    """Object -> placement; where `facts` have several for an object, the last, which is the one that holds first."""
    return {fact[1]: fact[2] for fact in at_pose(facts)}


def held(facts: Any) -> dict[str, Grasp]:
    """Object -> the grasp that holds it; where `facts` have several, the last, which is the one that holds first."""
    return {fact[1]: fact[2] for fact in facts if str(fact[0]).lower() == "atgrasp"}
