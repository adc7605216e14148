"""Whose tables the server that workers are forked from makes ahead: those of a batch's robots.

The server takes no arguments, so that it is told by an environment variable. It is told installed robots only: a file
that comes with a task is read where it can harm that task's run alone.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Sequence
from dataclasses import asdict

from tamp.task import Pose, Task
from tamp.task.robots import is_path

VARIABLE = "TAMP_BATCH_ROBOTS"
"""JSON: a list of [robot's name, its base's pose or null, its home or null]."""

MOST = 4
"""So many robots are made ready ahead; a batch of more is a rare thing, and each costs a quarter of a second."""


def tell(tasks: Iterable[Task], robot: str | None) -> None:
    """Say whose tables a server that is started from now on makes.

    Args:
        tasks: of the batch.
        robot: what stands in for the tasks' own, or None.
    """
    places = ((robot or task.robot, task.base and asdict(task.base), None if robot else task.home) for task in tasks)
    told = dict.fromkeys(json.dumps(place) for place in places if not is_path(place[0]))
    os.environ[VARIABLE] = f"[{', '.join([*told][:MOST])}]"


def told() -> Sequence[Task]:
    """An empty task for each robot that was told; for the default robot where nothing was."""
    places = json.loads(os.environ.get(VARIABLE, "[]"))
    tasks = [Task("nothing", (), robot=robot, base=base and Pose(**base), home=home) for robot, base, home in places]
    return tasks or [Task("nothing", ())]
