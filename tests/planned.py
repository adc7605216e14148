"""Plans of the built-in scenarios, each made once in a process for all tests that look at it or carry it out."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import tamp
from tamp.task import Plan, Task

SCENARIOS = Path(__file__).parents[1] / "scenarios"


@cache
def planned(scenario: str, seed: int) -> tuple[Task, Plan]:
    """A scenario's task, and the plan of a seed for it."""
    task = tamp.load_task(SCENARIOS / f"{scenario}.yaml")
    return task, tamp.plan(task, seed=seed, timeout=100.0)
