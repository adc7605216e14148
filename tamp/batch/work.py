"""The work of a batch: one task and seed in a worker process, as JSON-like arguments and a JSON-like result."""

from __future__ import annotations

import logging
import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from tamp.errors import ModelError, PartError, SamplerError, TampError
from tamp.results import Result, Status
from tamp.versions import versions

WORK = "tamp.batch.work:solve_file"
log = logging.getLogger("tamp")

PRELOAD = ("tamp.batch.warm", "scipy.optimize")
"""What workers find loaded: what every run needs, and what many do."""


def solve_file(
    name: str,
    path: str,
    seed: int,
    folder: str | None = None,
    allow_outside: bool = False,
    robot: str | None = None,
    **options: Any,
) -> Mapping[str, Any]:
    """Solve a task file; a mistake in the input makes a result of status "invalid", one in code of the user's "error".

    Args:
        name: the task's name.
        path: its file.
        seed: decides every random choice.
        folder: where the run's files go; None keeps none.
        allow_outside: accept meshes and a robot outside the task's folder.
        robot: a robot's name or the path of its file, in place of the task's own.
        options: timeout, execute, and the fields of `tamp.pipeline.options.settings.Settings`.
    """
    from tamp.pipeline.options.settings import Settings
    from tamp.pipeline.solving.run import save_run
    from tamp.pipeline.solving.solve import carry_out
    from tamp.task.files.load import load_task
    from tamp.task.robots import with_robot

    load = round(os.getloadavg()[0] / (os.cpu_count() or 1), 2)
    try:
        task = with_robot(load_task(path, allow_outside=allow_outside), robot)
        limits = {name: options[name] for name in ("timeout", "execute") if name in options}
        settings = Settings(**{name: value for name, value in options.items() if name not in limits})
        run = carry_out(task, seed=seed, settings=settings, **limits)
    except ModelError:  # files are read already: whoever makes such a value now has a bug
        raise
    except TampError as error:
        # Whose own code goes wrong while it runs has a bug in it, not a mistake in the task.
        status: Status = "error" if isinstance(error, SamplerError | PartError) else "invalid"
        log.info("%s, seed %d: %s", name, seed, status, exc_info=error)
        return Result(name, seed, status, message=str(error), versions=versions(), task_path=path).as_dict()
    run = replace(run, result=replace(run.result, task_path=path, load=load))
    if folder is not None:
        given = {"seed": seed, "allow_outside": allow_outside, "robot": robot, **options}
        save_run(run, task, {name: value for name, value in given.items() if name != "robot" or value}, Path(folder))
    return run.result.as_dict()
