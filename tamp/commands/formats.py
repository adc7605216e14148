"""`tamp import`."""

from __future__ import annotations

import argparse
import sys

from tamp.cli import SOLVED
from tamp.formats.ocrtoc import import_ocrtoc


def import_tasks(options: argparse.Namespace) -> int:
    """Import a folder of OCRTOC's and say what was written."""
    imported = import_ocrtoc(options.folder, options.output)
    for warning in imported.warnings:
        print(f"tamp: warning: {warning}", file=sys.stderr)
    print(f"{len(imported.paths)} tasks in {options.output}")
    return SOLVED
