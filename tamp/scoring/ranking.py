"""Several solutions over one set of tasks, ranked as OCRTOC ranks: by mean error, then by execution time.

A task that a solution did not attempt, or whose run left no score, counts at its do-nothing error. Tasks whose goals
are all symbolic have no error and are left out. Where the best of runs counts, so does the better of simulators, over
all tasks, as OCRTOC 2020 had it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from tamp.errors import TampError
from tamp.results import Result
from tamp.scoring.evaluate import improvement
from tamp.scoring.score import score
from tamp.task.model import At, Task

if TYPE_CHECKING:
    from numpy.typing import NDArray

RESAMPLES = 2000
CONFIDENCE = 0.95
SAME_ERROR_M = 1e-6
"""Errors closer than this are the same, and execution time decides [m]."""


@dataclass(frozen=True)
class Yardstick:
    """What a task's errors are held against.

    Attributes:
        task: its name.
        do_nothing_m: the error of its start poses [m].
        mean_ueb_m: the mean of its objects' bounds [m].
        level: of difficulty, where it has one.
    """

    task: str
    do_nothing_m: float
    mean_ueb_m: float
    level: int | None = None


@dataclass(frozen=True)
class Mean:
    """Errors over some tasks.

    Attributes:
        tasks: how many there are.
        error_m: mean error [m].
        do_nothing_m: mean do-nothing error [m].
        improvement: 1 - error / do-nothing.
        improvement_ueb: 1 - error / mean UEB.
    """

    tasks: int
    error_m: float
    do_nothing_m: float
    improvement: float | None
    improvement_ueb: float | None


@dataclass(frozen=True)
class Standing:
    """A solution's place.

    Attributes:
        rank: from 1; equal where neither error nor time tells solutions apart.
        solution: its name.
        mean: over all tasks.
        interval_m: bootstrap confidence interval of the mean error over tasks [m].
        levels: level -> mean over its tasks.
        attempted: tasks with at least one scored run.
        solved: tasks that were solved in a run that counts.
        execution_s: mean execution time of the attempted tasks; None where there is none [simulated s].
        grasps_attempted, grasps_succeeded: over the runs that count.
    """

    rank: int
    solution: str
    mean: Mean
    interval_m: tuple[float, float]
    levels: Mapping[int, Mean]
    attempted: int
    solved: int
    execution_s: float | None
    grasps_attempted: int
    grasps_succeeded: int

    @property
    def grasp_success(self) -> float | None:
        """Share of the grasps that held."""
        return self.grasps_succeeded / self.grasps_attempted if self.grasps_attempted else None

    def as_dict(self) -> dict[str, Any]:
        """JSON-like values."""
        return {**asdict(self), "grasp_success": self.grasp_success}


def measure(tasks: Iterable[Task]) -> tuple[Yardstick, ...]:
    """The yardsticks of a set of tasks; those without a goal pose are left out.

    Raises:
        TaskError: where a mesh cannot be read.
    """
    found = []
    for task in tasks:
        if any(isinstance(o.goal, At) for o in task.objects):
            idle = score(task, {o.name: o.pose for o in task.objects})
            assert idle.do_nothing_ede_m is not None and idle.mean_ueb_m is not None
            found.append(Yardstick(task.name, idle.do_nothing_ede_m, idle.mean_ueb_m, task.level))
    return tuple(found)


def recall(results: Iterable[Result]) -> tuple[Yardstick, ...]:
    """The yardsticks of all tasks on which some result says what doing nothing scores, by name."""
    known: dict[str, Yardstick] = {}
    for r in results:
        if r.do_nothing_ede_m is not None and r.mean_ueb_m is not None:
            known.setdefault(r.task, Yardstick(r.task, r.do_nothing_ede_m, r.mean_ueb_m, r.level))
    return tuple(known[name] for name in sorted(known))


def rank(
    solutions: Mapping[str, Sequence[Result]],
    tasks: Sequence[Yardstick],
    *,
    best_of: int | None = None,
    seed: int = 0,
) -> tuple[Standing, ...]:
    """Rank solutions, the best first.

    Args:
        solutions: name -> results; those of other tasks are left out.
        tasks: the set; every solution is held against all of it.
        best_of: count the best of a task's first runs, that many, by seed, and of several simulators the one that is
            better over all tasks; None counts the mean of all its runs.
        seed: of the bootstrap.

    Raises:
        TampError: where the set is empty.
    """
    if not tasks:
        raise TampError("there is no task with a goal pose to rank solutions by")
    draws = np.random.default_rng(seed).integers(0, len(tasks), (RESAMPLES, len(tasks)))
    standings = [
        min((_standing(name, runs, tasks, best_of, draws) for runs in _apart(results, best_of)), key=_key)
        for name, results in solutions.items()
    ]
    return placed(standings)


def placed(standings: Iterable[Standing]) -> tuple[Standing, ...]:
    """Standings over the same tasks in their order, the best first, with their ranks among each other."""
    ordered = sorted(standings, key=lambda s: (*_key(s), s.solution))
    keys = [_key(s) for s in ordered]
    return tuple(replace(s, rank=1 + keys.index(_key(s))) for s in ordered)


def _key(standing: Standing) -> tuple[int, float]:
    """What ranks: the error in steps of what counts as the same, then the time."""
    time = float("inf") if standing.execution_s is None else standing.execution_s
    return round(standing.mean.error_m / SAME_ERROR_M), time


def _apart(results: Sequence[Result], best_of: int | None) -> list[Sequence[Result]]:
    """The runs of each simulator, where the better of simulators counts; else all."""
    if best_of is None or not results:
        return [results]
    return [[r for r in results if r.simulator == name] for name in sorted({r.simulator for r in results})]


def _standing(
    name: str, results: Sequence[Result], tasks: Sequence[Yardstick], best_of: int | None, draws: NDArray[np.int64]
) -> Standing:
    runs = {task.task: _counting([r for r in results if r.task == task.task], best_of) for task in tasks}
    errors = np.array([_error(runs[task.task], task) for task in tasks])
    flat = [r for counted in runs.values() for r in counted]
    times = [sum(r.execution_sim_s for r in counted) / len(counted) for counted in runs.values() if counted]
    margin = 50 * (1 - CONFIDENCE)
    low, high = np.percentile(errors[draws].mean(axis=1), [margin, 100 - margin])
    levels = sorted({task.level for task in tasks if task.level is not None})
    return Standing(
        rank=0,
        solution=name,
        mean=_mean(errors, tasks),
        interval_m=(float(low), float(high)),
        levels={level: _mean(errors, tasks, level) for level in levels},
        attempted=len(times),
        solved=sum(any(r.status == "solved" for r in counted) for counted in runs.values()),
        execution_s=sum(times) / len(times) if times else None,
        grasps_attempted=sum(r.grasps_attempted for r in flat),
        grasps_succeeded=sum(r.grasps_succeeded for r in flat),
    )


def _counting(runs: list[Result], best_of: int | None) -> list[Result]:
    """The runs of one task that count; none where the task was not attempted."""
    runs = sorted(runs, key=lambda r: r.seed)
    scored = [r for r in runs[:best_of] if r.ede_m is not None]
    if best_of is None:
        return runs if scored else []
    return sorted(scored, key=lambda r: (r.ede_m, r.execution_sim_s))[:1]


def _error(runs: list[Result], task: Yardstick) -> float:
    """Mean error of the runs that count [m]; a run that left no score did nothing."""
    errors = [task.do_nothing_m if r.ede_m is None else r.ede_m for r in runs]
    return sum(errors) / len(errors) if errors else task.do_nothing_m


def _mean(errors: NDArray[np.float64], tasks: Sequence[Yardstick], level: int | None = None) -> Mean:
    chosen = [i for i, task in enumerate(tasks) if level is None or task.level == level]
    error = float(errors[chosen].mean())
    idle, bound = (float(np.mean([getattr(tasks[i], n) for i in chosen])) for n in ("do_nothing_m", "mean_ueb_m"))
    return Mean(len(chosen), error, idle, improvement(error, idle), improvement(error, bound))
