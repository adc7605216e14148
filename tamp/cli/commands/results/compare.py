"""`tamp compare`: the same tasks and seeds solved in different ways, and what the difference is worth."""

from __future__ import annotations

import argparse
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

from tamp.cli.batches import add_batch_options, batch, load_tasks, run_batches
from tamp.cli.options import add_json, add_settings, add_trust, command, is_sampler, number, seeds
from tamp.cli.output import to_stdout, write_json, write_text
from tamp.cli.paths import distinct, output_folder
from tamp.cli.status import BAD_INPUT, SOLVED, UNSOLVED
from tamp.errors import TampError, meant
from tamp.pipeline.options.settings import Settings
from tamp.pipeline.options.tuning import Tuning

if TYPE_CHECKING:
    from tamp.cli.options import Commands
    from tamp.report.comparison import Comparison
    from tamp.results import Result


def add(commands: Commands) -> None:
    """`compare`."""
    text = "solve the same tasks in different ways and show the differences with confidence intervals"
    parser = command(commands, "compare", compare, text)
    add = parser.add_argument
    tasks = "tasks to be solved, or folders of results to be compared as they are"
    add("tasks", nargs="+", type=Path, metavar="TASK.yaml|DIR", help=tasks)
    how = "NAME:STREAM=MODULE:FUNCTION,OPTION=VALUE,... or NAME alone; the first is what others are held against"
    add("--contender", type=contender, action="append", default=[], metavar="CONTENDER", help=how)
    how = "a contender without a name: STREAM=MODULE:FUNCTION,... or 'default'"
    add("--sampler", type=unnamed, action="append", dest="contender", metavar="SAMPLERS", help=how)
    add("--seed", type=seeds, action="extend", metavar="N|N-M", help="may be repeated, or a range; default 0")
    add_settings(parser)
    add("--no-execute", action="store_true", help="only plan and check")
    add(
        "--output",
        type=output_folder,
        metavar="DIR",
        required=True,
        help="a folder of results each, and comparison.html",
    )
    add_batch_options(parser)
    add_trust(parser)
    add_json(parser)


@dataclass(frozen=True)
class Contender:
    """One way to solve the tasks.

    Attributes:
        name: what it is called in tables.
        samplers: stream -> address of the function that serves it.
        settings: fields of `Settings`, in place of what the command line says for all.
    """

    name: str
    samplers: Mapping[str, str]
    settings: Mapping[str, Any]


def contender(text: str) -> Contender:
    """`NAME`, or `NAME:` and what it does otherwise, joined by commas."""
    name, _, rest = text.partition(":")
    if not name or "=" in name:
        raise argparse.ArgumentTypeError(f"{text} has no name; expected NAME:STREAM=MODULE:FUNCTION,OPTION=VALUE,...")
    return _read(name, rest)


def unnamed(text: str) -> Contender:
    """What a contender does otherwise, which is its name too."""
    return _read(text, "" if text == "default" else text)


def _read(name: str, text: str) -> Contender:
    given = {field.name: field.metadata for field in fields(Settings) if "help" in field.metadata}
    options = {name: () if metadata["own"] else metadata["choices"] for name, metadata in given.items()}
    numbers = [field.name for field in fields(Tuning)]
    samplers: dict[str, str] = {}
    settings: dict[str, Any] = {}
    for part in text.split(",") if text else ():
        key, equals, value = part.partition("=")
        field = key.replace("-", "_")
        if field in options and (not options[field] or value in options[field]):
            settings[field] = value
        elif equals and field in numbers:
            settings["tuning"] = {**settings.get("tuning", {}), **dict([number(f"{field}={value}")])}
        elif equals and key and is_sampler(value) and field not in options:
            samplers[key] = value
        else:
            others = (f"STREAM=MODULE:FUNCTION or one of {', '.join(options)} or a number of --tuning with a value",)
            near = meant(value, options[field]) if field in options else meant(field, [*options, *numbers])
            valid = f"{near}valid are {', '.join(options.get(field) or others)}"
            raise argparse.ArgumentTypeError(f"{part!r} of contender {name} is not valid; {valid}")
    return Contender(name, samplers, settings)


def compare(options: argparse.Namespace) -> int:
    """Print and write the comparison of contenders, or of folders of results.

    Returns:
        0 whoever is better; 1 where something of a contender's broke.
    """
    from tamp.report.comparison import compare as compare_results
    from tamp.report.reasons import outcomes

    folders = [path for path in options.tasks if path.is_dir()]
    if folders and (len(folders) < len(options.tasks) or options.contender):
        raise TampError("compare takes either folders of results, or TASK.yaml files and contenders")
    results = _read_folders(folders) if folders else _run(options)
    if results is None:
        return BAD_INPUT
    comparisons = compare_results(results)
    write_text(options.output / "comparison.html", _page(comparisons, results))
    if not to_stdout(options):
        for comparison in comparisons:
            _print(comparison, options.out)
        for name, theirs in results.items():
            print(f"{name}: {outcomes(theirs)}", file=options.out)
        print(options.output / "comparison.html", file=options.out)
    write_json(options, [comparison.as_dict() for comparison in comparisons])
    broken = any(result.status == "error" for theirs in results.values() for result in theirs)
    return UNSOLVED if broken else SOLVED


def _read_folders(folders: Sequence[Path]) -> Mapping[str, Sequence[Result]]:
    from tamp.report.report import named_folders
    from tamp.report.runs import read_runs

    folders = distinct(folders)
    if len(folders) < 2:
        raise TampError("compare needs at least two folders of results, each another one")
    return {name: [run.result for run in read_runs(folder)] for name, folder in named_folders(folders).items()}


def _run(options: argparse.Namespace) -> Mapping[str, Sequence[Result]] | None:
    """The results of each contender, all of them having run by turns; None where a task is invalid."""
    names = [one.name for one in options.contender]
    if len(names) < 2:
        raise TampError("compare needs at least two --contender or --sampler; one of them may be 'default'")
    if len(set(names)) < len(names):
        raise TampError(f"the same contender twice: {', '.join(names)}")
    tasks = load_tasks(options.tasks, options)
    if not tasks:
        return None
    options.output_given = True
    batches = [
        batch(
            options,
            tasks,
            samplers=one.samplers,
            settings=one.settings,
            output=options.output / folder_name(number, one.name),
        )
        for number, one in enumerate(options.contender)
    ]
    ended = run_batches(batches)
    ended.refuse_interrupted(options.output)
    return dict(zip(names, ended.results, strict=True))


def folder_name(number: int, name: str) -> str:
    """A folder for a contender's results: its place, and what of its name fits a path."""
    return f"{number}-{re.sub(r'[^A-Za-z0-9_.-]+', '-', name)[:60]}"


def _page(comparisons: Sequence[Comparison], results: Mapping[str, Sequence[Result]]) -> str:
    from tamp.report.page import render
    from tamp.report.plots import differences, survival
    from tamp.report.reasons import outcomes

    times = {name: [r.planning_s for r in theirs if r.solved] for name, theirs in results.items()}
    return render(
        "comparison.html",
        title="Comparison",
        comparisons=comparisons,
        outcomes={name: outcomes(theirs) for name, theirs in results.items()},
        picture=differences(comparisons),
        survival=survival(times, {name: len(theirs) for name, theirs in results.items()}),
    )


def _print(comparison: Comparison, out: TextIO) -> None:
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
    terminal = out.isatty()
    Console(file=out, width=None if terminal else 160, no_color=None if terminal else True).print(table)
