"""The pairwise collision test of placements, may two objects stand there together, and how close is close enough."""

from __future__ import annotations

from tamp.streams.context import Context
from tamp.streams.values import Placement
from tamp.streams.workspace import Workspace

CONTACT_DEPTH = 0.003  # what settled together touches; what overlaps deeper collides [m]
SUNK = 0.0018  # the same where both are convex, and no pieces bulge [m]
GRAZED = 0.001  # the same of what did not: it would be set down on what is beside its place [m]
SCRAPED = 0.0008  # deeper than where it rests what touches may be as it leaves and as it comes [m]
BESIDE = 0.002  # what an object at rest is nearer to than this it touches as it leaves and as it comes [m]
ARM_MARGIN = 0.002  # the arm and the hand stay clear of everything by this [m]


def test_cfree_placements(context: Context, obj: str, placement: Placement, other: str, standing: Placement) -> bool:
    """Whether two objects can stand at these placements together."""
    workspace: Workspace = context.scene
    if obj == other or _apart(workspace, obj, placement, other, standing):
        return True
    if overlap(workspace, obj, placement, other, standing):
        context.fail(f"{obj} would overlap {other}")
        return False
    return True


def overlap(workspace: Workspace, obj: str, placement: Placement, other: str, standing: Placement) -> bool:
    """Whether two objects would be in each other at these placements."""
    here, there = (
        places.get(obj) == placement and places.get(other) == standing
        for places in (workspace.start, {**workspace.start, **workspace.goals})
    )
    near = here or there or other in placement.on or obj in standing.on
    convex = all(len(workspace.world.geometries[name].parts) == 1 for name in (obj, other))
    depth = (SUNK if convex and not here else CONTACT_DEPTH) if near else GRAZED
    T, T_other = placement.pose.matrix, standing.pose.matrix
    if workspace.world.overlap(obj, T, other, T_other, tolerance=depth):
        return True
    return not here and workspace.world.crossed(obj, T, other, T_other)


def _apart(workspace: Workspace, obj: str, placement: Placement, other: str, standing: Placement) -> bool:
    """Whether the boxes around two objects do not meet, which settles it for most."""
    lower, upper = workspace.bounds(obj, placement.pose)
    low, high = workspace.bounds(other, standing.pose)
    return bool((lower > high).any() or (low > upper).any())
