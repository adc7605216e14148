"""`tamp robots`: which there are, and whether one fits what the framework counts on."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tamp.cli.options import add_json, command, natural
from tamp.cli.output import to_stdout, write_json
from tamp.cli.paths import output_file
from tamp.cli.status import SOLVED, UNSOLVED
from tamp.errors import RobotError

if TYPE_CHECKING:
    from tamp.cli.options import Commands


def add(commands: Commands) -> None:
    """`robots` and `robots check`."""
    parser = command(commands, "robots", robots, "list the robots that can be named")
    add_json(parser)
    text = "hold a robot against what planning, checking and execution count on; exit status 1 where anything is wrong"
    kit = command(parser.add_subparsers(metavar="check"), "check", check, text)
    kit.add_argument("robot", metavar="NAME|PATH", help="a robot's name, its robot.yaml, or the folder of that")
    kit.add_argument("--picture", type=output_file(), metavar="FILE", help="draw the robot at home, such as home.png")
    kit.add_argument("--seed", type=natural, default=0, metavar="N")
    add_json(kit)


def robots(options: argparse.Namespace) -> int:
    """One line a robot; of those that cannot be used, why."""
    from tamp.task.robots import robot_files

    listed = [_told(name, path) for name, path in sorted(robot_files().items())]
    if not to_stdout(options):
        for robot in listed:
            if "error" in robot:
                print(f"{robot['name']:12s} cannot be used: {robot['error']}", file=options.out)
            else:
                opens = f"gripper opens {1000 * robot['stroke_m']:.0f} mm, {Path(robot['urdf']).name}"
                print(f"{robot['name']:12s} {len(robot['joints'])} joints, {opens}", file=options.out)
    write_json(options, listed)
    return SOLVED


def _told(name: str, path: Path) -> dict[str, Any]:
    from tamp.task import load_robot

    try:
        s = load_robot(str(path))
    except RobotError as error:
        return {"name": name, "file": str(path), "error": str(error)}
    return {
        "name": name, "file": str(path), "joints": list(s.joints), "lower_rad": list(s.lower),
        "upper_rad": list(s.upper), "velocity_rad_s": list(s.velocity), "stroke_m": s.gripper.stroke,
        "urdf": str(s.urdf),
    }  # fmt: skip


def check(options: argparse.Namespace) -> int:
    """Print what the conformance kit has found; exit status 1 where anything is wrong."""
    from tamp.conformance.robot import check_robot
    from tamp.task import Task, load_robot

    judgement = check_robot(load_robot(options.robot), seed=options.seed)
    if options.picture is not None and judgement.drawable:
        from tamp.report.rendering.scene import render_task

        render_task(Task("home", (), robot=options.robot), {}, options.picture)
    if not to_stdout(options):
        print(judgement, file=options.out)
    write_json(options, judgement.as_dict())
    return SOLVED if judgement.fits else UNSOLVED
