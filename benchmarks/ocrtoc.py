"""OCRTOC's public tasks of 2021, from settled start scenes to a score, and the means that rank a solution."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from benchmarks.harness import Row, main
from benchmarks.jobs import by_task, solve_all
from tamp.formats.ocrtoc import import_ocrtoc

DATA = Path(__file__).parents[2] / "shared" / "ocrtoc" / "2021"
QUICK = ("0-0", "1-1-1", "6-1-1")


def rows(quick: bool) -> Iterator[Row]:
    """One row for each task, and the means over all."""
    if not DATA.is_dir():
        sys.exit(f"the tasks are not there: {DATA}")
    with tempfile.TemporaryDirectory() as folder:
        import_ocrtoc(DATA, Path(folder))
        tasks = [t for t in sorted(Path(folder).glob("*.yaml")) if not quick or t.stem in QUICK]
        results = list(solve_all(tasks, seeds=[0]))
    yield from by_task(results)
    scored = [r for r in results if r.ede_m is not None and r.do_nothing_ede_m is not None]
    error, idle = (sum(values) / len(scored) for values in zip(*_errors(scored), strict=True))
    solved = sum(r.status == "solved" for r in results)
    summary = {"task": "all", "solved": f"{solved} of {len(results)}", "ede_cm": 100 * error, "idle_cm": 100 * idle}
    yield {**summary, "message": f"improvement {1 - error / idle:.1%}"}


def _errors(results: list) -> Iterator[tuple[float, float]]:
    return ((r.ede_m, r.do_nothing_ede_m) for r in results)


if __name__ == "__main__":
    main("ocrtoc", lambda quick: list(rows(quick)))
