"""A batch: tasks times seeds, each run exactly once, its result in the journal before the next is shown."""

from __future__ import annotations

import json
import logging
from collections import Counter
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

from tamp.batch.identity import Making
from tamp.batch.journal import Journal
from tamp.batch.pool import Job, Outcome, run_jobs
from tamp.batch.robots import tell
from tamp.batch.work import PRELOAD, WORK
from tamp.errors import TampError
from tamp.pipeline.options.own_code import code_sha256, named_parts
from tamp.results import Result, Status, from_json, read_results
from tamp.task import Task
from tamp.task.files.digest import task_sha256
from tamp.versions import versions

RESULTS = "results.jsonl"

log = logging.getLogger("tamp")


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
        resume: run what results.jsonl does not have yet, or has from other options, another version of the task or
            of the user's own code, or other libraries.
        overwrite: forget the results that the folder has. With neither, a folder that has some is refused.
        work: the work function, "package.module:function".
        preload: modules imported once for all workers.
        executor: runs the jobs; takes and gives what `run_jobs` does.

    Raises:
        TampError: where two tasks have the same name.
    """

    tasks: Sequence[Task]
    seeds: Sequence[int] = (0,)
    options: Mapping[str, Any] = field(default_factory=dict)
    workers: int = 1
    time_limit_s: float | None = None
    memory_limit: int | None = None
    output: Path | None = None
    resume: bool = False
    overwrite: bool = False
    work: str = WORK
    preload: Sequence[str] = PRELOAD
    executor: Callable[..., Iterator[Outcome]] = run_jobs

    def __post_init__(self) -> None:
        files: dict[str, list[str]] = {}
        for task in self.tasks:
            files.setdefault(task.name, []).append(str(task.path or "a task without a file"))
        if clashes := [f"{' and '.join(paths)} both are {name!r}" for name, paths in files.items() if len(paths) > 1]:
            raise TampError(f"in one batch tasks' names must differ: {'; '.join(clashes)}")

    def run(self) -> Generator[Result, None, None]:
        """Yield results: first those that the output folder already has, where resuming, then each as it comes.

        Raises:
            TampError: where the results file cannot be used or written, or holds results that nobody gave up.
        """
        for done in run_together([self]):
            yield done.result

    def begin(self, place: int, stack: ExitStack) -> _Running:
        """Open the results file, if there is one, and see what is left to do."""
        makings = self._makings()
        if self.output is None:
            return _Running(makings, None, (), tuple(self._jobs(place, done=())))
        journal = stack.enter_context(Journal(self.output / RESULTS))
        done = self._kept(journal, makings)
        return _Running(makings, journal, done, tuple(self._jobs(place, done=[_key(r.task, r.seed) for r in done])))

    def refuse_to_overwrite(self) -> None:
        """Refuse a folder with results that nobody said what to do with.

        Raises:
            TampError: names the folder and the ways on.
        """
        if self.resume or self.overwrite or self.output is None:
            return
        results = self.output / RESULTS
        folders = [self._folder(self.output, task, seed) for task in self.tasks for seed in self.seeds]
        held = [results] if results.is_file() and results.stat().st_size else [f for f in folders if f.exists()]
        if held:
            stale = self._stale(read_results(results), self._makings())
            again = f", and again what was made otherwise: {_told(stale)}" if stale else ""
            raise TampError(
                f"{held[0]} has results already: --resume runs what is missing{again}; --overwrite starts anew; "
                "nothing was touched"
            )

    def _makings(self) -> Mapping[str, Making]:
        known: dict[Path, str] = {}
        code, libraries = cache(code_sha256), versions()  # the same for most tasks
        return {
            task.name: Making(self.options, task_sha256(task, known), libraries, code(named_parts(self.options, task)))
            for task in self.tasks
        }

    def _stale(self, results: Iterable[Result], makings: Mapping[str, Making]) -> Mapping[str, Sequence[str]]:
        """The results of this batch's tasks and seeds that were made otherwise -> what differs."""
        mine = (r for r in results if r.task in makings and r.seed in self.seeds)
        found = {_key(r.task, r.seed): makings[r.task].differences(r) for r in mine}
        return {key: differences for key, differences in found.items() if differences}

    def _kept(self, journal: Journal, makings: Mapping[str, Making]) -> Sequence[Result]:
        """The results that need not be made again; those made otherwise, or given up, leave the file."""
        if not self.resume:
            journal.keep(())
            return ()
        wanted = {_key(task.name, seed) for task in self.tasks for seed in self.seeds}
        results = journal.results()
        done = [r for r in results if _key(r.task, r.seed) in wanted]
        stale = self._stale(done, makings)
        if stale:
            told = f"{len(stale)} of {len(done)} results"
            log.warning("made otherwise and run again: %s; what differs: %s", told, _told(stale))
            journal.keep([r for r in results if _key(r.task, r.seed) not in stale])
        return [r for r in done if _key(r.task, r.seed) not in stale]

    @staticmethod
    def _folder(output: Path, task: Task, seed: int) -> Path:
        return output / f"{task.name}-{seed}"

    def _jobs(self, place: int, done: Sequence[str]) -> Iterator[Job]:
        for task in self.tasks:
            for seed in self.seeds:
                key = _key(task.name, seed)
                if key in done:
                    continue
                folder = None if self.output is None else str(self._folder(self.output, task, seed))
                file = {"name": task.name, "path": str(task.path), "seed": seed, "folder": folder}
                yield Job(f"{place}:{key}", {**file, **self.options})

    def outcomes(self, jobs: Iterable[Job]) -> Iterator[Outcome]:
        """Run jobs as this batch would."""
        tell(self.tasks, self.options.get("robot"))
        return self.executor(
            jobs,
            self.work,
            workers=self.workers,
            time_limit_s=self.time_limit_s,
            memory_limit=self.memory_limit,
            preload=self.preload,
        )


@dataclass(frozen=True)
class _Running:
    """A batch that has begun: what its results are made of, where they go, those it has, and what is to be run."""

    makings: Mapping[str, Making]
    journal: Journal | None
    done: Sequence[Result]
    jobs: Sequence[Job]


@dataclass(frozen=True)
class Done:
    """A result as it comes.

    Attributes:
        place: of its batch among those that run together.
        result: the result.
        kept: whether the output folder had it already.
    """

    place: int
    result: Result
    kept: bool = False


def run_together(batches: Sequence[Batch]) -> Generator[Done, None, None]:
    """Run several batches by turns: what comes and goes on the machine meets all of them alike.

    Args:
        batches: of the same tasks and seeds; the first one says how many workers there are and what they may take.

    Yields:
        First the results that output folders already have, then each as it comes.

    Raises:
        TampError: as `Batch.run` does, before anything runs.
    """
    for batch in batches:
        batch.refuse_to_overwrite()
    with ExitStack() as stack:
        running = [batch.begin(place, stack) for place, batch in enumerate(batches)]
        for place, one in enumerate(running):
            yield from (Done(place, result, kept=True) for result in one.done)
        for outcome in batches[0].outcomes(_by_turns([one.jobs for one in running])):
            if outcome.ended == "full":  # no fault of the task's, which is to run once there is room
                raise TampError(f"{outcome.message}; the results before this one are kept")
            place = int(outcome.job.key.partition(":")[0])
            result = _result(outcome, running[place].makings)
            if (journal := running[place].journal) is not None:
                journal.append(result)
            yield Done(place, result)


def _by_turns(jobs: Sequence[Sequence[Job]]) -> Iterator[Job]:
    """The jobs of all, those of the same task and seed together, each batch being first as often as the others."""
    groups: dict[str, list[Job]] = {}
    for theirs in jobs:
        for job in theirs:
            groups.setdefault(job.key.partition(":")[2], []).append(job)
    for turn, group in enumerate(groups.values()):
        first = turn % len(group)
        yield from (*group[first:], *group[:first])


def _told(stale: Mapping[str, Sequence[str]]) -> str:
    """What differs, and of how many results."""
    counts = Counter(name for differences in stale.values() for name in differences)
    return ", ".join(f"{name} ({number})" for name, number in counts.most_common())


def _key(task: str, seed: int) -> str:
    return f"{task}:{seed}"


def _result(outcome: Outcome, makings: Mapping[str, Making]) -> Result:
    """The worker's own result, or one that says how the worker ended; with what it was made of."""
    arguments = outcome.job.arguments
    making = makings[arguments["name"]]
    if outcome.value is not None:
        made = from_json(json.dumps(outcome.value), outcome.job.key)
        return replace(
            made,
            configuration=making.configuration,
            task_sha256=making.task_sha256,
            code_sha256=making.code_sha256,
            versions=made.versions or making.versions,
        )
    status: Status = "timeout" if outcome.ended == "timeout" else "error"
    return Result(
        task=arguments["name"],
        seed=arguments["seed"],
        status=status,
        wall_s=outcome.wall_s,
        message=outcome.message,
        versions=making.versions,
        task_path=arguments["path"],
        clock=making.configuration.get("clock", "wall"),
        configuration=making.configuration,
        task_sha256=making.task_sha256,
        code_sha256=making.code_sha256,
    )
