"""The report: everything that a results folder tells, as one page."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from tamp.report.page import render
from tamp.report.pictures import Gallery
from tamp.report.plots import bars, boxes, survival
from tamp.report.runs import Recorded, read_runs
from tamp.report.statistics import share
from tamp.report.words import reasons, sentences
from tamp.results import Result
from tamp.scoring.ranking import rank, recall

WORST_OBJECTS = 30
MOST_REASONS = 25


def write_report(folders: Sequence[Path], path: Path, *, pictures: int) -> None:
    """Write the page of one or several results folders.

    Args:
        folders: each with a results.jsonl and its runs' folders.
        path: the HTML file.
        pictures: how many runs get pictures; those that are not solved come first.

    Raises:
        TampError: where a folder has no results.
    """
    solutions = {name: read_runs(folder) for name, folder in _named(folders).items()}
    text = render("report.html", **_content(solutions, pictures))
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def _named(folders: Sequence[Path]) -> dict[str, Path]:
    """Folders by their last part; by their whole path where that is not enough."""
    short = Counter(folder.resolve().name for folder in folders)
    return {f.resolve().name if short[f.resolve().name] == 1 else str(f): f for f in folders}


def _content(solutions: Mapping[str, Sequence[Recorded]], pictures: int) -> dict[str, Any]:
    results = {name: [run.result for run in runs] for name, runs in solutions.items()}
    every = [result for theirs in results.values() for result in theirs]
    runs = [run for theirs in solutions.values() for run in theirs]
    return {
        "title": f"Results: {', '.join(solutions)}",
        "summaries": {name: _summary(theirs) for name, theirs in results.items()},
        "standings": rank(results, yardsticks) if (yardsticks := recall(every)) else (),
        "survival": survival(
            {name: [r.planning_s for r in theirs if r.solved] for name, theirs in results.items()},
            {name: len(theirs) for name, theirs in results.items()},
        ),
        "levels": _boxes(_by_level(runs), "EDE [cm]"),
        "objects": _boxes(_by_object(every), "EDE [cm]"),
        "phases": _split([run.phase_seconds for run in runs]),
        "streams": _split([run.stream_seconds for run in runs]),
        "reasons": reasons(every)[:MOST_REASONS],
        "runs": list(_pages(solutions, Gallery(pictures, runs))),
    }


def _summary(results: Sequence[Result]) -> dict[str, Any]:
    solved = share(sum(r.solved for r in results), len(results))
    attempted, held = (sum(getattr(r, f"grasps_{what}") for r in results) for what in ("attempted", "succeeded"))
    return {"solved": solved, "statuses": Counter(r.status for r in results), "attempted": attempted, "held": held}


def _by_level(runs: Sequence[Recorded]) -> dict[str, list[float]]:
    groups = defaultdict(list)
    for run in runs:
        if run.result.ede_m is not None:
            level = None if run.task is None else run.task.level
            groups["no level" if level is None else f"level {level}"].append(100 * run.result.ede_m)
    return dict(sorted(groups.items()))


def _by_object(results: Sequence[Result]) -> dict[str, list[float]]:
    """The objects with the largest mean errors, the worst on top."""
    groups = defaultdict(list)
    for result in results:
        for entry in result.objects:
            groups[entry["name"]].append(100 * entry["ede_m"])
    worst = sorted(groups, key=lambda name: (sum(groups[name]) / len(groups[name]), name))[-WORST_OBJECTS:]
    return {name: groups[name] for name in worst}


def _boxes(groups: Mapping[str, Sequence[float]], label: str) -> str:
    return boxes(groups, label) if groups else ""


def _split(parts: Sequence[Mapping[str, float]]) -> str:
    """Mean seconds a run, the largest first; empty where nothing is known."""
    told = [part for part in parts if part]
    total: Counter[str] = Counter()
    for part in told:
        total.update(part)
    means = {name: seconds / len(told) for name, seconds in total.most_common() if seconds > 0}
    return bars(means, "mean time a run [s]") if means else ""


def _pages(solutions: Mapping[str, Sequence[Recorded]], gallery: Gallery) -> Iterator[dict[str, Any]]:
    for name, runs in solutions.items():
        for run in runs:
            yield {
                "solution": name if len(solutions) > 1 else "",
                "result": run.result,
                "plans": [sentences(plan) for plan in run.plans],
                "pictures": gallery.of(run),
            }
