"""Which goals a plan in the making has reached, which it leaves and why, and what counts as there for being near."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from tamp.pipeline.asking import Asker
from tamp.pipeline.goals import away, goal_names, nearly_there, supports_first
from tamp.pipeline.situation import left_at
from tamp.scoring.score import SOLVED_WITHIN_M
from tamp.streams.enclosed import enclosed
from tamp.streams.topples import to_be_pushed


@dataclass
class Ledger:
    """The goals of a plan in the making.

    Attributes:
        asker: the plan so far.
        left: objects whose goals it does not reach -> why.
        reached: the others with a goal.
    """

    asker: Asker
    left: dict[str, str] = field(init=False)
    reached: set[str] = field(default_factory=set)

    def __post_init__(self) -> None:
        self.left = dict.fromkeys(goal_names(self.asker.workspace), "no time was left to plan for it")

    def reach(self, name: str) -> None:
        """Count an object as there."""
        del self.left[name]
        self.reached.add(name)

    def reach_near(self, names: Sequence[str]) -> bool:
        """Let objects that cannot be brought nearer count as there if their goals are near; others may rest on them."""
        before = len(self.left)
        for name in supports_first(self.asker.workspace, names):
            workspace = self.asker.workspace
            if nearly_there(workspace, name):
                goals = {**workspace.goals, **left_at(workspace.goals, name, workspace.start[name])}
                progress = self.asker.progress
                progress.now = replace(progress.now, workspace=replace(workspace, goals=goals))
                self.reach(name)
        return len(self.left) < before

    def reach_hard_to_grasp(self) -> None:
        """Let what is near its goal count as there while others are far from theirs, if it is hard to get hold of.

        It takes long to find hands that have room in a container, or ways to the table's edge for what no hand can
        grasp as it lies, and less is gained.
        """
        workspace = self.asker.workspace
        if any(away(workspace, name) > SOLVED_WITHIN_M for name in self.left if name in workspace.goals):
            places = [(workspace, name, workspace.start[name]) for name in self.left]
            self.reach_near([place[1] for place in places if enclosed(*place) or to_be_pushed(*place)])
