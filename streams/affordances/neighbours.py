"""What stands around an object at a placement: what carries it, what stands on it, what it lies in."""

from __future__ import annotations

from collections.abc import Mapping

from tamp.streams.values import Placement
from tamp.streams.workspace import TABLE, Workspace

AROUND = 0.05  # an object may meet others this far beside it as it comes to rest [m]
SUNK = 0.02  # an object lies in what reaches this much higher than its own lowest point [m]


def standing_on(obj: str, around: Mapping[str, Placement]) -> set[str]:
    """Those that stand on an object or on others that do: gone before it is taken, put down after it."""
    found: set[str] = set()
    while more := {name for name, place in around.items() if not {obj, *found}.isdisjoint(place.on)} - found:
        found |= more
    return found


def standing_around(workspace: Workspace, obj: str, place: Placement) -> dict[str, Placement]:
    """What stands around a placement of an object: the start scene, or the goal scene for a goal.

    What has no goal pose of its own is there as well.
    """
    around = {**workspace.start, **workspace.goals} if workspace.is_goal(obj, place) else workspace.start
    return {name: around[name] for name in sorted(around) if name != obj}


def beneath(place: Placement, around: Mapping[str, Placement]) -> list[str]:
    """Everything that carries an object at a placement, directly or through others, as it stands around; sorted."""
    found: set[str] = set()
    waiting = set(place.on)
    while waiting := (waiting & around.keys()) - found:
        found |= waiting
        waiting = {lower for name in waiting for lower in around[name].on}
    return sorted(found)


def carriers(workspace: Workspace, obj: str, place: Placement) -> dict[str, Placement]:
    """What carries an object at a placement, directly or through others, and where it stands then."""
    around = standing_around(workspace, obj, place)
    return {name: around[name] for name in beneath(place, around)}


def upon_carriers(workspace: Workspace, obj: str, *places: Placement) -> Workspace:
    """The part of a workspace that has an object and what carries it at some placements."""
    return workspace.part({obj, *(name for place in places for name in carriers(workspace, obj, place))})


def within(workspace: Workspace, obj: str, reach: float, *places: Placement) -> Workspace:
    """The part with an object, what carries it at some placements, and what is within reach [m] of its box there."""
    names = {obj}
    for place in places:
        around = standing_around(workspace, obj, place)
        lower, upper = workspace.bounds(obj, place.pose)
        names.update(beneath(place, around))
        for name, other in around.items():
            low, high = workspace.bounds(name, other.pose)
            if (low < upper + reach).all() and (lower - reach < high).all():
                names.add(name)
    return workspace.part(names)


def company(workspace: Workspace, name: str, place: Placement) -> list[str]:
    """What an object may meet as it comes to rest, and whatever that rests on or carries; all else keeps still."""
    low, high = workspace.bounds(name, place.pose)
    found, touched = set[str](), set[str]()
    for other, standing in workspace.start.items():
        lower, upper = workspace.bounds(other, standing.pose)
        if other != name and (lower < high + AROUND)[:2].all() and (upper > low - AROUND)[:2].all():
            touched.add(other)
    pairs = [{other, *standing.on} - {TABLE, name} for other, standing in workspace.start.items() if other != name]
    while touched > found:
        found = set(touched)
        touched = found.union(*(pair for pair in pairs if pair & found))
    return sorted(found & workspace.start.keys())


def enclosed(workspace: Workspace, obj: str, place: Placement) -> bool:
    """Whether an object lies in something that stays when it is taken; what touches the table merely leans on it."""
    return TABLE not in place.on and lies_in(workspace, obj, place, carriers(workspace, obj, place))


def lies_in(workspace: Workspace, obj: str, placement: Placement, below: Mapping[str, Placement]) -> bool:
    """Whether an object lies in one of those that carry it, directly or through others."""
    lower, upper = workspace.bounds(obj, placement.pose)
    middle = (lower + upper)[:2] / 2
    for name, place in below.items():
        low, high = workspace.bounds(name, place.pose)
        if (low[:2] < middle).all() and (middle < high[:2]).all() and high[2] > lower[2] + SUNK:
            return True
    return False
