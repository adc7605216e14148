"""Sliding: what no hand can grasp as it lies is pushed over the table's edge and gripped where it hangs over."""

from __future__ import annotations

from collections.abc import Iterator

from tamp.streams.exposed import Offer, free_first, grippable
from tamp.streams.pushing import CLOSE, push_hits, pushes
from tamp.streams.recall import recalled
from tamp.streams.slides import ways
from tamp.streams.values import Placement, Slide
from tamp.streams.workspace import Context

TRIED = 16  # ways


def plan_sliding(context: Context, obj: str, placement: Placement) -> Iterator[Offer]:
    """Yield (placement over the edge, first configuration, last configuration, slide) for an object at a placement.

    The arm can grip the object where it is slid to, as far as the table alone matters. Slides that are also free of
    what the plan has standing there come first; the others may serve when that has moved.
    """
    found = recalled(context, ("slides", obj, placement), lambda first: _alone(first, obj, placement))
    yield from free_first(context, obj, found)


def test_cfree_slide(context: Context, obj: str, slide: Slide, other: str, standing: Placement) -> bool:
    """Whether the arm can slide, nudge or topple `obj` while `other` stands there."""
    reason = push_hits(context.scene, slide, {other: standing})
    if reason is not None:
        context.fail(reason)
    return reason is None


def _alone(context: Context, obj: str, placement: Placement) -> Iterator[Slide | None]:
    """Two slides for each way to where the arm can grip the object, as if nothing else stood on the table.

    In the second the hand keeps close to the object, which may be the only room that neighbours leave.
    """
    for way in ways(context.scene, obj, placement)[:TRIED]:
        slide = next(pushes(context, obj, placement, way), None)
        yield None
        if slide is not None and (yield from grippable(context, obj, way.end)):
            yield slide
            yield next(pushes(context, obj, placement, way, CLOSE), None)
