"""`tamp generate`: a set of new tasks in a folder, and what they are like."""

from __future__ import annotations

import argparse
import json
import logging
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from tamp.batch.pool import Job, run_jobs
from tamp.cli import SOLVED
from tamp.errors import TampError
from tamp.generate.run import copy_library, recipes
from tamp.generate.statistics import statistics, table
from tamp.generate.task import Recipe
from tamp.scenarios.library.model import FOLDER

LOG = logging.getLogger(__name__)

AT_ONCE = 10
"""Tasks that one worker process makes: enough that its start costs little."""
PRELOAD = ("tamp.generate.run", "tamp.execution.settling", "tamp.world.kinematics")


def generate(options: argparse.Namespace) -> int:
    """Make the tasks; workers and their number leave no trace in what is made."""
    wanted = recipes(options.number, options.seed, options.level, options.family)
    copy_library(options.library or FOLDER, options.output)
    place = {recipe.name: i for i, recipe in enumerate(wanted)}
    rows = sorted(_rows(wanted, options.output, options.workers), key=lambda row: place[row["name"]])
    lines = statistics(rows)
    _write(options.output / "tasks.json", rows)
    print(table(lines))
    print(f"{len(rows)} tasks in {options.output}")
    return SOLVED


def _rows(wanted: Sequence[Recipe], output: Path, workers: int) -> Iterator[dict[str, Any]]:
    jobs = [
        Job(
            f"{first}", {"output": str(output), "asked": [asdict(recipe) for recipe in wanted[first : first + AT_ONCE]]}
        )
        for first in range(0, len(wanted), AT_ONCE)
    ]
    done = 0
    for outcome in run_jobs(jobs, "tamp.generate.run:make_tasks", workers=workers, preload=PRELOAD):
        if outcome.value is None:
            raise TampError(f"the tasks from number {outcome.job.key} on were not made: {outcome.message}")
        done += len(outcome.value["rows"])
        LOG.info("%d of %d tasks made", done, len(wanted))
        yield from outcome.value["rows"]


def _write(path: Path, rows: Sequence[dict[str, Any]]) -> None:
    try:
        path.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    except OSError as error:
        raise TampError(f"{path}: cannot be written: {error.strerror}") from error
