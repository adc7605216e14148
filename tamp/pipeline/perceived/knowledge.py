"""A task as far as it is known: the objects that have been found where they are thought to be, the goals they allow."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from tamp.domains.catalog import load_domain
from tamp.domains.domain import Domain
from tamp.pipeline.options.settings import Settings
from tamp.pipeline.prepare import Setup, settled_goals
from tamp.streams.cache import SampleCache
from tamp.streams.values import Placement
from tamp.task import In, On, Pose, Task, task_robot
from tamp.world.geometry.object_geometry import geometry_of_object
from tamp.world.robot.model import robot_model
from tamp.world.world import World

NOWHERE = Pose()
"""Where the planning side has objects of which nobody has told it anything."""


def blindfolded(task: Task) -> Task:
    """The task without its start: shapes, goals and table, and no file that more could be read from."""
    return replace(task, objects=tuple(replace(obj, pose=NOWHERE) for obj in task.objects), path=None)


@dataclass
class Knowledge:
    """What does not change while a table is rearranged, and what has been worked out for what is known of it.

    Attributes:
        task: without start poses.
        domain: what it is planned with.
        world: its geometry and robot.
        settings: how it is planned.
    """

    task: Task
    domain: Domain
    world: World
    settings: Settings
    _goals: dict[frozenset[str], dict[str, Placement]] = field(default_factory=dict, init=False)
    _caches: dict[tuple[str, ...], SampleCache] = field(default_factory=dict, init=False)

    @staticmethod
    def of(task: Task, settings: Settings) -> Knowledge:
        """Of a task that has been blindfolded, with settings that say everything.

        Raises:
            DomainError, RobotError, TaskError: where the input cannot be used.
        """
        geometries = {obj.name: geometry_of_object(obj) for obj in task.objects}
        robot = robot_model(task_robot(task))
        world = World(robot, geometries, task.table, motion_planner=settings.chosen("motion_planner"))
        return Knowledge(task, load_domain(settings.domain or task.domain), world, settings)

    def setup(self, poses: Mapping[str, Pose], deadline: float = math.inf) -> Setup:
        """What can be planned with objects known at `poses` (world frame), at rest; the others are not there.

        Raises:
            PlanningFailure: past the deadline, on the clock of tamp.clock.now() [s].
        """
        goals = self._settled_goals(poses, deadline)
        kept = self._reachable(goals, poses)
        objects = tuple(
            replace(obj, pose=poses[obj.name], goal=obj.goal if obj.name in kept else None)
            for obj in self.task.objects
            if obj.name in poses
        )
        known = {*poses, *(region.name for region in self.task.regions)}
        task = replace(
            self.task,
            objects=objects,
            init=tuple(fact for fact in self.task.init if known.issuperset(fact[1:])),
            goal=tuple(fact for fact in self.task.goal if known.issuperset(fact[1:])),
        )
        cache = self._caches.setdefault(tuple(sorted(poses)), SampleCache())
        placements = {name: goals[name] for name in goals if name in kept}
        return Setup(task, self.domain, self.world, dict(poses), placements, self.settings, cache)

    def _settled_goals(self, poses: Mapping[str, Pose], deadline: float) -> dict[str, Placement]:
        """Where all goals come to rest together, whether their objects have been found or not."""
        still = frozenset(obj.name for obj in self.task.objects if obj.goal is None and obj.name in poses)
        if still not in self._goals:
            task = replace(
                self.task, objects=tuple(o for o in self.task.objects if o.goal is not None or o.name in still)
            )
            self._goals[still] = settled_goals(task, self.world, poses, deadline, self.settings.settling)
        return self._goals[still]

    def _reachable(self, goals: Mapping[str, Placement], poses: Mapping[str, Pose]) -> set[str]:
        """Objects whose goals rest on nothing that has not been found."""
        kept = {obj.name for obj in self.task.objects if obj.goal is not None and obj.name in poses}
        names = {obj.name for obj in self.task.objects}
        while True:
            lost = {name for name in kept if not self._below(name, goals) & names <= kept | self._goalless(poses)}
            if not lost:
                return kept
            kept -= lost

    def _below(self, name: str, goals: Mapping[str, Placement]) -> set[str]:
        goal = self.task.object(name).goal
        return {goal.target} if isinstance(goal, On | In) else set(goals[name].on)

    def _goalless(self, poses: Mapping[str, Pose]) -> set[str]:
        return {obj.name for obj in self.task.objects if obj.goal is None and obj.name in poses}
