"""Arguments of `tamp import` and `tamp export`."""

from __future__ import annotations

import argparse
from pathlib import Path

from tamp.arguments.kinds import Commands, add_outside


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """`import`, `export`."""
    source = commands.add_parser("import", help="turn other task files into task.yaml files")
    source.add_argument("format", choices=("ocrtoc",))
    source.add_argument("folder", type=Path, metavar="FOLDER")
    source.add_argument("-o", "--output", type=Path, metavar="OUT", required=True)
    source.set_defaults(run="formats:import_tasks")
    target = commands.add_parser("export", help="turn task.yaml files into other task files")
    target.add_argument("format", choices=("ocrtoc",))
    target.add_argument("tasks", type=Path, nargs="+", metavar="TASK.yaml")
    target.add_argument("-o", "--output", type=Path, metavar="OUT", required=True)
    target.add_argument("--year", type=int, choices=(2020, 2021), default=2021, help="2021 (default): YAML; 2020: SDF")
    add_outside(target.add_argument)
    target.set_defaults(run="formats:export_tasks")
