"""Sliding: what no hand can grasp as it lies is pushed over the table's edge and gripped where it hangs over."""

from __future__ import annotations

from collections.abc import Callable, Generator, Hashable, Iterator
from itertools import islice

from tamp.streams.grasps import grasps_at
from tamp.streams.pushing import CLOSE, push_hits, pushes
from tamp.streams.reachability import inverse_kinematics
from tamp.streams.recall import Detached, recalled, stepwise
from tamp.streams.slides import ways
from tamp.streams.values import Configuration, Grasp, Placement, Slide
from tamp.streams.workspace import Context, standing

TRIED = 16  # ways
GRASPS, PATIENCE = 6, 60  # tried at the end of a way, and steps of the search for them after which it is given up

Draw = Callable[[Detached], Iterator[Grasp | None]]


def plan_sliding(
    context: Context, obj: str, placement: Placement
) -> Iterator[tuple[Placement, Configuration, Configuration, Slide]]:
    """Yield (placement over the edge, first configuration, last configuration, slide) for an object at a placement.

    The arm can grip the object where it is slid to, as far as the table alone matters. Slides that are also free of
    what the plan has standing there come first; the others may serve when that has moved.
    """
    around = {name: place for name, place in standing(context.bound).items() if name != obj}
    found = recalled(context, ("slides", obj, placement), lambda first: _alone(first, obj, placement))
    blocked = []
    for slide in found:
        before = Configuration(tuple(slide.approach[0].tolist()), slide.opening)
        after = Configuration(tuple(slide.retreat[-1].tolist()), slide.opening)
        if push_hits(context.scene, slide, around) is None:
            yield slide.end, before, after, slide
        else:
            blocked.append((slide.end, before, after, slide))
    yield from blocked


def sample_edge_grasp(context: Context, obj: str, placement: Placement) -> Iterator[Grasp]:
    """Yield grasps of an object that hangs over the table's edge, best first: those that also serve its goal."""
    yield from recalled(context, *_edge_grasps(context, obj, placement))


def test_cfree_slide(context: Context, obj: str, slide: Slide, other: str, standing: Placement) -> bool:
    """Whether the arm can slide `obj` while `other` stands there."""
    reason = push_hits(context.scene, slide, {other: standing})
    if reason is not None:
        context.fail(reason)
    return reason is None


def _edge_grasps(context: Context, obj: str, placement: Placement) -> tuple[Hashable, Draw]:
    """What names the grasps of an object that hangs over the table's edge, and what draws them."""
    goal = context.scene.goals.get(obj)
    places = [placement] if goal is None else [placement, goal]
    key = ("edge grasps", obj, *places, str(context.rng.bit_generator.state))
    return key, lambda first: grasps_at(first, obj, places)


def _alone(context: Context, obj: str, placement: Placement) -> Iterator[Slide | None]:
    """Two slides for each way to where the arm can grip the object, as if nothing else stood on the table.

    In the second the hand keeps close to the object, which may be the only room that neighbours leave.
    """
    for way in ways(context.scene, obj, placement)[:TRIED]:
        slide = next(pushes(context, obj, placement, way), None)
        yield None
        if slide is not None and (yield from _grippable(context, obj, way.end)):
            yield slide
            yield next(pushes(context, obj, placement, way, CLOSE), None)


def _grippable(context: Context, obj: str, placement: Placement) -> Generator[None, None, bool]:
    """Whether the arm can take an object that hangs over the edge by one of its best grasps."""
    tried = 0
    for grasp in islice(stepwise(context, *_edge_grasps(context, obj, placement)), PATIENCE):
        if grasp is None:
            yield None
        elif next(inverse_kinematics(context, obj, placement, grasp), None) is not None:
            return True
        elif (tried := tried + 1) == GRASPS:
            break
    return False
