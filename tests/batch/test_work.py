"""One run of a batch: whose fault it is that there is no result."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import pytest

from tamp.batch.work import solve_file
from tamp.execution.simulators import SIMULATORS, load_simulator

TASK = "objects: [{name: red, shape: {box: [0.05, 0.05, 0.08]}, pose: {xyz: [0.05, 0.2, 0.04]}, goal: {on: shelf}}]\n"
SHELF = "regions: [{name: shelf, box: {center: [0.05, -0.2], size: [0.2, 0.2]}}]\n"
PHYSICS = next(name for name, entry in SIMULATORS.items() if entry.installed)


@dataclass(frozen=True)
class Silent:
    """A strategy that answers nothing."""

    name: ClassVar[str] = "silent"

    def __call__(self, problem: Any, settings: Any) -> None:
        """Answer nothing."""


class Stopping(load_simulator(PHYSICS)):  # type: ignore[misc]
    """A simulator that breaks down on the way."""

    def step(self, count: int = 1) -> None:
        raise RuntimeError("out of fuel")


def silent_search(task: Any, timeout: float, bound: Any = None, effort: float = 0.0) -> None:
    """A search that answers nothing."""


@pytest.mark.parametrize(
    ("options", "status", "said"),
    [
        ({"strategy": f"{__name__}:Silent"}, "error", "strategy 'silent': expected a Solution, found None"),
        ({"search": f"{__name__}:silent_search"}, "error", "search silent_search: expected a SearchResult, found None"),
        ({"simulator": f"{__name__}:Stopping"}, "error", "Stopping': step raised RuntimeError: out of fuel at "),
        ({"robot": "pandda"}, "invalid", "pandda"),
    ],
)
def test_a_part_that_goes_wrong_is_an_error_and_no_invalid_task(
    options: dict[str, Any], status: str, said: str, tmp_path: Path
) -> None:
    """As an invalid task it would cost nothing with --skip-invalid, and the part be measured by what it solves."""
    (tmp_path / "task.yaml").write_text(TASK + SHELF, encoding="utf-8")
    result = solve_file("task", str(tmp_path / "task.yaml"), 0, **options)
    assert result["status"] == status and said in result["message"], result["message"]
