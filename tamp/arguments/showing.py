"""Arguments of the commands that show results: pages, pictures, the viewer."""

from __future__ import annotations

import argparse
from pathlib import Path

from tamp.arguments.kinds import Commands, command, natural


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """`report`."""
    report = command(commands, "report", "report:report", "write a report on results: one HTML file, no network")
    report.add_argument("folders", nargs="+", type=Path, metavar="DIR", help="folders of results, one a solution")
    report.add_argument("-o", "--output", type=Path, metavar="FILE", help="default: report.html in the first folder")
    report.add_argument("--pictures", type=natural, default=100, metavar="N", help="of at most N runs; default 100")
