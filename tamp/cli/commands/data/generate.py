"""`tamp generate`: a set of new tasks in a folder, and what they are like."""

from __future__ import annotations

import argparse
import json
import logging
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tamp.cli.options import command, natural, positive_int
from tamp.cli.output import write_text
from tamp.cli.paths import output_folder
from tamp.cli.status import SOLVED
from tamp.errors import TampError

if TYPE_CHECKING:
    from tamp.cli.options import Commands
    from tamp.generate.task import Recipe

LOG = logging.getLogger(__name__)

AT_ONCE = 10
"""Tasks that one worker process makes: enough that its start costs little."""
PRELOAD = ("tamp.generate.run", "tamp.execution.settling.settle", "tamp.world.kinematics.inverse")


def add(commands: Commands) -> None:
    """`generate`."""
    parser = command(commands, "generate", generate, "make new tasks from scene graphs")
    add = parser.add_argument
    add("-n", "--number", type=positive_int, default=1400, metavar="N", help="how many; default 1400, as the paper has")
    add("--seed", type=natural, default=0, metavar="N")
    add("-o", "--output", type=output_folder, metavar="OUT", required=True, help="the folder they are written to")
    add("--level", type=positive_int, metavar="L", help="only this level, 1 to 5")
    add("--family", metavar="F", help="only this family: food, tableware, stationery or mixed")
    add("--library", type=Path, metavar="DIR", help="a library of objects in place of ours")
    add("--workers", type=positive_int, default=1, metavar="N", help="processes at the same time; default 1")


def generate(options: argparse.Namespace) -> int:
    """Make the tasks; workers and their number leave no trace in what is made."""
    from tamp.generate.run import copy_library, recipes, refuse_to_overwrite
    from tamp.generate.statistics import statistics, table
    from tamp.scenarios.library.model import FOLDER

    wanted = recipes(options.number, options.seed, options.level, options.family)
    refuse_to_overwrite(options.output, wanted)
    copy_library(options.library or FOLDER, options.output)
    place = {recipe.name: i for i, recipe in enumerate(wanted)}
    rows = sorted(_rows(wanted, options.output, options.workers), key=lambda row: place[row["name"]])
    lines = statistics(rows)
    write_text(options.output / "tasks.json", json.dumps(rows, indent=1) + "\n")
    print(table(lines), file=options.out)
    print(f"{len(rows)} tasks in {options.output}", file=options.out)
    return SOLVED


def _rows(wanted: Sequence[Recipe], output: Path, workers: int) -> Iterator[dict[str, Any]]:
    from tamp.batch.pool import Job, run_jobs

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
