"""Whose tables the server that workers are forked from makes ahead: those of a batch's robots.

The server takes no arguments, so that it is told by an environment variable.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Sequence
from dataclasses import asdict

from tamp.errors import TampError
from tamp.task import Pose, Task
from tamp.task.robots import is_path, with_robot

VARIABLE = "TAMP_BATCH_ROBOTS"
"""JSON: a list of [robot, its base's pose or null]."""

MOST = 4
"""So many robots are made ready ahead; a batch of more is a rare thing, and each costs a quarter of a second."""


def tell(tasks: Iterable[Task], robot: str | None) -> None:
    """Say whose tables a server that is started from now on makes.

    Args:
        tasks: of the batch.
        robot: what stands in for the tasks' own, or None.
    """
    told = dict.fromkeys(json.dumps(_place(with_robot(task, robot))) for task in tasks if _is_there(task, robot))
    os.environ[VARIABLE] = f"[{', '.join([*told][:MOST])}]"


def told() -> Sequence[Task]:
    """An empty task for each robot that was told; for the default robot where nothing was."""
    places = json.loads(os.environ.get(VARIABLE, "[]"))
    tasks = [Task("nothing", (), robot=robot, base=base and Pose(**base)) for robot, base in places]
    return tasks or [Task("nothing", ())]


def _place(task: Task) -> tuple[str, dict[str, object] | None]:
    """A task's robot by its name or the whole path of its file, and where its base stands."""
    path = task.path is not None and is_path(task.robot)
    robot = str((task.path.parent / task.robot).resolve()) if path and task.path is not None else task.robot
    return robot, None if task.base is None else asdict(task.base)


def _is_there(task: Task, robot: str | None) -> bool:
    try:
        with_robot(task, robot)
    except TampError:  # its run says so
        return False
    return True
