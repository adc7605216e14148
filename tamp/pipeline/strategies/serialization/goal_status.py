"""The goals of a plan in the making: which are reached, which are left and why, and which count as there."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

from tamp import clock
from tamp.pipeline.situation import left_at
from tamp.pipeline.strategies.serialization.feasibility import Prospects
from tamp.pipeline.strategies.serialization.nearest_placement import bring_near
from tamp.pipeline.strategies.subproblems.goal_graph import all_goals, away, goal_names, nearly_there, supports_first
from tamp.pipeline.strategies.subproblems.subproblem import Asker
from tamp.scoring.score import SOLVED_WITHIN_M
from tamp.streams.affordances.neighbours import enclosed
from tamp.streams.affordances.topple_path import to_be_pushed

WAITS = "no time was left to plan for it"  # what is said of a goal until it is tried


@dataclass
class GoalStatus:
    """The goals of a plan in the making.

    Attributes:
        asker: the plan so far.
        unsteady: objects that did not end where they were put.
        left: objects whose goals it does not reach -> why.
        facts: symbolic goals that it does not reach, as PDDL writes them -> why.
        reached: the other objects with a goal.
    """

    asker: Asker
    unsteady: Collection[str] = ()
    left: dict[str, str] = field(init=False)
    facts: dict[str, str] = field(init=False)
    reached: set[str] = field(default_factory=set)

    def __post_init__(self) -> None:
        self.left = dict.fromkeys(goal_names(self.asker.workspace), WAITS)
        self.facts = {name: WAITS for name in all_goals(self.asker.workspace) if name not in self.left}

    def restart(self) -> None:
        """Count nothing as reached but what is at its goal pose."""
        workspace = self.asker.workspace
        there = {name for name, goal in workspace.goals.items() if workspace.start[name] == goal}
        names = goal_names(workspace)
        self.resume({name: WAITS for name in names if name not in there}, there.intersection(names))

    def resume(self, left: Mapping[str, str], reached: Collection[str]) -> None:
        """Count again as reached, and as left, what was so before."""
        self.left.clear()
        self.left.update(left)
        self.reached.clear()
        self.reached.update(reached)

    def clear(self) -> None:
        """Count everything as reached."""
        self.left.clear()
        self.facts.clear()

    def reach(self, name: str) -> None:
        """Count an object as there."""
        del self.left[name]
        self.reached.add(name)

    def reach_near(self, names: Sequence[str]) -> bool:
        """Let objects that cannot be brought nearer count as there if their goals are near; others may rest on them.

        What is unsteady may have slid off what it shall rest on.
        """
        before = len(self.left)
        for name in supports_first(self.asker.workspace, names):
            workspace = self.asker.workspace
            if nearly_there(workspace, name, slid=name in self.unsteady):
                progress = self.asker.progress
                progress.now = replace(progress.now, workspace=left_at(workspace, name))
                self.reach(name)
        return len(self.left) < before

    def reach_troublesome(self) -> None:
        """Let what is near its goal count as there while others are far from theirs, if it is hard to get there.

        It takes long to find hands that have room in a container, or ways to the table's edge for what no hand can
        grasp as it lies, and less is gained. What is unsteady would be put there again and again before the others.
        """
        workspace = self.asker.workspace
        if any(away(workspace, name) > SOLVED_WITHIN_M for name in self.left if name in workspace.goals):
            places = [(workspace, name, workspace.start[name]) for name in self.left]
            self.reach_near([p[1] for p in places if p[1] in self.unsteady or enclosed(*p) or to_be_pushed(*p)])


FAR = 0.15  # from its goal (EDE) is what is brought near before all else was tried [m]


@dataclass
class BroughtNear:
    """Objects without hope, or without the time that it takes to tell, each brought near once.

    Where such a one lies near its goal, among others, hands have less room to take it up again than where it was.

    Attributes:
        prospects: tell who has no hope.
        since: when anything may be brought merely near, on the clock of tamp.clock.now() [s].
    """

    prospects: Prospects
    since: float = math.inf
    _tried: set[str] = field(default_factory=set)

    def bring(self, name: str, left: Collection[str], kept: Collection[str]) -> bool:
        """Bring an object near if it has no hope and is far, but not to where those shall be that have; whether it was.

        Args:
            name: the object.
            left: all objects that are not at their goals.
            kept: objects that must stay at theirs.
        """
        asker = self.prospects.asker
        goals, hopeless = asker.workspace.goals.keys(), self.prospects.beyond_hope(left) | self.prospects.unknown
        if clock.now() < self.since or name not in hopeless & goals - self._tried:
            return False
        self._tried.add(name)
        return away(asker.workspace, name) > FAR and bring_near(asker, {name}, kept, (goals & {*left}) - hopeless)
