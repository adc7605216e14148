"""`tamp solve`: a batch, its progress, its table."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Protocol

from tamp.batch import Batch
from tamp.cli import BAD_INPUT, SOLVED, UNSOLVED
from tamp.errors import TampError
from tamp.results import Result, print_table
from tamp.task import Task
from tamp.task.load import load_task

BEYOND_LIMITS_S = 120.0
"""What a task may take beyond its limits of planning and execution before it is ended from outside [s]."""


def solve(options: argparse.Namespace) -> int:
    """Run the batch that the options describe; without tasks, or with a bad one, nothing is run."""
    if options.replay is not None:
        from tamp.commands.replay import replay

        return replay(options.replay)
    if not options.tasks:
        raise TampError("solve needs at least one TASK.yaml")
    if options.resume and options.output is None:
        raise TampError("--resume needs --output DIR, the folder that holds the results so far")
    tasks = _load(options.tasks, options.allow_outside)
    if not tasks:
        return BAD_INPUT
    results, interrupted = _run(_batch(options, tasks))
    for result in results:
        if result.status == "invalid":
            print(f"tamp: {result.message}", file=sys.stderr)
    if any(r.status != "invalid" for r in results):
        print_table(results, sys.stdout)
    if options.json is not None:
        _write(options.json, json.dumps([r.as_dict() for r in results], indent=1, allow_nan=False) + "\n")
    if interrupted:
        raise KeyboardInterrupt
    return _status(results)


def _load(paths: Sequence[Path], allow_outside: bool) -> list[Task]:
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


def _batch(options: argparse.Namespace, tasks: Sequence[Task]) -> Batch:
    replaced = dict(options.sampler)
    _refuse_unknown_samplers(tasks, replaced)
    longest = max((options.timeout or t.limits.planning_s) + t.limits.execution_sim_s for t in tasks)
    return Batch(
        tasks=tasks,
        seeds=tuple(dict.fromkeys(options.seed or (0,))),
        options={
            "timeout": options.timeout,
            "samplers": replaced,
            "algorithm": options.algorithm,
            "execute": not options.no_execute,
            "allow_outside": options.allow_outside,
        },
        workers=options.workers,
        time_limit_s=options.time_limit or longest + BEYOND_LIMITS_S,
        memory_limit=int(options.memory_limit * 2**30) if sys.platform.startswith("linux") else None,
        output=options.output,
        resume=options.resume,
    )


def _refuse_unknown_samplers(tasks: Sequence[Task], replaced: Mapping[str, str]) -> None:
    """Before anything runs; the domain is imported only where somebody names a sampler."""
    if not replaced and not any(task.samplers for task in tasks):
        return
    from tamp.domains.samplers import resolve_samplers
    from tamp.domains.tabletop import DEFAULT_SAMPLERS

    for task in tasks:
        resolve_samplers(DEFAULT_SAMPLERS, task.samplers, replaced)


def _run(batch: Batch) -> tuple[list[Result], bool]:
    """All results, and whether the user broke it off."""
    results: list[Result] = []
    runs = batch.run()
    try:
        with _progress(len(batch.tasks) * len(batch.seeds)) as progress:
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
def _progress(total: int) -> Iterator[_Progress]:
    """A bar on a terminal, nothing elsewhere."""
    if not sys.stderr.isatty():
        yield lambda result: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    now = TextColumn("{task.description}")
    with Progress(BarColumn(), MofNCompleteColumn(), now, console=Console(stderr=True), transient=True) as bar:
        line = bar.add_task("", total=total)
        yield lambda result: bar.update(line, advance=1, description=f"{result.task} {result.status}")


def _status(results: Sequence[Result]) -> int:
    if any(r.status == "invalid" for r in results):
        return BAD_INPUT
    return SOLVED if all(r.solved for r in results) else UNSOLVED


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise TampError(f"{path}: cannot be written: {error.strerror}") from error
