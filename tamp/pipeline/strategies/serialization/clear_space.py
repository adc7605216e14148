"""Making room where objects crowd: what lies in a container is nudged aside, so that a hand can take it or another."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import islice
from typing import TYPE_CHECKING

from tamp.pipeline.strategies.serialization.goal_graph import asking_for
from tamp.pipeline.strategies.serialization.subproblem import Asker
from tamp.planning import Context
from tamp.streams.affordances.neighbours import enclosed
from tamp.streams.affordances.nudges import nudgeable, nudged, slides_within
from tamp.streams.hand.candidates import Pinches
from tamp.streams.pushing.nudge import free_shifts, hands_over, with_room
from tamp.streams.values import Grasp, Placement
from tamp.streams.workspace import TABLE, Workspace

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

ENOUGH, PLENTY = 2, 10  # hands with room round an object: it is not stuck; more are no better
TRIES = 40  # nudges that the planner is asked for
ITERATIONS = 4  # of the stream planner for one


def make_room(asker: Asker, names: Collection[str], kept: Collection[str]) -> bool:
    """Nudge one object where that gives a hand room to take what no hand can take now; whether that was done.

    Args:
        asker: the plan so far, which grows.
        names: objects that shall be moved.
        kept: objects that must stay at their goals.
    """
    workspace = asker.workspace
    waiting = stuck(workspace, names)
    inside = [name for name in sorted(workspace.start) if name not in kept and _may_be_nudged(workspace, name)]
    gains = [found for name in inside if waiting for found in _gains(workspace, name, waiting)]
    best = sorted(gains, key=lambda gain: (-gain.freed, -min(gain.hands, PLENTY), gain.length))
    return any(not asker.late and _nudge(asker, gain, kept) for gain in islice(best, TRIES))


def stuck(workspace: Workspace, names: Collection[str]) -> set[str]:
    """Those of some objects in containers that must leave there and that no hand has room to take as all stand."""
    inside = (name for name in names if _lies_within(workspace, name) and not _leads_there(workspace, name))
    sought = (name for name in inside if len(hands_over(workspace, name, workspace.start[name])))
    return {name for name in sought if len(_roomy(workspace, name)) < ENOUGH}


def _leads_there(workspace: Workspace, name: str) -> bool:
    """Whether a nudge brings an object to its goal."""
    start = workspace.start[name]
    return nudgeable(workspace, name, start, workspace.goals.get(name, start))


def _lies_within(workspace: Workspace, name: str) -> bool:
    """Whether an object lies in one thing alone, and nothing on it."""
    place = workspace.start[name]
    free = not any(name in other.on for other in workspace.start.values())
    return free and len(place.on) == 1 and place.on != (TABLE,) and enclosed(workspace, name, place)


def _may_be_nudged(workspace: Workspace, name: str) -> bool:
    """Whether an object lies in one thing alone, nothing on it, and slides in there without taking that along."""
    return _lies_within(workspace, name) and slides_within(workspace, name, *workspace.start[name].on)


def _roomy(workspace: Workspace, name: str, without: str = "") -> Pinches:
    """Hands with room round an object as all stand but one that is taken away."""
    place = workspace.start[name]
    others = {other: standing for other, standing in workspace.start.items() if other not in (name, without)}
    return workspace.cache.value(
        ("roomy", name, place, *others.items()),
        lambda: with_room(workspace, hands_over(workspace, name, place), place.pose.matrix, _poses(others)),
    )


@dataclass(frozen=True)
class _Gain:
    """What a nudge of an object to a place would bring: objects that it frees, and for how many of the hands."""

    name: str
    end: Placement
    length: float
    freed: int
    hands: int


def _gains(workspace: Workspace, name: str, waiting: Collection[str]) -> Iterator[_Gain]:
    """Nudges of an object that free it or others that wait for it."""
    place, others = workspace.start[name], {**workspace.start}
    del others[name]
    # Only hands for which nothing else is in the way can be given room: they are few.
    barred = {other: _roomy(workspace, other, name) for other in sorted(waiting) if other != name}
    for shift in free_shifts(workspace, name, place, _poses(others)):
        end = nudged(place, shift)
        rooms = [
            len(with_room(workspace, hands, workspace.start[other].pose.matrix, _poses({name: end})))
            for other, hands in barred.items()
        ]
        if name in waiting:
            hands = hands_over(workspace, name, place)
            rooms.append(len(with_room(workspace, hands, end.pose.matrix, _poses(others))))
        if freed := sum(room >= ENOUGH for room in rooms):
            yield _Gain(name, end, math.hypot(*shift), freed, sum(rooms))


def _poses(places: Mapping[str, Placement]) -> dict[str, NDArray[np.float64]]:
    return {name: place.pose.matrix for name, place in places.items()}


def _nudge(asker: Asker, gain: _Gain, kept: Collection[str]) -> bool:
    """Plan a nudge while all others stay; whether that succeeded."""
    workspace = asker.workspace
    stay = {other: workspace.start[other] for other in workspace.goals}
    near = replace(workspace, goals={**stay, gain.name: gain.end})
    asked, samplers = asking_for(near, {*kept, gain.name}), {"sample-grasp": _no_grasp}
    solution = asker.ask(asked, ITERATIONS, {gain.name}, samplers, about=gain.name)
    return solution.plan is not None and asker.refused(solution.plan, gain.name) is None


def _no_grasp(context: Context, obj: str) -> Iterator[Grasp]:
    """No hand shall take what is nudged."""
    yield from ()
