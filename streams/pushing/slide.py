"""Sliding: what no hand can grasp as it lies is pushed over the table's edge and gripped there, or straight on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from itertools import chain, islice

from tamp.streams.affordances.detour import End, detours, ends
from tamp.streams.affordances.slide_path import Way, directions, ways, ways_to
from tamp.streams.cache import pausing, stepwise
from tamp.streams.context import Context
from tamp.streams.pushing.grasp_after_push import (
    Offer,
    free_first,
    goal_of,
    grippable,
    offer,
    offers,
    singly,
    table_alone,
)
from tamp.streams.pushing.hand_contact import barred, hands_at
from tamp.streams.pushing.push_motion import push_hits, pushes
from tamp.streams.values import Configuration, Placement, Slide
from tamp.streams.workspace import standing

TRIED = 16  # ways, and ends
PAIRS, LOOKED_AT = 4, 16  # of ways to each end that the arm can follow, and that it is asked for

Detour = tuple[Placement, Configuration, Configuration, Slide, Placement, Configuration, Configuration, Slide]


def plan_sliding(context: Context, obj: str, placement: Placement) -> Iterator[Offer]:
    """Yield (placement over the edge, first configuration, last configuration, slide) for an object at a placement.

    The arm can grip the object where it is slid to, as far as the table alone matters; ends at which no such grasp
    serves the goal too come last. Slides that are also free of what the plan has standing there come first; the others
    may serve when that has moved. As it takes long to find out where the arm can grip it, ways that are barred for the
    hand alone are only looked at after all others.
    """
    yield from pausing(context, slides_in_steps(context, obj, placement))


def slides_in_steps(context: Context, obj: str, placement: Placement) -> Iterator[Offer | None]:
    """The same with None for work done without any, so that whoever waits for one can give up."""
    around = {name: place for name, place in standing(context.bound).items() if name != obj}
    all_ways = ways(context.scene, obj, placement)[:TRIED]
    blocked = [way for way in all_ways if barred(context.scene, obj, placement, way, around)]
    clear = [way for way in all_ways if way not in blocked]
    for serving in dict.fromkeys((goal_of(context, obj), ())):
        found = _slides(context, obj, placement, clear, serving)
        yield from offers(free_first(context, obj, singly(found)))
        yield from offers(singly(_slides(context, obj, placement, blocked, serving)))


def _slides(
    context: Context, obj: str, placement: Placement, chosen: Sequence[Way], serving: tuple[Placement, ...]
) -> Iterator[Slide | None]:
    """Slides along some ways, to ends where a grasp serves some other placements too; None for work without any."""
    for way in chosen:
        inputs = (obj, placement, tuple(way.behind.tolist()), tuple(way.shift.tolist()), serving)
        draw = partial(_alone, obj=obj, placement=placement, way=way, serving=serving)
        yield from stepwise(context, "slides", inputs, table_alone(context.scene, obj), draw)


def plan_detour(context: Context, obj: str, placement: Placement) -> Iterator[Detour]:
    """Yield two slides after each other, as `plan_sliding` does one, where the second ends over an edge.

    There are none where a straight slide leads to any grasp, were nothing else on the table.
    """
    yield from pausing(context, _offers_by_detour(context, obj, placement))


def _offers_by_detour(context: Context, obj: str, placement: Placement) -> Iterator[Detour | None]:
    """The same with None for work done without any."""
    for slide in _slides(context, obj, placement, ways(context.scene, obj, placement)[:TRIED], ()):
        if slide is not None:
            return
        yield None
    all_ends = ends(context.scene, obj, placement)[:TRIED]
    for serving in dict.fromkeys((goal_of(context, obj), ())):
        for pair in free_first(context, obj, _pairs(context, obj, placement, all_ends, serving)):
            yield None if pair is None else (*offer(pair[0]), *offer(pair[1]))


def plan_sliding_to(
    context: Context, obj: str, start: Placement, end: Placement
) -> Iterator[tuple[Configuration, Configuration, Slide]]:
    """Yield (first configuration, last configuration, slide) for an object that shall be pushed straight to a place.

    Slides that are also free of what the plan has standing there come first.
    """
    all_ways = ways_to(context.scene, obj, start, end)
    found = (pushes(context, obj, start, way, gap, slim) for way in all_ways for gap, slim in _hands(context))
    for (slide,) in filter(None, free_first(context, obj, singly(chain.from_iterable(found)))):
        yield offer(slide)[1:]


def _pairs(
    context: Context, obj: str, placement: Placement, chosen: Sequence[End], serving: tuple[Placement, ...]
) -> Iterator[tuple[Slide, Slide] | None]:
    """Two slides each to some ends, where a grasp serves some other placements too; None for work without any."""
    for end in chosen:
        inputs = (obj, placement, end.placement, serving)
        draw = partial(_twice_alone, obj=obj, placement=placement, end=end, serving=serving)
        yield from stepwise(context, "detours", inputs, table_alone(context.scene, obj), draw)


def test_cfree_slide(context: Context, obj: str, slide: Slide, other: str, standing: Placement) -> bool:
    """Whether the arm can slide, nudge or topple `obj` while `other` stands there."""
    reason = push_hits(context.scene, slide, {other: standing})
    if reason is not None:
        context.fail(reason)
    return reason is None


def _alone(
    context: Context, obj: str, placement: Placement, way: Way, serving: tuple[Placement, ...]
) -> Iterator[Slide | None]:
    """A few slides along a way to where the arm can grip the object, as if nothing else stood on the table."""
    able = False
    for gap, slim in _hands(context):
        slide = next(pushes(context, obj, placement, way, gap, slim), None)
        yield None
        if slide is not None:
            # A grasp takes much longer to find than a push, so that it comes second.
            able = able or (yield from grippable(context, obj, way.end, *serving))
            if not able:
                return
            yield slide


def _hands(context: Context) -> tuple[tuple[float, bool], ...]:
    """How far behind an object a hand that pushes it comes down [m], and whether it is slim.

    The second keeps close to the object, the third is slim as well, which may be the only room that neighbours leave.
    """
    hand = context.scene.hand
    return (hand.push_gap, False), (hand.close_push_gap, False), (hand.close_push_gap, True)


def _twice_alone(
    context: Context, obj: str, placement: Placement, end: End, serving: tuple[Placement, ...]
) -> Iterator[tuple[Slide, Slide] | None]:
    """Pairs of slides to an end where the arm can grip the object, as if nothing else stood on the table."""
    among = directions(context.scene, obj, placement)
    able, left = False, PAIRS
    for first, second in islice(detours(context.scene, obj, placement, end, among), LOOKED_AT):
        last = _one_push(context, obj, first.end, second)
        yield None
        begin = None if last is None else _one_push(context, obj, placement, first)
        if begin is None or last is None:
            continue
        able = able or (yield from grippable(context, obj, end.placement, *serving))
        if not able:
            return
        yield begin, last
        left -= 1
        if not left:
            return


def _one_push(context: Context, obj: str, placement: Placement, way: Way) -> Slide | None:
    """A slide along a way by the first of the hands that fits the side pushed; None where none does, or the arm cannot.

    Another hand would be at about the same place, so that where the arm cannot move one it is asked for no other.
    """
    for gap, slim in _hands(context):
        if any(hands_at(context.scene, obj, placement, way, slim)):
            return next(pushes(context, obj, placement, way, gap, slim), None)
    return None
