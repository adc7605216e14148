"""Turning over on the table: what no two grasps turn over on its way to its goal may first lie as it shall lie there.

Two grasps bring an object to its goal only where hands have room at both ends and both reach one place in between. On
an empty spot of the table it is turned over more easily, and from there a single grasp may do.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tamp.pipeline.strategies.serialization.feasibility import turned_over
from tamp.pipeline.strategies.subproblems.goal_graph import alone, asking_to
from tamp.pipeline.strategies.subproblems.subproblem import EFFORTS, Asker, while_others_stay
from tamp.streams.affordances.stable_poses import resting, turned
from tamp.streams.placing.sampler import put_aside
from tamp.streams.values import Placement

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

FACES = 4  # to lie on that are tried, those first that leave least to turn
LEAST = np.cos(np.radians(75.0))  # between what is up on a face and at the goal: a hand turns it by no more on its way


def turn_over(asker: Asker, name: str, kept: Collection[str]) -> bool:
    """Put an object that has to be turned over down on the table so that one grasp can bring it to its goal.

    Args:
        asker: the plan so far, which grows.
        name: the object; its goal is a pose.
        kept: objects that must stay at their goals.

    Returns:
        Whether it was.
    """
    workspace = asker.workspace
    if not turned_over(workspace, name) or any(name in place.on for place in workspace.start.values()):
        return False
    for place in _places(asker, name):
        if asker.late:
            return False
        if _leads_on(asker, name, place) and _put(asker, name, place, kept):
            return True
    return False


def _places(asker: Asker, name: str) -> Iterator[Placement]:
    """Where the object lies out of the way on the table, for each of the faces on which it lies most as at its goal."""
    workspace = asker.workspace
    goal = workspace.goals[name].pose.matrix[:3, :3]
    faces = [R for R in resting(workspace, name) if R[2] @ goal[2] > LEAST]
    for R in sorted(faces, key=lambda R: -float(R[2] @ goal[2]))[:FACES]:
        M = R @ goal.T
        headed = turned(R, float(np.arctan2(M[0, 1] - M[1, 0], M[0, 0] + M[1, 1])))  # as near to the goal as it comes
        keys, seed = (name, repr(headed.round(6).tolist())), asker.drawn_seed(name)
        context = while_others_stay(workspace, name, "turn-over", keys, seed, asker.deadline)
        place = put_aside(context, name, headed)
        if place is not None:
            yield place


def _leads_on(asker: Asker, name: str, place: Placement) -> bool:
    """Whether the object reaches its goal from a place by one grasp, once all others are out of the way."""
    workspace = asker.workspace
    there = alone(replace(workspace, start={**workspace.start, name: place}), name)
    return asker.ask(there, asker.tuning.alone_iterations, {name}, about=name).plan is not None


def _put(asker: Asker, name: str, place: Placement, kept: Collection[str]) -> bool:
    """Put the object to a place while all others stay, by one grasp or else by two; whether it was."""
    asked = asking_to(asker.workspace, name, place, kept)
    for regrasped in (frozenset[str](), {name}):
        solution = asker.ask(asked, EFFORTS[0].iterations, {name}, regrasped=regrasped, about=name)
        if solution.plan is not None and asker.refused(solution.plan, name) is None:
            return True
    return False
