"""Making room where objects crowd: what lies in a container is nudged aside, so that a hand can take it or another.

What neighbours hem in on the table is pushed out of there.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from itertools import islice

from tamp.pipeline.strategies.subproblems.goal_graph import asking_to
from tamp.pipeline.strategies.subproblems.subproblem import Asker
from tamp.planning import Context
from tamp.streams.affordances.neighbours import enclosed
from tamp.streams.affordances.nudges import nudgeable, nudged, slides_within
from tamp.streams.affordances.slide_path import ways_to
from tamp.streams.grasping.hand_room import ENOUGH, hands_over, hemmed_in, matrices, roomy, with_room
from tamp.streams.pushing.nudge import free_shifts
from tamp.streams.values import Grasp, Placement
from tamp.streams.workspace import TABLE, Workspace

PLENTY = 10  # hands with room round an object: more are no better
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
    """Those of some objects that must leave where they are and that no hand has room to take as all stand."""
    leaving = (name for name in names if _lies_free(workspace, name) and not _leads_there(workspace, name))
    return {name for name in leaving if hemmed_in(workspace, name)}


def _leads_there(workspace: Workspace, name: str) -> bool:
    """Whether a push brings an object to its goal."""
    start = workspace.start[name]
    goal = workspace.goals.get(name, start)
    return nudgeable(workspace, name, start, goal) or bool(ways_to(workspace, name, start, goal))


def _lies_free(workspace: Workspace, name: str) -> bool:
    """Whether an object lies on the table or in one thing alone, and nothing on it."""
    place = workspace.start[name]
    free = not any(name in other.on for other in workspace.start.values())
    return free and len(place.on) == 1 and (place.on == (TABLE,) or enclosed(workspace, name, place))


def _may_be_nudged(workspace: Workspace, name: str) -> bool:
    """Whether an object slides where it lies without taking that along; on the table, one that no hand can take."""
    if not _lies_free(workspace, name):
        return False
    place = workspace.start[name]
    return hemmed_in(workspace, name) if place.on == (TABLE,) else slides_within(workspace, name, *place.on)


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
    barred = {other: roomy(workspace, other, name) for other in sorted(waiting) if other != name}
    for shift in free_shifts(workspace, name, place, matrices(others)):
        end = nudged(place, shift)
        rooms = [
            len(with_room(workspace, hands, workspace.start[other].pose.matrix, matrices({name: end})))
            for other, hands in barred.items()
        ]
        if name in waiting:
            hands = hands_over(workspace, name, place)
            rooms.append(len(with_room(workspace, hands, end.pose.matrix, matrices(others))))
        if freed := sum(room >= ENOUGH for room in rooms):
            yield _Gain(name, end, math.hypot(*shift), freed, sum(rooms))


def _nudge(asker: Asker, gain: _Gain, kept: Collection[str]) -> bool:
    """Plan a nudge while all others stay; whether that succeeded."""
    asked, samplers = asking_to(asker.workspace, gain.name, gain.end, kept), {"sample-grasp": _no_grasp}
    solution = asker.ask(asked, ITERATIONS, {gain.name}, samplers, about=gain.name)
    return solution.plan is not None and asker.refused(solution.plan, gain.name) is None


def _no_grasp(context: Context, obj: str) -> Iterator[Grasp]:
    """No hand shall take what is nudged."""
    yield from ()
