"""What stands on what in a scene at rest, which goals are fulfilled, and what goals mean where supports are off."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from tamp.scoring.ede import ede, mean_edge
from tamp.streams.affordances.stable_poses import BALANCE
from tamp.streams.affordances.stack_balance import at_rest, pile_of
from tamp.streams.affordances.support import inside_support
from tamp.streams.collisions import CONTACT_DEPTH
from tamp.streams.placing.sampler import RELEASE_HEIGHT
from tamp.streams.values import Placement
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import Pose
from tamp.world.transforms import rotation

TOUCHING = 0.003  # what is nearer than this carries [m]
SAME_PLACE = 0.01  # an object this near to its goal (EDE) counts as being there [m]


def placements(poses: Mapping[str, Pose], supports: Iterable[tuple[str, str]]) -> dict[str, Placement]:
    """Placements from poses and (above, below) pairs, in which nothing rests on itself by way of others."""
    below: dict[str, set[str]] = {name: set() for name in poses}
    for upper, lower in supports:
        if upper in below:
            below[upper].add(lower)
    kept = _without_rings(below)
    return {name: Placement(pose, tuple(sorted(kept[name])) or (TABLE,)) for name, pose in poses.items()}


def _without_rings(below: Mapping[str, set[str]]) -> Mapping[str, set[str]]:
    """The same where nothing rests on itself: what stands on something outside of a ring is not carried by the ring."""
    while True:
        ring = {name: {low for low in lows if name in _all_below(below, low)} for name, lows in below.items()}
        if not any(ring.values()):
            return below
        carried = {name for name, inside in ring.items() if inside and below[name] > inside}
        freed = carried or ring.keys()
        below = {name: lows - ring[name] if name in freed else lows for name, lows in below.items()}


def _all_below(below: Mapping[str, set[str]], name: str) -> set[str]:
    """Everything that `name` rests on, directly or through others."""
    found: set[str] = set()
    waiting = [name]
    while waiting:
        for lower in below.get(waiting.pop(), ()):
            if lower not in found:
                found.add(lower)
                waiting.append(lower)
    return found


def raised(placement: Placement, height: float = RELEASE_HEIGHT) -> Placement:
    """A placement a little above where an object rests, from where it is let go."""
    x, y, z = placement.pose.xyz
    return replace(placement, pose=Pose((x, y, z + height), placement.pose.quat))


def already_there(workspace: Workspace) -> Workspace:
    """The workspace with the start itself in place of every goal that is fulfilled and rests on what stays."""
    waiting = [name for name in workspace.goals if _near(workspace, name)]
    changed = True
    while changed:
        changed = False
        for name in list(waiting):
            start, goals = workspace.start, workspace.goals
            supports = [lower for lower in goals[name].on if lower != TABLE]
            if all(goals.get(lower, start[lower]) == start[lower] for lower in supports):
                workspace = left_at(workspace, name)
                waiting.remove(name)
                changed = True
    return workspace


def _near(workspace: Workspace, name: str) -> bool:
    here, there = workspace.start[name], workspace.goals[name]
    edge = mean_edge(workspace.task.object(name).shape)
    return here.on == there.on and ede(edge, here.pose, there.pose) < SAME_PLACE


def left_at(workspace: Workspace, name: str) -> Workspace:
    """The workspace with an object's start as its goal, and with what that means for the goals of what rests on it.

    Where it lies flat on what is a little off, an object keeps its own place. Stacked plates and nested bowls fit
    closely: where the lower one stands a centimetre off, the upper one would have to stand in its wall. It shifts as
    much as what it rests on, and so does what could not stay at rest otherwise.
    """
    start, goals = workspace.start, workspace.goals
    shift = start[name].pose @ raised(goals[name], -RELEASE_HEIGHT).pose.inverse()
    meant, above = {name: start[name]}, [name]
    while above:
        above = [other for other in goals if other not in meant and meant.keys() >= {*goals[other].on}]
        for other in above:
            own = replace(goals[other], pose=_not_aside(shift, goals[other].pose))
            kept = _carried(workspace, other, {**goals, **meant, other: own})
            meant[other] = own if kept else replace(goals[other], pose=shift @ goals[other].pose)
    meant |= {
        other: _touched(workspace, other, goals[other], meant)
        for other in goals.keys() - meant.keys()
        if not meant.keys().isdisjoint(goals[other].on)
    }
    return replace(workspace, goals={**goals, **meant})


def _touched(workspace: Workspace, name: str, goal: Placement, meant: Mapping[str, Placement]) -> Placement:
    """A goal without what would carry an object there and is off now, so that the object does not touch it any more."""
    T, world = raised(goal, -RELEASE_HEIGHT).pose.matrix, workspace.world
    on = tuple(
        lower
        for lower in goal.on
        if lower not in meant or world.separation(name, T, lower, meant[lower].pose.matrix) < TOUCHING
    )
    return goal if on in ((), goal.on) else replace(goal, on=on)


def _not_aside(shift: Pose, pose: Pose) -> Pose:
    """A pose after what a shift does to the level and the slope of the plane it stands on, where it is seen from above.

    It neither moves aside nor turns about the vertical.
    """
    R, goal, shifted = shift.matrix[:3, :3], pose.matrix, (shift @ pose).matrix
    yaw = np.arctan2(R[1, 0] - R[0, 1], R[0, 0] + R[1, 1])
    tilt = R @ rotation(np.array([0.0, 0.0, 1.0]), -float(yaw))
    aside = goal[:2, 3] - shifted[:2, 3]
    result = np.eye(4)
    result[:3, :3] = tilt @ goal[:3, :3]
    result[:3, 3] = *goal[:2, 3], shifted[2, 3] - float(R[:2, 2] @ aside) / float(R[2, 2])
    return Pose.from_matrix(result)


def _carried(workspace: Workspace, name: str, places: Mapping[str, Placement]) -> bool:
    """Whether an object stays at its place on what is below it there, together with what shall rest on it."""
    place = places[name]
    below = {lower: places[lower] for lower in place.on}
    T, world = place.pose.matrix, workspace.world
    if any(world.overlap(name, T, lower, at.pose.matrix, tolerance=CONTACT_DEPTH) for lower, at in below.items()):
        return False
    pile = {other: places[other] for other in sorted(pile_of(name, places))}
    return inside_support(workspace, name, place, below) > BALANCE and at_rest(workspace, pile)
