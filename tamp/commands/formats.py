"""`tamp import` and `tamp export`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from tamp.cli import SOLVED
from tamp.formats.export import export_ocrtoc
from tamp.formats.ocrtoc import import_ocrtoc
from tamp.task.load import load_task


def import_tasks(options: argparse.Namespace) -> int:
    """Import a folder of OCRTOC's and say what was written."""
    imported = import_ocrtoc(options.folder, options.output)
    return _say(len(imported.paths), imported.warnings, options)


def export_tasks(options: argparse.Namespace) -> int:
    """Export tasks as OCRTOC's own files and say what was written and what was lost."""
    tasks = [load_task(path, allow_outside=options.allow_outside) for path in options.tasks]
    exported = export_ocrtoc(tasks, options.output, options.year)
    return _say(len(exported.paths), exported.warnings, options)


def _say(count: int, warnings: Sequence[str], options: argparse.Namespace) -> int:
    for warning in warnings:
        print(f"tamp: warning: {warning}", file=sys.stderr)
    print(f"{count} {'task' if count == 1 else 'tasks'} in {options.output}")
    return SOLVED
