"""What every benchmark shares: its command line, its table, and a JSON file that two revisions can be compared by."""

from __future__ import annotations

import argparse
import json
import math
import os
import platform
import sys
import time
from collections.abc import Callable, Sequence
from importlib.metadata import distributions
from pathlib import Path
from typing import Any

Row = dict[str, Any]

PACKAGES = ("numpy", "pin", "coal", "ompl", "toppra", "python-fcl", "pybullet", "trimesh", "scipy", "up-fast-downward")


def main(
    name: str,
    run: Callable[..., Sequence[Row]],
    arguments: Sequence[str] | None = None,
    extra: argparse.ArgumentParser | None = None,
    asked: str = "",
) -> None:
    """Run a benchmark from the command line.

    Args:
        name: the benchmark's module name.
        run: takes whether to be quick (within a minute) and returns the rows of its table.
        arguments: in place of the command line's.
        extra: further options (a parser without its own help), which `run` takes by keyword.
        asked: what the numbers are held against, printed under the table.
    """
    parents = [] if extra is None else [extra]
    parser = argparse.ArgumentParser(prog=f"python -m benchmarks.{name}", parents=parents)
    parser.add_argument("--quick", action="store_true", help="fewer repetitions: ends within a minute")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write machine, versions and rows to FILE")
    options = parser.parse_args(arguments)
    start = time.monotonic()
    further = {key: value for key, value in vars(options).items() if key not in ("quick", "json")}
    rows = [dict(row) for row in run(options.quick, **further)]
    print(table(rows))
    if asked:
        print(f"asked: {asked}")
    print(f"{name}: {len(rows)} rows in {time.monotonic() - start:.1f} s")
    if options.json is not None:
        result = {
            "name": name,
            "quick": options.quick,
            "asked": asked,
            "machine": machine(),
            "versions": versions(),
            "rows": rows,
        }
        options.json.write_text(json.dumps(result, indent=2) + "\n", encoding="utf-8")


def machine() -> dict[str, Any]:
    """What the numbers were measured on."""
    return {"system": platform.system(), "processor": _processor(), "cores": os.cpu_count()}


def versions() -> dict[str, str]:
    """Versions of Python and of the libraries that the numbers depend on."""
    installed = {dist.metadata["Name"].lower(): dist.version for dist in distributions()}
    return {"python": platform.python_version(), **{name: installed.get(name, "absent") for name in PACKAGES}}


def table(rows: Sequence[Row]) -> str:
    """The rows as aligned columns, one for each key in order of first appearance."""
    columns = list(dict.fromkeys(key for row in rows for key in row))
    cells = [columns, *([_text(row.get(column, "")) for column in columns] for row in rows)]
    widths = [max(len(line[i]) for line in cells) for i in range(len(columns))]
    return "\n".join("  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)) for line in cells)


def percentile(values: Sequence[float], share: float) -> float:
    """The value that `share` percent of the values do not exceed, by the nearest rank."""
    ranked = sorted(values)
    return ranked[max(0, math.ceil(len(ranked) * share / 100) - 1)]


def _text(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _processor() -> str:
    """The processor's name where the system tells it."""
    path = Path("/proc/cpuinfo")
    if sys.platform.startswith("linux") and path.is_file():
        for line in path.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor()
