"""The report: everything that a results folder tells, as one page."""

from __future__ import annotations

import os
import shlex
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, get_args
from urllib.parse import quote

from tamp.report.page import render
from tamp.report.plots import bars, boxes, stacked, survival
from tamp.report.reasons import reasons
from tamp.report.rendering.pictures import Gallery
from tamp.report.runs import Recorded, read_runs
from tamp.report.statistics import share
from tamp.results import Result, Status
from tamp.scoring.ranking import rank, recall
from tamp.task.files.regular_file import followed, unlinked

WORST_OBJECTS = 30
MOST_REASONS = 25
REST = "settling, timing, checking"
"""What planning does outside the stream planner, which tells its own phases."""


def write_report(folders: Sequence[Path], path: Path, *, pictures: int) -> None:
    """Write the page of one or several results folders.

    Args:
        folders: each with a results.jsonl and its runs' folders.
        path: the HTML file; a link that is there in one of the folders is replaced, not followed.
        pictures: how many runs get pictures; those that are not solved come first.

    Raises:
        TampError: where a folder has no results.
        OSError: where the page cannot be written; names it.
    """
    solutions = {name: read_runs(folder) for name, folder in named_folders(folders).items()}
    text = render("report.html", **_content(solutions, path.resolve().parent, pictures))
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.parent in folders:
        unlinked(path)
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:  # of a full disk, Python does not say where
        raise OSError(error.errno, error.strerror, str(path)) from error


def named_folders(folders: Sequence[Path]) -> dict[str, Path]:
    """Folders by their last part; by their whole path where that is not enough."""
    names = {folder: followed(folder).name for folder in folders}
    short = Counter(names.values())
    return {name if short[name] == 1 else str(folder): folder for folder, name in names.items()}


def _content(solutions: Mapping[str, Sequence[Recorded]], home: Path, pictures: int) -> dict[str, Any]:
    results = {name: [run.result for run in runs] for name, runs in solutions.items()}
    gallery = Gallery(pictures, [run for theirs in solutions.values() for run in theirs])
    yardsticks = recall(result for theirs in results.values() for result in theirs)
    sections = {
        "Error by object, the worst": {name: _boxes(_by_object(theirs)) for name, theirs in results.items()},
        "Time in each stream's sampler": {name: _streams(runs) for name, runs in solutions.items()},
    }
    return {
        "title": f"Results: {', '.join(solutions)}",
        "summaries": {name: _summary(theirs) for name, theirs in results.items()},
        "standings": rank(results, yardsticks) if yardsticks else (),
        "survival": survival(
            {name: [r.planning_s for r in theirs if r.solved] for name, theirs in results.items()},
            {name: len(theirs) for name, theirs in results.items()},
        ),
        "phases": stacked({name: _phases(runs) for name, runs in solutions.items()}, "mean planning time a run [s]"),
        "levels": _boxes(_by_level(solutions)),
        "sections": {heading: {n: p for n, p in part.items() if p} for heading, part in sections.items()},
        "reasons": {name: reasons(theirs)[:MOST_REASONS] for name, theirs in results.items()},
        "statuses": [s for s in get_args(Status) if any(r.status == s for theirs in results.values() for r in theirs)],
        "runs": {name: [_page(run, home, gallery) for run in runs] for name, runs in solutions.items()},
    }


def _summary(results: Sequence[Result]) -> dict[str, Any]:
    solved = share(sum(r.solved for r in results), len(results))
    attempted, held = (sum(getattr(r, f"grasps_{what}") for r in results) for what in ("attempted", "succeeded"))
    return {"solved": solved, "statuses": Counter(r.status for r in results), "attempted": attempted, "held": held}


def _by_level(solutions: Mapping[str, Sequence[Recorded]]) -> dict[str, list[float]]:
    """Level and, where there are several, solution -> errors [cm]; the easiest on top."""
    groups = defaultdict(list)
    for name, runs in solutions.items():
        for result in (run.result for run in runs):
            if result.ede_m is not None:
                level = "no level" if result.level is None else f"level {result.level}"
                groups[f"{level}, {name}" if len(solutions) > 1 else level].append(100 * result.ede_m)
    return dict(sorted(groups.items(), reverse=True))


def _by_object(results: Sequence[Result]) -> dict[str, list[float]]:
    """The objects with the largest mean errors [cm], the worst on top; each task's for themselves."""
    several = len({result.task for result in results}) > 1
    groups = defaultdict(list)
    for result in results:
        for entry in result.objects:
            groups[f"{entry['name']} in {result.task}" if several else entry["name"]].append(100 * entry["ede_m"])
    worst = sorted(groups, key=lambda name: (sum(groups[name]) / len(groups[name]), name))[-WORST_OBJECTS:]
    return {name: groups[name] for name in worst}


def _boxes(groups: Mapping[str, Sequence[float]]) -> str:
    return boxes(groups, "EDE [cm]") if groups else ""


def _phases(runs: Sequence[Recorded]) -> dict[str, float]:
    """Phase -> mean seconds a run; all phases together are the mean planning time."""
    total: defaultdict[str, float] = defaultdict(float)
    for run in runs:
        phases = run.phase_seconds
        rest = max(0.0, run.result.planning_s - sum(phases.values()))
        for phase, seconds in {**phases, REST: rest}.items():
            total[phase] += seconds
    return {name: seconds / len(runs) for name, seconds in total.items()}


def _streams(runs: Sequence[Recorded]) -> str:
    """Mean seconds a run in each stream's sampler, the largest first; empty where nothing is known."""
    total: Counter[str] = Counter()
    for run in runs:
        total.update(run.stream_seconds)
    means = {name: seconds / len(runs) for name, seconds in total.most_common() if seconds > 0}
    return bars(means, "mean time a run [s]") if means else ""


def _page(run: Recorded, home: Path, gallery: Gallery) -> dict[str, Any]:
    folder = run.folder.resolve()
    there = folder.is_dir()
    link = Path(os.path.relpath(folder, home)).as_posix()
    films = [name for name in ("run.gif", "run.mp4") if there and (folder / name).is_file()]
    return {
        "result": run.result,
        "plans": run.told,
        "pictures": gallery.of(run),
        "folder": quote(link) if there else "",
        "films": [f"{quote(link)}/{name}" for name in films],
        "command": _again(run) if run.result.task_path else "",
    }


def _again(run: Recorded) -> str:
    """The command that repeats a run."""
    if (run.folder / "manifest.json").is_file():
        return f"tamp solve --replay {shlex.quote(str(run.folder))}"
    words = ["tamp", "solve", run.result.task_path, "--seed", str(run.result.seed)]
    for name, value in run.result.configuration.items():
        flag = f"--{name.replace('_', '-')}"
        if name == "samplers":
            words += [word for stream, address in value.items() for word in ("--sampler", f"{stream}={address}")]
        elif name == "tuning":
            for field, number in value.items():
                words += ["--tuning", f"{field}={','.join(map(str, number if isinstance(number, list) else [number]))}"]
        elif name == "execute":
            words += [] if value else ["--no-execute"]
        elif value is True:
            words.append(flag)
        elif value not in (None, False):
            words += [flag, str(value)]
    return shlex.join(words)
