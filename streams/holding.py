"""How firmly a grasp holds an object, and which grasps are offered after those that hold it firmly everywhere."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import zip_longest
from operator import itemgetter

from tamp.streams.slipping import slipping
from tamp.streams.squeezed import Squeezed
from tamp.streams.turning import turning
from tamp.streams.values import Grasp, Placement
from tamp.streams.workspace import Workspace
from tamp.task import Pose

FIRM = 0.1  # a grasp in which the object turns by less holds it firmly [rad]
LOST = 0.5  # one in which it turns by more does not hold it at all [rad]
AS_BAD = 0.02  # slipping so far is as bad as turning by one radian [m]


def looseness(workspace: Workspace, obj: str, grasp: Grasp, *poses: Pose) -> float:
    """How far an object moves in a hand that lifts it from any of some poses: the angle, or what is as bad [rad]."""
    squeezed = Squeezed(workspace, obj, grasp)
    return max(turning(squeezed, *poses), slipping(squeezed, *poses) / AS_BAD)


def second_best(
    workspace: Workspace, obj: str, place: Placement, loose: Sequence[tuple[float, Grasp]], partly: Sequence[Grasp]
) -> Iterator[Grasp | None]:
    """Yield by turns a grasp of all placements in which the object moves, and a firm one of some of them.

    An object that moves in the hand while it is lifted costs a new plan, and so does a grasp that only serves once
    others have moved: neither is clearly better. Grasps that are not even firm come last; those that lose the object
    never.

    Args:
        workspace: where the object is.
        obj: the object.
        place: where it stands.
        loose: grasps that serve all placements, with how loosely each holds the object [rad].
        partly: grasps that serve some of them, best first.

    Yields:
        Grasps, and None where one was looked at for nothing.
    """
    shaky: list[tuple[float, Grasp]] = []
    for one, other in zip_longest(sorted(loose, key=itemgetter(0)), partly):
        if one is not None and one[0] < LOST:
            yield one[1]
        angle = LOST if other is None else looseness(workspace, obj, other, place.pose)
        if other is not None and FIRM < angle < LOST:
            shaky.append((angle, other))
        yield other if angle <= FIRM else None
    yield from (grasp for _, grasp in sorted(shaky, key=itemgetter(0)))
