"""The rules of a contest, as contest.yaml has them; where it says nothing, those of the paper (OCRTOC, section V)."""

from __future__ import annotations

import hashlib
import types
import typing
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from pathlib import Path
from typing import Any, Literal

from tamp.contest.sandbox.isolation import Limits
from tamp.errors import TampError, meant
from tamp.execution.simulators import DEFAULT
from tamp.task.files.yaml_document import Document, FieldPath, parse_document, read_document

Bests = Literal["task", "solution", "mean"]

LEAST_S, MOST_S = 1e-3, 1e9
"""Of what is no whole number: times."""

LONGEST_LEASE_S = 3600.0
"""The longest time that a worker may be silent [s]: by it a clock that was put back is told from a long lease."""

MOST: Mapping[str, int] = types.MappingProxyType({"runs": 1000})
"""Whole numbers that are smaller than others: each run on each task waits in the database."""


@dataclass(frozen=True)
class Uploads:
    """What may be uploaded.

    Attributes:
        size_kb: of a package [KiB].
        unpacked_kb: of what is in it [KiB].
        files: how many files are in it, and in a zip folders.
        a_month: submissions to the contest set by a team in a calendar month (UTC).
        trials_a_month: the same to the trial set.
        a_minute: attempts of a team to upload.
    """

    size_kb: int = 65536
    unpacked_kb: int = 262144
    files: int = 2000
    a_month: int = 4
    trials_a_month: int = 100
    a_minute: int = 6


@dataclass(frozen=True)
class Rules:
    """The rules of a contest.

    Attributes:
        name: of the contest.
        about: what its first page says of it.
        contest: patterns of the hidden tasks' files, relative to contest.yaml.
        trial: patterns of the public ones'.
        simulators: in which every solution is run.
        runs: how often on each task and simulator.
        best_of_simulators: what counts of several simulators: the better one over all tasks ("solution", the paper's),
            the better one of each task ("task"), or the mean.
        best_of_runs: what counts of several runs: the best of each task ("task"), the best over all tasks ("solution"),
            or the mean.
        baseline: the default error that improvement is held against: the mean upper error bound ("ueb", the paper's),
            or that of the start poses ("do-nothing").
        execution_s: simulated time of a task [s].
        seed: of the sensors' noise; run N of a task has seed + N.
        cameras: file of the cameras; those of OCRTOC 2021 where it is None.
        renderer: "raycast" or "software".
        libraries: Python distributions that solutions may import, beside the standard library and NumPy.
        contest_log_kb: how much of what it printed on a hidden task an owner sees [KiB]; it could print the task.
        reveal: show pictures and films of the contest set, as when the contest is over.
        limits: of a solution's processes.
        uploads: of the service.
    """

    name: str = "contest"
    about: str = ""
    contest: tuple[str, ...] = ()
    trial: tuple[str, ...] = ()
    simulators: tuple[str, ...] = (DEFAULT,)
    runs: int = 3
    best_of_simulators: Bests = "solution"
    best_of_runs: Bests = "task"
    baseline: Literal["ueb", "do-nothing"] = "ueb"
    execution_s: float = 600.0
    seed: int = 0
    cameras: str | None = None
    renderer: Literal["raycast", "software"] = "raycast"
    libraries: tuple[str, ...] = ()
    contest_log_kb: int = 4
    reveal: bool = False
    limits: Limits = field(default_factory=Limits)
    uploads: Uploads = field(default_factory=Uploads)
    path: Path | None = None


def load_rules(path: Path) -> Rules:
    """Read contest.yaml.

    Raises:
        TaskError: names file, line and field, and what would be valid.
    """
    return _rules(read_document(path), path)


def read_rules(text: str, name: str = "contest.yaml") -> Rules:
    """The rules of a text; see `load_rules`."""
    return _rules(parse_document(text, name), None)


def _rules(document: Document, path: Path | None) -> Rules:
    given = document.value if document.value is not None else {}
    rules: Rules = _record(document, (), given, Rules, path=path)
    if not rules.simulators:
        raise TampError(f"{document.where(('simulators',))}: at least one is needed")
    if len(set(rules.simulators)) < len(rules.simulators):
        raise TampError(f"{document.where(('simulators',))}: one stands twice; say with 'runs' how often it is tried")
    return rules


def _record(document: Document, at: FieldPath, value: Any, kind: type[Any], **extra: Any) -> Any:
    """A dataclass of a mapping."""
    hints = typing.get_type_hints(kind)
    names = [f.name for f in fields(kind) if f.name != "path"]
    if not isinstance(value, Mapping):
        raise TampError(f"{document.where(at)}: expected a mapping of {', '.join(names)}")
    for key in value:
        if key not in names:
            raise TampError(f"{document.where((*at, key))}: unknown; {meant(key, names)}valid are {', '.join(names)}")
    return kind(**{key: _value(document, (*at, key), item, hints[key]) for key, item in value.items()}, **extra)


def _value(document: Document, at: FieldPath, value: Any, hint: Any) -> Any:
    """A value of a type; numbers are at least 0, and more than 0 where they are a limit of time or a count."""
    where = document.where(at)
    if is_dataclass(hint):
        return _record(document, at, value, typing.cast("type[Any]", hint))
    if typing.get_origin(hint) is Literal:
        if value not in typing.get_args(hint):
            raise TampError(f"{where}: {value!r} is not valid; valid are {', '.join(typing.get_args(hint))}")
        return value
    if typing.get_origin(hint) is tuple:
        if not isinstance(value, tuple) or not all(isinstance(item, str) and item for item in value):
            raise TampError(f"{where}: expected a list of texts")
        return value
    if isinstance(hint, types.UnionType):
        return None if value is None else _value(document, at, value, typing.get_args(hint)[0])
    if hint is bool and type(value) is not bool:
        raise TampError(f"{where}: expected true or false")
    if hint is str and not isinstance(value, str):
        raise TampError(f"{where}: expected text")
    if hint is int:
        least, most = int(at[-1] not in ("seed", "contest_log_kb")), MOST.get(str(at[-1]), 1 << 31)
        if type(value) is not int or not least <= value <= most:
            raise TampError(f"{where}: expected a whole number of at least {least} and at most {most}")
    if hint is float:
        if type(value) not in (int, float) or not LEAST_S <= value <= MOST_S:
            raise TampError(
                f"{where}: expected a positive number of seconds, at least {LEAST_S:g} and at most {MOST_S:g}"
            )
        return float(value)
    return value


def task_files(rules: Rules, kind: Literal["contest", "trial"]) -> tuple[Path, ...]:
    """The task files of a set, in the order of their paths within each pattern.

    Raises:
        TampError: where a pattern finds none.
    """
    folder = Path() if rules.path is None else rules.path.parent
    found: dict[Path, None] = {}
    for pattern in getattr(rules, kind):
        try:
            paths = sorted(folder.glob(pattern)) if not Path(pattern).is_absolute() else [Path(pattern)]
        except (ValueError, IndexError):  # as pathlib says that it is none
            raise TampError(f"{rules.path}: {kind}: {pattern!r} is no pattern of files, such as tasks/*.yaml") from None
        paths = [path for path in paths if path.is_file()]
        if not paths:
            raise TampError(f"{rules.path}: {kind}: there is no file {pattern!r} in {folder.resolve()}")
        found |= dict.fromkeys(paths)
    return tuple(found)


def scene_of(rules: Rules) -> dict[str, Any]:
    """What of the rules decides how a solution does a task, in JSON's types; cameras are known by their content.

    Raises:
        TampError: where the cameras cannot be read.
    """
    cameras = ""
    if rules.cameras is not None:
        path = (Path() if rules.path is None else rules.path.parent) / rules.cameras
        try:
            cameras = hashlib.sha256(path.read_bytes()).hexdigest()
        except OSError as error:
            raise TampError(f"{path}: the cameras cannot be read: {error.strerror}") from None
    kept = ("execution_s", "seed", "renderer")
    return {**{name: getattr(rules, name) for name in kept}, "cameras": cameras}
