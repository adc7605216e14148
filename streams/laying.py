"""Release before the end: an object that the hand cannot bring all the way is let go, and falls what is left of it.

One too wide to be put down flat is set on one edge, with the hand at the side that is up, and falls flat; one that
shall lie in something is let go above it and falls straight down. The shortest fall that leaves room for the hand
comes first.
"""

from __future__ import annotations

import time
from collections.abc import Iterator

from tamp.streams.clearance import beneath, hand_hits, opening_for, standing_around
from tamp.streams.dropping import drops
from tamp.streams.reachability import handlings
from tamp.streams.tilting import Tilt, layable, tilts
from tamp.streams.values import Configuration, Grasp, Handling, Placement
from tamp.streams.workspace import TABLE, Context, Workspace
from tamp.task import Pose
from tamp.world.scene import Scene

ON_EDGE = 0.004  # the edge is at most this far above what it is set on [m]


def plan_laying(
    context: Context, obj: str, placement: Placement, grasp: Grasp
) -> Iterator[tuple[Configuration, Configuration, Handling]]:
    """Yield (approach configuration, lift configuration, handling) that let an object fall to a placement.

    Read as those of `inverse_kinematics`: the handling ends where the object is let go.
    """
    workspace: Workspace = context.scene
    ways = list(drops(workspace, obj, placement))
    if layable(workspace, obj, placement):
        ways += [tilt.fall for tilt in tilts(workspace, obj, placement) if _on_edge(workspace, obj, placement, tilt)]
    roomy = [fall for fall in ways if _room(workspace, obj, placement, grasp, fall[0])]
    if not roomy:
        context.fail(f"the hand would hit what {obj} falls on" if ways else f"{obj} cannot be set on an edge there")
    for fall in roomy:
        if time.monotonic() > context.deadline:
            return
        yield from handlings(context, obj, placement, grasp, fall)


def _on_edge(workspace: Workspace, obj: str, placement: Placement, tilt: Tilt) -> bool:
    """Whether the tilted object touches what it is to lie on."""
    if TABLE in placement.on:
        return True
    around, T = standing_around(workspace, obj, placement), tilt.fall[0].matrix
    supports = [(name, around[name].pose.matrix) for name in placement.on if name in around]
    return any(workspace.world.separation(obj, T, name, T_support) < ON_EDGE for name, T_support in supports)


def _room(workspace: Workspace, obj: str, placement: Placement, grasp: Grasp, let_go: Pose) -> bool:
    """Whether the open hand is clear of the table and of what the object is to lie on or in."""
    around = standing_around(workspace, obj, placement)
    supports = Scene(poses={name: around[name].pose.matrix for name in beneath(placement, around)})
    opening = opening_for(workspace.world.robot.spec.gripper, grasp)
    return not hand_hits(workspace, let_go.matrix @ grasp.T_object_tool.matrix, opening, supports)
