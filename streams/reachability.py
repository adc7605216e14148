"""Inverse kinematics: how the arm reaches for a placed object, takes it and lifts it."""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np

from tamp.streams.collisions import ARM_MARGIN, handling_contact
from tamp.streams.grasps import opening_for
from tamp.streams.values import Configuration, Grasp, Handling, Placement
from tamp.streams.workspace import Context, Workspace
from tamp.world.kinematics import inverse, straight_line
from tamp.world.scene import Scene

APPROACHES = (0.08, 0.05, 0.12)  # how far back along the tool's axis the hand starts [m]
LIFTS = (0.08, 0.15, 0.04)  # how far up the object is carried off [m]
SOLUTIONS = 4  # arm configurations tried for one grasp


def inverse_kinematics(
    context: Context, obj: str, placement: Placement, grasp: Grasp
) -> Iterator[tuple[Configuration, Configuration, Handling]]:
    """Yield (approach configuration, lift configuration, handling) for an object held by a grasp at a placement.

    Each handling is free of collision with the table, the robot itself and the object; other objects are left to
    `test-cfree-handling`, since they may have moved by then.
    """
    workspace: Workspace = context.scene
    world = workspace.world
    T_world_tool = placement.pose.matrix @ grasp.T_object_tool.matrix
    opening = opening_for(world.robot.spec.gripper, grasp)
    alone = Scene(poses={obj: placement.pose.matrix}, opening=opening)
    blocked = world.hand_contact(T_world_tool, opening, alone, margin=ARM_MARGIN, ignore=(obj,))
    if blocked is not None:
        context.fail(f"the hand would hit {blocked}")
        return
    found = False
    for q in inverse(world.robot, T_world_tool, context.rng, count=SOLUTIONS):
        if time.monotonic() > context.deadline:
            return
        found = True
        handling = _handling(context, workspace, obj, placement, grasp, opening, np.asarray(q))
        if handling is not None:
            approach = Configuration(tuple(handling.approach[0].tolist()), opening)
            lift = Configuration(tuple(handling.lift[-1].tolist()), grasp.width)
            yield approach, lift, handling
    if not found:
        context.fail("no inverse kinematics")


def _handling(
    context: Context,
    workspace: Workspace,
    obj: str,
    placement: Placement,
    grasp: Grasp,
    opening: float,
    q: np.ndarray,
) -> Handling | None:
    """Straight approach and lift through one arm configuration; None (and the reason told) where there is none."""
    robot = workspace.world.robot
    T_grasp = robot.forward(q)
    reason = "the approach leaves the joint limits"
    for back in APPROACHES:
        T_back = T_grasp.copy()
        T_back[:3, 3] -= back * T_grasp[:3, 2]
        retreat = straight_line(robot, q, T_back)
        if retreat is None:
            continue
        for up in LIFTS:
            T_up = T_grasp.copy()
            T_up[2, 3] += up
            lift = straight_line(robot, q, T_up)
            if lift is None:
                reason = "the lift leaves the joint limits"
                continue
            handling = Handling(obj, placement, grasp, opening, retreat[::-1], lift)
            contact = handling_contact(workspace, handling, {})
            if contact is None:
                return handling
            reason = contact
    context.fail(reason)
    return None
