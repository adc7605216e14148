"""A report on many runs: how long it takes to write, how large it is, and how long a browser takes to open it.

A few runs, those of --results or else of some scenarios that are solved first, stand for many, as if of further seeds.
`opens_s` is what headless Chromium takes for a picture of the page beyond what it takes for an empty one.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import tempfile
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from statistics import median

from benchmarks.parts.harness import Row, main
from tamp.batch import Batch
from tamp.report.report import write_report
from tamp.report.runs import Recorded, read_runs
from tamp.results import to_json
from tamp.task.files.load import load_task

SCENARIOS = Path(__file__).parents[1] / "scenarios"
SOLVED_FIRST = ("clutter_ten", "in_box", "slide_twice", "turn_over")
LOOKS = 3
ASKED = "1,400 results in a report that opens within 3 s"


def run(quick: bool, results: Path | None, runs: int) -> Sequence[Row]:
    with tempfile.TemporaryDirectory() as scratch:
        few = results or _solved(Path(scratch) / "few")
        many = Path(scratch) / "many"
        _repeated(read_runs(few), 100 if quick else runs, many)
        return [_written(many, pictures) for pictures in (0, 10 if quick else 100)]


def _solved(folder: Path) -> Path:
    """Results of a few scenarios."""
    tasks = [load_task(SCENARIOS / f"{name}.yaml") for name in SOLVED_FIRST]
    list(Batch(tasks, output=folder).run())
    return folder


def _repeated(few: Sequence[Recorded], count: int, folder: Path) -> None:
    """A results folder of `count` runs, each a few's under another seed; large files are shared."""
    folder.mkdir()
    with (folder / "results.jsonl").open("w", encoding="utf-8") as lines:
        for index in range(count):
            of = few[index % len(few)]
            result = replace(of.result, seed=index // len(few))
            copied = folder / f"{result.task}-{result.seed}"
            shutil.copytree(of.folder, copied, copy_function=os.link)
            lines.write(to_json(result) + "\n")


def _written(folder: Path, pictures: int) -> Row:
    page = folder / "report.html"
    began = time.monotonic()
    write_report([folder], page, pictures=pictures)
    took = time.monotonic() - began
    row = {"runs": len(read_runs(folder)), "pictures_of": pictures, "written_in_s": took}
    return {**row, "mbytes": page.stat().st_size / 1e6, "opens_s": _opening_s(page)}


def _opening_s(page: Path) -> float | None:
    """Median over some looks; None without a browser."""
    browser = shutil.which("chromium")
    if browser is None:
        return None
    empty = page.with_name("empty.html")
    empty.write_text("<!doctype html><title>empty</title>", encoding="utf-8")
    beyond = [_picture_s(browser, page) - _picture_s(browser, empty) for _ in range(LOOKS)]
    return median(beyond)


def _picture_s(browser: str, page: Path) -> float:
    picture = page.with_suffix(".png")
    command = [browser, "--headless", "--no-sandbox", "--disable-gpu", f"--screenshot={picture}", page.as_uri()]
    began = time.monotonic()
    subprocess.run(command, capture_output=True, timeout=300, check=True)
    return time.monotonic() - began


if __name__ == "__main__":
    options = argparse.ArgumentParser(add_help=False)
    options.add_argument("--results", type=Path, metavar="DIR", help="of `tamp solve`; default: of some scenarios")
    options.add_argument("--runs", type=int, default=1400, metavar="N", help="default 1400")
    main("reports", run, extra=options, asked=ASKED)
