"""The built-in scenarios, solved from end to end."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path

from benchmarks.harness import Row, main
from benchmarks.jobs import by_task, solve_all

SEEDS = range(3)
QUICK = ("one_object", "swap", "stand_up_can")


def rows(quick: bool) -> Iterator[Row]:
    """One row for each scenario."""
    tasks = sorted((Path(str(files("tamp"))) / "scenarios").glob("*.yaml"))
    chosen = [task for task in tasks if not quick or task.stem in QUICK]
    yield from by_task(solve_all(chosen, range(1) if quick else SEEDS))


if __name__ == "__main__":
    main("scenarios", lambda quick: list(rows(quick)))
