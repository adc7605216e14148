"""Estimates settled in physics: nothing floats, and nothing is inside another thing."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from tamp.execution.monitor import angle_between
from tamp.execution.settling.settle import settle
from tamp.execution.simulators import DEFAULT
from tamp.perception.estimate import Estimate
from tamp.task import Pose, Task

FAR, TURNED = 0.03, 0.5
"""An estimate that moves or turns more than this while settling contradicts the others [m], [rad]."""

SURE = 0.5
"""One of less confidence that does so is given up."""

LOWEST = -0.02
"""What comes to rest lower has fallen off the table [m]."""


def at_rest(task: Task, estimates: Mapping[str, Estimate], simulator: str = DEFAULT) -> dict[str, Estimate]:
    """The estimates as the objects come to rest where they are said to be.

    Estimates that cannot be, and that are not sure, are given up one after the other, the least sure first.

    Args:
        task: objects and table; its own poses are not looked at.
        estimates: object -> estimate.
        simulator: in which it settles.
    """
    kept = dict(estimates)
    while True:
        poses = {name: e.pose for name, e in kept.items() if e.pose is not None}
        settled = settle(task, poses, simulator=simulator).poses if poses else {}
        doubtful = [name for name in poses if kept[name].confidence < SURE and _strays(poses[name], settled[name])]
        if not doubtful:
            break
        kept[min(doubtful, key=lambda name: (kept[name].confidence, name))] = Estimate(None, 0.0)
    return {
        name: Estimate(None, 0.0)
        if name in settled and settled[name].xyz[2] < LOWEST
        else replace(e, pose=settled.get(name))
        for name, e in kept.items()
    }


def _strays(pose: Pose, rest: Pose) -> bool:
    return math.dist(pose.xyz, rest.xyz) > FAR or angle_between(pose, rest) > TURNED
