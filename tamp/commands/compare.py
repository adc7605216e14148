"""`tamp compare`: the same tasks and seeds with different samplers, and what the difference is worth."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Mapping, Sequence

from tamp.cli import BAD_INPUT, SOLVED
from tamp.commands.batches import batch, load_tasks, run_batch
from tamp.commands.output import to_stdout, write_json, write_text
from tamp.errors import TampError
from tamp.report.comparison import Comparison
from tamp.report.comparison import compare as compare_results
from tamp.results import Result


def compare(options: argparse.Namespace) -> int:
    """Run each contender's batch, then print and write the comparison; exit status 0 whoever is better."""
    if len(options.sampler) < 2:
        raise TampError("compare needs at least two --sampler; one of them may be 'default'")
    names = [name for name, _ in options.sampler]
    if len(set(names)) < len(names):
        raise TampError(f"the same contender twice: {', '.join(names)}")
    tasks = load_tasks(options.tasks, options.allow_outside)
    if not tasks:
        return BAD_INPUT
    results: dict[str, list[Result]] = {}
    for number, (name, samplers) in enumerate(options.sampler):
        folder = options.output / folder_name(number, name)
        prepared = batch(options, tasks, samplers=samplers, output=folder)
        results[name], interrupted = run_batch(prepared, title=name)
        if interrupted:
            raise KeyboardInterrupt
    comparisons = compare_results(results)
    write_text(options.output / "comparison.html", _page(comparisons, results))
    if not to_stdout(options.json):
        for comparison in comparisons:
            _print(comparison)
        print(f"{options.output / 'comparison.html'}")
    write_json(options.json, [comparison.as_dict() for comparison in comparisons])
    return SOLVED


def folder_name(number: int, name: str) -> str:
    """A folder for a contender's results: its place, and what of its name fits a path."""
    return f"{number}-{re.sub(r'[^A-Za-z0-9_.-]+', '-', name)[:60]}"


def _page(comparisons: Sequence[Comparison], results: Mapping[str, Sequence[Result]]) -> str:
    from tamp.report.page import render
    from tamp.report.plots import differences, survival

    times = {name: [r.planning_s for r in theirs if r.solved] for name, theirs in results.items()}
    return render(
        "comparison.html",
        title="Comparison of samplers",
        comparisons=comparisons,
        picture=differences(comparisons),
        survival=survival(times, {name: len(theirs) for name, theirs in results.items()}),
    )


def _print(comparison: Comparison) -> None:
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(
        box=None, pad_edge=False, title=f"{comparison.other} against {comparison.first}", title_justify="left"
    )
    for heading in ("measure", "first", "other", "difference", "95 % interval", "pairs", "verdict"):
        table.add_column(heading, justify="left" if heading in ("measure", "verdict") else "right")
    for row in comparison.rows:
        if row.difference.count:
            table.add_row(
                Text(row.measure.name),
                row.number(row.first.mean),
                row.number(row.other.mean),
                row.signed(row.difference.mean),
                f"{row.signed(row.difference.lower)} .. {row.signed(row.difference.upper)}",
                str(row.difference.count),
                row.verdict,
            )
    terminal = sys.stdout.isatty()
    Console(file=sys.stdout, width=None if terminal else 160, no_color=None if terminal else True).print(table)
