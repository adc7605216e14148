"""The result of one task and seed: a record, one JSON line, and a row in the table."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import MISSING, Field, dataclass, field, fields
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal, get_args

from tamp.errors import TampError
from tamp.frozen import FrozenDict

if TYPE_CHECKING:
    from typing import TextIO

Status = Literal["solved", "planned", "failed", "timeout", "infeasible", "invalid", "error"]


@dataclass(frozen=True)
class Result:
    """What came of one task and seed.

    Attributes:
        task: the task's name.
        seed: the seed.
        status: "solved": planned, accepted by the checker, executed, every goal pose within 3 cm EDE and every symbolic
            goal met. "planned": the same without execution, which was not asked for. "failed": some goal was not
            reached. "timeout": no plan in time. "infeasible": proven to have no plan. "invalid": the input is wrong.
            "error": a bug, a crash, or a limit enforced from outside.
        planning_s: time of planning, checking and replanning [s].
        execution_sim_s: simulated time of execution [s].
        wall_s: wall time of everything [s].
        n_actions: actions of all plans that were executed, as far as they were begun; of the plan where none was.
        n_replans: plans made after the first.
        grasps_attempted: how often the fingers closed on an object.
        grasps_succeeded: how often it was still held after the lift.
        plan_checked: whether the checker accepted every plan.
        plans_rejected: plans that the checker sent back to the planner: each is a bug of the planner's.
        ede_m, do_nothing_ede_m, mean_ueb_m: see `tamp.scoring.Score`; None where no object has a goal pose [m].
        improvement, improvement_ueb: share of either baseline that was made good.
        objects: one mapping an object with a goal pose: name, ede_m, ueb_m, error_m, lost.
        goals_met: object -> whether its goal holds.
        plan_sha256: of the first plan's content; empty without a plan.
        message: why it is not solved, in words.
        remarks: poses of the task that settle elsewhere than given, in words.
        versions: of the program, of Python and of the libraries that decide results.
        task_path: the file the task came from, from the root; empty where it was built in code.
        level: of difficulty, as the task's file has it.
        clock: on which the limit for planning was kept: "wall", or "processor" time; planning_s is in it too.
        domain: what it was planned with.
        strategy: by which parts of the task were put to the planner.
        simulator: in which the plans were carried out; empty in results of before it was recorded.
        perceived: whether poses were estimated from cameras, and not given.
        perceiving_s: time that estimating poses took, on the same clock; no part of planning [s].
        perception: one mapping an object, where poses were perceived: name, fate, estimate_m, raw_m, confidence, look,
            end_m; see `tamp.pipeline.perceived.outcome.Outcome`.
        settings: every option that decided the result, defaults and the task's own included.
        configuration: the options that a batch was given, by which it can be run again.
        task_sha256: of the task's file and meshes, as the batch found them.
        code_sha256: of the user's own code that took part, as the batch found it; empty where there was none.
        load: of the machine when the run began: processes that wanted to run over the minute before, for each core.
    """

    task: str
    seed: int
    status: Status
    planning_s: float = 0.0
    execution_sim_s: float = 0.0
    wall_s: float = 0.0
    n_actions: int = 0
    n_replans: int = 0
    grasps_attempted: int = 0
    grasps_succeeded: int = 0
    plan_checked: bool = False
    plans_rejected: int = 0
    ede_m: float | None = None
    do_nothing_ede_m: float | None = None
    mean_ueb_m: float | None = None
    improvement: float | None = None
    improvement_ueb: float | None = None
    objects: tuple[Mapping[str, Any], ...] = ()
    goals_met: Mapping[str, bool] = field(default_factory=dict)
    plan_sha256: str = ""
    message: str = ""
    remarks: tuple[str, ...] = ()
    versions: Mapping[str, str] = field(default_factory=dict)
    task_path: str = ""
    level: int | None = None
    clock: str = "wall"
    domain: str = ""
    strategy: str = ""
    simulator: str = ""
    perceived: bool = False
    perceiving_s: float = 0.0
    perception: tuple[Mapping[str, Any], ...] = ()
    settings: Mapping[str, Any] = field(default_factory=dict)
    configuration: Mapping[str, Any] = field(default_factory=dict)
    task_sha256: str = ""
    code_sha256: str = ""
    load: float | None = None

    def __post_init__(self) -> None:
        if self.status not in get_args(Status):
            raise ValueError(f"unknown status {self.status!r}; valid are {', '.join(get_args(Status))}")
        object.__setattr__(self, "remarks", tuple(self.remarks))
        for name in ("objects", "perception"):
            object.__setattr__(self, name, tuple(FrozenDict(o) for o in getattr(self, name)))
        for name in ("goals_met", "versions", "settings", "configuration"):
            object.__setattr__(self, name, FrozenDict(getattr(self, name)))

    @property
    def solved(self) -> bool:
        """Whether everything that was asked for was reached."""
        return self.status in ("solved", "planned")

    def as_dict(self) -> dict[str, Any]:
        """JSON-like values, in the order of the attributes."""
        values = {f.name: getattr(self, f.name) for f in fields(self)}
        return {key: _plain(value) for key, value in values.items()}


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return dict(value)
    return [_plain(v) for v in value] if isinstance(value, tuple) else value


def to_json(result: Result) -> str:
    """One line of JSON, without its newline."""
    return json.dumps(result.as_dict(), allow_nan=False, separators=(", ", ": "))


def from_json(line: str, where: str = "result") -> Result:
    """Read back what `to_json` wrote; fields it does not know, from a newer version, are left out.

    Raises:
        TampError: where the line is not a result; `where` names it in the message.
    """
    try:
        data = json.loads(line)
        known = {f.name for f in fields(Result)}
        if missing := [f.name for f in fields(Result) if _needed(f) and f.name not in data]:
            raise ValueError(f"it lacks {' and '.join(missing)}")
        return Result(**{key: value for key, value in data.items() if key in known})
    except (ValueError, TypeError, AttributeError, RecursionError) as error:
        raise TampError(f"{where}: not a result: {error}") from None


def _needed(field: Field[Any]) -> bool:
    """Whether a field has no default."""
    return field.default is MISSING and field.default_factory is MISSING


def read_results(path: Path) -> tuple[Result, ...]:
    """All results of a results.jsonl; a last line that was cut off is left out, its task counts as not run.

    Raises:
        TampError: where another line is not a result.
    """
    if not path.is_file():
        return ()
    lines = path.read_bytes().split(b"\n")
    return tuple(
        from_json(line.decode("utf-8", errors="replace"), f"{path}:{number}")
        for number, line in enumerate(lines[:-1], start=1)
        if line.strip()
    )


COLUMNS: Mapping[str, Callable[[Result], str]] = MappingProxyType(
    {
        "task": lambda r: r.task,
        "seed": lambda r: str(r.seed),
        "status": lambda r: r.status,
        "actions": lambda r: str(r.n_actions),
        "replans": lambda r: str(r.n_replans),
        "grasps": lambda r: f"{r.grasps_succeeded}/{r.grasps_attempted}",
        "plan s": lambda r: f"{r.planning_s:.1f}",
        "sim s": lambda r: f"{r.execution_sim_s:.0f}",
        "EDE cm": lambda r: _number(r.ede_m, 100.0, ".2f"),
        "doing nothing cm": lambda r: _number(r.do_nothing_ede_m, 100.0, ".1f"),
        "improvement": lambda r: percent(r.improvement, 0),
    }
)
"""Heading of the table -> the cell of a result."""

GIVEN_UP = ("doing nothing cm", "replans", "improvement", "grasps", "sim s", "actions", "plan s", "EDE cm")
"""Columns that go where a terminal is too narrow for all, the first one first; names of tasks are never cut."""


def print_table(results: Sequence[Result], file: TextIO) -> None:
    """Print a table with a row a result and a line of totals; colour on a terminal only."""
    from rich.console import Console

    terminal = file.isatty()
    # Lines are as long as they are: names can be copied, and other programs can read them.
    console = Console(file=file, no_color=None if terminal else True, soft_wrap=True, markup=False, highlight=False)
    lines = table_lines(results, console.width if terminal else None)
    console.print(lines[0], style="bold")
    for line, result in zip(lines[1:], results, strict=True):
        console.print(_shown(line), style=None if result.solved else "red")
    for result in results:
        if result.message and not result.solved:
            console.print(_shown(f"{result.task} (seed {result.seed}): {result.message}"))
    console.print(summary(results))


def _shown(text: str) -> str:
    """A line without what would move a terminal's cursor, or clear its screen: names are a file's."""
    return "".join(sign if sign.isprintable() else "\N{REPLACEMENT CHARACTER}" for sign in text)


def table_lines(results: Sequence[Result], width: int | None = None) -> list[str]:
    """The heading and a line a result; in a width, columns are given up where they do not all fit."""
    columns = {name: [name, *map(cell, results)] for name, cell in COLUMNS.items()}
    for name in GIVEN_UP if width is not None else ():
        if sum(2 + max(map(len, cells)) for cells in columns.values()) - 2 <= (width or 0):
            break
        del columns[name]
    widths = {name: max(map(len, cells)) for name, cells in columns.items()}
    rows = zip(*columns.values(), strict=True)
    left = ("task", "status")
    return [
        "  ".join(
            cell.ljust(widths[name]) if name in left else cell.rjust(widths[name])
            for name, cell in zip(columns, row, strict=True)
        ).rstrip()
        for row in rows
    ]


def _number(value: float | None, scale: float, form: str) -> str:
    return "-" if value is None else format(scale * value, form)


def percent(share: float | None, digits: int = 1) -> str:
    """A share such as "12.3%", or "-" where there is none; what rounds to nothing has no sign."""
    return "-" if share is None else f"{round(share, digits + 2) + 0.0:.{digits}%}"


def summary(results: Iterable[Result]) -> str:
    """One line: how many are solved, and the mean error against doing nothing."""
    results = tuple(results)
    solved = sum(r.solved for r in results)
    scored = [(r.ede_m, r.do_nothing_ede_m) for r in results if r.ede_m is not None and r.do_nothing_ede_m is not None]
    planned = bool(results) and all(r.status != "solved" for r in results if r.solved) and solved > 0
    text = f"{solved} of {len(results)} {'planned' if planned else 'solved'}"
    if not scored:
        return text
    mean, idle = (sum(values) / len(scored) for values in zip(*scored, strict=True))
    return f"{text}; mean EDE {100 * mean:.2f} cm, doing nothing {100 * idle:.2f} cm"
