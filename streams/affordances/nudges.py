"""Whether an object may be nudged: pushed on a little within what it lies in."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.affordances.friction_cones import friction_of
from tamp.streams.affordances.neighbours import enclosed
from tamp.streams.values import LEVEL, Placement, shifted_alone
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import Pose

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

STEP, STEPS = 0.01, 4  # of a nudge [m]


def nudgeable(workspace: Workspace, obj: str, start: Placement, end: Placement) -> bool:
    """Whether one placement is so near another, on one level in the same thing, that a nudge may lead from it there.

    That thing does not come along: the object slides in it at least as well as it does on what carries it.
    """
    shift = np.subtract(end.pose.xyz, start.pose.xyz)
    inside = len(start.on) == 1 and start.on != (TABLE,) and enclosed(workspace, obj, start)
    stays = inside and slides_within(workspace, obj, start.on[0])
    return shifted_alone(start, end) and stays and 0.0 < float(np.linalg.norm(shift)) < STEPS * STEP + LEVEL


def slides_within(workspace: Workspace, obj: str, container: str) -> bool:
    """Whether what an object lies in stays where it is when the object slides in it."""
    under = workspace.start[container].on if container in workspace.start else ()
    return all(friction_of(workspace, obj) <= friction_of(workspace, other) for other in under)


def nudged(placement: Placement, shift: Array) -> Placement:
    """Where an object is after it was nudged by a level shift, (3,) [m]."""
    x, y, z = np.array(placement.pose.xyz) + shift
    return Placement(Pose((float(x), float(y), float(z)), placement.pose.quat), placement.on)
