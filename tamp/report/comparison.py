"""Two or more ways to solve the same tasks, held against each other task by task and seed by seed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from tamp.report.statistics import Estimate, mean
from tamp.results import Result

FEW_TASKS = 6
"""Fewer tasks than these say nothing of others: that all differ in the same direction is chance in 2 / 2^n of the cases
(sign test), which is more than 5 % for less than 6, and the bootstrap's interval then lies on one side of zero."""


@dataclass(frozen=True)
class Measure:
    """Something that is compared.

    Attributes:
        name: with its unit.
        value: of one result; None where the result has none.
        better: "higher", "lower", or "neither": what should be the same for all to be comparable.
        form: how a value is printed.
    """

    name: str
    value: Callable[[Result], float | None]
    better: str
    form: str = ".2f"


def _if_solved(value: Callable[[Result], float]) -> Callable[[Result], float | None]:
    return lambda result: value(result) if result.solved else None


def _found(result: Result) -> float | None:
    """How many of its objects a run with perceived poses ever found [%]."""
    rows = result.perception
    return 100.0 * sum(row["estimate_m"] is not None for row in rows) / len(rows) if rows else None


def _off(result: Result) -> float | None:
    """How far the first estimates of a run are off in the mean, over the meshes' symmetries [cm]."""
    errors = [row["estimate_m"] for row in result.perception if row["estimate_m"] is not None]
    return 100.0 * sum(errors) / len(errors) if errors else None


MEASURES = (
    Measure("solved [%]", lambda r: 100.0 * r.solved, "higher", ".0f"),
    Measure("EDE [cm]", lambda r: None if r.ede_m is None else 100.0 * r.ede_m, "lower"),
    Measure("planning [s], where both solve", _if_solved(lambda r: r.planning_s), "lower"),
    Measure("execution [s], where both solve", _if_solved(lambda r: r.execution_sim_s), "lower", ".0f"),
    Measure("actions, where both solve", _if_solved(lambda r: float(r.n_actions)), "lower", ".1f"),
    Measure("objects found [%]", _found, "higher", ".0f"),
    Measure("estimates off [cm], where both find any", _off, "lower"),
    Measure("perceiving [s]", lambda r: r.perceiving_s if r.perception else None, "lower", ".1f"),
    Measure("load of the machine, for each core", lambda r: r.load, "neither"),
)


@dataclass(frozen=True)
class Row:
    """One measure of one contender beside the first one, over the pairs where both have it.

    Attributes:
        measure: what is compared.
        first, other: their means.
        difference: other minus first, pair by pair.
        tasks: how many tasks the pairs are of.
    """

    measure: Measure
    first: Estimate
    other: Estimate
    difference: Estimate
    tasks: int

    @property
    def verdict(self) -> str:
        """In words, whether the difference is more than chance would make."""
        if not self.difference.count:
            return "nothing to compare"
        if self.tasks < FEW_TASKS:
            return "too few tasks"
        if not self.difference.excludes_zero:
            return "no clear difference"
        if self.measure.better == "neither":
            return "not the same for both"
        return "better" if (self.difference.mean > 0) == (self.measure.better == "higher") else "worse"

    def number(self, value: float) -> str:
        """A value as it is printed."""
        return format(value, self.measure.form)

    def signed(self, value: float) -> str:
        """A difference as it is printed."""
        return format(value, f"+{self.measure.form}")


@dataclass(frozen=True)
class Comparison:
    """A contender held against the first one."""

    first: str
    other: str
    pairs: int
    rows: tuple[Row, ...]

    def as_dict(self) -> dict[str, Any]:
        """JSON-like values; what has no values is None."""
        return {
            "first": self.first,
            "other": self.other,
            "pairs": self.pairs,
            "measures": [
                {
                    "measure": row.measure.name,
                    "better": row.measure.better,
                    **{part: _plain(getattr(row, part)) for part in ("first", "other", "difference")},
                    "verdict": row.verdict,
                }
                for row in self.rows
            ],
        }


def compare(results: Mapping[str, Sequence[Result]]) -> tuple[Comparison, ...]:
    """Hold every contender against the first one.

    Args:
        results: contender -> its results; only tasks and seeds that both have are compared.
    """
    (first, reference), *others = results.items()
    return tuple(_against(first, reference, other, theirs) for other, theirs in others)


def _against(first: str, reference: Sequence[Result], other: str, results: Sequence[Result]) -> Comparison:
    theirs = {(r.task, r.seed): r for r in results}
    pairs = [(r, theirs[r.task, r.seed]) for r in reference if (r.task, r.seed) in theirs]
    return Comparison(first, other, len(pairs), tuple(_row(measure, pairs) for measure in MEASURES))


def _row(measure: Measure, pairs: Sequence[tuple[Result, Result]]) -> Row:
    ours: dict[str, list[float]] = {}
    theirs: dict[str, list[float]] = {}
    differences: dict[str, list[float]] = {}
    for a, b in pairs:
        x, y = measure.value(a), measure.value(b)
        if x is not None and y is not None:
            for values, value in ((ours, x), (theirs, y), (differences, y - x)):
                values.setdefault(a.task, []).append(value)
    return Row(measure, mean(ours), mean(theirs), mean(differences), len(differences))


def _plain(estimate: Estimate) -> dict[str, Any]:
    return asdict(estimate) if estimate.count else {"mean": None, "lower": None, "upper": None, "count": 0}
