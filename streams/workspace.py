"""What the samplers see of a task: its world, where everything stands and where it shall stand."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from tamp.execution.simulators import DEFAULT
from tamp.streams.cache import SampleCache
from tamp.streams.surfaces import typical_points
from tamp.streams.values import Grasp, Placement
from tamp.task import Pose, Region, Task

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.world.world import World

TABLE = "table"


@dataclass(frozen=True)
class HandMotion:
    """How the hand comes, goes, and keeps away from what stands around; a run has one, as its tuning says.

    Attributes:
        approaches: how far back along the tool's axis the hand starts; the first way that is free is taken [m].
        withdrawals: the same for how far it draws back from what has fallen out of it [m].
        push_gap: how far behind an object that it pushes it comes down and goes up again [m].
        close_push_gap: the same where others leave no more room [m].
        push_height: how far above that it begins and ends [m].
        margin: between the open hand, looked at without the arm, and what stands around [m].
    """

    approaches: tuple[float, ...] = (0.08, 0.05, 0.12)
    withdrawals: tuple[float, ...] = (0.05, 0.02)
    push_gap: float = 0.025
    close_push_gap: float = 0.008
    push_height: float = 0.12
    margin: float = 0.002


@dataclass(frozen=True, eq=False)
class Workspace:
    """A task in its world. Nothing about it changes: another state is another workspace.

    Attributes:
        task: the task.
        world: collision geometry and robot.
        start: object -> where it stands now.
        goals: object -> the placement that its goal pose means; only objects whose goal is a pose.
        cache: what samplers keep, for all workspaces of the same run; it belongs to this world.
        hand: how the hand comes and goes, the same for all workspaces that share a cache.
        all_goals: the task with all its goals, where `task` asks for some of them only; None where it asks for all.
        settling: the simulator that tells where things come to rest, the same for all that share a cache.
    """

    task: Task
    world: World
    start: Mapping[str, Placement]
    goals: Mapping[str, Placement]
    cache: SampleCache = field(default_factory=SampleCache, repr=False)
    hand: HandMotion = HandMotion()
    all_goals: Task | None = field(default=None, repr=False)
    settling: str = DEFAULT

    def __post_init__(self) -> None:
        for name in ("start", "goals"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))

    @property
    def whole(self) -> Task:
        """The task with all its goals."""
        return self.all_goals or self.task

    def part(self, names: Collection[str]) -> Workspace:
        """The same table with no objects but some, in order of their names."""
        start, goals = ({name: of[name] for name in sorted(names) if name in of} for of in (self.start, self.goals))
        return replace(self, start=start, goals=goals)

    @property
    def placements(self) -> tuple[tuple[tuple[str, Placement], ...], ...]:
        """Every object with where it stands, and with where it shall stand: what two workspaces of a run differ in."""
        return tuple(self.start.items()), tuple(self.goals.items())

    def placements_of(self, name: str) -> Iterator[Placement]:
        """Where the object is known to stand: its start, then its goal pose if it has one."""
        yield self.start[name]
        if name in self.goals:
            yield self.goals[name]

    def is_goal(self, name: str, placement: Placement) -> bool:
        """Whether a placement is where an object shall stand by its goal pose, and does not stand now."""
        return placement == self.goals.get(name) != self.start.get(name)

    def region(self, name: str) -> Region:
        """A named region; "table" is the whole table top."""
        if name == TABLE:
            return Region(TABLE, self.task.table.center, self.task.table.size)
        return next(region for region in self.task.regions if region.name == name)

    def points(self, name: str) -> NDArray[np.float64]:
        """The corners of an object's parts in its own frame, shape (n, 3) [m]."""
        parts = self.world.geometries[name].parts
        return self.cache.value(("points", name), lambda: np.concatenate([part.vertices for part in parts]))

    def bounds(self, name: str, pose: Pose) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Lower and upper corner of the box along the world's axes around an object at a pose, (3,) each [m]."""

        def corners() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
            points = self.points(name) @ pose.matrix[:3, :3].T + pose.xyz
            return points.min(axis=0), points.max(axis=0)

        return self.cache.value(("bounds", name, pose), corners)

    @property
    def surface(self) -> Mapping[str, NDArray[np.float64]]:
        """Object -> points on its surface in its own frame, shape (n, 3) [m]; the same for every seed."""
        geometries = self.world.geometries
        return self.cache.value(
            "surface", lambda: {name: typical_points(geometries[name].parts) for name in geometries}
        )


def at_pose(facts: Any) -> Iterator[Any]:
    """The `AtPose` facts among `facts`: (predicate, object, placement)."""
    return (fact for fact in facts if str(fact[0]).lower() == "atpose")


def standing(facts: Any) -> dict[str, Placement]:
    """Object -> placement; where `facts` have several for an object, the last, which is the one that holds first."""
    return {fact[1]: fact[2] for fact in at_pose(facts)}


def held(facts: Any) -> dict[str, Grasp]:
    """Object -> the grasp that holds it; where `facts` have several, the last, which is the one that holds first."""
    return {fact[1]: fact[2] for fact in facts if str(fact[0]).lower() == "atgrasp"}
