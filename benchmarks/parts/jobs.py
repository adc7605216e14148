"""Whole jobs, settled to scored, as rows of a table."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import groupby
from pathlib import Path

from benchmarks.parts.harness import Row
from tamp.clock import Clock
from tamp.pipeline.solving.solve import solve
from tamp.results import Result
from tamp.task.files.load import load_task


def solve_all(files: Iterable[Path], seeds: Iterable[int], clock: Clock = "wall") -> Iterator[Result]:
    """Solve every task with every seed, one after the other in this process."""
    seeds = tuple(seeds)
    for file in files:
        task = load_task(file)
        for seed in seeds:
            yield solve(task, seed=seed, clock=clock)


def by_task(results: Iterable[Result]) -> Iterator[Row]:
    """One row for each task: solved, times, grasps, errors; and what was left, in words."""
    for name, group in groupby(results, key=lambda result: result.task):
        runs = list(group)
        errors = [run.ede_m for run in runs if run.ede_m is not None]
        yield {
            "task": name,
            "solved": f"{sum(run.status == 'solved' for run in runs)} of {len(runs)}",
            "planning_max_s": max(run.planning_s for run in runs),
            "execution_s": sum(run.execution_sim_s for run in runs) / len(runs),
            "grasps": f"{sum(run.grasps_succeeded for run in runs)}/{sum(run.grasps_attempted for run in runs)}",
            "replans": sum(run.n_replans for run in runs),
            "ede_cm": 100 * sum(errors) / len(errors) if errors else "-",
            "idle_cm": "-" if runs[0].do_nothing_ede_m is None else 100 * runs[0].do_nothing_ede_m,
            "message": next((run.message[:100] for run in runs if run.message), ""),
        }
