"""Regrasps: an object is put down in between, so that it is put to its goal by another grasp than it was taken up by.

Grasps for the start and grasps for the goal are paired where the object has a face to stand on that leaves room for
both hands. Then a place for it is sought on the table where the arm reaches it by both. What has to be turned over may
be laid down there, unless it would roll, and what goes into something may be dropped: it falls the last bit (see
`laying`); before that, places over an edge of the table are tried.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import chain, islice, product
from typing import TYPE_CHECKING

import numpy as np

from tamp import clock
from tamp.streams.affordances.neighbours import upon_carriers
from tamp.streams.affordances.stable_poses import amid, resting, stays, turned
from tamp.streams.affordances.tilts import layable, tilts
from tamp.streams.cache import recalled
from tamp.streams.context import Context, Detached
from tamp.streams.grasping.sampler import grasps
from tamp.streams.hand.clearance import arm_above_table, hand_above_table
from tamp.streams.motion.inverse_kinematics import reaches
from tamp.streams.placing.over_edge import Grasps, Regrasp, regrasps_over_edges
from tamp.streams.placing.sampler import RELEASE_HEIGHT, put_aside, stands_then
from tamp.streams.releasing.tilted_release import falls_flat, lays, letting_go_at
from tamp.streams.values import Grasp, Placement
from tamp.streams.workspace import TABLE, Workspace, standing
from tamp.task import Pose
from tamp.world.kinematics.inverse import approachable

if TYPE_CHECKING:
    from numpy.typing import NDArray

ENDS = 80  # grasps for the start, and for the goal, that are looked at
PAIRS = 24  # of them that are tried in turn
ROUNDS = 6  # times at most that a place in between is sought for each pair
BLOCKED = 24  # pairs of which none takes the object up without meeting others, before these are tried
DRAWN, BLOCKS = 24, 3  # places in one round, drawn so many times at most ...
TRIES = 8  # ... until so many are found that the arm seems to reach, for which it is asked
FEW = 8  # grasps that can lay it down; where there are fewer, such ones are sought ...
RELEASES, EACH = 4, 12  # ... for the start and each of so many tilts, so many grasps each

Pair = tuple[Grasp, Grasp, list["NDArray[np.float64]"], bool]
Ask = Callable[[Context, str, Placement, Grasp], bool]


@dataclass(frozen=True)
class Ends:
    """Both ends of a regrasp: where an object is and shall be, and grasps that may serve there, the best first."""

    obj: str
    start: Placement
    goal: Placement
    first: Sequence[Grasp]
    second: Sequence[Grasp]


def sample_regrasp(context: Context, obj: str, start: Placement, goal: Placement) -> Iterator[Regrasp]:
    """Yield (grasp that takes the object up, placement in between, grasp that puts it to its goal).

    Each is free of collision with the table, the robot and the object, as if nothing else stood there. The placement
    keeps away from what the plan has placed, and from every start and goal.
    """
    yield from _regrasps(context, obj, start, goal, _grasps_for)


def _grasps_for(context: Context, obj: str, *places: Placement) -> Iterator[Grasp]:
    yield from grasps(context, obj, places)


def regrasping(sample_grasp: Callable[..., Iterable[Grasp]]) -> Callable[..., Iterator[Regrasp]]:
    """The same with the grasps of another sampler for `sample-grasp`."""

    def wherever(context: Context, obj: str, *_: Placement) -> Iterable[Grasp]:
        return sample_grasp(context, obj)

    def sample(context: Context, obj: str, start: Placement, goal: Placement) -> Iterator[Regrasp]:
        yield from _regrasps(context, obj, start, goal, wherever)

    return sample


def _regrasps(context: Context, obj: str, start: Placement, goal: Placement, grasps: Grasps) -> Iterator[Regrasp]:
    """Those that put the object down amid the table; else over an edge that many hands serve, or lay it down.

    If there are none of these, those over an edge that few hands seem to serve.
    """
    first, second = (list(islice(grasps(context, obj, place), ENDS)) for place in (start, goal))
    for found, deed in ((first, "takes it up"), (second, "puts it to its goal")):
        if not found:
            context.fail(f"no grasp of {obj} {deed}")
    ends = Ends(obj, start, goal, first, second)
    over_edges = partial(regrasps_over_edges, context, obj, start, goal, grasps)
    for regrasps in (
        _amid(context, ends, _pairs(context, ends, laid=False)),
        chain(over_edges(many=True), _laid_amid(context, ends, grasps)),
        over_edges(many=False),
    ):
        came = False
        for regrasp in regrasps:
            came = True
            yield regrasp
        if came or clock.now() > context.deadline:
            return


def _laid_amid(context: Context, ends: Ends, grasps: Grasps) -> Iterator[Regrasp]:
    """Regrasps that lay an object down amid the table, by grasps that are sought for that too."""
    workspace, obj = context.scene, ends.obj
    midst = [amid(workspace, obj, R) for R in resting(workspace, obj)]
    faces = [place for place in midst if any(hand_above_table(workspace, place.pose, grasp) for grasp in ends.second)]
    first = [*ends.first, *_layers(context, obj, ends.start, faces, ends.first, grasps)]
    able = replace(ends, first=first)
    yield from _amid(context, able, _pairs(context, able, laid=True))


def _amid(context: Context, ends: Ends, paired: Iterable[Pair]) -> Iterator[Regrasp]:
    """Pairs of grasps with a place amid the table that both of them reach."""
    obj, pairs = ends.obj, _free_first(context, ends.obj, ends.start, paired)
    drawn: Iterable[Pair] = islice(pairs, PAIRS)
    for _ in range(ROUNDS):
        found, tried = False, list[Pair]()
        for pair in drawn:
            tried.append(pair)
            place = _between(context, ends, *pair)
            if place is not None:
                found = True
                yield pair[0], place, pair[1]
                continue
            context.fail(f"no place for {obj} in between that both grasps reach")
            if clock.now() > context.deadline:
                return
        if not found:
            return
        drawn = tried


def _free_first(context: Context, obj: str, start: Placement, pairs: Iterable[Pair]) -> Iterator[Pair]:
    """The pairs that take an object up without meeting what the plan has standing there; those that meet it come last.

    Only so many of those are looked at.
    """
    around = {name: place for name, place in standing(context.bound).items() if name != obj}

    @cache
    def free(grasp: Grasp) -> bool:
        return reaches(Detached.of(context), obj, start, grasp, among=around)

    blocked: list[Pair] = []
    for pair in pairs:
        if free(pair[0]):
            yield pair
        else:
            blocked.append(pair)
        if len(blocked) == BLOCKED:
            break
    yield from blocked


def _pairs(context: Context, ends: Ends, *, laid: bool) -> Iterator[Pair]:
    """Grasps that can take turns, and the faces (3, 3) to rest on meanwhile; the best of both ends first.

    Where an object is laid down, grasps that can do so from many tilts come first: the arm seldom gets to the one tilt
    that another leaves; those come last of which it is not sure that it lands on the face, and those whose arm is above
    the table at its edges alone. Else those come first that put it on a face from which it does not tip over.
    """
    workspace: Workspace = context.scene
    obj, first, second = ends.obj, ends.first, ends.second
    rotations = resting(workspace, obj)
    midst = [amid(workspace, obj, R) for R in rotations]
    over = {grasp: [hand_above_table(workspace, place.pose, grasp) for place in midst] for grasp in second}
    put = {grasp: [_ways_down(workspace, ends, place, grasp, laid) for place in midst] for grasp in first}
    best = sorted(first, key=lambda grasp: -max(put[grasp], default=0))
    shared = {pair: _shared(rotations, put[pair[0]], over[pair[1]]) for pair in product(best, second)}
    takes = cache(lambda grasp: _known(context, "takes", obj, ends.start, grasp, _takes))
    brings = cache(lambda grasp: _known(context, "brings", obj, ends.goal, grasp, _brings))
    able, unsure = False, list[Pair]()
    for one, other in _each_with_others(best, second, shared):
        if clock.now() > context.deadline:
            return
        if takes(one) and brings(other):
            able, faces = True, shared[one, other]
            sure = [R for R in faces if not laid or _falls_flat(workspace, obj, R, one, surely=True)]
            if sure and (not laid or any(_reached_amid(context, obj, R, one) for R in sure)):
                yield one, other, sure, laid
            elif len(unsure) < FEW and (faces := [R for R in faces if _falls_flat(workspace, obj, R, one)]):
                unsure.append((one, other, faces, laid))
    yield from unsure
    if laid and first and second and not able:
        context.fail(f"{obj} has no face to rest on with room for the hands of two grasps that reach it")


def _layers(
    context: Context, obj: str, start: Placement, faces: list[Placement], known: Sequence[Grasp], grasps: Grasps
) -> list[Grasp]:
    """Grasps that take an object up and can lay it down on one of some faces, where few of the known ones can.

    They are sought for the start and the poses from which most hands could let it fall: the most tilted ones.
    """
    workspace: Workspace = context.scene
    if sum(any(_ways_laid(workspace, obj, place, grasp) for place in faces) for grasp in known) >= FEW:
        return []
    falls = [tilt.fall[0] for place in faces if _able(workspace, obj, place) for tilt in tilts(workspace, obj, place)]
    found = list[Grasp]()
    for let_go in falls[: -RELEASES - 1 : -1]:
        found += islice(grasps(context, obj, start, Placement(let_go, (TABLE,))), EACH)
    return [grasp for grasp in dict.fromkeys(found) if grasp not in known]


def _falls_flat(workspace: Workspace, obj: str, R: NDArray[np.float64], grasp: Grasp, *, surely: bool = False) -> bool:
    """Whether an object that a hand lays down comes to rest turned by R (3, 3), let go as far up as places are."""
    return falls_flat(workspace, obj, _let_go_over(workspace, obj, R), grasp, surely=surely)


def _let_go_over(workspace: Workspace, obj: str, R: NDArray[np.float64]) -> Placement:
    """An object turned by R (3, 3) in the middle of the table, as far up as places are."""
    pose = amid(workspace, obj, R).pose
    x, y, z = pose.xyz
    return Placement(Pose((x, y, z + RELEASE_HEIGHT), pose.quat), (TABLE,))


def _able(workspace: Workspace, obj: str, place: Placement) -> bool:
    """Whether an object may be laid down at a place, where it is sure to stay."""
    return layable(workspace, obj, place) and _stays(workspace, obj, place.pose.matrix[:3, :3])


def _shared(rotations: list[NDArray[np.float64]], one: list[int], other: list[bool]) -> list[NDArray[np.float64]]:
    """The faces, among `rotations` (3, 3), for which both say yes."""
    return [R for R, *both in zip(rotations, one, other, strict=True) if all(both)]


def _each_with_others(
    first: Sequence[Grasp], second: Sequence[Grasp], shared: Mapping[tuple[Grasp, Grasp], list[NDArray[np.float64]]]
) -> Iterator[tuple[Grasp, Grasp]]:
    """The pairs that share a face: each of the first grasps with one partner, then each with another one, and so on.

    What bars one grasp from being laid down bars those like it, whatever they are paired with.
    """
    partners = {one: [other for other in second if shared[one, other]] for one in first}
    for turn in range(len(second)):
        for index, one in enumerate(first):
            if turn < len(partners[one]):
                yield one, partners[one][(index + turn) % len(partners[one])]


def _known(context: Context, word: str, obj: str, place: Placement, grasp: Grasp, ask: Ask) -> bool:
    """What is found of a grasp at the start or at the goal, remembered: many other ends are paired with it."""
    reads = upon_carriers(context.scene, obj, place)
    found = recalled(context, word, (obj, place, grasp), reads, lambda own: iter((ask(own, obj, place, grasp),)))
    return next(found, False)


def _takes(context: Context, obj: str, place: Placement, grasp: Grasp) -> bool:
    return reaches(Detached.of(context), obj, place, grasp)


def _brings(context: Context, obj: str, place: Placement, grasp: Grasp) -> bool:
    return _takes(context, obj, place, grasp) or lays(Detached.of(context), obj, place, grasp)


def _ways_down(workspace: Workspace, ends: Ends, place: Placement, grasp: Grasp, laid: bool) -> int:
    """How many ways there are to put an object down, or else to lay it down, with the hand clear of the table.

    To put it where it stays, even turned as it may be in the hand by then, counts twice.
    """
    obj = ends.obj
    if not laid:
        able = hand_above_table(workspace, place.pose, grasp)
        return able and 1 + stands_then(workspace, obj, grasp, ends.start.pose, place.pose.matrix[:3, :3])
    return _ways_laid(workspace, obj, place, grasp)


def _ways_laid(workspace: Workspace, obj: str, place: Placement, grasp: Grasp) -> int:
    tilted = tilts(workspace, obj, place) if _able(workspace, obj, place) else ()
    return sum(hand_above_table(workspace, tilt.fall[0], grasp) for tilt in tilted)


def _stays(workspace: Workspace, obj: str, R: NDArray[np.float64]) -> bool:
    """Whether an object that is let go of, turned by R (3, 3), is sure to stay so, even if it slipped in the hand."""
    return workspace.cache.value(("stays", obj, R.tobytes()), lambda: stays(workspace.world.geometries[obj], R))


def _between(
    context: Context, ends: Ends, one: Grasp, other: Grasp, faces: list[NDArray[np.float64]], laid: bool
) -> Placement | None:
    """A place on the table where the arm puts or lays the object down by one grasp and takes it up by the other."""
    workspace, obj, lifted = context.scene, ends.obj, ends.start.pose
    surely = partial(_stays, workspace, obj) if laid else partial(stands_then, workspace, obj, one, lifted)
    faces = list(filter(surely, faces)) or faces
    for place in islice(_at_a_glance(context, obj, one, other, faces, laid), TRIES):
        if clock.now() > context.deadline:
            return None
        if _takes(context, obj, place, other) and (_lays if laid else _takes)(context, obj, place, one):
            return place
    return None


def _at_a_glance(
    context: Context, obj: str, one: Grasp, other: Grasp, faces: list[NDArray[np.float64]], laid: bool
) -> Iterator[Placement]:
    """Places that the arm seems to reach by both grasps: to find out that it does not takes 100 times longer."""
    for _ in range(BLOCKS):
        R = faces[context.rng.integers(len(faces))]
        angles = context.rng.uniform(-np.pi, np.pi, DRAWN)
        places = [*filter(None, (put_aside(context, obj, turned(R, angle)) for angle in angles))]
        for grasp, falls in ((other, False), (one, laid)):
            if places:
                reached = _reached(context, obj, places, grasp, falls)
                places = [place for place, able in zip(places, reached, strict=True) if able]
        yield from places


def _reached(context: Context, obj: str, places: list[Placement], grasp: Grasp, falls: bool) -> NDArray[np.bool_]:
    """Whether the arm seems to get a hand to each of n places, or to where the object may fall from to it, and back.

    The places differ in where they are on the table and in heading alone, and so do the ways to fall to them; (n,).
    """
    workspace: Workspace = context.scene
    T = np.array([place.pose.matrix for place in places])
    poses = letting_go_at(context, obj, places[0], grasp) if falls else [places[0].pose]
    if not poses:
        return np.zeros(len(T), bool)
    tools = np.linalg.inv(T[0]) @ np.array([pose.matrix for pose in poses]) @ grasp.T_object_tool.matrix
    found = (T[:, None] @ tools).reshape(-1, 4, 4)
    back, away = min(workspace.hand.approaches), found.copy()
    away[:, :3, 3] -= back * found[:, :3, 2]
    able = arm_above_table(workspace, found) & arm_above_table(workspace, away)
    able[able] = approachable(workspace.world.robot, found[able], back)
    return np.asarray(able.reshape(len(T), -1).any(axis=1))


def _reached_amid(context: Context, obj: str, R: NDArray[np.float64], grasp: Grasp) -> bool:
    """Whether the arm may be above the table where it lays an object down by a grasp in the middle of it."""
    return bool(_reached(context, obj, [_let_go_over(context.scene, obj, R)], grasp, True)[0])


def _lays(context: Context, obj: str, place: Placement, grasp: Grasp) -> bool:
    return lays(Detached.of(context), obj, place, grasp)
