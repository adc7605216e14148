"""What commands that run batches share: tasks from files, a batch from options, its progress."""

from __future__ import annotations

import argparse
import logging
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Protocol

from tamp.batch import Batch
from tamp.batch.pool import Outcome, run_jobs
from tamp.errors import TampError
from tamp.results import Result
from tamp.task import Task
from tamp.task.load import load_task

BEYOND_LIMITS_S = 120.0
"""What a task may take beyond its limits of planning and execution before it is ended from outside [s]."""

log = logging.getLogger("tamp")


def load_tasks(paths: Sequence[Path], allow_outside: bool) -> list[Task]:
    """The tasks; none where one of the files is bad, after a sentence on each that is."""
    tasks = [_task(path, allow_outside) for path in paths]
    good = [task for task in tasks if task is not None]
    return good if len(good) == len(tasks) else []


def _task(path: Path, allow_outside: bool) -> Task | None:
    try:
        return load_task(path, allow_outside=allow_outside)
    except TampError as error:
        print(f"tamp: {error}", file=sys.stderr)
        return None


def batch(
    options: argparse.Namespace, tasks: Sequence[Task], *, samplers: Mapping[str, str], output: Path | None
) -> Batch:
    """The batch that options describe.

    Args:
        options: as `add_batch_options` and `add_planning_options` make them.
        tasks: what to solve.
        samplers: stream name -> address, in place of the tasks' own.
        output: where results go; None keeps none.

    Raises:
        SamplerError: for a stream or a function that does not exist, before anything runs.
    """
    _refuse_unknown_samplers(tasks, samplers)
    longest = max((options.timeout or t.limits.planning_s) + t.limits.execution_sim_s for t in tasks)
    return Batch(
        tasks=tasks,
        seeds=tuple(dict.fromkeys(options.seed or (0,))),
        options={
            "timeout": options.timeout,
            "samplers": dict(samplers),
            "algorithm": options.algorithm,
            "execute": not options.no_execute,
            "allow_outside": options.allow_outside,
        },
        workers=options.workers,
        time_limit_s=options.time_limit or longest + BEYOND_LIMITS_S,
        memory_limit=int(options.memory_limit * 2**30) if sys.platform.startswith("linux") else None,
        output=output,
        resume=options.resume,
        executor=_executor(options, output),
    )


def _executor(options: argparse.Namespace, output: Path | None) -> Callable[..., Iterator[Outcome]]:
    """What runs the jobs; libraries of clusters are imported only where they are asked for."""
    if options.executor == "dask":
        from tamp.batch.dask import run_on_dask

        return partial(run_on_dask, address=options.address)
    if options.executor == "submitit":
        from tamp.batch.slurm import run_on_slurm

        if output is None:
            raise TampError("--executor submitit needs --output DIR, a folder that all machines see")
        return partial(run_on_slurm, folder=output / "jobs", parameters=dict(options.slurm))
    return run_jobs


def _refuse_unknown_samplers(tasks: Sequence[Task], replaced: Mapping[str, str]) -> None:
    """Before anything runs; the domain is imported only where somebody names a sampler."""
    if not replaced and not any(task.samplers for task in tasks):
        return
    from tamp.domains.samplers import resolve_samplers
    from tamp.domains.tabletop import DEFAULT_SAMPLERS

    for task in tasks:
        resolve_samplers(DEFAULT_SAMPLERS, task.samplers, replaced)


def run_batch(batch: Batch, *, title: str = "") -> tuple[list[Result], bool]:
    """All results, and whether the user broke it off."""
    results: list[Result] = []
    runs = batch.run()
    try:
        with _progress(len(batch.tasks) * len(batch.seeds), title) as progress:
            for result in runs:
                results.append(result)
                progress(result)
    except KeyboardInterrupt:
        runs.close()
        return results, True
    return results, False


class _Progress(Protocol):
    def __call__(self, result: Result) -> None: ...


@contextmanager
def _progress(total: int, title: str) -> Iterator[_Progress]:
    """A bar on a terminal: solved, failed, time left; elsewhere one log line a result."""
    if not sys.stderr.isatty() or log.getEffectiveLevel() > logging.WARNING:
        yield _tell
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    counts = TextColumn("[green]{task.fields[solved]} solved[/green] [red]{task.fields[failed]} failed[/red]")
    columns = (TextColumn(title), BarColumn(), MofNCompleteColumn(), counts, TimeRemainingColumn())
    now = TextColumn("{task.description}", markup=False)
    with Progress(*columns, now, console=Console(stderr=True), transient=True) as bar:
        line = bar.add_task("", total=total, solved=0, failed=0)
        seen = {True: 0, False: 0}

        def advance(result: Result) -> None:
            seen[result.solved] += 1
            said = f"{result.task} {result.status}"
            bar.update(line, advance=1, description=said, solved=seen[True], failed=seen[False])

        yield advance


def _tell(result: Result) -> None:
    log.info("%s, seed %d: %s after %.1f s", result.task, result.seed, result.status, result.wall_s)
