"""Whether an object reaches its goal at all: alone in the world, or only for what stands in its way."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import islice
from typing import Any

from tamp.pipeline.strategies.subproblems.goal_graph import alone, goal_supports, supports_first, supports_in_the_way
from tamp.pipeline.strategies.subproblems.subproblem import Asker, reason
from tamp.planning import Context, Solution
from tamp.planning.context import generator_for
from tamp.streams.affordances.flat_faces import lies_flat
from tamp.streams.affordances.tilts import upside_down
from tamp.streams.affordances.topple_path import to_be_pushed
from tamp.streams.collisions import overlap
from tamp.streams.motion.handling_contacts import handling_hits
from tamp.streams.values import Placement
from tamp.streams.workspace import Workspace
from tamp.world.world import ROBOT

BEGINNING_WITH_A_SLIDE = 2  # so many times as many iterations find plans that do and are longer
REGRASPING = 0.25  # of the time that is left goes to whether another grasp on the way helps: that may be sought in vain


@dataclass
class Prospects:
    """What short tries say of single objects; each object is tried once, from where it stands by then.

    Attributes:
        asker: the plan so far.
        hopeless: object that does not reach its goal even alone -> where it stood then, and why.
        regrasped: objects that reach theirs alone by way of another grasp.
        plans: object that reaches its goal alone -> how; None where no such plan is known that may guide another.
        unknown: objects of which time was up before that was known.
    """

    asker: Asker
    hopeless: dict[str, tuple[Placement, str]] = field(default_factory=dict)
    regrasped: set[str] = field(default_factory=set)
    unknown: set[str] = field(default_factory=set)
    plans: dict[str, Solution | None] = field(default_factory=dict)

    def known_against(self, name: str) -> str | None:
        """Why an object does not reach its goal even alone, where that is known by now, wherever it stands."""
        if name not in self.hopeless and self.impossible(name):
            start = self.asker.workspace.start[name]
            self.hopeless[name] = start, f"even alone: {name} would stand in the robot's base"
        return self.hopeless[name][1] if name in self.hopeless else None

    def impossible(self, name: str) -> bool:
        """Whether links that never move stand where an object's goal is: no search needs to find that out."""
        goal = self.asker.workspace.goals.get(name)
        return goal is not None and self.asker.workspace.world.overlap(name, goal.pose.matrix, ROBOT)

    def beyond_hope(self, names: Collection[str]) -> set[str]:
        """Those that are known not to reach their goals even alone, and all whose goals rest on any of them."""
        found, workspace = {name for name in names if name in self.hopeless}, self.asker.workspace
        for name in supports_first(workspace, sorted(names)):
            if found & {*goal_supports(workspace, name)}:
                found.add(name)
        return found

    def against(self, name: str) -> str | None:
        """Why an object does not reach its goal even with all others out of the way; None where it does."""
        if name in self.plans:
            return None
        if (known := self.known_against(name)) is not None:
            return known
        workspace = alone(self.asker.workspace, name)
        iterations = longer = self.asker.tuning.alone_iterations
        pushed = to_be_pushed(workspace, name, workspace.start[name])
        if pushed:
            longer *= BEGINNING_WITH_A_SLIDE
        # What no single hand can turn over is asked about two of them first.
        if self.turned(name) and self._regrasp_helps(workspace, name, longer):
            self.plans.setdefault(name, None)
            return None
        movable = {name, *supports_in_the_way(workspace, name)}
        solution = self.asker.ask(workspace, iterations, movable, about=name)
        if solution.plan is None and pushed:
            solution = self.asker.ask(workspace, longer, movable, about=name)
        if solution.plan is None and not self.turned(name) and self._regrasp_helps(workspace, name, longer):
            self.plans.setdefault(name, None)
            return None
        if solution.plan is not None:
            self.plans[name] = solution
            return None
        why = f"even alone: {reason(solution)}"
        if self.asker.late:
            self.unknown.add(name)
        else:
            self.hopeless[name] = workspace.start[name], why
        return why

    def mislead(self, name: str) -> None:
        """The checker sent a plan for an object back: how it reaches its goal alone guides no more."""
        if name in self.plans:
            self.plans[name] = None

    def forget(self, name: str) -> None:
        """An object lies otherwise than before: it is tried anew."""
        self.hopeless.pop(name, None)
        self.plans.pop(name, None)
        self.regrasped.discard(name)
        self.unknown.discard(name)

    def turned(self, name: str) -> bool:
        """Whether two grasps have to turn an object over for its goal, as things stand."""
        return turned_over(self.asker.workspace, name)

    def _regrasp_helps(self, workspace: Workspace, name: str, iterations: int) -> bool:
        """Whether an object reaches its goal alone by way of another grasp; remembered, for all further tries."""
        if name in self.regrasped:
            return True
        # Wherever what lies flat is put down in between, no hand takes it up again.
        if name not in workspace.goals or lies_flat(workspace, name) or self.asker.stays_unturned(name):
            return False
        movable = {name, *supports_in_the_way(workspace, name)}
        with self.asker.within(REGRASPING):
            solution = self.asker.ask(workspace, iterations, movable, regrasped={name}, about=name)
        if solution.plan is not None:
            self.regrasped.add(name)
            self.plans[name] = solution
        elif solution.status == "failed" and self.turned(name):
            self.asker.unturned[name] = self.asker.workspace.start[name]
        return solution.plan is not None


def turned_over(workspace: Workspace, name: str) -> bool:
    """Whether two grasps have to turn an object over for its goal.

    What is pushed first may turn over by that, and what lies flat is not taken up again by a second grasp.
    """
    if name not in workspace.goals or lies_flat(workspace, name):
        return False
    if to_be_pushed(workspace, name, workspace.start[name]):
        return False
    return upside_down(workspace, name, workspace.goals[name])


LOOKED_AT = 12  # grasps of an object


def clearest_first(
    workspace: Workspace,
    names: Sequence[str],
    samplers: Mapping[str, Callable[..., Any]],
    seed: Callable[[str], int],
    deadline: float,
) -> list[str]:
    """The names, those of objects for which the fewest others have to leave first.

    Arguments as of `in_the_way`, but for a seed for each name.
    """
    if len(names) < 2:
        return [*names]
    return sorted(names, key=lambda name: len(in_the_way(workspace, name, samplers, seed(name), deadline)))


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
        deadline: on the clock of tamp.clock.now() [s].
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
        rng = partial(generator_for, seed, "test-cfree-placements", map(repr, inputs))
        context = Context(workspace, rng, deadline, seed=seed)
        if goal is not None and other != name and not test(context, *inputs):
            return f"{name} would overlap {other}"
    return None


def _overlapping(workspace: Workspace, name: str, goal: Placement, others: Mapping[str, Placement]) -> set[str]:
    return {other for other, place in others.items() if overlap(workspace, name, goal, other, place)}


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
        made = Context(workspace, lambda: generator_for(seed, stream, keys), deadline, seed=seed)
        made.bound = tuple(("AtPose", other, place) for other, place in others.items())
        return made

    start, fewest = workspace.start[name], set(others)
    for grasp in filter(None, islice(samplers["sample-grasp"](context("sample-grasp"), name), LOOKED_AT)):
        ways = samplers["inverse-kinematics"](context("inverse-kinematics", start, grasp), name, start, grasp)
        for _, _, handling in filter(None, islice(ways, 1)):
            fewest = min(fewest, set(handling_hits(workspace, handling, others)), key=len)
        if not fewest:
            break
    return fewest
