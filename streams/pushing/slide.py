"""Sliding: what no hand can grasp as it lies is pushed over the table's edge and gripped where it hangs over."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from tamp.streams.affordances.slide_path import Way, ways
from tamp.streams.cache import recalled
from tamp.streams.context import Context
from tamp.streams.pushing.grasp_after_push import Offer, free_first, grippable, offer, table_alone
from tamp.streams.pushing.hand_contact import barred
from tamp.streams.pushing.push_motion import push_hits, pushes
from tamp.streams.values import Placement, Slide
from tamp.streams.workspace import standing

TRIED = 16  # ways


def plan_sliding(context: Context, obj: str, placement: Placement) -> Iterator[Offer]:
    """Yield (placement over the edge, first configuration, last configuration, slide) for an object at a placement.

    The arm can grip the object where it is slid to, as far as the table alone matters. Slides that are also free of
    what the plan has standing there come first; the others may serve when that has moved. As it takes long to find out
    where the arm can grip it, ways that are barred for the hand alone are only looked at after all others.
    """
    around = {name: place for name, place in standing(context.bound).items() if name != obj}
    all_ways = ways(context.scene, obj, placement)[:TRIED]
    blocked = [way for way in all_ways if barred(context.scene, obj, placement, way, around)]

    def slides(chosen: list[Way]) -> Iterator[Slide]:
        for way in chosen:
            inputs = (obj, placement, tuple(way.behind.tolist()), tuple(way.shift.tolist()))
            draw = partial(_alone, obj=obj, placement=placement, way=way)
            yield from recalled(context, "slides", inputs, table_alone(context.scene, obj), draw)

    yield from free_first(context, obj, slides([way for way in all_ways if way not in blocked]))
    yield from map(offer, slides(blocked))


def test_cfree_slide(context: Context, obj: str, slide: Slide, other: str, standing: Placement) -> bool:
    """Whether the arm can slide, nudge or topple `obj` while `other` stands there."""
    reason = push_hits(context.scene, slide, {other: standing})
    if reason is not None:
        context.fail(reason)
    return reason is None


def _alone(context: Context, obj: str, placement: Placement, way: Way) -> Iterator[Slide | None]:
    """A few slides along a way to where the arm can grip the object, as if nothing else stood on the table.

    In the second the hand keeps close to the object, in the third it is slim as well, which may be the only room that
    neighbours leave.
    """
    hand = context.scene.hand
    slide = next(pushes(context, obj, placement, way, hand.push_gap), None)
    yield None
    if slide is not None and (yield from grippable(context, obj, way.end)):
        yield slide
        yield next(pushes(context, obj, placement, way, hand.close_push_gap), None)
        yield next(pushes(context, obj, placement, way, hand.close_push_gap, slim=True), None)
