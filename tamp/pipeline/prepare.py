"""A task made ready for planning: validated in physics, settled, and turned into the workspace that samplers see."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from tamp.checking import Verdict, check
from tamp.domains.catalog import load_domain
from tamp.domains.domain import Domain
from tamp.errors import DomainError, TaskError
from tamp.execution.settling import settle
from tamp.execution.simulators import DEFAULT
from tamp.language.sexpr import suggest
from tamp.pipeline.options.settings import DEFAULT_SETTINGS, Settings
from tamp.scoring.ede import ede, mean_edge
from tamp.streams.cache import SampleCache
from tamp.streams.placing.sampler import RELEASE_HEIGHT
from tamp.streams.values import Placement
from tamp.streams.workspace import TABLE
from tamp.task import At, Mesh, Object, Plan, Pose, SymbolicFact, Task, load_robot
from tamp.task.files.yaml_document import FieldPath, read_document
from tamp.task.validate import validate
from tamp.world.geometry.object_geometry import geometry_of_object
from tamp.world.robot.model import robot_model
from tamp.world.world import World

INSIDE = 0.025  # rounding lets given poses overlap a little; deeper than this, two objects are inside each other [m]
THIN = 0.9  # of what is thin, less: spoons were found 13 mm deep in the plates they shall lie on
IN_THE_AIR = 0.05  # a goal that settles farther than this rests on nothing [m]


def _stands_in(obj: Object) -> bool:
    """Whether no more than an object's size is known."""
    return isinstance(obj.shape, Mesh) and obj.shape.stand_in


def check_geometry(task: Task, world: World) -> None:
    """Refuse objects inside each other and objects that stand off the table; what stands in for a mesh may overlap.

    Raises:
        TaskError: names the object, its line in the file, and what would be valid.
    """
    for index, obj in enumerate(task.objects):
        _check_on_table(task, world, ("objects", index, "pose"), obj.name, obj.pose)
        if isinstance(obj.goal, At):
            _check_on_table(task, world, ("objects", index, "goal", "pose"), obj.name, obj.goal.pose)
    known = [(index, obj) for index, obj in enumerate(task.objects) if not _stands_in(obj)]
    for (_, first), (second_index, second) in itertools.combinations(known, 2):
        if _inside(world, first.name, first.pose, second.name, second.pose):
            field = ("objects", second_index, "pose")
            raise _refusal(task, field, f"{second.name} is inside {first.name}; move one of them")
        if (
            isinstance(first.goal, At)
            and isinstance(second.goal, At)
            and _inside(world, first.name, first.goal.pose, second.name, second.goal.pose)
        ):
            goal_field = ("objects", second_index, "goal", "pose")
            raise _refusal(
                task, goal_field, f"the goal of {second.name} is inside that of {first.name}; move one of them"
            )


def check_settled(task: Task, start: Mapping[str, Pose], goals: Mapping[str, Placement]) -> None:
    """Refuse objects that fall off the table and goals that nothing supports.

    Where something stands in for a mesh that is missing nothing is refused: it pushes away what should lie in it.

    Raises:
        TaskError: names the object, its line in the file, and what would be valid.
    """
    if any(map(_stands_in, task.objects)):
        return
    for index, obj in enumerate(task.objects):
        if start[obj.name].xyz[2] < -task.table.thickness:
            field: FieldPath = ("objects", index, "pose")
            raise _refusal(task, field, f"{obj.name} does not stay on the table; give it a pose that is supported")
        if isinstance(obj.goal, At):
            fallen = math.dist(obj.goal.pose.xyz, goals[obj.name].pose.xyz)
            if fallen > IN_THE_AIR:
                raise _refusal(
                    task,
                    ("objects", index, "goal", "pose"),
                    f"nothing supports {obj.name} there: it would fall {100 * fallen:.0f} cm; "
                    f"give a goal that rests on the table or on another goal",
                )


def _check_on_table(task: Task, world: World, field: FieldPath, name: str, pose: Pose) -> None:
    geometry, table = world.geometries[name], task.table
    center = pose.matrix[:3, :3] @ geometry.center_of_mass + pose.matrix[:3, 3]
    low = [c - s / 2 for c, s in zip(table.center, table.size, strict=True)]
    high = [c + s / 2 for c, s in zip(table.center, table.size, strict=True)]
    if not all(lo <= c <= hi for lo, c, hi in zip(low, center, high, strict=False)):
        raise _refusal(
            task,
            field,
            f"{name} is off the table, which spans x {low[0]:.2f} to {high[0]:.2f} and y {low[1]:.2f} to {high[1]:.2f}",
        )
    if center[2] < 0:
        raise _refusal(task, field, f"{name} is under the table top, which is at z = 0")


def _inside(world: World, a: str, pose_a: Pose, b: str, pose_b: Pose) -> bool:
    thinnest = min(float((world.geometries[n].upper - world.geometries[n].lower).min()) for n in (a, b))
    return world.overlap(a, pose_a.matrix, b, pose_b.matrix, tolerance=min(INSIDE, THIN * thinnest))


def _refusal(task: Task, field: FieldPath, complaint: str) -> TaskError:
    if task.path is None:
        return TaskError(f"task {task.name}: {complaint}")
    return TaskError(f"{read_document(task.path).where(field)}: {complaint}")


SAME_PLACE = 0.01  # an object this near to its goal (EDE) counts as being there [m]
DISJOINT = 0.005  # objects without a goal that overlap a goal deeper than this are not part of the goal scene [m]

Supports = Iterable[tuple[str, str]]


@dataclass(frozen=True)
class Situation:
    """A scene at rest and its goals.

    Attributes:
        start: object -> where it stands now.
        goals: object with a goal pose -> the placement it means; the object's own start where it is there already.
    """

    start: Mapping[str, Placement]
    goals: Mapping[str, Placement]


def observe(
    task: Task,
    poses: Mapping[str, Pose],
    goals: Mapping[str, Placement],
    deadline: float = math.inf,
    simulator: str = DEFAULT,
) -> Situation:
    """The situation of a task whose objects are at rest at `poses`.

    Args:
        task: the task.
        poses: object -> pose (world frame).
        goals: what the goals mean, from `settled_goals`.
        deadline: on the clock of tamp.clock.now() [s]; PlanningFailure past it.
        simulator: in which it settles.
    """
    start = placements(poses, settle(task, poses, deadline=deadline, simulator=simulator).supports)
    return Situation(MappingProxyType(start), MappingProxyType(_already_there(task, start, goals)))


def placements(poses: Mapping[str, Pose], supports: Supports) -> dict[str, Placement]:
    """Placements from poses and (above, below) pairs; bodies that lean on each other support neither."""
    pairs = set(supports)
    below: dict[str, set[str]] = {name: set() for name in poses}
    for upper, lower in pairs:
        if upper in below:
            below[upper].add(lower)
    kept = {name: {lower for lower in lowers if name not in _all_below(below, lower)} for name, lowers in below.items()}
    return {name: Placement(pose, tuple(sorted(kept[name])) or (TABLE,)) for name, pose in poses.items()}


def _all_below(below: Mapping[str, set[str]], name: str) -> set[str]:
    """Everything that `name` rests on, directly or through others."""
    found: set[str] = set()
    waiting = [name]
    while waiting:
        for lower in below.get(waiting.pop(), ()):
            if lower not in found:
                found.add(lower)
                waiting.append(lower)
    return found


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
    settled = settle(task, {**bystanders, **wanted}, deadline=deadline, simulator=simulator)
    resting = placements(settled.poses, settled.supports)
    return {name: raised(resting[name]) for name in wanted}


def _overlap(world: World, a: str, pose_a: Pose, b: str, pose_b: Pose) -> bool:
    return world.overlap(a, pose_a.matrix, b, pose_b.matrix, tolerance=DISJOINT)


def raised(placement: Placement, height: float = RELEASE_HEIGHT) -> Placement:
    """A placement a little above where an object rests, from where it is let go."""
    x, y, z = placement.pose.xyz
    return replace(placement, pose=Pose((x, y, z + height), placement.pose.quat))


def _already_there(task: Task, start: Mapping[str, Placement], goals: Mapping[str, Placement]) -> dict[str, Placement]:
    """Goals, with the start itself in place of every goal that is fulfilled and rests on what stays."""
    result = dict(goals)
    waiting = [name for name in goals if _near(task, name, start[name], goals[name])]
    changed = True
    while changed:
        changed = False
        for name in list(waiting):
            supports = [lower for lower in goals[name].on if lower != TABLE]
            if all(result.get(lower, start[lower]) is start[lower] for lower in supports):
                result |= left_at(goals, name, start[name])
                waiting.remove(name)
                changed = True
    return result


def left_at(goals: Mapping[str, Placement], name: str, here: Placement) -> dict[str, Placement]:
    """The goals of an object that stays a little off its own, and of what shall rest on it alone, which is off as much.

    Stacked plates and nested bowls fit closely: where the lower one stands a centimetre off, the upper one would
    otherwise have to stand in its wall.

    Args:
        goals: what the goals mean, each a little above where the object rests.
        name: the object that stays.
        here: where it rests.
    """
    shift = here.pose @ raised(goals[name], -RELEASE_HEIGHT).pose.inverse()
    moved = {name: here}
    changed = True
    while changed:
        above = {other: goals[other] for other in goals if other not in moved and moved.keys() >= {*goals[other].on}}
        moved |= {other: replace(place, pose=shift @ place.pose) for other, place in above.items()}
        changed = bool(above)
    return moved


def _near(task: Task, name: str, here: Placement, there: Placement) -> bool:
    return here.on == there.on and ede(mean_edge(task.object(name).shape), here.pose, there.pose) < SAME_PLACE


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
    """

    task: Task
    domain: Domain
    world: World
    start: Mapping[str, Pose]
    goals: Mapping[str, Placement]
    settings: Settings = DEFAULT_SETTINGS
    cache: SampleCache = field(default_factory=SampleCache, repr=False)

    def check(
        self,
        plan: Plan,
        *,
        start: Mapping[str, Pose],
        goals: Mapping[str, Pose],
        facts: Iterable[SymbolicFact] | None = None,
    ) -> Verdict:
        """The independent checker's word on a plan from a known state, by the rules of the domain."""
        return check(self.task, plan, start=start, goals=goals, facts=facts, rules=self.domain.rules)


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
    domain, simulator = _domain(task, settings.domain), settings.settling
    geometries = {obj.name: geometry_of_object(obj) for obj in task.objects}
    world = World(
        robot_model(load_robot(task.robot)), geometries, task.table, motion_planner=settings.chosen("motion_planner")
    )
    check_geometry(task, world)
    start = settle(task, deadline=deadline, simulator=simulator).poses
    goals = settled_goals(task, world, start, deadline, simulator)
    check_settled(task, start, goals)
    return Setup(task, domain, world, start, goals, settings)


def _domain(task: Task, name: str | None) -> Domain:
    """The domain that a task is planned with, which must know the predicates that the task uses."""
    try:
        domain = load_domain(name or task.domain)
    except DomainError as error:
        if name is not None:
            raise
        raise _refusal(task, ("domain",), str(error)) from None
    for section, facts in (("init", task.init), ("goal", task.goal)):
        for index, (predicate, *names) in enumerate(facts):
            signature = domain.pddl.predicates.get(predicate)
            if signature is None:
                near = suggest(predicate, domain.pddl.predicates, "predicates")
                raise _refusal(task, (section, index), f"domain {domain.name} has no predicate {predicate!r}{near}")
            if len(signature.parameters) != len(names):
                complaint = f"{predicate} is said of {len(signature.parameters)} things, here of {len(names)}"
                raise _refusal(task, (section, index), complaint)
    return domain
