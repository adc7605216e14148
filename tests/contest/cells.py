"""A robot cell without a simulator, and the rules that tests run hostile solutions by."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import numpy as np

from tamp.contest.evaluation.trial import run_solution
from tamp.contest.evaluation.workcell import Workcell
from tamp.contest.package import unpack
from tamp.contest.rules import Rules
from tamp.contest.sandbox.isolation import Ending, Limits, Sandbox
from tamp.task import Table, Task, load_robot

QUICK = Limits(wall_s=60.0, processor_s=20.0, memory_mb=400, processes=24, output_kb=64, scratch_mb=16)
"""Enough to begin and to misbehave."""


class EmptyCell:
    """Answers as a workcell does whose robot never moves."""

    def __init__(self) -> None:
        self.task = Task("empty", (), table=Table())
        self.robot = self
        self.spec = load_robot("panda")
        self.cameras: dict[str, Any] = {}
        self.time, self.time_left = 0.0, 600.0

    def state(self) -> tuple[Any, Any, float]:
        return np.array(self.spec.home), np.eye(4), 0.08


def run_in(sandbox: Sandbox, solution: Path, folder: Path, limits: Limits = QUICK) -> tuple[Ending, bytes]:
    """How a solution ended, and what it printed."""
    models = folder / "models"
    models.mkdir(parents=True)
    package = unpack(solution, folder / "solution")
    cell = cast("Workcell", EmptyCell())
    return run_solution(cell, package, models, [], Rules(limits=limits), sandbox)
