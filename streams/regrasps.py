"""Regrasps: an object is put down in between, so that it is put to its goal by another grasp than it was taken up by.

Grasps for the start and grasps for the goal are paired where the object has a face to stand on that leaves room for
both hands. Then a place for it is sought on the table where the arm reaches it by both.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from itertools import islice, product
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.clearance import hand_hits, opening_for
from tamp.streams.footing import resting
from tamp.streams.grasps import grasps_at
from tamp.streams.placements import put_aside
from tamp.streams.reachability import reaches
from tamp.streams.recall import Detached, recalled
from tamp.streams.values import Grasp, Placement
from tamp.streams.workspace import Context, Workspace
from tamp.world.scene import Scene

if TYPE_CHECKING:
    from numpy.typing import NDArray

ENDS = 60  # grasps for the start, and for the goal, that are looked at
PAIRS = 8  # of them that are tried in turn
ROUNDS = 6  # times that a place in between is sought for each pair
TRIES = 12  # places in one round

Regrasp = tuple[Grasp, Placement, Grasp]
Pair = tuple[Grasp, Grasp, list["NDArray[np.float64]"]]
Grasps = Callable[[Context, str, Placement], Iterable[Grasp]]


def sample_regrasp(context: Context, obj: str, start: Placement, goal: Placement) -> Iterator[Regrasp]:
    """Yield (grasp that takes the object up, placement in between, grasp that puts it to its goal).

    Each is free of collision with the table, the robot and the object, as if nothing else stood there. The placement
    keeps away from what the plan has placed, and from every start and goal.
    """
    yield from _regrasps(context, obj, start, goal, _grasps_for)


def _grasps_for(context: Context, obj: str, place: Placement) -> Iterator[Grasp]:
    key = ("grasps at", obj, place, str(context.rng.bit_generator.state))
    yield from recalled(context, key, lambda first: grasps_at(first, obj, [place]))


def regrasping(sample_grasp: Callable[..., Iterable[Grasp]]) -> Callable[..., Iterator[Regrasp]]:
    """The same with the grasps of another sampler for `sample-grasp`."""

    def sample(context: Context, obj: str, start: Placement, goal: Placement) -> Iterator[Regrasp]:
        yield from _regrasps(context, obj, start, goal, lambda context, obj, _: sample_grasp(context, obj))

    return sample


def _regrasps(context: Context, obj: str, start: Placement, goal: Placement, grasps: Grasps) -> Iterator[Regrasp]:
    pairs = list(islice(_pairs(context, obj, start, goal, grasps), PAIRS))
    for _ in range(ROUNDS):
        for one, other, faces in pairs:
            place = _between(context, obj, one, other, faces)
            if place is not None:
                yield one, place, other
                continue
            context.fail(f"no place for {obj} in between that both grasps reach")
            if time.monotonic() > context.deadline:
                return


def _pairs(context: Context, obj: str, start: Placement, goal: Placement, grasps: Grasps) -> Iterator[Pair]:
    """Grasps that can take turns, and the faces (3, 3) to stand on meanwhile; the best of both ends first."""
    workspace: Workspace = context.scene
    first, second = (list(islice(grasps(context, obj, place), ENDS)) for place in (start, goal))
    for found, deed in ((first, "takes it up"), (second, "puts it to its goal")):
        if not found:
            context.fail(f"no grasp of {obj} {deed}")
    rotations = resting(workspace, obj)
    above = {grasp: [_above_table(workspace, obj, R, grasp) for R in rotations] for grasp in (*first, *second)}
    reached = cache(lambda place, grasp: _reaches(context, obj, place, grasp))
    taken_over = False
    for one, other in sorted(product(first, second), key=lambda pair: first.index(pair[0]) + second.index(pair[1])):
        faces = [R for R, *both in zip(rotations, above[one], above[other], strict=True) if all(both)]
        taken_over |= bool(faces)
        if faces and reached(start, one) and reached(goal, other):
            yield one, other, faces
    if first and second and not taken_over:
        context.fail(f"{obj} has no face to stand on with room for the hands of both grasps")


def _reaches(context: Context, obj: str, place: Placement, grasp: Grasp) -> bool:
    return reaches(Detached(context.scene, context.rng.spawn(1)[0]), obj, place, grasp)


def _above_table(workspace: Workspace, obj: str, R: NDArray[np.float64], grasp: Grasp) -> bool:
    """Whether the open hand is clear of the table where the object stands on a face."""
    T = np.eye(4)
    T[:3, :3] = R
    T[2, 3] = -float((workspace.points(obj) @ R[2]).min())
    opening = opening_for(workspace.world.robot.spec.gripper, grasp)
    return not hand_hits(workspace, T @ grasp.T_object_tool.matrix, opening, Scene())


def _between(
    context: Context, obj: str, one: Grasp, other: Grasp, faces: list[NDArray[np.float64]]
) -> Placement | None:
    """A place on the table where the arm puts the object down by one grasp and takes it up by the other."""
    for _ in range(TRIES):
        angle = context.rng.uniform(-np.pi, np.pi)
        c, s = np.cos(angle), np.sin(angle)
        turned = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ faces[context.rng.integers(len(faces))]
        place = put_aside(context, obj, turned)
        if place is not None and all(_reaches(context, obj, place, grasp) for grasp in (one, other)):
            return place
    return None
