"""A task made ready for planning: validated in physics, settled, and turned into the workspace that samplers see."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from tamp.checking import Verdict, check
from tamp.checking.check import begin, check_left
from tamp.checking.scene import State
from tamp.domains.catalog import load_domain
from tamp.domains.domain import Domain
from tamp.errors import DomainError
from tamp.execution.settling.cache import settle_once
from tamp.execution.settling.settle import Settled, settle
from tamp.execution.simulators import DEFAULT
from tamp.language.read_formula import OPERATORS
from tamp.language.sexpr import suggest
from tamp.pipeline.options.settings import DEFAULT_SETTINGS, Settings
from tamp.pipeline.situation import already_there, placements, raised
from tamp.pipeline.validity import check_geometry, check_settled, refusal, remarks
from tamp.streams.affordances.stable_poses import tipped_on
from tamp.streams.cache import SampleCache
from tamp.streams.values import Placement
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import At, Plan, Pose, SymbolicFact, Task, task_robot
from tamp.task.validate import validate
from tamp.world.geometry.object_geometry import geometry_of_object
from tamp.world.robot.model import robot_model
from tamp.world.world import World

if TYPE_CHECKING:
    from numpy.typing import NDArray

DISJOINT = 0.005  # objects without a goal that overlap a goal deeper than this are not part of the goal scene [m]
RESTLESS = "the start never comes to rest: what moves by itself may end anywhere, whatever is done"


def settled_goals(
    task: Task,
    world: World,
    now: Mapping[str, Pose],
    deadline: float = math.inf,
    simulator: str = DEFAULT,
) -> dict[str, Placement]:
    """Where each object with a goal pose comes to rest when all of them stand as asked, a little above that."""
    wanted = {obj.name: obj.goal.pose for obj in task.objects if isinstance(obj.goal, At)}
    if not wanted:
        return {}
    bystanders = {
        obj.name: now[obj.name]
        for obj in task.objects
        if obj.goal is None and not any(_overlap(world, obj.name, now[obj.name], *other) for other in wanted.items())
    }
    settled = _settled(task, world, {**bystanders, **wanted}, deadline, simulator)
    resting = placements(settled.poses, settled.supports)
    return {name: raised(resting[name]) for name in wanted}


def _settled(task: Task, world: World, poses: Mapping[str, Pose] | None, deadline: float, simulator: str) -> Settled:
    """A scene at rest. What a simulator leaves balancing by itself, on a tip or an edge, falls: nothing stays so."""
    rest = settle_once(task, poses, deadline=deadline, simulator=simulator)
    tipped = {}
    for name, pose in rest.poses.items():
        by_itself = [pair for pair in rest.supports if name in pair] == [(name, TABLE)]
        turned = tipped_on(world.geometries[name], pose.matrix[:3, :3]) if by_itself else None
        if turned is not None:
            tipped[name] = _turned(world, name, pose, turned)
    return settle_once(task, {**rest.poses, **tipped}, deadline=deadline, simulator=simulator) if tipped else rest


def _turned(world: World, name: str, pose: Pose, R: NDArray[np.float64]) -> Pose:
    """An object turned about its centre of mass, and lowered or raised so that its lowest point stays as high."""
    geometry, T = world.geometries[name], pose.matrix
    made = np.eye(4)
    made[:3, :3] = R
    made[:3, 3] = T[:3, :3] @ geometry.center_of_mass + T[:3, 3] - R @ geometry.center_of_mass
    made[2, 3] = (geometry.hull.vertices @ T[2, :3]).min() + T[2, 3] - (geometry.hull.vertices @ R[2]).min()
    return Pose.from_matrix(made)


def _overlap(world: World, a: str, pose_a: Pose, b: str, pose_b: Pose) -> bool:
    return world.overlap(a, pose_a.matrix, b, pose_b.matrix, tolerance=DISJOINT)


@dataclass(frozen=True, eq=False)
class Setup:
    """A task ready to be planned: geometry, the settled start, and what the goals mean.

    Attributes:
        task: the task.
        domain: what it is planned with.
        world: its geometry and robot.
        start: object -> pose (world frame) after settling.
        goals: object with a goal pose -> the placement it comes to rest in.
        settings: how it is planned and carried out.
        cache: what samplers keep, for every search of the run.
        remarks: what its settled poses have to do with the given ones, where that is not plain.
        supports: what rests on what at the start, pairs (above, below); None where that was not seen.
    """

    task: Task
    domain: Domain
    world: World
    start: Mapping[str, Pose]
    goals: Mapping[str, Placement]
    settings: Settings = DEFAULT_SETTINGS
    cache: SampleCache = field(default_factory=SampleCache, repr=False)
    remarks: tuple[str, ...] = ()
    supports: tuple[tuple[str, str], ...] | None = None

    def observe(self, poses: Mapping[str, Pose], deadline: float = math.inf) -> Workspace:
        """The scene with all objects at rest at `poses`, and what the goals mean there.

        Args:
            poses: object -> pose (world frame).
            deadline: on the clock of tamp.clock.now() [s].

        Raises:
            PlanningFailure: past the deadline.
        """
        seen = self.supports if dict(poses) == dict(self.start) else None
        if seen is None:
            seen = settle(self.task, poses, deadline=deadline, simulator=self.settings.settling).supports
        return already_there(self.workspace(placements(poses, seen), self.goals))

    def workspace(self, start: Mapping[str, Placement], goals: Mapping[str, Placement]) -> Workspace:
        """What samplers see of the run where everything stands and shall stand as given."""
        hand, simulator = self.settings.tuning.hand, self.settings.settling
        return Workspace(self.task, self.world, start, goals, self.cache, hand, settling=simulator)

    def check(
        self,
        plan: Plan,
        *,
        start: Mapping[str, Pose],
        goals: Mapping[str, Pose],
        facts: Iterable[SymbolicFact] | None = None,
        after: State | None = None,
    ) -> Verdict:
        """The independent checker's word on a plan from a known state, by the rules of the domain; see `check`."""
        return check(self.task, plan, start=start, goals=goals, facts=facts, rules=self.domain.rules, after=after)

    def stays(self, name: str, poses: Mapping[str, Pose]) -> bool:
        """Whether the checker has an object stay that is let go among others, all at `poses`, whoever put it there."""
        return not check_left(self.task, name, poses)

    def begun(self, poses: Mapping[str, Pose], q: tuple[float, ...], facts: Iterable[SymbolicFact]) -> State | None:
        """What the checker knows before a plan from the task's own scene; None from any other, which was seen."""
        own = tuple(q) == tuple(self.world.robot.spec.home) and dict(poses) == dict(self.start)
        return begin(self.task, poses, facts) if own else None


def prepare(task: Task, deadline: float = math.inf, settings: Settings = DEFAULT_SETTINGS) -> Setup:
    """Read the geometry, refuse what cannot be, and let start and goals settle.

    Args:
        task: the task.
        deadline: on the clock of tamp.clock.now() [s].
        settings: how it is planned and carried out.

    Raises:
        PlanningFailure: where that has not ended by the deadline.
        TaskError: where the task cannot be used; one sentence that says where and why.
        RobotError: where its robot cannot.
    """
    validate(task)
    settings = settings.for_task(task)
    domain, simulator = domain_of(task, settings.domain), settings.settling
    geometries = {obj.name: geometry_of_object(obj) for obj in task.objects}
    world = World(
        robot_model(task_robot(task)), geometries, task.table, motion_planner=settings.chosen("motion_planner")
    )
    check_geometry(task, world)
    settled = _settled(task, world, None, deadline, simulator)
    start = settled.poses
    goals = settled_goals(task, world, start, deadline, simulator)
    check_settled(task, world, start, goals)
    notes = (*remarks(task, start, goals), *(() if settled.resting else (RESTLESS,)))
    seen = settled.supports if settled.resting else None
    return Setup(task, domain, world, start, goals, settings, remarks=notes, supports=seen)


def domain_of(task: Task, name: str | None) -> Domain:
    """The domain that a task is planned with, which must know the predicates that the task uses.

    Args:
        task: the task.
        name: what the user names in place of the task's own, or None.

    Raises:
        DomainError, TaskError: where there is none of that name, or a predicate is unknown or used wrongly.
    """
    try:
        domain = load_domain(name or task.domain)
    except DomainError as error:
        if name is not None:
            raise
        raise refusal(task, ("domain",), str(error)) from None
    for section, facts in (("init", task.init), ("goal", task.goal)):
        for index, (predicate, *names) in enumerate(facts):
            signature = domain.pddl.predicates.get(predicate)
            if predicate in OPERATORS:
                own = "for anything else the domain needs a predicate of its own, which its skills tell of"
                raise refusal(
                    task, (section, index), f"{predicate!r} is no predicate: facts are listed that hold; {own}"
                )
            if signature is None:
                near = suggest(predicate, domain.pddl.predicates, "predicates")
                raise refusal(task, (section, index), f"domain {domain.name} has no predicate {predicate!r}{near}")
            if len(signature.parameters) != len(names):
                complaint = f"{predicate} is said of {len(signature.parameters)} things, here of {len(names)}"
                raise refusal(task, (section, index), complaint)
    for index, fact in enumerate(task.goal):
        if fact[0] not in domain.followed and fact not in task.init:
            valid = f"valid are {', '.join(sorted(domain.followed))}" if domain.followed else "there are no such facts"
            complaint = f"no skill of domain {domain.name} says when {fact[0]} holds; {valid}"
            where = "where an object shall be is its own goal, such as goal: {on: shelf}"
            raise refusal(task, ("goal", index), f"{complaint}; {where}")
    return domain
