"""Inverse kinematics: how the arm reaches for a placed object, takes it and lifts it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.affordances.neighbours import carriers, upon_carriers
from tamp.streams.cache import SampleCache, recalled
from tamp.streams.collisions import ARM_MARGIN
from tamp.streams.context import Context, Detached
from tamp.streams.hand.clearance import caught, opening_for
from tamp.streams.hand.finger_closing import between_pads
from tamp.streams.motion.handling_contacts import approach_contact, handling_hits, told
from tamp.streams.motion.lift import Reach, lifted, standing_under
from tamp.streams.values import Configuration, Grasp, Handling, Placement, falls_straight
from tamp.streams.workspace import Workspace, standing
from tamp.task import Pose
from tamp.world.kinematics.inverse import inverse, straight_line
from tamp.world.scene import Scene
from tamp.world.transforms import moved
from tamp.world.world import ROBOT

if TYPE_CHECKING:
    from numpy.typing import NDArray

BESIDE = 0.002  # what has fallen is not even so little beside what is between the pads then [m]
FALLING_PAST = 0.004  # so far from the hand what turns over is seen to fall, every few degrees [m]
SOLUTIONS = 4  # arm configurations tried for one grasp

Joints = tuple[float, ...]
"""An arm configuration that can be part of a key [rad]."""


def inverse_kinematics(
    context: Context, obj: str, placement: Placement, grasp: Grasp
) -> Iterator[tuple[Configuration, Configuration, Handling]]:
    """Yield (approach configuration, lift configuration, handling) for an object held by a grasp at a placement."""
    yield from handlings(context, obj, placement, grasp)


def handlings(
    context: Context, obj: str, placement: Placement, grasp: Grasp, fall: tuple[Pose, ...] = ()
) -> Iterator[tuple[Configuration, Configuration, Handling]]:
    """Yield (approach configuration, lift configuration, handling) for an object that a grasp brings to a placement.

    Each handling is free of collision with the table, the robot itself and the object. Those that are also free of
    what the plan has standing there by then come first; the others may serve when that has moved, which
    `test-cfree-handling` decides.

    Args:
        context: of the stream that is called.
        obj: the object.
        placement: where it stands in the end.
        grasp: how it is held.
        fall: poses (world frame) from where it is let go to its placement; empty where it is let go there.
    """
    workspace: Workspace = context.scene
    world = workspace.world
    pose = fall[0] if fall else placement.pose
    T_world_tool = pose.matrix @ grasp.T_object_tool.matrix
    opening = opening_for(world.robot.spec.gripper, grasp)
    around = {name: place for name, place in standing(context.bound).items() if name != obj}
    neighbours = Scene(poses={name: place.pose.matrix for name, place in around.items()})
    hand_blocked: bool | None = None
    blocked_by_others = []
    for reach in _recalled(context, obj, placement, grasp, fall, _taken_at(context, obj, placement, grasp)):
        handling = _lifted(context, reach)
        if handling is None:
            continue
        if hand_blocked is None:  # where the hand itself meets others, no other arm configuration will help
            widths = (opening, grasp.width)
            contacts = (world.hand_contact(T_world_tool, w, neighbours, margin=ARM_MARGIN) for w in widths)
            hand_blocked = any(contact is not None for contact in contacts)
        before = Configuration(tuple(handling.approach[0].tolist()), opening)
        after = Configuration(tuple(handling.lift[-1].tolist()), grasp.width)
        if hand_blocked:  # one handling stands for all
            yield before, after, handling
            return
        if not handling_hits(workspace, handling, around):
            yield before, after, handling
        else:
            blocked_by_others.append((before, after, handling))
    yield from blocked_by_others


def _taken_at(context: Context, obj: str, placement: Placement, grasp: Grasp) -> Joints | None:
    """Arm configuration at which a grasp takes an object from where it stands: it is carried from there, best not far.

    None where it cannot, or where that is the placement itself.
    """
    start = context.scene.start[obj]
    if placement == start:
        return None
    first = next(_recalled(Detached.of(context, context.deadline), obj, start, grasp), None)
    return None if first is None else tuple(first.approach[-1].tolist())


def _recalled(
    context: Context,
    obj: str,
    placement: Placement,
    grasp: Grasp,
    fall: tuple[Pose, ...] = (),
    near: Joints | None = None,
) -> Iterator[Reach]:
    """What `_reaches` yields, remembered."""
    inputs = (obj, placement, grasp, fall, near)
    reads = upon_carriers(context.scene, obj, placement)
    yield from recalled(context, "reaches", inputs, reads, lambda first: _reaches(first, *inputs))


def reaches(
    context: Context,
    obj: str,
    placement: Placement,
    grasp: Grasp,
    fall: tuple[Pose, ...] = (),
    among: Mapping[str, Placement] | None = None,
) -> bool:
    """Whether there is a handling at all that meets none of some objects; it is not remembered.

    Args:
        context: as of `handlings`, like the other arguments.
        obj: the object.
        placement: where it stands in the end.
        grasp: how it is held.
        fall: poses from where it is let go.
        among: what stands there; what carries the object at its placement where it is None.
    """
    if among is None:
        among = carriers(context.scene, obj, placement)
    lifts = (_lifted(context, reach) for reach in _reaches(context, obj, placement, grasp, fall))
    return any(handling is not None and not handling_hits(context.scene, handling, among) for handling in lifts)


def _lifted(context: Context, reach: Reach) -> Handling | None:
    """A way to take an object with the lift that suits what stands around it; None, and the reason told."""
    lift = lifted(context, reach)
    if lift is None:
        return None
    way, path = lift
    # One and the same for all who lift it so: what it hits is remembered for each.
    cache: SampleCache = context.scene.cache
    return cache.value(("handling", reach, way), lambda: reach.lifted(path))


def _reaches(
    context: Context,
    obj: str,
    placement: Placement,
    grasp: Grasp,
    fall: tuple[Pose, ...],
    near: Joints | None = None,
) -> Iterator[Reach]:
    """Ways to an object as if nothing else stood on the table but what carries it, those near a configuration first."""
    workspace: Workspace = context.scene
    world = workspace.world
    pose = fall[0] if fall else placement.pose
    T_world_tool = pose.matrix @ grasp.T_object_tool.matrix
    opening = opening_for(world.robot.spec.gripper, grasp)
    if any(world.overlap(obj, fallen.matrix, ROBOT, tolerance=-BESIDE) for fallen in fall):
        context.fail(f"{obj} would fall against the robot's base")
        return
    alone = Scene(poses={obj: pose.matrix}, opening=opening)
    blocked = world.hand_contact(T_world_tool, opening, alone, margin=ARM_MARGIN, ignore=(obj,))
    if blocked is not None:
        context.fail(f"the hand would hit {blocked}")
        return
    found = False
    close = None if near is None else np.array(near)
    for q in inverse(world.robot, T_world_tool, context.rng, near=close, count=SOLUTIONS):
        found = True
        approach = _approach(context, obj, placement, opening, q, fall)
        if approach is not None:
            yield Reach(obj, placement, grasp, opening, approach, fall)
    if not found:
        context.fail("no inverse kinematics")


def _approach(
    context: Context, obj: str, placement: Placement, opening: float, q: NDArray[np.float64], fall: tuple[Pose, ...]
) -> NDArray[np.float64] | None:
    """A straight way to the grasp at `q` along the tool's axis, shape (n, joints); None, and the reason told.

    Where it begins, and ends for a hand that has let go, the hand is out of the way of an object that falls. If
    possible it is also clear of what the object stands on or in.
    """
    workspace: Workspace = context.scene
    pose = fall[0] if fall else placement.pose
    reason = "the approach leaves the joint limits"
    T = workspace.world.robot.forward(q)
    drops, stroke = bool(fall) and falls_straight(fall[0], fall[-1]), workspace.world.robot.spec.gripper.stroke
    if drops and caught(workspace, obj, fall, T, opening):
        context.fail(f"{obj} would fall onto the hand")
        return None
    on = standing_under(workspace, obj, placement)
    blocked, farthest = None, math.inf
    for back in workspace.hand.withdrawals if drops else workspace.hand.approaches:
        if back > farthest:  # it begins with the way that could not be gone
            continue
        T_away = moved(T, -back * T[:3, 2])
        if fall and len(between_pads(workspace, obj, fall[-1].inverse().matrix @ T_away, stroke, -BESIDE)):
            reason = f"{obj} would not fall out of the hand"
            continue
        retreat = straight_line(workspace.world.robot, q, T_away)
        if retreat is None:
            farthest = back
        else:
            path = retreat[::-1]
            contact = approach_contact(workspace, obj, pose, opening, path, {})
            # What falls straight down passes between the fingers, which do not move before it lies.
            way, near = (path, 0.0) if drops else (path[:1], FALLING_PAST)
            under = (approach_contact(workspace, obj, fallen, opening, way, {}, near) for fallen in fall)
            contact = contact or next(filter(None, under), None)
            # From there the empty hand moves on, as far from the object as from all else.
            contact = contact or approach_contact(workspace, obj, placement.pose, opening, path[:1], {}, ARM_MARGIN)
            if contact is None:
                if not on or approach_contact(workspace, obj, pose, opening, path, on) is None:
                    return path
                blocked = path if blocked is None else blocked
            else:
                reason = told(contact)
    if blocked is None:
        context.fail(reason)
    return blocked
