"""Does what a plan lets go come to rest where the plan says, wherever the checker would let it be let go?

The robot is left out: the object is let fall from near where the plan releases it, in the simulator, among all others
as the plan has them. It starts a little aside, higher and turned, within what the checker allows a grip to be off.
Where it comes to rest elsewhere from some of these places, as a ball does in a bowl that is wide for it, or a pen that
leans on the rim of a holder, no plan could say where it ends.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from tamp.checking import Tolerances
from tamp.checking.robot.links import read_links
from tamp.execution.settling.settle import let_fall
from tamp.execution.simulators import DEFAULT
from tamp.scoring.ede import ede, mean_edge
from tamp.task import Fall, Move, Plan, Pose, Release, Task, load_robot

DRAWS = 24
"""Places from which it is let fall."""


def spread(task: Task, plan: Plan, index: int, simulator: str = DEFAULT) -> list[float]:
    """How far from where the plan has it the object that an action lets go comes to rest, from each place [m].

    Infinite where it still moves after a while; nothing where the action lets nothing go.

    Args:
        task: the objects.
        plan: what is to be done.
        index: of the action.
        simulator: its name.
    """
    before, after = list(expected(plan))[index : index + 2]
    held = None
    for step in plan.actions[index].steps:
        if isinstance(step, Release) and held is not None:
            name, T = held
            thing = task.object(name)
            ends = (
                let_fall(task.objects, {**before, name: near}, table=task.table, simulator=simulator)
                for near in _near(T, index)
            )
            return [math.inf if end is None else ede(mean_edge(thing.shape), end[name], after[name]) for end in ends]
        if isinstance(step, Move) and step.held is not None:
            tool = read_links(load_robot(plan.robot)).tree.tool(step.trajectory.positions[-1:])[0]
            held = step.held.object, Pose.from_matrix(tool) @ step.held.T_tool_object
    return []


def _near(pose: Pose, seed: int) -> Iterator[Pose]:
    """Poses that are off by up to what a grip may be off, and never lower."""
    allow, rng = Tolerances(), np.random.default_rng(seed)
    for _ in range(DRAWS):
        aside, turn = (rng.uniform(-1.0, 1.0, 3) * bound for bound in (allow.grasp, allow.grasp_angle))
        x, y, z = pose.xyz
        yield Pose(
            (x + aside[0], y + aside[1], z + abs(aside[2])),
            (Pose.from_rpy((0.0, 0.0, 0.0), tuple(turn)) @ Pose(quat=pose.quat)).quat,
        )


def expected(plan: Plan) -> Iterator[Mapping[str, Pose]]:
    """Where the plan has every object at the start and after each of its actions; what is held where it was taken."""
    poses, tree = dict(plan.start), read_links(load_robot(plan.robot)).tree
    yield dict(poses)
    for action in plan.actions:
        for step in action.steps:
            if isinstance(step, Release | Fall):
                poses[step.object] = step.pose
            elif isinstance(step, Move) and step.pushed is not None:
                tool = tree.tool(np.array(step.trajectory.positions[-1:]))[0]
                poses[step.pushed.object] = Pose.from_matrix(tool) @ step.pushed.T_tool_object
        yield dict(poses)
