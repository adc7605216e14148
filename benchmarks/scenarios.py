"""The built-in scenarios, solved from end to end."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from importlib.resources import files
from pathlib import Path

from benchmarks.parts.harness import Row, main
from benchmarks.parts.jobs import by_task, solve_all
from tamp.clock import Clock

QUICK = ("one_object", "swap", "stand_up_can")


def rows(quick: bool, seeds: int, only: Sequence[str], clock: Clock) -> Iterator[Row]:
    """One row for each scenario."""
    tasks = sorted((Path(str(files("tamp"))) / "scenarios").glob("*.yaml"))
    wanted = set(only or (QUICK if quick else ()))
    chosen = [task for task in tasks if not wanted or task.stem in wanted]
    yield from by_task(solve_all(chosen, range(1 if quick else seeds), clock))


def _options() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--seeds", type=int, default=3, metavar="N", help="how many seeds each")
    parser.add_argument("--only", nargs="*", default=(), metavar="NAME", help="only these, such as swap")
    parser.add_argument("--clock", choices=("wall", "processor"), default="wall", help="on which limits are kept")
    return parser


if __name__ == "__main__":
    main("scenarios", lambda quick, **options: list(rows(quick, **options)), extra=_options())
