"""`tamp doctor`: versions and binaries, and a task small enough to show that all parts work together."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

from tamp.cli import SOLVED, UNSOLVED
from tamp.results import Result
from tamp.versions import versions


def doctor(options: argparse.Namespace) -> int:
    """Print what is installed and what works; exit status 1 where something does not."""
    for name, version in versions().items():
        print(f"{name:18s} {version}")
    missing = [name for name, version in versions().items() if version == "absent"]
    checks: list[tuple[str, Callable[[], str]]] = [
        ("Fast Downward", _fast_downward), ("robots", _robots), ("one block, from A to B", _one_block),
    ]  # fmt: skip
    broken = list(missing)
    for title, check in checks:
        began = time.monotonic()
        try:
            said = check()
        except Exception as error:  # whatever is broken here is what the user came to be told
            said = f"BROKEN: {type(error).__name__}: {error}"
            broken.append(title)
        print(f"{title:24s} {said}  ({time.monotonic() - began:.1f} s)")
    print("all is well" if not broken else f"broken or absent: {', '.join(broken)}")
    return UNSOLVED if broken else SOLVED


def _fast_downward() -> str:
    from tamp.planning.fast_downward import binary

    return str(binary())


def _robots() -> str:
    from tamp.task import load_robot, robot_names
    from tamp.world.robot_model import robot_model

    for name in robot_names():
        robot_model(load_robot(name))
    return ", ".join(robot_names())


def _one_block() -> str:
    from tamp.pipeline.solving import solve
    from tamp.task import At, Box, Object, Pose, Task

    block = Object("block", Box((0.05, 0.05, 0.08)), Pose((0.1, 0.2, 0.04)), At(Pose((0.1, -0.2, 0.04))))
    result: Result = solve(Task("doctor", (block,)), timeout=30.0)
    if not result.solved:
        raise RuntimeError(f"{result.status}: {result.message}")
    return f"solved with {result.n_actions} actions, error {1000 * (result.ede_m or 0.0):.1f} mm"
