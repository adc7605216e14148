"""What stands where now, and what each goal means: both settled in physics, so that plans start and end at rest."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

from tamp.execution.settling import settle
from tamp.scoring.ede import ede, mean_edge
from tamp.streams.placements import RELEASE_HEIGHT
from tamp.streams.values import Placement
from tamp.streams.workspace import TABLE
from tamp.task import At, Pose, Task
from tamp.world.world import World

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
    task: Task, poses: Mapping[str, Pose], goals: Mapping[str, Placement], deadline: float = math.inf
) -> Situation:
    """The situation of a task whose objects are at rest at `poses`.

    Args:
        task: the task.
        poses: object -> pose (world frame).
        goals: what the goals mean, from `settled_goals`.
        deadline: on the clock of time.monotonic [s]; PlanningFailure past it.
    """
    start = placements(poses, settle(task, poses, deadline=deadline).supports)
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
    task: Task, world: World, now: Mapping[str, Pose], deadline: float = math.inf
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
    settled = settle(task, {**bystanders, **wanted}, deadline=deadline)
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
