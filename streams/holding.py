"""Which grasps are offered after those that hold an object firmly wherever it stands and shall stand."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import zip_longest
from operator import itemgetter

from tamp.streams.turning import turning
from tamp.streams.values import Grasp, Placement
from tamp.streams.workspace import Workspace

FIRM = 0.1  # a grasp in which the object turns by less holds it firmly [rad]
LOST = 0.5  # one in which it turns by more does not hold it at all [rad]


def second_best(
    workspace: Workspace, obj: str, place: Placement, loose: Sequence[tuple[float, Grasp]], partly: Sequence[Grasp]
) -> Iterator[Grasp | None]:
    """Yield by turns a grasp of all placements in which the object turns, and a firm one of some of them.

    An object that turns while it is lifted costs a new plan, and so does a grasp that only serves once others have
    moved: neither is clearly better. Grasps that are not even firm come last; those that lose the object never.

    Args:
        workspace: where the object is.
        obj: the object.
        place: where it stands.
        loose: grasps that serve all placements, with the angles that the object turns by in them [rad].
        partly: grasps that serve some of them, best first.

    Yields:
        Grasps, and None where one was looked at for nothing.
    """
    shaky: list[tuple[float, Grasp]] = []
    for one, other in zip_longest(sorted(loose, key=itemgetter(0)), partly):
        if one is not None and one[0] < LOST:
            yield one[1]
        angle = LOST if other is None else turning(workspace, obj, other, place.pose)
        if other is not None and FIRM < angle < LOST:
            shaky.append((angle, other))
        yield other if angle <= FIRM else None
    yield from (grasp for _, grasp in sorted(shaky, key=itemgetter(0)))
