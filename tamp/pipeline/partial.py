"""As much of a task as can be done: goals one after the other, each kept once it is reached.

When no plan for all goals is found in time, one object may be to blame. Then the goals are taken one at a time, from
the state that the plan so far would leave, with all goals reached before; those that find no plan are left for last
and tried again as long as others make progress.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from tamp.domains.tabletop import tabletop_problem
from tamp.planning import GroundAction, Solution
from tamp.planning import solve as solve_problem
from tamp.streams.values import Configuration, Placement
from tamp.streams.workspace import Workspace
from tamp.task import In, On


@dataclass(frozen=True)
class PartialSolution:
    """Ground actions that reach some of the goals.

    Attributes:
        actions: in order.
        left: object -> why its goal is not among them.
    """

    actions: tuple[GroundAction, ...]
    left: Mapping[str, str]


def solve_partly(
    workspace: Workspace,
    samplers: Mapping[str, Callable[..., Any]],
    configuration: Configuration,
    *,
    seed: int,
    deadline: float,
    algorithm: str,
) -> PartialSolution:
    """Reach as many goals as possible, one at a time.

    Args:
        workspace: what stands where, and where it shall stand.
        samplers: one function for each stream.
        configuration: where the arm is.
        seed: decides every random choice.
        deadline: on the clock of time.monotonic [s].
        algorithm: of the stream planner.
    """
    actions: list[GroundAction] = []
    start, reached = dict(workspace.start), set[str]()
    waiting = [obj.name for obj in workspace.task.objects if obj.goal is not None]
    left: dict[str, str] = {}
    progress = True
    while waiting and progress:
        progress = False
        for name in _supports_first(workspace, waiting):
            missing = [lower for lower in _goal_supports(workspace, name) if start[lower] != workspace.goals[lower]]
            if missing:
                left[name] = f"its goal rests on {missing[0]}, which is not at its own"
                continue
            now = _restricted(workspace, start, reached | {name})
            limit = (deadline - time.monotonic()) / len(waiting)
            if limit <= 0:
                left.setdefault(name, "no time was left to plan for it")
                continue
            problem = tabletop_problem(now, samplers, configuration)
            solution = solve_problem(problem, algorithm=algorithm, timeout=limit, seed=seed)
            if solution.plan is None:
                left[name] = _reason(solution)
                continue
            actions += solution.plan
            start, configuration = _after(start, configuration, solution.plan)
            reached.add(name)
            waiting.remove(name)
            left.pop(name, None)
            progress = True
    return PartialSolution(tuple(actions), left)


def _goal_supports(workspace: Workspace, name: str) -> list[str]:
    """Objects with goal poses that the goal pose of an object rests on."""
    return [lower for lower in workspace.goals[name].on if lower in workspace.goals] if name in workspace.goals else []


def _supports_first(workspace: Workspace, names: list[str]) -> list[str]:
    """Goals in an order in which what others rest on comes before them."""
    below: dict[str, tuple[str, ...]] = {name: place.on for name, place in workspace.goals.items()}
    for obj in workspace.task.objects:
        if isinstance(obj.goal, On | In):
            below[obj.name] = (obj.goal.target,)

    def height(name: str) -> int:
        return 1 + max((height(lower) for lower in below.get(name, ()) if lower in below), default=0)

    return sorted(names, key=height)


def _restricted(workspace: Workspace, start: Mapping[str, Placement], names: set[str]) -> Workspace:
    """The workspace with only some objects' goals left."""
    objects = tuple(obj if obj.name in names else replace(obj, goal=None) for obj in workspace.task.objects)
    goals = {name: place for name, place in workspace.goals.items() if name in names}
    return Workspace(replace(workspace.task, objects=objects), workspace.world, dict(start), goals, workspace.memory)


def _after(
    start: Mapping[str, Placement], configuration: Configuration, plan: tuple[GroundAction, ...]
) -> tuple[dict[str, Placement], Configuration]:
    """Where objects and arm are when a plan has been carried out."""
    placements = dict(start)
    for action in plan:
        if action.name in ("place", "stack", "lay", "lay-on"):
            handling = action.args[-1]
            placements[handling.object] = handling.placement
            configuration = action.args[-3]
        elif action.name == "move-free":
            configuration = action.args[1]
    return placements, configuration


def _reason(solution: Solution) -> str:
    """Where the skeleton that was tried most broke; without one, the commonest failure of any stream; in words."""
    broken = [skeleton for skeleton in solution.report.skeletons if skeleton.reason]
    if broken:
        most = max(broken, key=lambda skeleton: skeleton.attempts)
        return f"{solution.status}; {most.broke_at}: {most.reason}"
    streams = [s for s in solution.report.streams if s.failures]
    if not streams:
        return solution.status
    worst = max(streams, key=lambda s: s.failures[0][1])
    return f"{solution.status}; {worst.name}: {worst.failures[0][0]}"
