"""`tamp solve`: a batch and its table."""

from __future__ import annotations

import argparse
import logging
import sys
from collections.abc import Sequence

from tamp.cli import BAD_INPUT, SOLVED, UNSOLVED
from tamp.commands.batches import batch, load_tasks, run_batch
from tamp.commands.output import to_stdout, write_json, write_text
from tamp.errors import TampError
from tamp.report.tables import csv_text, summary_line
from tamp.results import Result, print_table

log = logging.getLogger("tamp")


def solve(options: argparse.Namespace) -> int:
    """Run the batch that the options describe; without tasks, or with a bad one, nothing is run."""
    if options.replay is not None:
        from tamp.commands.replay import replay

        return replay(options.replay)
    if not options.tasks:
        raise TampError("solve needs at least one TASK.yaml")
    if options.resume and options.output is None:
        raise TampError("--resume needs --output DIR, the folder that holds the results so far")
    tasks = load_tasks(options.tasks, options.allow_outside)
    if not tasks:
        return BAD_INPUT
    prepared = batch(options, tasks, samplers=dict(options.sampler), output=options.output)
    results, interrupted = run_batch(prepared)
    _show(results, quiet=to_stdout(options.json) or log.getEffectiveLevel() > logging.WARNING)
    write_json(options.json, [result.as_dict() for result in results])
    if options.csv is not None:
        write_text(options.csv, csv_text(results))
    if interrupted:
        raise KeyboardInterrupt
    return _status(results)


def _show(results: Sequence[Result], *, quiet: bool) -> None:
    for result in results:
        if result.status == "invalid":
            print(f"tamp: {result.message}", file=sys.stderr)
        if result.plans_rejected:
            log.warning("%s: the checker sent %d plans back: a bug of ours", result.task, result.plans_rejected)
    if not quiet and any(r.status != "invalid" for r in results):
        print_table(results, sys.stdout)
        print(summary_line(results))


def _status(results: Sequence[Result]) -> int:
    if any(r.status == "invalid" for r in results):
        return BAD_INPUT
    return SOLVED if all(r.solved for r in results) else UNSOLVED
