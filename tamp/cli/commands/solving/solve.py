"""`tamp solve`: tasks planned, checked, executed and scored, many at a time, and their table."""

from __future__ import annotations

import argparse
import itertools
import logging
from collections.abc import Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from tamp.cli.batches import add_batch_options, batch, load_tasks, run_batches, say_invalid
from tamp.cli.commands.solving.replay import replay
from tamp.cli.options import add_json, add_planning_options, command, seeds
from tamp.cli.output import to_stdout, write_asked, write_json
from tamp.cli.paths import TABLE, distinct, output_file, output_folder
from tamp.cli.status import BAD_INPUT, SOLVED, UNSOLVED
from tamp.errors import TampError
from tamp.task.files.regular_file import followed

if TYPE_CHECKING:
    from tamp.cli.options import Commands
    from tamp.results import Result

log = logging.getLogger("tamp")


def add(commands: Commands) -> None:
    """`solve`."""
    parser = command(commands, "solve", solve, "plan, check, execute and score tasks")
    add = parser.add_argument
    add("tasks", nargs="*", type=Path, metavar="TASK.yaml")
    add("--seed", type=seeds, action="extend", metavar="N|N-M", help="may be repeated, or a range; default 0")
    add_planning_options(parser)
    add("--no-execute", action="store_true", help="only plan and check")
    add("--output", type=output_folder, metavar="DIR", help="for results; default: a new folder in results/")
    add_json(parser)
    add("--csv", type=output_file(TABLE), metavar="FILE", help="the same as comma-separated values; - likewise")
    add("--replay", type=Path, metavar="RUN", help="run again what a run's folder records, and compare the plans")
    add_batch_options(parser)


def solve(options: argparse.Namespace) -> int:
    """Run the batch that the options describe; without tasks, or with a bad one, nothing is run."""
    from tamp.report.tables import csv_text

    if options.replay is not None:
        return replay(options)
    if not options.tasks:
        raise TampError("solve needs at least one TASK.yaml")
    if options.resume and options.output is None:
        raise TampError("--resume needs --output DIR, the folder that holds the results so far")
    options.output_given = options.output is not None
    options.output = options.output or new_folder()
    _refuse_one_file_for_two(options)
    options.tasks = distinct(options.tasks)
    tasks = load_tasks(options.tasks, options)
    if not tasks:
        return BAD_INPUT
    prepared = batch(options, tasks, samplers=dict(options.sampler), output=options.output)
    ended = run_batches([prepared])
    (results,) = ended.results
    counts = {"skipped": len(options.tasks) - len(tasks) + len(_invalid(results))} if options.skip_invalid else {}
    _show(results, options, counts | ({"kept": ended.kept} if options.resume else {}))
    write_json(options, [result.as_dict() for result in results])
    if options.csv is not None:
        write_asked(options, options.csv, csv_text(results))
    ended.refuse_interrupted(options.output)
    return _status(results, options)


def _refuse_one_file_for_two(options: argparse.Namespace) -> None:
    """Refuse options of which one would write over what another writes."""
    from tamp.batch import RESULTS

    taken = {followed(options.output / RESULTS): "the results of the batch itself"}
    for option, path in (("--json", options.json), ("--csv", options.csv)):
        if path is not None and (other := taken.setdefault(followed(path), option)) != option:
            raise TampError(f"{option} {path} is where {other} would be written, too; choose another file")


def _invalid(results: Sequence[Result]) -> Mapping[str, str]:
    """The files of tasks that only a run has found to be invalid -> why."""
    return {result.task_path: result.message for result in results if result.status == "invalid"}


def new_folder() -> Path:
    """A folder in results/ that does not exist yet, named by the time."""
    stamp = datetime.now().strftime("%Y-%m-%d-%H%M%S")
    names = (Path("results") / (stamp if i == 1 else f"{stamp}-{i}") for i in itertools.count(1))
    return next(name for name in names if not name.exists())


def _show(results: Sequence[Result], options: argparse.Namespace, counts: Mapping[str, int]) -> None:
    from tamp.report.tables import summary_line
    from tamp.results import print_table

    for path, why in _invalid(results).items():
        say_invalid(path, why, options)
    for task, remarks in {result.task: result.remarks for result in results if result.remarks}.items():
        log.warning("%s: %s", task, "; ".join(remarks))
    for result in results:
        if result.plans_rejected:
            whose = "your samplers or " * bool(result.configuration.get("samplers")) + f"domain {result.domain}"
            sent = f"the checker sent {result.plans_rejected} plans back: a bug of {whose}"
            log.warning("%s: %s; report.txt in its folder says why", result.task, sent)
    if not (to_stdout(options) or options.quiet) and any(r.status != "invalid" for r in results):
        print_table(results, options.out)
        print(summary_line(results, options.output, counts), file=options.out)
    else:
        log.info("results in %s", options.output)


def _status(results: Sequence[Result], options: argparse.Namespace) -> int:
    invalid = sum(r.status == "invalid" for r in results)
    if invalid and not (options.skip_invalid and invalid < len(results)):
        return BAD_INPUT
    return SOLVED if all(r.solved for r in results if r.status != "invalid") else UNSOLVED
