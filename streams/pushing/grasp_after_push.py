"""Grasps of what was pushed to where a hand can take it: over the table's edge, or onto another face."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator, Mapping
from itertools import islice
from typing import TypeVar

from tamp.streams.affordances.neighbours import upon_carriers
from tamp.streams.context import Context
from tamp.streams.grasping.sampler import grasps, grasps_in_steps
from tamp.streams.motion.inverse_kinematics import inverse_kinematics
from tamp.streams.pushing.push_motion import is_refused_push, push_hits
from tamp.streams.values import Configuration, Grasp, Placement, Slide
from tamp.streams.workspace import Workspace, standing

GRASPS, PATIENCE = 6, 60  # tried at the end of a way, and steps of the search for them after which it is given up

Offer = tuple[Placement, Configuration, Configuration, Slide]
Pushes = TypeVar("Pushes", bound=tuple[Slide, ...])


def sample_exposed_grasp(context: Context, obj: str, placement: Placement) -> Iterator[Grasp]:
    """Yield grasps of an object where it was pushed to, best first: those that also serve its goal."""
    yield from grasps(context, obj, (placement, *goal_of(context, obj)))


def grippable(context: Context, obj: str, placement: Placement, *others: Placement) -> Generator[None, None, bool]:
    """Whether the arm can take an object where it was pushed to by one of the best grasps for there and some others."""
    tried = 0
    for grasp in islice(grasps_in_steps(context, obj, (placement, *others)), PATIENCE):
        if grasp is None:
            yield None
        elif next(inverse_kinematics(context, obj, placement, grasp), None) is not None:
            return True
        elif (tried := tried + 1) == GRASPS:
            break
    context.fail(f"the arm cannot take {obj} where it would be pushed to")
    return False


def free_first(context: Context, obj: str, found: Iterable[Pushes | None]) -> Iterator[Pushes | None]:
    """Yield pushes of an object that follow each other, those first that are free of what the plan has standing there.

    The others may serve when that has moved. None stands for work done without any, as in what is given, and for what
    the checker has refused.
    """
    around = {name: place for name, place in standing(context.bound).items() if name != obj}
    blocked = list[Pushes]()
    for pushes in found:
        if pushes is not None and any(is_refused_push(context.scene, push) for push in pushes):
            context.fail(f"the checker refuses so to push {obj}")
            yield None
        elif pushes is None or all(push_hits(context.scene, push, around) is None for push in pushes):
            yield pushes
        else:
            blocked.append(pushes)
    yield from blocked


def offer(slide: Slide) -> Offer:
    """A slide with where it ends and the configurations that it begins and ends at."""
    before = Configuration(tuple(slide.approach[0].tolist()), slide.opening)
    return slide.end, before, Configuration(tuple(slide.retreat[-1].tolist()), slide.opening), slide


def singly(found: Iterable[Slide | None]) -> Iterator[tuple[Slide] | None]:
    """Each push by itself; None as it is."""
    yield from (None if slide is None else (slide,) for slide in found)


def offers(found: Iterable[tuple[Slide] | None]) -> Iterator[Offer | None]:
    """The `offer` of each; None as it is."""
    yield from (None if pushes is None else offer(pushes[0]) for pushes in found)


def table_alone(workspace: Workspace, obj: str) -> Workspace:
    """The part of a workspace that decides whether a push is any good: the object, and what its goal rests on."""
    return upon_carriers(workspace, obj, *workspace.placements_of(obj))


def goal_of(context: Context, obj: str) -> tuple[Placement, ...]:
    """The goal pose of an object, if it has one: grasps that serve there too need no regrasp."""
    goals: Mapping[str, Placement] = context.scene.goals
    return (goals[obj],) if obj in goals else ()
