"""Arguments of `tamp generate`."""

from __future__ import annotations

import argparse
from pathlib import Path

from tamp.arguments.kinds import Commands, natural, positive_int


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """`generate`."""
    generate = commands.add_parser("generate", help="make new tasks from scene graphs")
    add = generate.add_argument
    add("-n", "--number", type=positive_int, default=1400, metavar="N", help="how many; default 1400, as the paper has")
    add("--seed", type=natural, default=0, metavar="N")
    add("-o", "--output", type=Path, metavar="OUT", required=True, help="the folder they are written to")
    add("--level", type=positive_int, metavar="L", help="only this level, 1 to 5")
    add("--family", metavar="F", help="only this family: food, tableware, stationery or mixed")
    add("--library", type=Path, metavar="DIR", help="a library of objects in place of ours")
    add("--workers", type=positive_int, default=1, metavar="N", help="processes at the same time; default 1")
    generate.set_defaults(run="generate:generate")
