"""The arm in the scene that a call is about: where everything stands then, and what the hand holds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from tamp.streams.values import Configuration, Grasp
from tamp.streams.workspace import Workspace, standing
from tamp.world.collision.checker import CollisionChecker
from tamp.world.scene import Scene


def arm_checker(
    workspace: Workspace, inputs: Sequence[Any], fluents: Sequence[Any], *, margin: float
) -> CollisionChecker:
    """The collision check of the arm in the scene of a call.

    Args:
        workspace: objects, table and robot.
        inputs: what the sampler was called with: a grasp among them holds the object that is named there, the hand is
            otherwise as wide open as all configurations allow.
        fluents: the facts that the sampler was told, which say where everything stands.
        margin: least distance to everything [m]; a negative one tolerates so much penetration.
    """
    poses = {name: placement.pose.matrix for name, placement in standing(fluents).items()}
    openings = [value.opening for value in inputs if isinstance(value, Configuration)]
    scene = Scene(poses, opening=min(openings, default=0.0))
    grasp = next((value for value in inputs if isinstance(value, Grasp)), None)
    held = next((value for value in inputs if isinstance(value, str) and value in workspace.world.geometries), None)
    if grasp is not None and held is not None:
        scene = scene.attached(held, grasp.T_object_tool.inverse().matrix, grasp.width)
    return workspace.world.checker(scene, margin=margin)
