"""Arguments of `tamp import`."""

from __future__ import annotations

import argparse
from pathlib import Path

from tamp.arguments.kinds import Commands


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """`import`."""
    source = commands.add_parser("import", help="turn other task files into task.yaml files")
    source.add_argument("format", choices=("ocrtoc",))
    source.add_argument("folder", type=Path, metavar="FOLDER")
    source.add_argument("-o", "--output", type=Path, metavar="OUT", required=True)
    source.set_defaults(run="formats:import_tasks")
