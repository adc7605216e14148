"""Arguments of `tamp score`."""

from __future__ import annotations

import argparse
from pathlib import Path

from tamp.arguments.kinds import Commands, add_json, add_outside, command, natural, positive_int


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """`score`."""
    score = command(commands, "score", "score:score", "score final poses from any source, or rank solutions")
    add = score.add_argument
    add("task", type=Path, nargs="?", metavar="TASK.yaml")
    add("poses", type=Path, nargs="?", metavar="POSES.json")
    add("--metric", default="ede", metavar="NAME", help="ede (default), ocrtoc2020, ocrtoc2021, ocrtoc2024")
    add("--leaderboard", type=Path, nargs="+", metavar="DIR", help="rank solutions: folders with a results.jsonl each")
    add("--tasks", type=Path, nargs="+", metavar="TASK.yaml", help="the set to rank by; default: all that were run")
    add(
        "--best-of",
        type=positive_int,
        metavar="K",
        help="of a task's first K runs the best counts; default: mean",
    )
    add("--seed", type=natural, default=0, metavar="N", help="of the confidence intervals")
    add_outside(add)
    add_json(score)
