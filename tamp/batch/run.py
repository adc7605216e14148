"""A batch: tasks times seeds, each run exactly once, its result in the journal before the next is shown."""

from __future__ import annotations

import json
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tamp.batch.journal import Journal
from tamp.batch.pool import Job, Outcome, run_jobs
from tamp.batch.work import PRELOAD, WORK
from tamp.errors import TampError
from tamp.results import Result, Status, from_json
from tamp.task import Task
from tamp.versions import versions

RESULTS = "results.jsonl"


@dataclass(frozen=True)
class Batch:
    """What to run and within which bounds.

    Attributes:
        tasks: each with a path and a name of its own.
        seeds: every task runs with each.
        options: further arguments of the work function, JSON-like.
        workers: how many at the same time.
        time_limit_s: per task and seed, enforced from outside [s].
        memory_limit: per process, bytes.
        output: folder of results.jsonl and the runs; None keeps nothing.
        resume: run only what results.jsonl does not have yet; without it the file starts anew.
        work: the work function, "package.module:function".
        preload: modules imported once for all workers.
        executor: runs the jobs; takes and gives what `run_jobs` does.
    """

    tasks: Sequence[Task]
    seeds: Sequence[int] = (0,)
    options: Mapping[str, Any] = field(default_factory=dict)
    workers: int = 1
    time_limit_s: float | None = None
    memory_limit: int | None = None
    output: Path | None = None
    resume: bool = False
    work: str = WORK
    preload: Sequence[str] = PRELOAD
    executor: Callable[..., Iterator[Outcome]] = run_jobs

    def __post_init__(self) -> None:
        names = [task.name for task in self.tasks]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise TampError(f"several files call their task {', '.join(twice)}; in one batch names must differ")

    def run(self) -> Generator[Result, None, None]:
        """Yield results: first those that the output folder already has, where resuming, then each as it comes.

        Raises:
            TampError: where the results file cannot be used or written.
        """
        if self.output is None:
            yield from map(_result, self._outcomes(self._jobs(done=())))
            return
        with Journal(self.output / RESULTS) as journal:
            if not self.resume:
                journal.clear()
            wanted = {_key(task.name, seed) for task in self.tasks for seed in self.seeds}
            done = [r for r in journal.results() if _key(r.task, r.seed) in wanted]
            yield from done
            for outcome in self._outcomes(self._jobs(done=[_key(r.task, r.seed) for r in done])):
                if outcome.ended == "full":  # no fault of the task's, which is to run once there is room
                    raise TampError(f"{outcome.message}; the results before this one are kept")
                result = _result(outcome)
                journal.append(result)
                yield result

    def _jobs(self, done: Sequence[str]) -> Iterator[Job]:
        for task in self.tasks:
            for seed in self.seeds:
                key = _key(task.name, seed)
                if key in done:
                    continue
                folder = None if self.output is None else str(self.output / f"{task.name}-{seed}")
                file = {"name": task.name, "path": str(task.path), "seed": seed, "folder": folder}
                yield Job(key, {**file, **self.options})

    def _outcomes(self, jobs: Iterator[Job]) -> Iterator[Outcome]:
        return self.executor(
            jobs,
            self.work,
            workers=self.workers,
            time_limit_s=self.time_limit_s,
            memory_limit=self.memory_limit,
            preload=self.preload,
        )


def _key(task: str, seed: int) -> str:
    return f"{task}:{seed}"


def _result(outcome: Outcome) -> Result:
    """The worker's own result, or one that says how the worker ended."""
    if outcome.value is not None:
        return from_json(json.dumps(outcome.value), outcome.job.key)
    arguments = outcome.job.arguments
    status: Status = "timeout" if outcome.ended == "timeout" else "error"
    return Result(
        task=arguments["name"],
        seed=arguments["seed"],
        status=status,
        wall_s=outcome.wall_s,
        message=outcome.message,
        versions=versions(),
        task_path=arguments["path"],
    )
