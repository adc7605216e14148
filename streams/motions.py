"""Collision-free motions between two configurations, empty-handed or holding, in the scene as it is by then."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any

import numpy as np

from tamp.streams.values import ArmPath, Configuration, Grasp
from tamp.streams.workspace import Context, Workspace, standing
from tamp.world.motion import plan_motion
from tamp.world.scene import Scene

MARGIN = 0.002  # kept between the moving arm and everything else [m]
ITERATIONS = 3000  # a query that OMPL has not answered by then is given up for this state


def plan_free_motion(context: Context, start: Configuration, goal: Configuration) -> Iterator[ArmPath]:
    """Yield a path of the empty-handed arm among the objects as they stand in `context.fluents`."""
    # The fingers close to the narrower opening before the motion and open to the other one after it.
    scene = Scene(poses=_poses(context), opening=min(start.opening, goal.opening))
    yield from _paths(context, scene, start, goal)


def plan_holding_motion(
    context: Context, obj: str, grasp: Grasp, start: Configuration, goal: Configuration
) -> Iterator[ArmPath]:
    """Yield a path of the arm holding `obj` among the objects as they stand in `context.fluents`."""
    poses = {name: T for name, T in _poses(context).items() if name != obj}
    scene = Scene(poses=poses).attached(obj, grasp.T_object_tool.inverse().matrix, grasp.width)
    yield from _paths(context, scene, start, goal)


def _poses(context: Context) -> dict[str, Any]:
    placed = standing(context.fluents)
    return {name: placed[name].pose.matrix for name in sorted(placed)}


def _paths(context: Context, scene: Scene, start: Configuration, goal: Configuration) -> Iterator[ArmPath]:
    workspace: Workspace = context.scene
    robot = workspace.world.robot
    checker = workspace.world.checker(scene, margin=MARGIN, held_margin=MARGIN)
    ends = np.asarray(start.q), np.asarray(goal.q)
    budget = context.deadline - time.monotonic()
    if budget <= 0:
        return
    seed = int(context.rng.integers(2**31))
    result = plan_motion(checker, robot.lower, robot.upper, *ends, seed=seed, timeout=budget, iterations=ITERATIONS)
    if result.path is not None:
        yield ArmPath(result.path)
        return
    touched = {name for q in ends if (contact := checker.contact(q)) for name in (contact.a, contact.b)}
    context.fail(result.reason, because=[fact for fact in context.fluents if fact[1] in touched])
