"""What commands that run batches share: tasks from files, a batch from options, its progress."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from tamp.cli.options import load, positive_int, seconds, setting, settings_given
from tamp.cli.parser import Parser
from tamp.cli.progress import progress
from tamp.errors import TampError
from tamp.pipeline.options.settings import Settings
from tamp.task.files.regular_file import followed

if TYPE_CHECKING:
    from tamp.batch import Batch
    from tamp.batch.pool import Outcome
    from tamp.results import Result
    from tamp.task import Task

BEYOND_LIMITS_S = 120.0
"""What a task may take beyond its limits of planning and execution before it is ended from outside [s]."""

PERCEIVING_S = 1800.0
"""What estimating poses may take beyond that: many looks at many objects on a busy machine [s]."""


def add_batch_options(parser: Parser) -> None:
    """How a batch is run; the same for every command that runs one."""
    add = parser.add_argument
    add("--workers", type=positive_int, default=1, metavar="N", help="tasks at the same time; default 1")
    where = "where the work is done: here, on a Dask cluster, or as SLURM jobs; default local"
    add("--executor", choices=("local", "dask", "submitit"), default="local", help=where)
    add("--address", metavar="tcp://HOST:PORT", help="of a Dask scheduler; default: a cluster started here")
    add("--slurm", type=setting, action="append", default=[], metavar="NAME=VALUE", help="such as partition=cpu")
    resume = "run what --output does not have yet, or has from other options, another task or other versions"
    add("--resume", action="store_true", help=resume)
    add("--overwrite", action="store_true", help="forget the results that --output has")
    add("--skip-invalid", action="store_true", help="run the other tasks where some are invalid")
    add("--time-limit", type=seconds, metavar="SECONDS", help="kill a task that takes longer in all; default: ample")
    add("--memory-limit", type=seconds, default=6.0, metavar="GIB", help="kill a task that takes more; default 6")


def load_tasks(paths: Sequence[Path], options: argparse.Namespace) -> list[Task]:
    """The tasks that can be run, after a sentence on each bad file; none where one is bad and none is to be skipped."""
    settings = Settings(**settings_given(options))
    tasks = [_task(path, settings, options) for path in paths]
    good = [task for task in tasks if task is not None]
    return good if options.skip_invalid or len(good) == len(tasks) else []


def _task(path: Path, settings: Settings, options: argparse.Namespace) -> Task | None:
    from tamp.pipeline.options.trust import refuse_code

    try:
        task = load(path, options)
        refuse_code(task, options.domain, trusted=options.trust_task_code)
        settings.for_task(task)
        return task
    except TampError as error:
        say_invalid(path, str(error), options)
        return None


def say_invalid(path: str | Path, why: str, options: argparse.Namespace) -> None:
    """Say what is wrong with a task's file, in a line that begins with the file as it was given."""
    meant = followed(Path(path))
    given = next(str(file) for file in (*options.tasks, meant) if followed(file) == meant)
    why = why.replace(str(meant), given)
    file = "" if why.startswith(given) else f"{given}: "
    print(f"tamp: {'skipped: ' * options.skip_invalid}{file}{why}", file=sys.stderr)


def batch(
    options: argparse.Namespace,
    tasks: Sequence[Task],
    *,
    samplers: Mapping[str, str],
    output: Path,
    settings: Mapping[str, Any] = MappingProxyType({}),
) -> Batch:
    """The batch that options describe.

    Args:
        options: as `add_batch_options` and `add_planning_options` make them.
        tasks: what to solve.
        samplers: stream name -> address, in place of the tasks' own.
        output: where results go.
        settings: fields of `Settings`, in place of what the options say.

    Raises:
        DomainError, SamplerError: for a domain, a stream or a function that does not exist, before anything runs.
    """
    from tamp.batch import Batch
    from tamp.batch.work import PRELOAD

    given = {**settings_given(options), **settings}
    if "tuning" in settings:
        given["tuning"] = {**dict(options.tuning), **settings["tuning"]}
    Settings(**given)
    _refuse_unknown_parts(tasks, samplers, given.get("domain"))
    longest = max((options.timeout or t.limits.planning_s) + t.limits.execution_sim_s for t in tasks)
    longest += PERCEIVING_S if given.get("perceive") or any(task.perceive for task in tasks) else 0.0
    return Batch(
        tasks=tasks,
        seeds=tuple(dict.fromkeys(options.seed or (0,))),
        options={
            "timeout": options.timeout,
            "samplers": dict(samplers),
            **given,
            "execute": not options.no_execute,
            "allow_outside": options.allow_outside,
            "trust_task_code": options.trust_task_code,
            **_robot(options),
        },
        workers=options.workers,
        time_limit_s=options.time_limit or longest + BEYOND_LIMITS_S,
        memory_limit=int(options.memory_limit * 2**30) if sys.platform.startswith("linux") else None,
        output=output,
        resume=options.resume,
        overwrite=options.overwrite,
        executor=_executor(options, output if options.output_given else None),
        preload=(*PRELOAD, "tamp.cli"),  # a worker imports the module that its parent was started with
    )


def _robot(options: argparse.Namespace) -> dict[str, str]:
    """The robot that stands in for the tasks' own, its path whole: workers may have another working folder."""
    from tamp.task.robots import is_path

    if options.robot is None:
        return {}
    return {"robot": str(followed(Path(options.robot).expanduser())) if is_path(options.robot) else options.robot}


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
    from tamp.batch.pool import run_jobs

    return run_jobs


def _refuse_unknown_parts(tasks: Sequence[Task], replaced: Mapping[str, str], domain: str | None) -> None:
    """Before anything runs; a domain is imported only where somebody names one, or a sampler."""
    if not (replaced or domain or any(task.samplers for task in tasks)):
        return
    from tamp.domains.catalog import load_domain
    from tamp.domains.samplers import resolve_samplers

    for task in tasks:
        resolve_samplers(load_domain(domain or task.domain).samplers, task.samplers, replaced)


@dataclass(frozen=True)
class Ended:
    """What has come of batches that ran by turns.

    Attributes:
        results: of each batch.
        kept: how many of them all were there already.
        total: how many there are where the user breaks nothing off.
        interrupted: whether the user did.
    """

    results: Sequence[Sequence[Result]]
    kept: int
    total: int
    interrupted: bool = False

    def refuse_interrupted(self, output: Path) -> None:
        """Say what is left where the user broke it off, and how to go on.

        Raises:
            KeyboardInterrupt: with that in words.
        """
        if self.interrupted:
            left = self.total - sum(map(len, self.results))
            why = f"{left} of {self.total} runs did not end; the same command with --resume --output {output} runs them"
            raise KeyboardInterrupt(why)


def run_batches(batches: Sequence[Batch]) -> Ended:
    """Run several batches by turns."""
    from tamp.batch import run_together

    results: list[list[Result]] = [[] for _ in batches]
    kept, total = 0, sum(len(batch.tasks) * len(batch.seeds) for batch in batches)
    runs = run_together(batches)
    try:
        with progress(total) as advance:
            for done in runs:
                results[done.place].append(done.result)
                kept += done.kept
                advance(done.result, kept=done.kept)
    except KeyboardInterrupt:
        runs.close()
        return Ended(results, kept, total, interrupted=True)
    return Ended(results, kept, total)
