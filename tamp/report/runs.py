"""Results folders as a report needs them: each result with its plans, its task and where its pictures come from."""

from __future__ import annotations

import json
import logging
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

from tamp.errors import TampError
from tamp.results import Result, from_json, read_results
from tamp.task import Plan, Pose, Task
from tamp.task.files.load import load_task
from tamp.task.files.plan_file import load_plan
from tamp.task.files.poses_file import load_poses
from tamp.task.files.regular_file import read_regular
from tamp.task.mesh.parts import parts
from tamp.task.robots import with_robot

RESULTS = "results.jsonl"

Entry = TypeVar("Entry")

log = logging.getLogger("tamp")


@dataclass(frozen=True)
class Sighting:
    """One look of a run in which poses were perceived.

    Attributes:
        number: from 0.
        estimates: object -> where it was thought to be (world frame); what was not found is absent.
        truth: object -> where it was.
        confidence: object -> 0..1.
        errors: object -> how far its estimate was off, over its mesh's symmetries [m]; records of before have how far
            apart the origins are.
        pictures: what was seen with the estimates drawn over it.
    """

    number: int
    estimates: Mapping[str, Pose]
    truth: Mapping[str, Pose]
    confidence: Mapping[str, float]
    errors: Mapping[str, float]
    pictures: tuple[Path, ...]


@dataclass(frozen=True)
class Recorded:
    """One run as its folder has it.

    Attributes:
        result: the record.
        folder: of the run; it may be gone.
    """

    result: Result
    folder: Path

    @cached_property
    def plans(self) -> tuple[Plan, ...]:
        """All plans that the run made, in order."""
        paths = sorted(self.folder.glob("plan-*.json"), key=lambda path: int(path.stem.partition("-")[2]))
        return tuple(load_plan(path) for path in paths)

    @cached_property
    def task(self) -> Task | None:
        """The task; None where its file, or a mesh of it, is gone or no longer reads."""
        try:
            if not self.result.task_path:
                return None
            task = load_task(self.result.task_path, allow_outside=True)
            for thing in task.objects:
                parts(thing.shape)
            return with_robot(task, self.result.configuration.get("robot"))
        except TampError as error:
            log.warning("%s: no pictures and no level: %s", self.folder, error)
            return None

    @cached_property
    def final_poses(self) -> Mapping[str, Pose]:
        """Object -> pose at the end; what is lost is absent."""
        path = self.folder / "poses.json"
        poses = load_poses(path) if path.is_file() else {}
        return {name: pose for name, pose in poses.items() if pose is not None}

    @cached_property
    def sights(self) -> tuple[Sighting, ...]:
        """What was seen in each look, in order; none where poses were given."""
        paths = self.folder.glob("look-*.details.json")
        return tuple(map(_sighting, sorted(paths, key=lambda path: int(path.name.split("-")[1].partition(".")[0]))))

    @cached_property
    def told(self) -> tuple[tuple[str, ...], ...]:
        """Each plan in words, an entry an action; of runs that kept none, the plans' own names."""
        found = self._kept("actions.json", _words)
        return tuple(tuple(map(str, plan.actions)) for plan in self.plans) if found is None else found

    @cached_property
    def searches(self) -> tuple[Mapping[str, Any], ...]:
        """What the planner tells of each search, those in vain included; of runs that kept none, of each plan."""
        found = self._kept("searches.json", _search)
        return tuple(plan.report for plan in self.plans) if found is None else found

    def _kept(self, name: str, read: Callable[[Any], Entry]) -> tuple[Entry, ...] | None:
        """The entries of a list that the run kept; None where it kept none, and with a warning where it is broken."""
        path = self.folder / name
        try:
            found = json.loads(read_regular(path))
            if not isinstance(found, list):
                raise TypeError("it is no list")
            return tuple(map(read, found))
        except FileNotFoundError:
            return None
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
            log.warning("%s: left out, as it is not what a run keeps there: %s", path, error)
            return None

    @property
    def stream_seconds(self) -> dict[str, float]:
        """Stream -> time spent in its sampler, over all searches that tell [s]."""
        return self._summed("streams", lambda report: {s["name"]: s["seconds"] for s in report})

    @property
    def phase_seconds(self) -> dict[str, float]:
        """Phase of planning -> time spent in it, over all searches that tell [s]."""
        return self._summed("seconds", dict)

    def _summed(self, key: str, read: Any) -> dict[str, float]:
        total: dict[str, float] = {}
        for search in self.searches:
            for name, seconds in read(search.get(key, ())).items():
                total[name] = total.get(name, 0.0) + seconds
        return total


def _words(entry: Any) -> tuple[str, ...]:
    """Raises TypeError where the entry is not what `tamp solve` writes."""
    if not isinstance(entry, list) or not all(isinstance(text, str) for text in entry):
        raise TypeError("a plan in words is a list of sentences")
    return tuple(entry)


def _search(entry: Mapping[str, Any]) -> Mapping[str, Any]:
    """Raises an error of the value where the entry is not what `tamp solve` writes."""
    return {
        "seconds": {phase: float(seconds) for phase, seconds in entry["seconds"].items()},
        "streams": [{"name": str(each["name"]), "seconds": float(each["seconds"])} for each in entry["streams"]],
    }


def _sighting(path: Path) -> Sighting:
    """Raises TampError where the file is not what `tamp solve --perceive` writes."""
    try:
        entries = json.loads(read_regular(path))
        estimates, truth = (_poses(entries, which) for which in ("pose", "truth"))
        confidence = {name: float(entry["confidence"]) for name, entry in entries.items()}
        apart = {name: math.dist(pose.xyz, truth[name].xyz) for name, pose in estimates.items()}
        errors = {name: float(entries[name].get("error_m", distance)) for name, distance in apart.items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise TampError(f"{path}: not the record of a look: {error}") from None
    stem = path.name.partition(".")[0]
    pictures = tuple(sorted(path.parent.glob(f"{stem}-*.png")))
    return Sighting(int(stem.partition("-")[2]), estimates, truth, confidence, errors, pictures)


def _poses(entries: Mapping[str, Any], which: str) -> dict[str, Pose]:
    told = {name: entry[which] for name, entry in entries.items() if entry[which] is not None}
    return {name: Pose(tuple(pose["xyz"]), tuple(pose["quat"])) for name, pose in told.items()}


def read_run(folder: Path) -> Recorded:
    """One run from its own folder.

    Raises:
        TampError: where it is no run's folder.
    """
    path = folder / "result.json"
    if not path.is_file():
        if not folder.is_dir():
            raise TampError(f"{folder}: there is no such folder; `tamp solve ... --output DIR` makes runs")
        runs = sorted(inner.parent for inner in folder.glob("*/result.json"))
        if runs:
            raise TampError(f"{folder}: not a run, but a folder of {len(runs)}; name one of them, such as {runs[0]}")
        raise TampError(f"{folder}: not a run: there is no result.json in it; `tamp solve ... --output DIR` makes runs")
    return Recorded(from_json(path.read_text(encoding="utf-8"), str(path)), folder)


def read_runs(folder: Path) -> tuple[Recorded, ...]:
    """All runs of a results folder, in the order of its results.jsonl.

    Raises:
        TampError: where there is no such folder, or it has no results, or those of runs elsewhere.
    """
    if not folder.is_dir():
        raise TampError(f"{folder}: there is no such folder; `tamp solve ... --output DIR` writes one with results")
    results = read_results(folder / RESULTS)
    if not results:
        raise TampError(f"{folder}: there are no results in it; `tamp solve ... --output {folder}` writes some")
    for result in results:
        if Path(result.task).name != result.task:  # else files are read that a stranger's folder has not
            raise TampError(f"{folder / RESULTS}: {result.task!r} is no name of a task")
    return tuple(Recorded(result, folder / f"{result.task}-{result.seed}") for result in results)
