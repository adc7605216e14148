"""Putting aside what would lie so flat, on some faces, that no hand has room beside it.

Few grasps of it leave room for the hand on any other face, and on those it can only be laid. So the grasp is chosen
together with the place: one that the object can be taken up by, whether or not it serves its goal.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain, islice
from math import dist
from typing import TYPE_CHECKING

import numpy as np

from tamp import clock
from tamp.streams.affordances.detour import ends
from tamp.streams.affordances.flat_faces import flat_faces, lies_flat
from tamp.streams.affordances.neighbours import within
from tamp.streams.affordances.stable_poses import amid, resting, turned
from tamp.streams.cache import pausing, stepwise
from tamp.streams.collisions import overlap
from tamp.streams.context import Context, Detached
from tamp.streams.grasping.sampler import grasps_in_steps
from tamp.streams.hand.candidates import hangs_over
from tamp.streams.hand.clearance import hand_above_table, reach_of_hand
from tamp.streams.motion.handling_contacts import handling_hits
from tamp.streams.motion.inverse_kinematics import inverse_kinematics, reaches
from tamp.streams.placing.sampler import RELEASE_HEIGHT, put_aside, stands_then
from tamp.streams.pushing.grasp_after_push import grippable
from tamp.streams.pushing.slide import slides_in_steps
from tamp.streams.releasing.tilted_release import lays
from tamp.streams.values import Grasp, Handling, Placement
from tamp.streams.workspace import TABLE, Workspace, standing
from tamp.task import Pose
from tamp.world.transforms import moved

if TYPE_CHECKING:
    from numpy.typing import NDArray

LOOKED_AT = 200  # grasps, or tries at one
TAKERS = 16  # of them, by which the arm takes the object up
FUTILE = 8  # of those, for none of which there is a place, before no more are tried
TRIES = 3  # places for each of them in a round, and headings over the table's edges
EDGES = 2  # places over those for each heading
ROUNDS = 4  # through the grasps that serve
FAMILIAR = 0.985  # cosine of the angle between two faces that count as one

Serve = Callable[[Context, str, Grasp], Generator[None, None, Placement | None]]
"""Finds a place for an object that is held by a grasp, and pauses after each that is none."""


def sample_put_aside(context: Context, obj: str, start: Placement) -> Iterator[tuple[Grasp, Placement]]:
    """Yield (grasp that takes an object up, place on the table out of the way where it puts it down).

    There it does not lie flat, so that a hand can take it up again. Grasps by which the hand meets nothing that stands
    there by then come first.
    """
    if len(flat_faces(context.scene, obj)) == len(resting(context.scene, obj)):
        context.fail(f"{obj} would lie flat on every face")
        return
    yield from pausing(context, _aside(context, obj, start, _put))


def sample_laid_aside(context: Context, obj: str, start: Placement) -> Iterator[tuple[Grasp, Placement]]:
    """Yield (grasp that takes an object up, place on the table out of the way where it lays it down flat).

    Grasps by which the hand meets nothing that stands there by then come first.
    """
    yield from pausing(context, _aside(context, obj, start, _laid))


def sample_exposed_aside(context: Context, obj: str, start: Placement) -> Iterator[tuple[Grasp, Placement]]:
    """Yield (grasp that takes an object up, place over the table's edge where it lays it down flat).

    There a hand can take up again what lies flat on every face; nothing for what does not.
    """
    if not lies_flat(context.scene, obj):
        context.fail(f"{obj} need not hang over the table's edge to be taken up again")
        return
    yield from pausing(context, _aside(context, obj, start, _exposed))


def _aside(context: Context, obj: str, start: Placement, serve: Serve) -> Iterator[tuple[Grasp, Placement] | None]:
    """Grasps with places that they serve; None for work done without any."""
    around = {name: place for name, place in standing(context.bound).items() if name != obj}
    free, blocked = list[Grasp](), list[Grasp]()
    reads = within(context.scene, obj, reach_of_hand(context.scene), start, context.scene.start[obj])
    draw = partial(_taking, obj=obj, start=start, serve=serve)
    came = 0
    for handling in stepwise(context, f"takers{serve.__name__}", (obj, start), reads, draw):
        if handling is None:
            yield None
            continue
        if handling_hits(context.scene, handling, around):
            blocked.append(handling.grasp)
        else:
            free.append(handling.grasp)
            came += yield from _each(context, obj, [handling.grasp], serve)
            if len(free) == FUTILE and not came:
                return
        if len(free) + len(blocked) == TAKERS:
            break
    hopeful = came > 0 or not free
    for _ in range(ROUNDS):
        if not hopeful:  # what came to nothing for every grasp will not in another round
            return
        hopeful = (yield from _each(context, obj, [*free, *blocked], serve)) > 0


def _each(
    context: Context, obj: str, grasps: Sequence[Grasp], serve: Serve
) -> Generator[tuple[Grasp, Placement] | None, None, int]:
    """Yield each of the grasps for which there is a place, with it; return how many there were."""
    count = 0
    for grasp in grasps:
        place = yield from serve(context, obj, grasp)
        if place is not None:
            count += 1
            yield grasp, place
    return count


def _taking(context: Context, obj: str, start: Placement, serve: Serve) -> Iterator[Handling | None]:
    """One handling for each grasp by which the arm reaches an object, were nothing else on the table.

    None stands for work done without one.
    """
    steps = grasps_in_steps(context, obj, (start,))
    for grasp in steps if serve is _put else islice(steps, LOOKED_AT):
        if grasp is None or (serve is _put and not _upright(context.scene, obj, grasp)):
            yield None
        else:
            found = inverse_kinematics(Detached.of(context), obj, start, grasp)
            yield next((handling for _, _, handling in found), None)


def _put(context: Context, obj: str, grasp: Grasp) -> Generator[None, None, Placement | None]:
    """Of a few places where the arm can put an object down by a grasp that which is nearest to its goal."""
    faces = _upright(context.scene, obj, grasp)
    surely = partial(stands_then, context.scene, obj, grasp, context.scene.start[obj].pose)
    faces = list(filter(surely, faces)) or faces
    for place in _places(context, obj, faces, grasp):
        if clock.now() > context.deadline:
            return None
        if reaches(Detached.of(context, context.deadline), obj, place, grasp):
            return place
        yield None
    context.fail(f"no place was found where the arm can put {obj} down")
    return None


def _laid(context: Context, obj: str, grasp: Grasp) -> Generator[None, None, Placement | None]:
    """Its goal, or of a few places where the arm can lay an object down by a grasp that which is nearest to it.

    What lies flat on every face can be taken up again only where it hangs over the table's edge, or is slid there:
    such places come first.
    """
    second_best = None
    for place in chain(_free_goal(context, obj), _over_edges(context, obj), _flat_places(context, obj)):
        if clock.now() > context.deadline:
            break
        if lays(Detached.of(context, context.deadline), obj, place, grasp):
            if place == context.scene.goals.get(obj) or (yield from _taken_up_again(context, obj, place)):
                return place
            second_best = second_best or place
        yield None
    if second_best is None:
        context.fail(f"no place was found where the arm can lay {obj} down")
    return second_best


def _exposed(context: Context, obj: str, grasp: Grasp) -> Generator[None, None, Placement | None]:
    """A place over the table's edge where the arm can lay an object down by a grasp, and take it up by another one."""
    for place in _over_edges(context, obj):
        if clock.now() > context.deadline:
            return None
        detached = Detached.of(context, context.deadline)
        if lays(detached, obj, place, grasp) and (yield from grippable(detached, obj, place)):
            return place
        yield None
    context.fail(f"no place over an edge was found where the arm can lay {obj} down and take it up again")
    return None


def _taken_up_again(context: Context, obj: str, place: Placement) -> Generator[None, None, bool]:
    """Whether an object that was laid down can be gripped as it lies, or be slid to where it can."""
    if not lies_flat(context.scene, obj):
        return True
    detached = Detached.of(context, context.deadline)
    if hangs_over(context.scene, obj, place):
        return (yield from grippable(detached, obj, place))
    for slide in slides_in_steps(detached, obj, place):
        if slide is not None:
            return True
        yield None
    return False


def _flat_places(context: Context, obj: str) -> Iterator[Placement]:
    yield from _places(context, obj, flat_faces(context.scene, obj))


def _over_edges(context: Context, obj: str) -> Iterator[Placement]:
    """Places out of the way where what would lie flat on every face hangs over the table's edge, the safest first."""
    workspace: Workspace = context.scene
    if not lies_flat(workspace, obj):
        return
    others = {name: place for name, place in standing(context.bound).items() if name != obj}
    kept = [*others.items(), *((name, goal) for name, goal in workspace.goals.items() if name != obj)]
    flat = flat_faces(workspace, obj)
    for _ in range(TRIES):
        R = turned(flat[int(context.rng.integers(len(flat)))], context.rng.uniform(-np.pi, np.pi))
        amidst = amid(workspace, obj, R)
        above = replace(amidst, pose=Pose.from_matrix(moved(amidst.pose.matrix, np.array([0.0, 0.0, RELEASE_HEIGHT]))))
        free = (
            end.placement
            for end in sorted(ends(workspace, obj, above), key=lambda end: end.hanging)
            if not any(overlap(workspace, obj, end.placement, name, other) for name, other in kept)
        )
        yield from islice(free, EDGES)


def _free_goal(context: Context, obj: str) -> Iterator[Placement]:
    """The goal of an object, if it is another place on the table than now and nothing stands there by then."""
    workspace: Workspace = context.scene
    goal = workspace.goals.get(obj, workspace.start[obj])
    others = {name: place for name, place in standing(context.bound).items() if name != obj}
    if goal == workspace.start[obj] or goal.on != (TABLE,):
        return
    if not any(overlap(workspace, obj, goal, name, other) for name, other in others.items()):
        yield goal


def _upright(workspace: Workspace, obj: str, grasp: Grasp) -> list[NDArray[np.float64]]:
    """Steady orientations (3, 3) on the table in which the hand that puts the object down is clear of it."""
    flat = flat_faces(workspace, obj)
    faces = [R for R in resting(workspace, obj) if not _among(R, flat)]
    return [R for R in faces if hand_above_table(workspace, amid(workspace, obj, R).pose, grasp)]


def _among(R: NDArray[np.float64], faces: list[NDArray[np.float64]]) -> bool:
    return any(np.array_equal(R, other) for other in faces)


def _places(
    context: Context, obj: str, faces: list[NDArray[np.float64]], grasp: Grasp | None = None
) -> list[Placement]:
    """A few places out of the way, those first where it rests as it does now or shall, then those near its goal.

    What it rests on there is known to carry it; and it may have to stay near its goal.
    """
    workspace: Workspace = context.scene
    known = [place.pose.matrix[2, :3] for place in workspace.placements_of(obj)]
    familiar = [R for R in faces if any(R[2] @ up > FAMILIAR for up in known)]
    goal, found = workspace.goals.get(obj), []
    for choice in (familiar or faces, *[faces] * (TRIES - 1)):
        R = choice[int(context.rng.integers(len(choice)))]
        place = put_aside(context, obj, turned(R, context.rng.uniform(-np.pi, np.pi)), grasp)
        if place is not None:
            far = 0.0 if goal is None else dist(place.pose.xyz, goal.pose.xyz)
            found.append((not _among(R, familiar), far, place))
    return [place for _, _, place in sorted(found, key=lambda each: each[:2])]
