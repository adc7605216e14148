"""Putting aside what lies so flat, on every face, that no hand has room beside it: on the table it can only be laid.

The grasp is chosen together with the place: one that the object can be taken up by, whether or not it serves its goal.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from itertools import islice
from math import dist
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.collisions import handling_hits
from tamp.streams.footing import amid, resting, turned
from tamp.streams.grasps import grasps_at
from tamp.streams.laying import plan_laying
from tamp.streams.placements import put_aside
from tamp.streams.reachability import inverse_kinematics
from tamp.streams.recall import Detached, recalled
from tamp.streams.slides import slidable
from tamp.streams.tilting import too_wide
from tamp.streams.values import Grasp, Handling, Placement
from tamp.streams.workspace import TABLE, Context, Workspace, standing

if TYPE_CHECKING:
    pass

LOOKED_AT = 200  # grasps, or tries at one
TRIES = 6  # places for each of them
ROUNDS = 4  # through the grasps that serve


def lies_flat(workspace: Workspace, obj: str) -> bool:
    """Whether no hand can put an object down or pick it up on the table, whatever face it rests on."""
    start = workspace.start[obj]
    if start.on == (TABLE,) and not too_wide(workspace, obj, start):  # one face is enough
        return False
    key = ("lies flat", obj)
    if key not in workspace.memory:
        workspace.memory[key] = all(slidable(workspace, obj, amid(workspace, obj, R)) for R in resting(workspace, obj))
    answer: bool = workspace.memory[key]
    return answer


def sample_laid_aside(context: Context, obj: str, start: Placement) -> Iterator[tuple[Grasp, Placement]]:
    """Yield (grasp that takes a flat object up, place on the table out of the way where it lays it down).

    Grasps by which the hand meets nothing that stands there by then come first.
    """
    around = {name: place for name, place in standing(context.bound).items() if name != obj}
    free, blocked = list[Grasp](), list[Grasp]()
    key = ("taking", obj, start, str(context.rng.bit_generator.state))
    for handling in recalled(context, key, lambda first: _taking(first, obj, start)):
        if handling_hits(context.scene, handling, around):
            blocked.append(handling.grasp)
        else:
            free.append(handling.grasp)
            yield from _laid(context, obj, handling.grasp)
    for _ in range(ROUNDS):
        for grasp in [*free, *blocked]:
            yield from _laid(context, obj, grasp)


def _taking(context: Context, obj: str, start: Placement) -> Iterator[Handling | None]:
    """One handling for each grasp by which the arm reaches an object, were nothing else on the table.

    None stands for work done without one.
    """
    for grasp in islice(grasps_at(context, obj, [start]), LOOKED_AT):
        found = inverse_kinematics(_detached(context), obj, start, grasp) if grasp is not None else iter(())
        yield next((handling for _, _, handling in found), None)


def _laid(context: Context, obj: str, grasp: Grasp) -> Iterator[tuple[Grasp, Placement]]:
    """A grasp and, of a few places where the arm can lay the object down by it, that which is nearest to its goal."""
    for place in _places(context, obj):
        if time.monotonic() > context.deadline:
            return
        if next(plan_laying(_detached(context), obj, place, grasp), None) is not None:
            yield grasp, place
            return
    context.fail(f"no place was found where the arm can lay {obj} down")


def _places(context: Context, obj: str) -> list[Placement]:
    """A few places out of the way, those nearest to the object's goal first: it may have to stay there."""
    faces, goal = resting(context.scene, obj), context.scene.goals.get(obj)
    turns = (faces[int(context.rng.integers(len(faces)))] for _ in range(TRIES))
    drawn = (put_aside(context, obj, turned(R, context.rng.uniform(-np.pi, np.pi))) for R in turns)
    places = [place for place in drawn if place is not None]
    return places if goal is None else sorted(places, key=lambda place: dist(place.pose.xyz, goal.pose.xyz))


def _detached(context: Context) -> Detached:
    return Detached(context.scene, context.rng.spawn(1)[0], context.deadline)
