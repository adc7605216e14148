"""The work of a batch: one task and seed in a worker process, as JSON-like arguments and a JSON-like result."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from tamp.errors import TampError
from tamp.results import Result
from tamp.versions import versions

WORK = "tamp.batch.work:solve_file"
PRELOAD = ("tamp.pipeline.records", "ompl.base", "ompl.geometric", "pinocchio", "toppra", "trimesh", "fcl")


def solve_file(
    name: str,
    path: str,
    seed: int,
    folder: str | None = None,
    allow_outside: bool = False,
    **options: Any,
) -> Mapping[str, Any]:
    """Solve a task file; a mistake in the input makes a result of status "invalid".

    Args:
        name: the task's name.
        path: its file.
        seed: decides every random choice.
        folder: where the run's files go; None keeps none.
        allow_outside: accept meshes outside the task's folder.
        options: timeout, samplers, algorithm, execute, as `tamp.solve` takes them.
    """
    from tamp.pipeline.records import save_run
    from tamp.pipeline.solving import carry_out
    from tamp.task.load import load_task

    try:
        task = load_task(path, allow_outside=allow_outside)
        run = carry_out(task, seed=seed, **options)
    except TampError as error:
        return Result(name, seed, "invalid", message=str(error), versions=versions(), task_path=path).as_dict()
    run = replace(run, result=replace(run.result, task_path=path))
    if folder is not None:
        save_run(run, task, {"seed": seed, "allow_outside": allow_outside, **options}, Path(folder))
    return run.result.as_dict()
