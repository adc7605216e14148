"""`tamp import` and `tamp export`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from tamp.cli.options import add_trust, command, load, seconds
from tamp.cli.paths import output_folder, output_path
from tamp.cli.status import SOLVED
from tamp.errors import TampError

if TYPE_CHECKING:
    from tamp.cli.options import Commands


def add(commands: Commands) -> None:
    """`import`, `export`."""
    source = command(commands, "import", import_tasks, "turn other task files into task.yaml files")
    source.add_argument("format", choices=("ocrtoc",))
    source.add_argument("folder", type=Path, metavar="FOLDER")
    source.add_argument("-o", "--output", type=output_folder, metavar="OUT", required=True)
    told = "give tasks of 2020 that year's robot, ur5e_2f85, where it stood; else they have the default one"
    source.add_argument("--own-robot", action="store_true", help=told)
    target = command(commands, "export", export, "turn tasks into other task files, or a plan into set points")
    target.add_argument("what", choices=("ocrtoc", "trajectory"))
    target.add_argument(
        "files", type=Path, nargs="+", metavar="FILE", help="tasks; of a trajectory one plan, PLAN.json"
    )
    target.add_argument("-o", "--output", type=output_path, metavar="OUT", required=True)
    target.add_argument("--year", type=int, choices=(2020, 2021), default=2021, help="2021 (default): YAML; 2020: SDF")
    target.add_argument(
        "--format", choices=("csv", "ros2", "rosbag2"), default="csv", help="of a trajectory; default csv"
    )
    target.add_argument("--rate", type=seconds, default=100.0, metavar="HZ", help="set points a second; default 100")
    add_trust(target)


def import_tasks(options: argparse.Namespace) -> int:
    """Import a folder of OCRTOC's and say what was written."""
    from tamp.formats.ocrtoc import import_ocrtoc

    imported = import_ocrtoc(options.folder, options.output, own_robot=options.own_robot)
    return _say(len(imported.paths), imported.warnings, options)


def export(options: argparse.Namespace) -> int:
    """Export what is asked for."""
    return _export_trajectory(options) if options.what == "trajectory" else export_tasks(options)


def _export_trajectory(options: argparse.Namespace) -> int:
    """Export a plan's motions as set points for a robot's own controller."""
    from tamp.formats.trajectory import export_trajectory
    from tamp.task import load_robot
    from tamp.task.files.plan_file import load_plan
    from tamp.task.robots import is_path

    if len(options.files) != 1:
        raise TampError(f"tamp export trajectory takes one plan, not {len(options.files)}")
    plan = load_plan(options.files[0])
    if options.robot is None and is_path(plan.robot):
        told = f"its robot, {plan.robot}, is told from where its task is; give it by --robot"
        raise TampError(f"{options.files[0]}: {told}")
    robot = load_robot(options.robot or plan.robot)
    if len(robot.joints) != len(plan.home):
        told = f"the plan moves {len(plan.home)} joints, robot {robot.name} has {len(robot.joints)}"
        raise TampError(f"{options.files[0]}: {told}; give the plan's robot by --robot")
    count = export_trajectory(plan, robot, options.output, options.format, options.rate)
    print(f"{count} set points in {options.output}", file=options.out)
    return SOLVED


def export_tasks(options: argparse.Namespace) -> int:
    """Export tasks as OCRTOC's own files and say what was written and what was lost."""
    from tamp.formats.export import export_ocrtoc

    tasks = [load(path, options) for path in options.files]
    exported = export_ocrtoc(tasks, options.output, options.year)
    return _say(len(exported.paths), exported.warnings, options)


def _say(count: int, warnings: Sequence[str], options: argparse.Namespace) -> int:
    for warning in warnings:
        print(f"tamp: warning: {warning}", file=sys.stderr)
    print(f"{count} {'task' if count == 1 else 'tasks'} in {options.output}", file=options.out)
    return SOLVED
