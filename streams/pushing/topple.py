"""Toppling: what no hand can grasp as it stands is pushed over by the fingertips and gripped as it lies then."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.affordances.topple_path import Topple, topples
from tamp.streams.cache import pausing, stepwise
from tamp.streams.context import Context
from tamp.streams.motion.payload import push_too_heavy
from tamp.streams.pushing.grasp_after_push import Offer, free_first, goal_of, grippable, offers, singly, table_alone
from tamp.streams.pushing.hand_contact import hands_behind
from tamp.streams.pushing.push_motion import drawn_back, push_hits
from tamp.streams.values import Placement, Slide
from tamp.streams.workspace import Workspace
from tamp.task import Pose
from tamp.world.kinematics.inverse import inverse, straight_lines

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

TRIED = 12  # edges
HANDS = 12  # for one edge
SOLUTIONS = 4  # arm configurations for one hand
STRAIGHT_UP = np.zeros(3)  # when the object has fallen nothing is before the hand


def plan_toppling(context: Context, obj: str, placement: Placement) -> Iterator[Offer]:
    """Yield (placement on another face, first configuration, last configuration, topple) for an object at a placement.

    The arm can grip the object as it lies then, as far as the table alone matters. Topples that are also free of what
    the plan has standing there come first; the others may serve when that has moved.
    """
    reads = table_alone(context.scene, obj)
    found = stepwise(context, "topples", (obj, placement), reads, lambda first: _alone(first, obj, placement))
    yield from pausing(context, offers(free_first(context, obj, singly(found))))


def _alone(context: Context, obj: str, placement: Placement) -> Iterator[Slide | None]:
    """A topple over each edge after which the arm can grip the object, as if nothing else stood on the table."""
    for topple in topples(context.scene, obj, placement)[:TRIED]:
        slide = next(_toppled(context, obj, placement, topple), None)
        yield None
        if slide is not None and (yield from grippable(context, obj, topple.end, *goal_of(context, obj))):
            yield slide


def _toppled(context: Context, obj: str, start: Placement, topple: Topple) -> Iterator[Slide]:
    """Yield topples of an object over one edge that the arm can follow, as if nothing else stood on the table."""
    workspace: Workspace = context.scene
    robot, behind = workspace.world.robot, -workspace.hand.push_gap * topple.ahead
    for T, opening in islice(hands_behind(workspace, obj, start, topple.ahead, topple.heights), HANDS):
        T_tool_object = Pose.from_matrix(T).inverse() @ start.pose
        for q in inverse(robot, T, context.rng, count=SOLUTIONS):
            heavy = push_too_heavy(workspace, obj, topple.ahead, opening, q[None], topple.share)
            ways = [(pose @ T_tool_object.inverse()).matrix for pose in topple.pushed[1:]]
            push = straight_lines(robot, q, ways) if heavy is None else None
            begin = None if push is None else drawn_back(workspace, push[0], behind)
            after = None if push is None else drawn_back(workspace, push[-1], STRAIGHT_UP)
            if push is None or begin is None or after is None:
                context.fail(heavy or f"the way to push {obj} over leaves the joint limits")
                continue
            slide = Slide(obj, start, topple.end, opening, begin[::-1], push, after, T_tool_object, topple.fall)
            hit = push_too_heavy(workspace, obj, topple.ahead, opening, push, topple.share) or push_hits(
                workspace, slide, {}
            )
            if hit is None:
                yield slide
            else:
                context.fail(hit)
