"""What counts of a solution's runs, and who is ranked where: best of runs, best of simulators, as the rules have it."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from tamp.contest.rules import Bests, Rules
from tamp.results import Result
from tamp.scoring.ranking import Standing, Yardstick, rank

Key = Callable[[Result], Any]


def counting(results: Sequence[Result], tasks: Sequence[Yardstick], rules: Rules) -> tuple[Result, ...]:
    """The runs of one solution that count: first the best of runs in each simulator, then the best of simulators."""
    by_simulator = [
        _best(group, tasks, rules.best_of_runs, lambda r: r.seed) for group in _grouped(results, lambda r: r.simulator)
    ]
    kept = [result for group in by_simulator for result in group]
    return tuple(_best(kept, tasks, rules.best_of_simulators, lambda r: r.simulator))


def _best(results: Sequence[Result], tasks: Sequence[Yardstick], how: Bests, key: Key) -> list[Result]:
    """Of results that differ in a key, those that count."""
    if how == "mean":
        return list(results)
    if how == "task":
        groups = _grouped(results, lambda r: r.task)
        return [min(group, key=lambda r: (_error(r, tasks), r.execution_sim_s, key(r))) for group in groups]
    whole = _grouped(results, key)
    return min(whole, key=lambda group: _total(group, tasks), default=[])


def _total(group: Sequence[Result], tasks: Sequence[Yardstick]) -> tuple[float, float]:
    """Mean error over all tasks, those without a result at that of doing nothing, and mean time."""
    errors = []
    for task in tasks:
        mine = [_error(r, tasks) for r in group if r.task == task.task]
        errors.append(statistics.fmean(mine) if mine else task.do_nothing_m)
    return statistics.fmean(errors) if errors else 0.0, statistics.fmean(r.execution_sim_s for r in group)


def _error(result: Result, tasks: Sequence[Yardstick]) -> float:
    idle = next((task.do_nothing_m for task in tasks if task.task == result.task), 0.0)
    return idle if result.ede_m is None else result.ede_m


def _grouped(results: Iterable[Result], key: Key) -> list[list[Result]]:
    groups: dict[Any, list[Result]] = {}
    for result in results:
        groups.setdefault(key(result), []).append(result)
    return [groups[name] for name in sorted(groups)]


def standings(
    solutions: Mapping[str, Sequence[Result]], tasks: Sequence[Yardstick], rules: Rules
) -> tuple[Standing, ...]:
    """Solutions ranked by mean error, then by execution time; see `tamp.scoring.ranking.rank`.

    Args:
        solutions: name -> all of its runs.
        tasks: the set.
        rules: say which runs count.

    Raises:
        TampError: where no task has a goal pose.
    """
    kept = {name: _numbered(counting(results, tasks, rules)) for name, results in solutions.items()}
    return rank(kept, tasks)


def _numbered(results: Iterable[Result]) -> list[Result]:
    """The same with a seed each, by which the ranking tells several of a task apart."""
    return [replace(result, seed=number) for number, result in enumerate(results)]


def improvement(standing: Standing, rules: Rules) -> float | None:
    """What a solution made good of the rules' default error."""
    return standing.mean.improvement_ueb if rules.baseline == "ueb" else standing.mean.improvement
