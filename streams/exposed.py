"""Grasps of what was pushed to where a hand can take it: over the table's edge, or onto another face."""

from __future__ import annotations

from collections.abc import Callable, Generator, Hashable, Iterator
from itertools import islice

from tamp.streams.grasps import grasps_at
from tamp.streams.pushing import push_hits
from tamp.streams.reachability import inverse_kinematics
from tamp.streams.recall import Detached, recalled, stepwise
from tamp.streams.values import Configuration, Grasp, Placement, Slide
from tamp.streams.workspace import Context, standing

GRASPS, PATIENCE = 6, 60  # tried at the end of a way, and steps of the search for them after which it is given up

Offer = tuple[Placement, Configuration, Configuration, Slide]
Draw = Callable[[Detached], Iterator[Grasp | None]]


def sample_exposed_grasp(context: Context, obj: str, placement: Placement) -> Iterator[Grasp]:
    """Yield grasps of an object where it was pushed to, best first: those that also serve its goal."""
    yield from recalled(context, *_grasps(context, obj, placement))


def grippable(context: Context, obj: str, placement: Placement) -> Generator[None, None, bool]:
    """Whether the arm can take an object where it was pushed to by one of its best grasps."""
    tried = 0
    for grasp in islice(stepwise(context, *_grasps(context, obj, placement)), PATIENCE):
        if grasp is None:
            yield None
        elif next(inverse_kinematics(context, obj, placement, grasp), None) is not None:
            return True
        elif (tried := tried + 1) == GRASPS:
            break
    return False


def free_first(context: Context, obj: str, found: Iterator[Slide]) -> Iterator[Offer]:
    """Yield (placement, first configuration, last configuration, slide) for each of some slides of an object.

    Those that are free of what the plan has standing there come first; the others may serve when that has moved.
    """
    around = {name: place for name, place in standing(context.bound).items() if name != obj}
    blocked = []
    for slide in found:
        if push_hits(context.scene, slide, around) is None:
            yield offer(slide)
        else:
            blocked.append(offer(slide))
    yield from blocked


def offer(slide: Slide) -> Offer:
    """A slide with where it ends and the configurations that it begins and ends at."""
    before = Configuration(tuple(slide.approach[0].tolist()), slide.opening)
    return slide.end, before, Configuration(tuple(slide.retreat[-1].tolist()), slide.opening), slide


def _grasps(context: Context, obj: str, placement: Placement) -> tuple[Hashable, Draw]:
    """What names the grasps of an object where it was pushed to, and what draws them."""
    goal = context.scene.goals.get(obj)
    places = [placement] if goal is None else [placement, goal]
    key = ("exposed grasps", obj, *places, str(context.rng.bit_generator.state))
    return key, lambda first: grasps_at(first, obj, places)
