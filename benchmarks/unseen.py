"""Tables in the manner of OCRTOC 2021 that nobody has tuned for, drawn by `benchmarks.parts.unseen_tables` and solved.

    python -m benchmarks.unseen --count 200 --output DIR

Means are by the family of the public task that a table is drawn from. Every result is on disk before the next task
begins, and the same command goes on where it was interrupted.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from benchmarks.ocrtoc import DATA, add_batch_options, solved
from benchmarks.parts.harness import Row, main
from benchmarks.parts.unseen_tables import family, write_tables
from tamp.formats.ocrtoc import import_ocrtoc
from tamp.task.files.load import load_task

COUNT, QUICK = 200, 3
"""Tables."""


def rows(
    quick: bool, count: int | None, first: int, tables_seed: int, output: Path | None, **how: Any
) -> Iterator[Row]:
    """One row for each table and seed, and the means over each family and all."""
    data = DATA / "2021"
    if not data.is_dir():
        sys.exit(f"OCRTOC's models are not there: {data}")
    number = count or (QUICK if quick else COUNT)
    with tempfile.TemporaryDirectory() as scratch:
        folder = output or Path(scratch)
        names = write_tables(data, folder / "drawn", range(first, first + number), tables_seed)
        import_ocrtoc(folder / "drawn", folder / "tasks")
        tasks = [load_task(folder / "tasks" / f"{name}.yaml") for name in names]
        yield from solved(tasks, folder, lambda result: f"family {family(result.task)}", **how)


def _options() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--count", type=int, metavar="N", help=f"how many tables (default {COUNT})")
    parser.add_argument("--first", type=int, default=0, metavar="N", help="number of the first (default 0)")
    parser.add_argument("--tables-seed", type=int, default=0, metavar="N", help="of the tables (default 0)")
    add_batch_options(parser)
    return parser


if __name__ == "__main__":
    main("unseen", lambda quick, **options: list(rows(quick, **options)), extra=_options())
