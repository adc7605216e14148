"""Batches of toy jobs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tamp.batch import Batch
from tamp.results import Result
from tamp.task import Task

WORK = "tests.batch.toys:work"


def tasks_named(*names: str) -> list[Task]:
    return [Task(name, (), path=Path(f"{name}.yaml")) for name in names]


def run_batch(*names: str, options: dict[str, Any] | None = None, **bounds: Any) -> dict[tuple[str, int], Result]:
    batch = Batch(tasks_named(*names), options=options or {}, work=WORK, **bounds)
    results = list(batch.run())
    assert len({(r.task, r.seed) for r in results}) == len(results)
    return {(r.task, r.seed): r for r in results}
