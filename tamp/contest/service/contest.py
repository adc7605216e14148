"""A contest as its service sees it: the rules, and the tasks of both sets with what their errors are held against."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from tamp.contest.rules import Rules, load_rules, task_files
from tamp.errors import TampError
from tamp.execution.simulators import require
from tamp.scoring.ranking import Yardstick, measure
from tamp.task import Task
from tamp.task.files.load import load_task

Kind = Literal["contest", "trial"]
KINDS: tuple[Kind, ...] = ("contest", "trial")


@dataclass(frozen=True)
class Entry:
    """A task of a set.

    Attributes:
        label: what the public calls it: its name in the trial set, a number in the contest set.
        task: the task.
    """

    label: str
    task: Task


@dataclass(frozen=True)
class Contest:
    """A contest.

    Attributes:
        rules: its rules.
        entries: set -> its tasks.
        yardsticks: set -> what their errors are held against, under their labels.
    """

    rules: Rules
    entries: dict[Kind, tuple[Entry, ...]]
    yardsticks: dict[Kind, tuple[Yardstick, ...]]

    def entry(self, kind: Kind, label: str) -> Entry:
        """A task by its label.

        Raises:
            TampError: where the set has none of that label any more.
        """
        for entry in self.entries[kind]:
            if entry.label == label:
                return entry
        raise TampError(f"the {kind} set has no task {label!r}; tasks must stay the same while a contest runs")


def load_contest(path: Path) -> Contest:
    """Read contest.yaml and all tasks that it names.

    Raises:
        TampError: where the rules or a task cannot be used, a simulator is missing, there is no contest task or none
            that is scored, or one of them is a trial task, too.
    """
    rules = load_rules(path)
    for name in rules.simulators:
        require(name)
    entries: dict[Kind, tuple[Entry, ...]] = {}
    sets = {kind: task_files(rules, kind) for kind in KINDS}
    if both := {file.resolve() for file in sets["contest"]} & {file.resolve() for file in sets["trial"]}:
        raise TampError(
            f"{path}: {min(both)} is in both sets; whoever asks gets the trial tasks, a contest task is hidden"
        )
    for kind, found in sets.items():
        tasks = [load_task(file, allow_outside=True) for file in found]
        labels = [task.name if kind == "trial" else numbered(number) for number, task in enumerate(tasks, start=1)]
        if len(set(labels)) < len(labels):
            raise TampError(f"{path}: {kind}: two tasks have the same name; names must differ within a set")
        entries[kind] = tuple(Entry(label, task) for label, task in zip(labels, tasks, strict=True))
    if not entries["contest"]:
        raise TampError(f"{path}: contest: name at least one task file")
    yardsticks = {kind: _yardsticks(entries[kind]) for kind in KINDS}
    if not yardsticks["contest"]:
        raise TampError(f"{path}: contest: none of the tasks has a goal pose, by which a solution is scored")
    return Contest(rules, entries, yardsticks)


def numbered(number: int) -> str:
    """What the public calls a contest task."""
    return f"{number:03}"


def _yardsticks(entries: tuple[Entry, ...]) -> tuple[Yardstick, ...]:
    return tuple(replace(one, task=entry.label) for entry in entries for one in measure([entry.task]))
