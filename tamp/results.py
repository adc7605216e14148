"""The result of one task and seed: a record, one JSON line, and a row in the table."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal, get_args

from tamp.errors import TampError

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
        planning_s: wall time of planning, checking and replanning [s].
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
        versions: of the program, of Python and of the libraries that decide results.
        task_path: the file the task came from, as it was given.
        level: of difficulty, as the task's file has it.
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
    versions: Mapping[str, str] = field(default_factory=dict)
    task_path: str = ""
    level: int | None = None

    def __post_init__(self) -> None:
        if self.status not in get_args(Status):
            raise ValueError(f"unknown status {self.status!r}; valid are {', '.join(get_args(Status))}")
        object.__setattr__(self, "objects", tuple(MappingProxyType(dict(o)) for o in self.objects))
        for name in ("goals_met", "versions"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))

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
        return Result(**{key: value for key, value in data.items() if key in known})
    except (ValueError, TypeError, AttributeError, RecursionError) as error:
        raise TampError(f"{where}: not a result: {error}") from None


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


def print_table(results: Sequence[Result], file: TextIO) -> None:
    """Print a table with a row a result and a line of totals; colour on a terminal only."""
    from rich.console import Console
    from rich.table import Table

    table = Table(box=None, pad_edge=False)
    table.add_column("task")
    for heading in ("seed", "status", "actions", "replans", "grasps", "plan s", "sim s", "EDE cm", "idle cm", "better"):
        table.add_column(heading, justify="left" if heading == "status" else "right")
    for result in results:
        table.add_row(*_cells(result), style=None if result.solved else "red")
    # Off a terminal the width is unknown: lines are as long as they are, so that other programs can read them.
    console = Console(file=file, width=None if file.isatty() else 160, no_color=None if file.isatty() else True)
    console.print(table)
    for result in results:
        if result.message and not result.solved:
            console.print(f"{result.task} (seed {result.seed}): {result.message}", markup=False, highlight=False)
    console.print(summary(results), highlight=False)


def _cells(result: Result) -> tuple[str, ...]:
    return (
        result.task,
        str(result.seed),
        result.status,
        str(result.n_actions),
        str(result.n_replans),
        f"{result.grasps_succeeded}/{result.grasps_attempted}",
        f"{result.planning_s:.1f}",
        f"{result.execution_sim_s:.0f}",
        _number(result.ede_m, 100.0, ".2f"),
        _number(result.do_nothing_ede_m, 100.0, ".1f"),
        _number(result.improvement, 1.0, ".0%"),
    )


def _number(value: float | None, scale: float, form: str) -> str:
    return "-" if value is None else format(scale * value, form)


def summary(results: Iterable[Result]) -> str:
    """One line: how many are solved, and the mean error against doing nothing."""
    results = tuple(results)
    solved = sum(r.solved for r in results)
    scored = [(r.ede_m, r.do_nothing_ede_m) for r in results if r.ede_m is not None and r.do_nothing_ede_m is not None]
    text = f"{solved} of {len(results)} solved"
    if not scored:
        return text
    mean, idle = (sum(values) / len(scored) for values in zip(*scored, strict=True))
    return f"{text}; mean EDE {100 * mean:.2f} cm, doing nothing {100 * idle:.2f} cm"
