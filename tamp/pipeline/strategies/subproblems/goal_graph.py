"""Which goals of a task are asked for, on what they rest, and what else must stand for one of them alone."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

from tamp.scoring.ede import ede, mean_edge
from tamp.scoring.score import SOLVED_WITHIN_M, fact_text
from tamp.streams.affordances.neighbours import within
from tamp.streams.collisions import overlap
from tamp.streams.hand.clearance import reach_of_hand
from tamp.streams.placing.packing import crowded
from tamp.streams.values import Placement
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import At, Goal, In, On

Placements = tuple[tuple[tuple[str, Placement], ...], ...]


def goal_names(workspace: Workspace) -> list[str]:
    """Objects that have a goal, in the task's order."""
    return [obj.name for obj in workspace.task.objects if obj.goal is not None]


def all_goals(workspace: Workspace) -> list[str]:
    """Those objects, and the symbolic facts that the task asks for, as PDDL writes them."""
    return [*goal_names(workspace), *(fact_text(fact) for fact in workspace.task.goal)]


def goal_supports(workspace: Workspace, name: str) -> list[str]:
    """Objects with goal poses that the goal pose of an object rests on."""
    return [lower for lower in workspace.goals[name].on if lower in workspace.goals] if name in workspace.goals else []


def under_goal(workspace: Workspace, name: str) -> list[str]:
    """Objects with goal poses that the goal pose of an object rests on, directly or through others."""
    return [lower for lower in _all_below(workspace.goals, name) if lower in workspace.goals]


def nearly_there(workspace: Workspace, name: str, *, slid: bool = False) -> bool:
    """Whether an object is as near to its goal pose as a solved task asks, on supports that are at theirs.

    It may touch other objects besides, and the table once it bears all that it shall: what has tilted down to that does
    not bear what comes next.

    Args:
        workspace: where all is.
        name: the object.
        slid: whether it may also lie beside what it shall rest on, if that is at its own goal.
    """
    if not _near(workspace, name, slid=slid):
        return False
    tilted_down = TABLE in {*workspace.start[name].on} - {*workspace.goals[name].on}
    at_theirs = all(workspace.start[lower] == workspace.goals[lower] for lower in goal_supports(workspace, name))
    return at_theirs and not (tilted_down and not _bears_all(workspace, name))


def _near(workspace: Workspace, name: str, *, slid: bool = False) -> bool:
    """The same wherever its supports are."""
    obj, here = workspace.task.object(name), workspace.start[name]
    if not isinstance(obj.goal, At):
        return False
    near = ede(mean_edge(obj.shape), here.pose, obj.goal.pose) <= SOLVED_WITHIN_M
    return near and (slid or {*here.on} >= {*workspace.goals[name].on})


def _bears_all(workspace: Workspace, name: str) -> bool:
    """Whether all whose goal poses rest on an object, or on what does, are near them."""
    return all(_near(workspace, other) for other in workspace.goals if name in _all_below(workspace.goals, other))


def away(workspace: Workspace, name: str) -> float:
    """How far an object with a goal pose is from it (EDE) [m]."""
    obj = workspace.task.object(name)
    return ede(mean_edge(obj.shape), workspace.start[name].pose, workspace.goals[name].pose)


def supports_first(workspace: Workspace, names: Sequence[str]) -> list[str]:
    """The names in an order in which what others rest on at their goals comes before them."""
    below: dict[str, tuple[str, ...]] = {name: place.on for name, place in workspace.goals.items()}
    for obj in workspace.task.objects:
        if isinstance(obj.goal, On | In):
            below[obj.name] = (obj.goal.target,)

    def height(name: str, seen: tuple[str, ...] = ()) -> int:
        lower = [other for other in below.get(name, ()) if other in below and other not in seen]
        return 1 + max((height(other, (*seen, name)) for other in lower), default=0)

    return sorted(names, key=height)


def farthest_first(workspace: Workspace, names: Collection[str]) -> list[str]:
    """Objects with goal poses, those farthest from theirs (EDE) first, each after those that its goal rests on.

    What is much nearer to its own goal than what shall rest on it has less to gain, and comes later all the same.
    """
    order: list[str] = []

    def add(name: str, above: tuple[str, ...] = ()) -> None:
        for lower in goal_supports(workspace, name):
            if lower in names and lower not in above and 2 * away(workspace, lower) > away(workspace, name):
                add(lower, (*above, name))
        if name not in order:
            order.append(name)

    for name in sorted(names, key=lambda name: (-away(workspace, name), name)):
        add(name)
    return order


def asking_for(workspace: Workspace, names: Collection[str]) -> Workspace:
    """The workspace in which only some goals are asked for: of objects, and symbolic ones as PDDL writes them.

    The goal poses of the others stay known: that is where they may be put aside to, and where buffers are not wanted.
    """
    objects = tuple(obj if obj.name in names else replace(obj, goal=None) for obj in workspace.task.objects)
    facts = tuple(fact for fact in workspace.task.goal if fact_text(fact) in names)
    return replace(workspace, task=replace(workspace.task, objects=objects, goal=facts), all_goals=workspace.whole)


def asking_to(workspace: Workspace, name: str, place: Placement, kept: Collection[str]) -> Workspace:
    """The workspace in which an object is asked for at a place; all others stay, and those that are kept must."""
    stay = {other: workspace.start[other] for other in workspace.goals}
    return asking_for(replace(workspace, goals={**stay, name: place}), {*kept, name})


def alone(workspace: Workspace, name: str) -> Workspace:
    """The workspace with one object, what it rests on at its start and its goal, and what it shall be put on or in.

    All else is taken away.
    """
    start, goal = workspace.start, workspace.task.object(name).goal
    below = _all_below({**start, **workspace.goals}, name) if name in workspace.goals else []
    there = [goal.target] if isinstance(goal, On | In) and goal.target in start else []
    standing = {other: start[other] for first in (name, *there) for other in (first, *_all_below(start, first))}
    standing |= {other: workspace.goals.get(other, start[other]) for other in below}
    # Where it stands on something now, the goal of that does not matter, nor is what that would rest on there.
    goals = {other: workspace.goals[other] for other in (name, *below) if other in workspace.goals}
    return replace(asking_for(workspace, {name}), start=standing, goals=goals)


def surroundings(workspace: Workspace, name: str) -> Placements:
    """What stands within a hand's reach of an object, or of its goal: all else seldom decides a short try.

    All that stands anywhere, where the goal is no pose.
    """
    if name not in workspace.goals:
        return workspace.placements
    return within(workspace, name, reach_of_hand(workspace), *workspace.placements_of(name)).placements


def supports_in_the_way(workspace: Workspace, name: str) -> list[str]:
    """What an object rests on that stands where its goal is, so that it has to leave once the object is taken off."""
    goal = workspace.goals.get(name)
    below = _all_below(workspace.start, name) if goal is not None else []
    return [low for low in below if goal is not None and overlap(workspace, name, goal, low, workspace.start[low])]


def _all_below(places: Mapping[str, Placement], name: str) -> list[str]:
    """Everything that an object rests on, directly or through others, as `places` have it."""
    found: list[str] = []
    waiting = [name]
    while waiting:
        placement = places.get(waiting.pop())
        for lower in placement.on if placement is not None else ():
            if lower != TABLE and lower != name and lower not in found:
                found.append(lower)
                waiting.append(lower)
    return found


def takes_room(workspace: Workspace, goal: Goal | None) -> bool:
    """Whether it is open where a goal is reached, so that one that is reached alone may take the room of the next.

    Where a region is filled in rows it does not: there a jam shall cost one object and not the plan for all.
    """
    regions = {region.name: region for region in workspace.task.regions}
    in_rows = isinstance(goal, On) and goal.target in regions and crowded(workspace, regions[goal.target])
    return isinstance(goal, On | In) and not in_rows
