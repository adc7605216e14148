"""Letting a scene come to rest: where things really stand, what stands on what, and what leans on what."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tamp import clock
from tamp.errors import PlanningFailure
from tamp.execution.monitor import angle_between
from tamp.execution.simulator import ROBOT, Simulator, Touch, wait
from tamp.execution.simulators import DEFAULT, make_simulator
from tamp.frozen import FrozenDict
from tamp.task import Object, Pose, Table, Task
from tamp.world.geometry.object_geometry import geometry_of_object

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

INSIDE = 0.002
"""What has its centre of mass no farther than this inside what carries it would tip over by itself, or nearly [m]."""

LOW = 0.002
"""Vertices so little above the lowest are over what carries a body too: the simulator names a few contacts only [m]."""

AGAINST = 0.1
"""Least share that a push has in all that keeps a body from tipping, each along the way in which it would."""


def leaning(
    objects: Iterable[Object], poses: Mapping[str, Pose], touches: Iterable[Touch], upright: float
) -> Iterator[tuple[str, str]]:
    """Yield pairs (what leans, on what) of bodies, "table" among the latter.

    Of two that push each other, that leans whose centre of mass is farther beside what carries it.

    Args:
        objects: the bodies.
        poses: object -> where it is at rest (world frame).
        touches: the contacts of all of them.
        upright: vertical share of a contact's normal from which it carries.
    """
    seen = [*touches]
    seen += [Touch(t.b, t.a, (-t.normal[0], -t.normal[1], -t.normal[2]), t.depth, t.force, t.point) for t in seen]
    beside: dict[tuple[str, str], float] = {}
    for item in objects:
        mine = [touch for touch in seen if touch.a == item.name]
        carrying = np.array([touch.point for touch in mine if touch.normal[2] > upright]).reshape(-1, 3)
        far, way = _tipping(item, poses[item.name], carrying) if len(carrying) else (-math.inf, np.zeros(2))
        pushing = [touch for touch in mine if far > -INSIDE and touch.normal[2] <= upright]
        against = [max(0.0, -touch.force * float(np.array(touch.normal[:2]) @ way)) for touch in pushing]
        for touch, push in zip(pushing, against, strict=True):
            if push > AGAINST * sum(against):
                beside[item.name, touch.b] = far
    yield from (pair for pair, far in beside.items() if far > beside.get(pair[::-1], -math.inf))


def _tipping(item: Object, pose: Pose, carrying: Array) -> tuple[float, Array]:
    """How far a body's centre of mass is beside what carries it, (n, 3) [m], and in which level direction (2,)."""
    geometry, T = geometry_of_object(item), pose.matrix
    points = np.vstack([part.vertices for part in geometry.parts]) @ T[:3, :3].T + T[:3, 3]
    low = np.vstack([points[points[:, 2] < points[:, 2].min() + LOW], carrying])
    angles = np.linspace(0.0, 2 * np.pi, 90, endpoint=False)
    ways = np.column_stack([np.cos(angles), np.sin(angles)])
    center = T[:3, :3] @ geometry.center_of_mass + T[:3, 3]
    reach = ((low - center)[:, :2] @ ways.T).max(axis=0)
    worst = int(reach.argmin())
    return -float(reach[worst]), ways[worst]


GENTLE_S = 0.5
"""How long speeds are limited at the start, so that bodies that overlap part without a bang [s]."""

PARTED, PARTED_S = 0.005, 2.0
"""Bodies that are deeper than this in each other [m] are let part as gently, but no longer than this [s]."""

GENTLE_SPEED, GENTLE_TURN = 0.05, 0.5
"""[m/s], [rad/s]."""

REST_SPEED, REST_TURN = 0.002, 0.02
"""Below these a body counts as resting [m/s], [rad/s]."""

REST_STEPS = 60
"""How long it must rest."""

WINDOW_S = 0.5
"""What trembles rests too where it hardly moves on: slower than that on the whole over this long [s]."""

UPRIGHT = 0.2
"""A contact supports where its normal's vertical share is over this: a bowl in a bowl hangs on walls of 75 degrees."""


@dataclass(frozen=True)
class Settled:
    """A scene at rest.

    Attributes:
        poses: object -> pose (world frame).
        supports: pairs (above, below) of bodies that touch with one carrying the other, or keeping it from tipping
            over, sorted; "table" may be below.
        moved: object -> how far its origin moved while settling [m].
        resting: whether everything came to rest within the time allowed.
    """

    poses: Mapping[str, Pose]
    supports: tuple[tuple[str, str], ...]
    moved: Mapping[str, float]
    resting: bool

    def __post_init__(self) -> None:
        object.__setattr__(self, "poses", FrozenDict(self.poses))
        object.__setattr__(self, "moved", FrozenDict(self.moved))


def settle(
    task: Task,
    poses: Mapping[str, Pose] | None = None,
    *,
    limit_s: float = 6.0,
    deadline: float = math.inf,
    simulator: str = DEFAULT,
) -> Settled:
    """Drop a task's objects as they stand and wait until they rest; the robot is left out.

    Args:
        task: objects and table.
        poses: object -> pose (world frame); an object absent here stays out of the scene. None: the start poses.
        limit_s: simulated time after which the scene is taken as it is [s].
        deadline: on the clock of tamp.clock.now() [s].
        simulator: its name, or "package.module:Class".

    Raises:
        TampError: where the simulator is unknown or not installed.
        TaskError: where an object's mesh cannot be used.
        PlanningFailure: past the deadline, since a scene that still moves is nothing to plan from.
    """
    start = {item.name: item.pose for item in task.objects} if poses is None else dict(poses)
    objects = [item for item in task.objects if item.name in start]
    _in_time(deadline)
    with make_simulator(simulator, objects, start, table=task.table) as world:
        resting = let_settle(world, limit_s, deadline)
        settled = world.poses()
        return Settled(
            poses=settled,
            supports=_one_way(objects, settled, world),
            moved={name: math.dist(pose.xyz, start[name].xyz) for name, pose in settled.items()},
            resting=resting,
        )


def _one_way(objects: Iterable[Object], settled: Mapping[str, Pose], world: Simulator) -> tuple[tuple[str, str], ...]:
    """What carries what, sorted; of two that push each other up, as what is jammed in a box does, the lower carries."""
    found = {*supports(world), *leaning(objects, settled, world.touches(), UPRIGHT)}
    height = {item.name: _height(item, settled[item.name]) for item in objects}
    kept = (pair for pair in found if pair[::-1] not in found or height[pair[0]] > height[pair[1]])
    return tuple(sorted(kept))


def _height(item: Object, pose: Pose) -> float:
    """Of a body's centre of mass over the table [m]."""
    return float((pose.matrix[:3, :3] @ geometry_of_object(item).center_of_mass)[2] + pose.xyz[2])


FALLING_S = 3.0
"""How long something may fall, rock and roll until it rests [s]."""

FALLEN_STEPS = 20
"""How long it must rest after that."""


def let_fall(
    objects: Sequence[Object], poses: Mapping[str, Pose], *, table: Table, simulator: str = DEFAULT
) -> Mapping[str, Pose] | None:
    """Where objects come to rest that are let go as they stand, at full speed; None where they still move.

    Args:
        objects: all bodies beside the table.
        poses: object -> pose (world frame).
        table: on which they fall.
        simulator: its name, or "package.module:Class".

    Raises:
        TampError, TaskError: as `settle`.
    """
    with make_simulator(simulator, objects, poses, table=table) as world:
        rests = wait(world, FALLING_S, _resting(world), patience=FALLEN_STEPS)
        return world.poses() if rests else None


def _in_time(deadline: float) -> None:
    if clock.now() >= deadline:
        raise PlanningFailure("timeout", "time was up before the scene had come to rest")


def let_settle(simulator: Simulator, limit_s: float, deadline: float = math.inf) -> bool:
    """Step a scene until it rests, gently at first; False where it still moves after `limit_s` [s]."""
    began = simulator.time
    while simulator.time < began + GENTLE_S or (simulator.time < began + PARTED_S and _deepest(simulator) > PARTED):
        simulator.step()
        simulator.limit_speeds(GENTLE_SPEED, GENTLE_TURN)
    _in_time(deadline)
    return wait(simulator, limit_s - GENTLE_S, _resting(simulator, deadline), patience=REST_STEPS)


def _resting(simulator: Simulator, deadline: float = math.inf) -> Callable[[], bool]:
    """Tells after each step whether every object is nearly still, or has hardly moved on for a while."""
    since, poses, stays = simulator.time, simulator.poses(), False

    def resting() -> bool:
        nonlocal since, poses, stays
        if simulator.time >= since + WINDOW_S:
            _in_time(deadline)
            before, poses = poses, simulator.poses()
            stays = _stays(before, poses, simulator.time - since)
            since = simulator.time
        return stays or at_rest(simulator)

    return resting


def _deepest(simulator: Simulator) -> float:
    """How deep two bodies are in each other, at most [m]."""
    return max((touch.depth for touch in simulator.touches()), default=0.0)


def at_rest(simulator: Simulator) -> bool:
    """Whether every object is nearly still."""
    return all(v < REST_SPEED and w < REST_TURN for v, w in simulator.speeds().values())


def _stays(before: Mapping[str, Pose], after: Mapping[str, Pose], seconds: float) -> bool:
    """Whether every object has hardly moved on in a time, however it trembled: contacts of many hulls keep pushing."""
    return all(
        math.dist(pose.xyz, before[name].xyz) < REST_SPEED * seconds
        and angle_between(pose, before[name]) < REST_TURN * seconds
        for name, pose in after.items()
    )


def supports(simulator: Simulator) -> tuple[tuple[str, str], ...]:
    """Pairs (above, below) of bodies where the lower one carries the upper one, sorted."""
    found = set()
    for touch in simulator.touches():
        if touch.force <= 0.0 or ROBOT in (touch.a, touch.b):
            continue
        if touch.normal[2] > UPRIGHT:
            found.add((touch.a, touch.b))
        elif touch.normal[2] < -UPRIGHT:
            found.add((touch.b, touch.a))
    return tuple(sorted(found))
