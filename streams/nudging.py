"""Nudging: what lies in something is pushed on a little in there, so that hands have room round it or round others."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

import numpy as np

from tamp.streams.clearance import standing_around
from tamp.streams.nudges import pushing_hands
from tamp.streams.pushing import push_hits, pushed
from tamp.streams.values import Configuration, Placement, Slide
from tamp.streams.workspace import Context, standing

TRIED = 6  # hands for one nudge
STRAIGHT_UP = np.zeros(3)  # between walls there is no room to draw back


def plan_nudging(
    context: Context, obj: str, start: Placement, end: Placement
) -> Iterator[tuple[Configuration, Configuration, Slide]]:
    """Yield (first configuration, last configuration, nudge) for an object that shall be pushed to a near placement.

    All are free of what the plan has standing there, or else of what stands there now.
    """
    bound = {name: place for name, place in standing(context.bound).items() if name != obj}
    around = bound or standing_around(context.scene, obj, start)
    poses = {name: place.pose.matrix for name, place in around.items()}
    shift = np.subtract(end.pose.xyz, start.pose.xyz)
    for T, opening in islice(pushing_hands(context.scene, obj, start, shift, poses), TRIED):
        for nudge in pushed(context, obj, start, end, T, opening, STRAIGHT_UP):
            if push_hits(context.scene, nudge, around) is None:
                before = Configuration(tuple(nudge.approach[0].tolist()), opening)
                yield before, Configuration(tuple(nudge.retreat[-1].tolist()), opening), nudge
                break
