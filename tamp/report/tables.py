"""Results for other programs: a CSV, and a batch in one line of key=value pairs."""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from types import MappingProxyType
from typing import Any, get_args

from tamp.results import Result, Status

NOT_IN_CSV = ("objects", "perception", "versions", "settings", "configuration")
"""What has no place in one cell; results.jsonl has it."""


def csv_text(results: Sequence[Result]) -> str:
    """One row a result, one column a field of `Result` that fits a cell; what is None or has nothing in it is empty."""
    columns = [f.name for f in fields(Result) if f.name not in NOT_IN_CSV]
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([_cell(getattr(result, name)) for name in columns] for result in results)
    return file.getvalue()


def _cell(value: Any) -> Any:
    """A value as a spreadsheet has it: lists of sentences and goals as one text."""
    if isinstance(value, Mapping):
        return "; ".join(f"{name}: {'met' if met else 'not met'}" for name, met in value.items())
    return "; ".join(value) if isinstance(value, tuple) else value


def summary_line(
    results: Sequence[Result], output: Path | None = None, counts: Mapping[str, int] = MappingProxyType({})
) -> str:
    """`summary: total=10 solved=9 ... mean_ede_m=0.0012 output=runs`: statuses, means, and where the results are.

    Args:
        results: what is told.
        output: where they are.
        counts: what else was counted, by name.
    """
    ends = Counter(result.status for result in results)
    pairs = [f"total={len(results)}", *(f"{status}={ends[status]}" for status in get_args(Status))]
    pairs += [f"{name}={count}" for name, count in counts.items()]
    for name in ("ede_m", "do_nothing_ede_m", "improvement", "planning_s", "execution_sim_s"):
        values = [value for result in results if (value := getattr(result, name)) is not None]
        pairs += [f"mean_{name}={sum(values) / len(values):.6g}"] if values else []
    pairs += [] if output is None else [f"output={output}"]
    return f"summary: {' '.join(pairs)}"
