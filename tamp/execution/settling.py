"""Letting a scene come to rest: where things really stand, and what stands on what."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from tamp.errors import PlanningFailure
from tamp.execution.leaning import leaning
from tamp.execution.monitor import angle_between
from tamp.execution.simulator import Simulator
from tamp.task import Pose, Task

GENTLE_S = 0.5
"""How long speeds are limited at the start, so that bodies that overlap part without a bang [s]."""

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
        object.__setattr__(self, "poses", MappingProxyType(dict(self.poses)))
        object.__setattr__(self, "moved", MappingProxyType(dict(self.moved)))


def settle(
    task: Task, poses: Mapping[str, Pose] | None = None, *, limit_s: float = 6.0, deadline: float = math.inf
) -> Settled:
    """Drop a task's objects as they stand and wait until they rest; the robot is left out.

    Args:
        task: objects and table.
        poses: object -> pose (world frame); an object absent here stays out of the scene. None: the start poses.
        limit_s: simulated time after which the scene is taken as it is [s].
        deadline: on the clock of time.monotonic [s].

    Raises:
        TaskError: where an object's mesh cannot be used.
        PlanningFailure: past the deadline, since a scene that still moves is nothing to plan from.
    """
    start = {item.name: item.pose for item in task.objects} if poses is None else dict(poses)
    objects = [item for item in task.objects if item.name in start]
    _in_time(deadline)
    with Simulator(objects, start, table=task.table) as simulator:
        resting = let_settle(simulator, limit_s, deadline)
        settled = simulator.poses()
        return Settled(
            poses=settled,
            supports=tuple(sorted({*supports(simulator), *leaning(objects, settled, simulator.touches(), UPRIGHT)})),
            moved={name: math.dist(pose.xyz, start[name].xyz) for name, pose in settled.items()},
            resting=resting,
        )


def _in_time(deadline: float) -> None:
    if time.monotonic() >= deadline:
        raise PlanningFailure("timeout", "time was up before the scene had come to rest")


def let_settle(simulator: Simulator, limit_s: float, deadline: float = math.inf) -> bool:
    """Step a scene until it rests, gently at first; False where it still moves after `limit_s` [s]."""
    gentle_until = simulator.time + GENTLE_S
    while simulator.time < gentle_until:
        _in_time(deadline)
        simulator.step()
        simulator.limit_speeds(GENTLE_SPEED, GENTLE_TURN)

    since, poses, stays = simulator.time, simulator.poses(), False

    def resting() -> bool:
        nonlocal since, poses, stays
        _in_time(deadline)
        if simulator.time >= since + WINDOW_S:
            before, poses = poses, simulator.poses()
            stays = _stays(before, poses, simulator.time - since)
            since = simulator.time
        return stays or at_rest(simulator)

    return simulator.wait(limit_s - GENTLE_S, resting, patience=REST_STEPS)


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
        if touch.force <= 0.0 or "robot" in (touch.a, touch.b):
            continue
        if touch.normal[2] > UPRIGHT:
            found.add((touch.a, touch.b))
        elif touch.normal[2] < -UPRIGHT:
            found.add((touch.b, touch.a))
    return tuple(sorted(found))
