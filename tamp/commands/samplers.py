"""`tamp samplers check`."""

from __future__ import annotations

import argparse

from tamp.cli import SOLVED, UNSOLVED
from tamp.commands.output import to_stdout, write_json
from tamp.conformance import check_sampler
from tamp.task.load import load_task


def check(options: argparse.Namespace) -> int:
    """Print what the conformance kit has found; exit status 1 where anything is wrong."""
    tasks = None if options.task is None else [load_task(options.task, allow_outside=options.allow_outside)]
    judgement = check_sampler(options.address, options.stream, domain=options.domain, tasks=tasks, seed=options.seed)
    if not to_stdout(options.json):
        print(judgement)
    write_json(options.json, judgement.as_dict())
    return SOLVED if judgement.fits else UNSOLVED
