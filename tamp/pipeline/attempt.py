"""One attempt to plan from one state."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from tamp.checking import Verdict, check
from tamp.domains.samplers import resolve_samplers
from tamp.domains.tabletop import DEFAULT_SAMPLERS, assemble
from tamp.pipeline.setup import Setup
from tamp.pipeline.situation import observe
from tamp.planning import GroundAction
from tamp.streams.values import Configuration
from tamp.streams.workspace import Workspace
from tamp.task import Plan, Pose

Samplers = Mapping[str, "str | Callable[..., Any]"]


@dataclass(frozen=True, eq=False)
class Attempt:
    """One state to plan from, and how a solution found there becomes a checked plan.

    Attributes:
        setup: the prepared task.
        workspace: what stands where, and where it shall stand.
        samplers: one function for each stream.
        configuration: where the arm is; the hand is empty.
    """

    setup: Setup
    workspace: Workspace
    samplers: Mapping[str, Callable[..., Any]]
    configuration: Configuration

    @staticmethod
    def of(
        setup: Setup,
        poses: Mapping[str, Pose],
        q: tuple[float, ...],
        samplers: Samplers | None,
        deadline: float = math.inf,
    ) -> Attempt:
        """The attempt from objects at rest at `poses` and an empty hand at arm configuration `q` [rad]."""
        situation = observe(setup.task, poses, setup.goals, deadline)
        workspace = Workspace(setup.task, setup.world, situation.start, situation.goals)
        functions = resolve_samplers(DEFAULT_SAMPLERS, setup.task.samplers, samplers or {})
        return Attempt(setup, workspace, functions, Configuration(tuple(q), setup.world.robot.spec.gripper.stroke))

    def finish(self, actions: Sequence[GroundAction], seed: int, report: Mapping[str, Any]) -> tuple[Plan, Verdict]:
        """Time a solution and have it checked.

        Args:
            actions: the planner's ground actions.
            seed: recorded in the plan.
            report: recorded in the plan.

        Raises:
            NotFree: where a timed motion cannot keep clear.
        """
        task, start = self.setup.task, {name: place.pose for name, place in self.workspace.start.items()}
        goals = {name: place.pose for name, place in self.workspace.goals.items()}
        timed = assemble(self.workspace, actions)
        found = Plan(task.name, task.robot, seed, start, self.configuration.q, goals, timed, report)
        return found, check(task, found, start=start, goals=goals)
