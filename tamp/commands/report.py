"""`tamp report`."""

from __future__ import annotations

import argparse

from tamp.cli import SOLVED
from tamp.report.report import write_report


def report(options: argparse.Namespace) -> int:
    """Write the page and say where it is."""
    path = options.output or options.folders[0] / "report.html"
    write_report(options.folders, path, pictures=options.pictures)
    print(path)
    return SOLVED
