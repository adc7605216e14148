"""What a set of generated tasks is like: counts and mean errors by set and level."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

Row = Mapping[str, Any]

MEANS = ("objects", "stacked", "occupied", "cycles", "reoriented")
ERRORS = ("do_nothing_ede_m", "mean_ueb_m", "floor_ede_m")


def statistics(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Means over all, by family, by set, and by set and level.

    Args:
        rows: one a task, from `make_tasks`.

    Returns:
        One line each: what it is about, how many tasks, means of the counts an object or task, errors [cm].
    """
    groups: dict[str, list[Row]] = {}
    for row in rows:
        for what in (f"{row['set']}, level {row['level']}", row["set"], row["family"], "all"):
            groups.setdefault(what, []).append(row)
    return [_line(what, groups[what]) for what in sorted(groups)]


def _line(what: str, rows: Sequence[Row]) -> dict[str, Any]:
    means = {name: _mean(rows, name) for name in MEANS}
    errors = {name.replace("_ede_m", "_cm").replace("_ueb_m", "_ueb_cm"): 100 * _mean(rows, name) for name in ERRORS}
    return {"tasks of": what, "number": len(rows), **means, **errors}


def _mean(rows: Sequence[Row], name: str) -> float:
    return float(sum(row[name] for row in rows)) / len(rows)


def table(lines: Sequence[Mapping[str, Any]]) -> str:
    """The lines as aligned columns."""
    columns = list(lines[0])
    cells = [columns, *([_text(line[column]) for column in columns] for line in lines)]
    widths = [max(len(row[i]) for row in cells) for i in range(len(columns))]
    return "\n".join("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in cells)


def _text(value: Any) -> str:
    return f"{value:.2f}" if isinstance(value, float) else str(value)
