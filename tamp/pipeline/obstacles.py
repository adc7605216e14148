"""What has to leave before an object can be brought to its goal, as far as a short look says."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import islice
from typing import Any

from tamp.planning import Context
from tamp.planning.context import generator_for
from tamp.streams.collisions import CONTACT_DEPTH, handling_hits
from tamp.streams.values import Placement
from tamp.streams.workspace import Workspace

LOOKED_AT = 12  # grasps of an object


def clearest_first(
    workspace: Workspace, names: Sequence[str], samplers: Mapping[str, Callable[..., Any]], seed: int, deadline: float
) -> list[str]:
    """The names, those of objects for which the fewest others have to leave first; arguments as of `in_the_way`."""
    return sorted(names, key=lambda name: len(in_the_way(workspace, name, samplers, seed, deadline)))


def in_the_way(
    workspace: Workspace, name: str, samplers: Mapping[str, Callable[..., Any]], seed: int, deadline: float
) -> set[str]:
    """What stands on an object, where its goal is, or in the hand's way to it, and all that stands on any of those.

    Of the grasps that are looked at, that which meets the fewest counts.

    Args:
        workspace: what stands where.
        name: the object.
        samplers: one function for each stream.
        seed: decides every random choice.
        deadline: on the clock of time.monotonic [s].
    """
    others = {other: place for other, place in workspace.start.items() if other != name}
    found = {other for other, place in others.items() if name in place.on}
    if name in workspace.goals:
        found |= _overlapping(workspace, name, workspace.goals[name], others)
    found |= _met(workspace, name, others, samplers, seed, deadline)
    while above := {other for other, place in others.items() if not found.isdisjoint(place.on)} - found:
        found |= above
    return found


def barred(
    workspace: Workspace, name: str, samplers: Mapping[str, Callable[..., Any]], seed: int, deadline: float
) -> str | None:
    """Why an object cannot reach its goal while no other moves, as where they stand tells; None if that does not.

    Something may stand on it, or where its goal pose is; arguments as of `in_the_way`.
    """
    goal, test = workspace.goals.get(name), samplers["test-cfree-placements"]
    for other, place in workspace.start.items():
        if name in place.on:
            return f"{other} stands on {name}"
        inputs = (name, goal, other, place)
        context = Context(workspace, partial(generator_for, seed, "test-cfree-placements", map(repr, inputs)), deadline)
        if goal is not None and other != name and not test(context, *inputs):
            return f"{name} would overlap {other}"
    return None


def _overlapping(workspace: Workspace, name: str, goal: Placement, others: Mapping[str, Placement]) -> set[str]:
    return {
        other
        for other, place in others.items()
        if workspace.world.overlap(name, goal.pose.matrix, other, place.pose.matrix, tolerance=CONTACT_DEPTH)
    }


def _met(
    workspace: Workspace,
    name: str,
    others: Mapping[str, Placement],
    samplers: Mapping[str, Callable[..., Any]],
    seed: int,
    deadline: float,
) -> set[str]:
    """Those that the arm meets where it takes an object from where it stands by the grasp that meets the fewest."""

    def context(stream: str, *inputs: Any) -> Context:
        keys = (name, *map(repr, inputs))
        made = Context(workspace, lambda: generator_for(seed, stream, keys), deadline)
        made.bound = tuple(("AtPose", other, place) for other, place in others.items())
        return made

    start, fewest = workspace.start[name], set(others)
    for grasp in islice(samplers["sample-grasp"](context("sample-grasp"), name), LOOKED_AT):
        ways = samplers["inverse-kinematics"](context("inverse-kinematics", start, grasp), name, start, grasp)
        for _, _, handling in islice(ways, 1):
            fewest = min(fewest, set(handling_hits(workspace, handling, others)), key=len)
        if not fewest:
            break
    return fewest
