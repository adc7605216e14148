"""Whether objects stay at their goals before all others are at theirs, and where they are put if they do not."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from tamp.pipeline.strategies.serialization.nearest_placement import bring_to_rest, rest_from_goal
from tamp.pipeline.strategies.subproblems.goal_graph import Placements, away, goal_supports, surroundings, under_goal
from tamp.pipeline.strategies.subproblems.partial_plan import SHIFTED
from tamp.pipeline.strategies.subproblems.subproblem import Asker, Effort
from tamp.scoring.ede import ede, mean_edge
from tamp.streams.affordances.friction_cones import in_equilibrium
from tamp.streams.affordances.neighbours import within
from tamp.streams.affordances.stable_poses import rolls
from tamp.streams.affordances.stack_balance import tips_with
from tamp.streams.affordances.support import stands_on
from tamp.streams.workspace import TABLE, Workspace

FALLS = 0.03  # what comes to rest so far from its goal (EDE) does not stay there [m]
FELT = 0.003  # surface so near to another body touches it: the checker counts on no more [m]


class GoalStability:
    """What physics says of single goals in one search.

    Args:
        asker: the plan so far, whose workspace says what stands where by now.
        reached: names of objects that are at their goals, kept up to date by the search.
    """

    def __init__(self, asker: Asker, reached: Collection[str]) -> None:
        self._asker = asker
        self._reached = reached
        self._rested: dict[tuple[str, Effort], Placements] = {}
        self._fallen: dict[str, Placements] = {}

    def uncertain(self, name: str) -> bool:
        """Whether only physics tells if an object stays at its goal before all others are at theirs.

        It may be in balance by a little only, or lie so that it would roll on, and what carries it may stand otherwise
        than where the goals settled.
        """
        workspace, settled = self._asker.workspace, self._asker.progress.now.setup.goals
        if name not in workspace.goals:
            return False
        under = {lower: workspace.start[lower] for lower in goal_supports(workspace, name)}
        edges = {lower: mean_edge(workspace.task.object(lower).shape) for lower in under}
        if any(ede(edges[lower], place.pose, settled[lower].pose) > SHIFTED for lower, place in under.items()):
            return True
        goal, geometry = workspace.goals[name], workspace.world.geometries[name]
        turns = rolls(geometry, goal.pose.matrix[:3, :3]) or not stands_on(workspace, name, goal, under)
        return turns or not self.stays(name)

    def stays(self, name: str, *, others_move: bool = False) -> bool:
        """Whether the checker has an object stay that is let go at its goal, with all that stands there by now.

        Goals are at rest together, by physics; by what the checker knows for certain a few never are.
        `others_move`: whether what is not at its goal may leave before.
        """
        now, workspace = self._asker.progress.now, self._asker.workspace
        start, goals = workspace.start, workspace.goals
        if others_move:
            start = {other: place for other, place in start.items() if goals.get(other, place) == place}
        return name not in goals or replace(now, workspace=replace(workspace, start=start)).stays(name, goals[name])

    def falls(self, name: str) -> bool:
        """Whether an object is known to fall from its goal, or to go on, with all that stands there by now."""
        return self._fallen.get(name) == surroundings(self._asker.workspace, name)

    def always_tips(self, name: str) -> bool:
        """Whether an object tips what it rests on at its goal, whatever comes to its own goal before it."""
        goal = self._asker.workspace.goals.get(name)
        return goal is not None and goal.on != (TABLE,) and tips_with(self._before_its_load(name), name, goal)

    def never_stays(self, name: str) -> bool:
        """Whether an object always tips at its goal, or the checker never has it stay, whatever comes before it."""
        goal = self._asker.workspace.goals.get(name)
        if goal is None or self.always_tips(name):
            return goal is not None
        return not replace(self._asker.progress.now, workspace=self._before_its_load(name)).stays(name, goal)

    def _before_its_load(self, name: str) -> Workspace:
        """All others at their goals but for what rests on an object there: only those could hold it."""
        workspace = self._asker.workspace
        upon = {other for other in workspace.goals if name in under_goal(workspace, other)}
        others = {**workspace.start, **workspace.goals}
        return replace(workspace, start={other: others[other] for other in others.keys() - upon})

    def brought_to_rest(self, name: str, turned: Collection[str], effort: Effort) -> bool:
        """Put an object to where it comes to rest from its goal, if that is near; whether it was.

        That is tried once with each effort for each way in which others stand there. What falls waits for a change, and
        so does what goes on: for others that may hold it, and do not rest on it, where they need not be moved for it.
        """
        here = surroundings(self._asker.workspace, name)
        if self._rested.get((name, effort)) == here:
            return False
        self._rested[name, effort] = here
        there = rest_from_goal(self._asker, name)
        if there is None:
            return False
        goes_on = not self.stays(name)
        resting = {other for other, goal in there.goals.items() if name in goal.on}
        waits = goes_on and not effort.others_move and self.awaited(name, resting)
        if not waits and bring_to_rest(self._asker, name, there, self._reached, turned, effort):
            return True
        if goes_on or away(there, name) > FALLS or (self.awaited(name) and not _is_held(there, name)):
            self._fallen[name] = here
        return False

    def awaited(self, name: str, but: Collection[str] = ()) -> bool:
        """Whether another object is still to come to where it may hold an object at its goal."""
        workspace = self._asker.workspace
        near = within(workspace, name, FELT, workspace.goals[name]).goals
        return any(other not in (name, *but) and workspace.start[other] != goal for other, goal in near.items())


def _is_held(workspace: Workspace, name: str) -> bool:
    """Whether what an object is felt to touch where it stands holds it there, by forces within friction."""
    others = {other: place for other, place in workspace.start.items() if other != name}
    return in_equilibrium(workspace, {name: workspace.start[name]}, others, near=FELT)
