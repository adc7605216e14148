"""Scenes that have come to rest before, in this run or another, kept in the user's cache folder by all that decides it.

That is the scene, the code that lets it settle, the versions of simulator and libraries, and the processor: the last
bits of a matrix product are its own affair.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import importlib.util
import json
import math
import platform
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tamp import clock
from tamp.errors import PlanningFailure
from tamp.execution import monitor
from tamp.execution import simulator as protocol
from tamp.execution.settling import rounding, settle
from tamp.execution.settling.rounding import nearest_rest
from tamp.execution.settling.settle import Settled
from tamp.execution.simulators import DEFAULT, SIMULATORS
from tamp.task import Mesh, Object, Pose, Task
from tamp.task.mesh.cache import cached, content_key
from tamp.task.mesh.parts import parts
from tamp.versions import versions
from tamp.world.geometry import object_geometry

if TYPE_CHECKING:
    from numpy.typing import NDArray

CPUINFO = Path("/proc/cpuinfo")
WORTH_S = 0.05
"""A scene that settles in less processor time settles again: thousands of small ones would fill the folder [s]."""


def settle_once(
    task: Task, poses: Mapping[str, Pose] | None = None, *, deadline: float = math.inf, simulator: str = DEFAULT
) -> Settled:
    """What `nearest_rest` returns, to the last bit, without a simulation where the same scene came to rest before.

    For what is likely to be asked again: a task's start and goals. What a simulator of somebody else's does is not
    kept, since nobody knows what decides it.

    Args:
        task: objects and table.
        poses: object -> pose (world frame); an object absent here stays out of the scene. None: the start poses.
        deadline: on the clock of tamp.clock.now() [s].
        simulator: its name, or "package.module:Class".

    Raises:
        TampError, TaskError, PlanningFailure: as `nearest_rest`.
    """
    start = {item.name: item.pose for item in task.objects} if poses is None else dict(poses)
    objects = [item for item in task.objects if item.name in start]
    if simulator not in SIMULATORS or not SIMULATORS[simulator].installed:
        return nearest_rest(task, start, deadline=deadline, simulator=simulator)
    if clock.now() >= deadline:
        raise PlanningFailure("timeout", "time was up before the scene had come to rest")
    scene = [_said_of(item, start[item.name]) for item in objects]
    key = content_key("settled-2", _program(simulator), repr(task.table), *scene)
    names = [item.name for item in objects]

    def simulated() -> dict[str, NDArray[Any]]:
        return _arrays(nearest_rest(task, start, deadline=deadline, simulator=simulator), names)

    found = cached("settled", key, simulated, worth_s=WORTH_S)
    return _settled(found, names, start)


def _said_of(item: Object, pose: Pose) -> bytes:
    """All of an object that decides how it comes to rest."""
    digest = hashlib.sha256(repr((item.name, item.mass, item.friction, item.inertia, pose)).encode())
    if isinstance(item.shape, Mesh):
        for part in parts(item.shape):
            digest.update(repr((part.vertices.shape, part.faces.shape)).encode())
            digest.update(part.vertices.tobytes() + part.faces.tobytes())
    else:
        digest.update(repr(item.shape).encode())
    return digest.digest()


@cache
def _program(name: str) -> str:
    """Code, versions and processor, as one number."""
    entry = SIMULATORS[name]
    engine = importlib.util.find_spec(entry.address.partition(":")[0])
    files = [Path(str(module.__file__)) for module in (monitor, rounding, settle, protocol, object_geometry)]
    files += sorted(Path(str(engine.origin)).parent.glob("*.py")) if engine is not None else []
    version = importlib.metadata.version(entry.library)
    said = json.dumps([versions(), entry.library, version, platform.machine(), _processor()])
    return content_key(said, *(file.read_bytes() for file in files))


def _processor() -> str:
    """The processor's name, as far as the system tells it."""
    lines = CPUINFO.read_text(encoding="utf-8").splitlines() if CPUINFO.is_file() else ()
    return next((line for line in lines if line.startswith("model name")), platform.processor())


def _arrays(settled: Settled, names: Sequence[str]) -> dict[str, NDArray[Any]]:
    return {
        "poses": np.array([(*settled.poses[name].xyz, *settled.poses[name].quat) for name in names]).reshape(-1, 7),
        "supports": np.array(settled.supports, dtype=np.str_).reshape(-1, 2),
        "resting": np.array(settled.resting),
    }


def _settled(arrays: Mapping[str, NDArray[Any]], names: Sequence[str], start: Mapping[str, Pose]) -> Settled:
    rows = dict(zip(names, arrays["poses"].tolist(), strict=True))
    poses = {name: Pose((x, y, z), (a, b, c, d)) for name, (x, y, z, a, b, c, d) in rows.items()}
    return Settled(
        poses=poses,
        supports=tuple((above, below) for above, below in arrays["supports"].tolist()),
        moved={name: math.dist(pose.xyz, start[name].xyz) for name, pose in poses.items()},
        resting=bool(arrays["resting"]),
    )
