"""Candidate placements in place of a goal: upright, turned, shifted, and those that come to rest."""

from __future__ import annotations

import heapq
import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from tamp import clock
from tamp.execution.settling.settle import settle
from tamp.execution.simulators import DEFAULT
from tamp.pipeline.situation import placements, raised
from tamp.pipeline.strategies.subproblems.goal_graph import goal_supports
from tamp.scoring.ede import CORNERS, ede, mean_edge
from tamp.streams.affordances.neighbours import company
from tamp.streams.affordances.slide_path import LONGEST, directions, shifted, towards
from tamp.streams.affordances.stable_poses import righted, stands, steady_faces
from tamp.streams.collisions import overlap
from tamp.streams.placing.sampler import RELEASE_HEIGHT
from tamp.streams.values import Placement
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import At, Pose

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

LOWERINGS = 48  # steps on the way down
SETTLING_S = 3.0  # an object that moves longer than this has no place there
PUSHED = 0.004  # what the others move at most, and turn, when an object settles among them (EDE) [m]
SUNK = 4  # release heights at most above where an object comes to rest, to be clear of what it sinks into there
DRIFT = 0.01  # what they move so far at most by themselves, as what rolls does, is not that object's doing (EDE) [m]


def lowered(
    workspace: Workspace, name: str, pose: Pose, least: float, others: Mapping[str, Placement]
) -> Placement | None:
    """Lower an object straight down from a pose until it touches something; None where that takes too many steps.

    Args:
        workspace: the shapes.
        name: the object.
        pose: where it begins (world frame), clear of all others.
        least: the height of its origin when it is just above the table [m].
        others: what stands in its way.
    """
    T = pose.matrix
    beside = {other: place.pose.matrix for other, place in others.items()}
    for _ in range(LOWERINGS):
        gaps = {other: workspace.world.separation(name, T, other, T_other) for other, T_other in beside.items()}
        down = min([gap - RELEASE_HEIGHT for gap in gaps.values()], default=math.inf)
        if down < RELEASE_HEIGHT:
            touched = [other for other, gap in gaps.items() if gap < 2 * RELEASE_HEIGHT]
            return Placement(Pose.from_matrix(T), tuple(sorted(touched)))
        if T[2, 3] == least:
            return Placement(Pose.from_matrix(T), (TABLE,))
        # Lowering by the distance cannot make them touch, whatever their shapes (conservative advancement).
        T = T + np.outer([0, 0, 1, 0], [0, 0, 0, max(least - T[2, 3], -down)])
    return None


def settled(workspace: Workspace, name: str, place: Placement, simulator: str = DEFAULT) -> Placement | None:
    """Where an object comes to rest that is let go at a place; None where that pushes others or it falls off the table.

    It may sink into others as it does: it is let go as far above as it takes to be clear of them.

    Args:
        workspace: what else stands where.
        name: the object.
        place: where it is let go.
        simulator: in which it settles.
    """
    return _come_to_rest(workspace, name, place, simulator)[0]


def _come_to_rest(
    workspace: Workspace, name: str, place: Placement, simulator: str
) -> tuple[Placement | None, frozenset[str]]:
    """What `settled` says, and which others are pushed where it is None for that."""
    poses = {other: workspace.start[other].pose for other in company(workspace, name, place)}
    after = settle(workspace.task, {**poses, name: place.pose}, limit_s=SETTLING_S, simulator=simulator)
    low, _ = workspace.bounds(name, after.poses[name])
    if not after.resting or low[2] < -workspace.task.table.thickness:
        return None, frozenset()
    if _moved(workspace, poses, after.poses, PUSHED):
        alone = settle(workspace.task, poses, limit_s=SETTLING_S, simulator=simulator).poses
        pushed = _moved(workspace, alone, after.poses, PUSHED) | _moved(workspace, poses, alone, DRIFT)
        if pushed:
            return None, pushed
    rest = placements(after.poses, after.supports)[name]
    above = (raised(rest, steps * RELEASE_HEIGHT) for steps in range(1, SUNK + 1))
    return next((place for place in above if not _overlaps(workspace, name, place, poses)), None), frozenset()


def _moved(
    workspace: Workspace, before: Mapping[str, Pose], after: Mapping[str, Pose], farthest: float
) -> frozenset[str]:
    """Which of some objects move, and turn, farther than that (EDE) [m]."""
    edges = {name: mean_edge(workspace.task.object(name).shape) for name in before}
    return frozenset(name for name, pose in before.items() if ede(edges[name], after[name], pose) > farthest)


def _overlaps(workspace: Workspace, name: str, place: Placement, others: Iterable[str]) -> bool:
    return any(overlap(workspace, name, place, other, workspace.start[other]) for other in others)


GAIN = 0.03  # a placement must bring the object this much nearer to its goal (EDE) [m]
FACES = 6  # stable poses tried, the likeliest
TURNS = 8  # about the vertical, in which each is tried
RINGS = (0.015, 0.03, 0.05, 0.07, 0.09, 0.12, 0.15, 0.18, 0.22, 0.27, 0.33)  # round the goal's position [m]
SPOKES = 12  # positions on each ring
LOWERED = 300  # of those over other objects that are looked at
SETTLED = 12  # of those that are tried in physics
UNSEEN = 3  # of those, the nearest, that are tried whether they seem worth it or not
UNFIT = 30  # beginnings that are looked at, the nearest, of those in which no hand has room
APART = 0.02  # EDE between two that are tried [m]
UPSET = 0.02  # each time that an object was pushed, places on it count as so much farther (EDE) [m]
ALIKE = 0.02  # orientations whose entries differ by less are one
STRIDE = 0.04  # between places that an object is pushed to [m]
ABOVE = 0.005  # where an object begins on its way down, above everything below it [m]


@dataclass(frozen=True, eq=False)
class _Start:
    """Where an object begins on its way down, and how near its goal it may end.

    Attributes:
        pose: above everything below it (world frame).
        least: the height of its origin when it is just above the table [m].
        below: what may be in its way.
        bound: EDE at the best height on its way [m].
        steady: whether it would stay as it is on the table.
        fit: whether a hand that puts it down so may have room.
    """

    pose: Pose
    least: float
    below: tuple[str, ...]
    bound: float
    steady: bool
    fit: bool


@dataclass(frozen=True, eq=False)
class _Lowered:
    """Where an object touches something on its way down; it may fall from there.

    Attributes:
        place: there.
        below: what it touches.
        bound: EDE there [m].
        fit: as of where it began.
    """

    place: Placement
    below: tuple[str, ...]
    bound: float
    fit: bool


def substitutes(
    workspace: Workspace,
    name: str,
    worth: Callable[[Placement], bool],
    fits: Callable[[Array], bool],
    deadline: float = math.inf,
    simulator: str = DEFAULT,
) -> Iterator[Placement]:
    """Yield places to rest that are nearer to an object's goal than it is by `GAIN`, the nearest first.

    Those on what does not stay under the object where that was tried come later than others.

    Args:
        workspace: what stands where.
        name: an object whose goal, in the workspace's task, is a pose.
        worth: whether a place is worth a look in physics, where it is not plainly on the table.
        fits: whether a hand may put the object down as it is turned, shape (3, 3); otherwise only the nearest places
            are looked at, and none where the goal has all that it rests on and nothing is in its place.
        deadline: when no more are looked at, on the clock of tamp.clock.now() [s].
        simulator: in which objects settle there.
    """
    edge = mean_edge(workspace.task.object(name).shape)
    enough = _error(workspace, name, workspace.start[name].pose) - GAIN
    turns = [(R, steady, fits(R)) for R, steady in _orientations(workspace, name)]
    starts = [start for turn in turns for start in _starts(workspace, name, *turn)]
    waiting: list[tuple[float, int, _Start | _Lowered | Placement]] = [
        (start.bound, number, start) for number, start in enumerate(starts) if start.bound < enough
    ]
    heapq.heapify(waiting)
    # Where nothing keeps it from its goal, that itself was tried, and what it is near will fail alike.
    unfit, unseen = (0, 0) if _open(workspace, name) else (UNFIT, UNSEEN)
    lowerings, looked, upset = LOWERED, list[Pose](), Counter[str]()
    while waiting and clock.now() < deadline:
        counted, number, found = heapq.heappop(waiting)
        if isinstance(found, Placement):
            yield found
            continue
        farther = UPSET * max((upset[other] for other in found.below), default=0)
        if found.bound + farther > counted:
            heapq.heappush(waiting, (found.bound + farther, number, found))
            continue
        if isinstance(found, _Start):
            unfit -= not found.fit
            if (unfit < 0 and not found.fit) or (found.below and not lowerings):
                continue
            lowerings -= bool(found.below)
            step = _lowered(workspace, name, found)
        else:
            place = found.place
            known = any(ede(edge, place.pose, pose) < APART for pose in looked)
            if known or len(looked) == SETTLED or not (len(looked) < unseen or (found.fit and worth(place))):
                continue
            looked.append(place.pose)
            step, pushed = _come_to_rest(workspace, name, place, simulator)
            upset.update(pushed)
        if step is not None and (error := _error(workspace, name, _pose(step))) < enough:
            heapq.heappush(waiting, (error, number, step))


def _open(workspace: Workspace, name: str) -> bool:
    """Whether all that an object's goal rests on is there, and nothing is in its place."""
    goal, others = workspace.goals.get(name), [pair for pair in workspace.start.items() if pair[0] != name]
    there = all(workspace.start[lower] == workspace.goals[lower] for lower in goal_supports(workspace, name))
    return there and not (goal and any(overlap(workspace, name, goal, *other) for other in others))


def on_table(workspace: Workspace, name: str, fits: Callable[[Array], bool]) -> list[Placement]:
    """Places on the table with nothing over them that are nearer to an object's goal than it is, the nearest first.

    Arguments as of `substitutes`; a hand fits at each.
    """
    turns = [R for R, steady in _orientations(workspace, name) if steady and fits(R)]
    starts = [start for R in turns for start in _starts(workspace, name, R, steady=True, fit=True)]
    enough = _error(workspace, name, workspace.start[name].pose) - GAIN
    poses = [
        replace(start.pose, xyz=(*start.pose.xyz[:2], start.least))
        for start in starts
        if not start.below and start.bound < enough
    ]
    errors = [_error(workspace, name, pose) for pose in poses]
    nearest = sorted((error, number) for number, error in enumerate(errors) if error < enough)
    return [Placement(poses[number], (TABLE,)) for _, number in nearest]


def straight_ahead(workspace: Workspace, name: str) -> list[Placement]:
    """Places to which an object on the table could be pushed straight, nearer to its goal by `GAIN`, the nearest first.

    The whole object is on the table there, and nothing is above it or in its place.
    """
    here, others = workspace.start[name], [other for other in workspace.start if other != name]
    boxes = np.array([workspace.bounds(other, workspace.start[other].pose) for other in others]).reshape(-1, 2, 3)
    lower, upper = (bound[:2] for bound in workspace.bounds(name, here.pose))
    middle, half = np.array(workspace.task.table.center), np.array(workspace.task.table.size) / 2
    enough, found = _error(workspace, name, here.pose) - GAIN, list[tuple[float, int, Placement]]()
    to_goal = np.subtract(_goal(workspace, name).xyz, here.pose.xyz)[:2]
    straight = towards(workspace, name, here, to_goal) if to_goal.any() else ()
    for direction in (*directions(workspace, name, here), *straight):
        for length in np.arange(STRIDE, LONGEST, STRIDE):
            shift = length * direction.ahead
            whole = (lower + shift > middle - half).all() and (upper + shift < middle + half).all()
            taken = ((lower + shift < boxes[:, 1, :2]) & (upper + shift > boxes[:, 0, :2])).all(axis=1).any()
            end = shifted(here, shift)
            if whole and not taken and (error := _error(workspace, name, end.pose)) < enough:
                found.append((error, len(found), end))
    return [end for _, _, end in sorted(found)]


def _lowered(workspace: Workspace, name: str, start: _Start) -> _Lowered | Placement | None:
    """Where an object touches something on its way down, as it would rest there where that is plain."""
    below = {other: workspace.start[other] for other in start.below}
    place = lowered(workspace, name, start.pose, start.least, below)
    if place is None or (start.steady and place.on == (TABLE,)):
        return place
    return _Lowered(place, place.on, _error(workspace, name, place.pose), start.fit)


def _pose(step: _Lowered | Placement) -> Pose:
    return step.place.pose if isinstance(step, _Lowered) else step.pose


def _goal(workspace: Workspace, name: str) -> Pose:
    goal = workspace.task.object(name).goal
    if not isinstance(goal, At):
        raise ValueError(f"the goal of {name} is no pose")
    return goal.pose


def _error(workspace: Workspace, name: str, pose: Pose) -> float:
    return ede(mean_edge(workspace.task.object(name).shape), pose, _goal(workspace, name))


def _orientations(workspace: Workspace, name: str) -> Iterator[tuple[Array, bool]]:
    """Different orientations (3, 3), and whether the object stands so on the table."""
    seen: list[Array] = []
    for R, steady in _turns(workspace, name):
        if not any(np.allclose(R, other, atol=ALIKE) for other in seen):
            seen.append(R)
            yield R, steady


def _turns(workspace: Workspace, name: str) -> Iterator[tuple[Array, bool]]:
    """Orientations (3, 3): as the goal has it, as it is, and that and its stable faces turned about the vertical.

    The first turn of each is as near to the goal's orientation as it comes.
    """
    geometry = workspace.world.geometries[name]
    wanted, here = _goal(workspace, name).matrix[:3, :3], workspace.start[name].pose.matrix[:3, :3]
    # A ball has many faces, none of them likely, but it rests as it lies now.
    known = [righted(geometry, here)] if workspace.start[name].on == (TABLE,) else []
    faces = steady_faces(geometry)
    yield wanted, stands(geometry, wanted)
    yield from ((R, True) for R in known)
    for R in [*known, *faces[:FACES]]:
        M = R @ wanted.T
        # The angle that maximises the trace of Rz(angle) M.
        nearest = np.arctan2(M[0, 1] - M[1, 0], M[0, 0] + M[1, 1])
        for angle in nearest + np.linspace(0.0, 2 * np.pi, TURNS, endpoint=False):
            c, s = np.cos(angle), np.sin(angle)
            yield np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ R, True


def _starts(workspace: Workspace, name: str, R: Array, steady: bool, fit: bool) -> Iterator[_Start]:
    """Where an object may begin on its way down in one orientation, over and around its goal."""
    goal, points = _goal(workspace, name), workspace.points(name) @ R.T
    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = np.array(workspace.task.table.center), np.array(workspace.task.table.size) / 2
    xy = np.array(goal.xyz[:2]) + _offsets()
    xy = xy[((xy + low[:2] > middle - half) & (xy + high[:2] < middle + half)).all(axis=1)]
    names = [other for other in workspace.start if other != name]
    boxes = np.array([workspace.bounds(other, workspace.start[other].pose) for other in names]).reshape(-1, 2, 3)
    over = ((xy[:, None] + low[:2] < boxes[:, 1, :2]) & (xy[:, None] + high[:2] > boxes[:, 0, :2])).all(axis=2)
    least = RELEASE_HEIGHT - low[2]
    most = np.maximum(least, np.where(over, boxes[:, 1, 2] + ABOVE - low[2], -np.inf).max(axis=1, initial=-np.inf))
    best = np.column_stack([xy, np.clip(goal.xyz[2], least, most)])
    turn = mean_edge(workspace.task.object(name).shape) * CORNERS @ (R - goal.matrix[:3, :3]).T
    bounds = np.linalg.norm(best[:, None] - goal.xyz + turn, axis=2).mean(axis=1)
    T = np.eye(4)
    T[:3, :3] = R
    for (x, y), z, bound, hit in zip(xy, most, bounds, over, strict=True):
        T[:3, 3] = x, y, z
        below = tuple(other for other, is_hit in zip(names, hit, strict=True) if is_hit)
        yield _Start(Pose.from_matrix(T), float(least), below, float(bound), steady, fit)


def _offsets() -> Array:
    """Positions on the rings and their centre, shape (n, 2) [m]."""
    angles = np.linspace(0.0, 2 * np.pi, SPOKES, endpoint=False)
    rings = np.multiply.outer(RINGS, np.column_stack([np.cos(angles), np.sin(angles)]))
    return np.vstack([np.zeros((1, 2)), rings.reshape(-1, 2)])
