"""`tamp dataset`: labelled scenes, rendered with a sensor's noise, for training and measuring."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tamp.cli.options import add_trust, command, load, natural, positive_int
from tamp.cli.paths import output_folder
from tamp.cli.progress import counted
from tamp.cli.status import SOLVED
from tamp.errors import TampError

if TYPE_CHECKING:
    from tamp.cli.options import Commands

FORMATS = ("bop", "ocrtoc")
PRELOAD = ("tamp.perception.dataset.generate", "tamp.execution.settling.settle")
DROPPED = 6
"""So many objects of different shapes are dropped where nothing else is asked for."""

WORK = "tamp.perception.dataset.generate:write_random_scene"


def add(commands: Commands) -> None:
    """`dataset`."""
    text = "render labelled scenes of the objects of tasks; needs the extra 'perception'"
    parser = command(commands, "dataset", dataset, text)
    add = parser.add_argument
    add("tasks", nargs="+", type=Path, metavar="TASK.yaml", help="tasks whose objects may be in the scenes")
    add("-n", "--number", type=positive_int, default=76, metavar="SCENES", help="default 76, as the paper has")
    add("--views", type=positive_int, default=79, metavar="N", help="pictures of a scene; default 79, as the paper has")
    text = f"dropped on to the table; default {DROPPED}, or all where the tasks have fewer"
    add("--objects", type=positive_int, metavar="N", help=text)
    add(
        "-o",
        "--output",
        type=output_folder,
        metavar="OUT",
        required=True,
        help="its folder; what is there already is kept",
    )
    add("--format", choices=FORMATS, default="bop", help="the layout; default bop")
    add("--seed", type=natural, default=0, metavar="N", help="of scenes, views and noise")
    add("--workers", type=positive_int, default=1, metavar="N", help="processes at the same time; default 1")
    add_trust(parser)


def dataset(options: argparse.Namespace) -> int:
    """Write the models and every scene that is not there yet; workers leave no trace in what is written."""
    from tamp.perception.dataset.generate import pool
    from tamp.perception.dataset.layouts import layout

    how, output = layout(options.format), options.output
    objects, looks = pool([load(path, options) for path in options.tasks])
    if options.objects is not None and options.objects > len(objects):
        raise TampError(f"--objects {options.objects}: the tasks have {len(objects)} objects of different shapes")
    options = argparse.Namespace(**{**vars(options), "objects": options.objects or DROPPED})
    refuse_other(output, options)
    how.write_models(looks, output)
    missing = [n for n in range(options.number) if not how.scene_folder(output, n).is_dir()]
    with counted(options.number, "scenes") as advance:
        for _ in range(options.number - len(missing)):
            advance("there already")
        for number in _written(missing, options):
            advance(f"scene {number}")
    there = options.number - len(missing)
    told = f" ({there} of them were there)" if there else ""
    pictures = options.number * options.views
    print(f"{options.number} scenes{told}, {pictures} pictures of {len(objects)} objects in {output}", file=options.out)
    return SOLVED


def refuse_other(output: Path, options: argparse.Namespace) -> None:
    """Refuse a folder that holds something else, or scenes made otherwise; write down how these are made.

    Raises:
        TampError: says so, or in what they differ.
    """
    import json

    path = output / "dataset.json"
    names = ("views", "objects", "format", "seed")
    made: dict[str, Any] = {name: getattr(options, name) for name in names}
    made["tasks"] = sorted(str(task.resolve()) for task in options.tasks)
    if path.is_file():
        try:
            before = json.loads(path.read_text(encoding="utf-8"))
        except ValueError as error:
            raise TampError(f"{path}: not a record of a data set: {error}") from None
        other = [name for name in made if not isinstance(before, dict) or before.get(name) != made[name]]
        if other:
            raise TampError(f"{output} holds a data set made with other {', '.join(other)}; give another --output")
    elif output.is_dir() and any(output.iterdir()):
        raise TampError(f"{output} holds something else than a data set of this command; give another --output")
    output.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(made, indent=1) + "\n", encoding="utf-8")


def _written(missing: Sequence[int], options: argparse.Namespace) -> Iterator[int]:
    from tamp.batch.pool import Job, run_jobs

    shared = {
        "task_files": [str(path.resolve()) for path in options.tasks],
        "folder": str(options.output.resolve()),
        "views": options.views,
        "count": options.objects,
        "seed": options.seed,
        "layout": options.format,
    }
    jobs = [Job(str(number), {**shared, "number": number}) for number in missing]
    for outcome in run_jobs(jobs, WORK, workers=options.workers, preload=PRELOAD):
        if outcome.value is None:
            raise TampError(f"scene {outcome.job.key} was not made: {outcome.message}")
        yield int(outcome.job.key)
