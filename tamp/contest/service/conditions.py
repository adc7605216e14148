"""Under what runs are done: tasks, simulators and all else that decides a result; runs of other ones are not compared.

They are kept in the database. A task is known by its content, not by its place in a folder: a contest task keeps its
number for good, and that of one that is gone is given to no other. Where rules or tasks have changed since, the
service does not begin until its organiser says, by `tamp contest again`, that all submissions are held against these.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

from tamp.contest.rules import scene_of
from tamp.contest.service.contest import KINDS, Contest, Entry, Kind, numbered
from tamp.task.files.digest import task_sha256

Run = tuple[str, str, int]
"""A task's label, a simulator, a number."""


@dataclass(frozen=True)
class Conditions:
    """What decides the result of a run.

    Attributes:
        tasks: set -> label -> SHA-256 of the task's files.
        simulators, runs: which runs there are.
        scene: the rules by which each of them is done.
    """

    tasks: dict[str, dict[str, str]]
    simulators: tuple[str, ...]
    runs: int
    scene: dict[str, Any]


def runs(asked: Conditions, kind: Kind) -> Iterator[Run]:
    """All runs of a submission to a set."""
    for run in range(asked.runs):
        for label in asked.tasks[kind]:
            for simulator in asked.simulators:
                yield label, simulator, run


def conditions(contest: Contest) -> Conditions:
    """Those of a contest.

    Raises:
        TampError: where its cameras cannot be read.
    """
    rules = contest.rules
    tasks: dict[str, dict[str, str]] = {}
    for kind in KINDS:
        tasks[kind] = {entry.label: task_sha256(entry.task) for entry in contest.entries[kind]}
    return Conditions(tasks, rules.simulators, rules.runs, scene_of(rules))


def labelled(contest: Contest, known: Mapping[str, str]) -> Contest:
    """The contest with hidden tasks under the numbers that they ever had, and new ones under higher ones.

    Args:
        contest: as it was read.
        known: label -> SHA-256 of each hidden task that there ever was.
    """
    free: dict[str, list[str]] = {}
    for label, digest in known.items():
        free.setdefault(digest, []).append(label)
    most = max(map(int, known), default=0)
    renamed = {}
    for entry in contest.entries["contest"]:
        labels = free.get(task_sha256(entry.task))
        most += not labels
        renamed[entry.label] = labels.pop(0) if labels else numbered(most)
    entries = [Entry(renamed[entry.label], entry.task) for entry in contest.entries["contest"]]
    yardsticks = [replace(one, task=renamed[one.task]) for one in contest.yardsticks["contest"]]
    return replace(
        contest,
        entries={**contest.entries, "contest": tuple(sorted(entries, key=lambda entry: int(entry.label)))},
        yardsticks={**contest.yardsticks, "contest": tuple(sorted(yardsticks, key=lambda one: int(one.task)))},
    )


def labels(history: Sequence[Conditions]) -> dict[str, dict[str, str]]:
    """Set -> label -> the SHA-256 that it had last."""
    found: dict[str, dict[str, str]] = {kind: {} for kind in KINDS}
    for one in history:
        for kind in KINDS:
            found[kind] |= one.tasks[kind]
    return found


def changes(before: Conditions, now: Conditions) -> Iterator[str]:
    """What differs, in words that tell no hidden task."""
    for kind in KINDS:
        was, is_ = before.tasks[kind], now.tasks[kind]
        gone, new = sorted(was.keys() - is_.keys()), sorted(is_.keys() - was.keys())
        other = sorted(label for label in was.keys() & is_.keys() if was[label] != is_[label])
        for some, what in ((gone, "gone"), (new, "new"), (other, "changed")):
            if some:
                yield f"{kind} tasks {', '.join(some[:10])}{' and more' * (len(some) > 10)} are {what}"
    for name in ("simulators", "runs"):
        if getattr(before, name) != getattr(now, name):
            yield f"{name} was {_said(getattr(before, name))} and is {_said(getattr(now, name))}"
    yield from (f"{name} has changed" for name, value in now.scene.items() if before.scene.get(name) != value)


def _said(value: Any) -> str:
    return ", ".join(value) if isinstance(value, tuple) else str(value)


def to_text(kept: Conditions) -> str:
    """As the database keeps them."""
    return json.dumps(asdict(kept))


def from_text(text: str) -> Conditions:
    """What `to_text` wrote."""
    value = json.loads(text)
    return Conditions(value["tasks"], tuple(value["simulators"]), value["runs"], value["scene"])
