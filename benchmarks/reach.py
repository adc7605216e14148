"""What grasps, placements and kinematics can do with each object alone, before any order or neighbour matters.

For every object of OCRTOC's public tasks of 2021 that has to move: is there one grasp by which the arm reaches its
start and its goal, by which it can at least be laid down there, or are there two, so that it must be regrasped between?
What is left cannot be picked up at its start, or not be put down at its goal; the commonest reason is named.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.ocrtoc import DATA, QUICK
from benchmarks.parts.harness import Row, main
from tamp.formats.ocrtoc import import_ocrtoc
from tamp.pipeline.prepare import prepare
from tamp.streams.grasping.sampler import sample_grasp
from tamp.streams.motion.inverse_kinematics import inverse_kinematics
from tamp.streams.releasing.tilted_release import plan_laying
from tamp.streams.workspace import TABLE, Workspace
from tamp.task.files.load import load_task

GRASPS = 100  # looked at for one object
WAYS = ("same grasp", "laid", "regrasped", "not picked", "not placed", "neither")


@dataclass
class Alone:
    """The first argument of a sampler that is asked outside any plan."""

    scene: Workspace
    seed: int = 0
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(0))
    deadline: float = field(default_factory=lambda: time.monotonic() + 600.0)
    fluents: tuple[Any, ...] = ()
    bound: tuple[Any, ...] = ()
    reasons: list[str] = field(default_factory=list)

    def fail(self, reason: str, because: Any = (), proven: bool = True) -> None:
        """Remember why nothing came."""
        self.reasons.append(reason)


def way(workspace: Workspace, name: str) -> tuple[str, str]:
    """How an object gets from its start to its goal, one of WAYS, and what hinders it where it does not."""
    start, goal = workspace.start[name], workspace.goals[name]
    picked = placed = False
    hindered: dict[str, Counter[str]] = {"start": Counter(), "goal": Counter()}

    def reached(sampler: Any, end: str, *inputs: Any) -> bool:
        context = Alone(workspace)
        if next(sampler(context, name, *inputs), None) is not None:
            return True
        hindered[end].update(context.reasons[-1:])
        return False

    asked = Alone(workspace)
    for grasp in islice(sample_grasp(asked, name), GRASPS):
        here = reached(inverse_kinematics, "start", start, grasp)
        there = reached(inverse_kinematics, "goal", goal, grasp)
        if here and there:
            return "same grasp", ""
        if here and reached(plan_laying, "goal", goal, grasp):
            return "laid", ""
        picked, placed = picked or here, placed or there
    if picked and placed:
        return "regrasped", ""
    end = "goal" if picked else "start"
    reason = hindered[end].most_common(1)[0][0] if hindered[end] else "; ".join(asked.reasons[:1]) or "no grasp"
    return "not placed" if picked else "not picked" if placed else "neither", f"{name} at its {end}: {reason}"


def rows(quick: bool) -> Iterator[Row]:
    """One row for each task, and the sum over all."""
    if not DATA.is_dir():
        sys.exit(f"the tasks are not there: {DATA}")
    total: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as folder:
        import_ocrtoc(DATA, Path(folder))
        for file in sorted(Path(folder).glob("*.yaml")):
            if not quick or file.stem in QUICK:
                ways = list(_of_task(file))
                counts = Counter(found for found, _ in ways)
                total += counts
                reasons = "; ".join(reason for _, reason in ways if reason)
                yield {"task": file.stem, "objects": len(ways), **{w: counts[w] for w in WAYS}, "reasons": reasons}
    yield {"task": "all", "objects": total.total(), **{w: total[w] for w in WAYS}, "reasons": ""}


def _of_task(file: Path) -> Iterator[tuple[str, str]]:
    """The way of every object of a task that is not yet at its goal."""
    setup = prepare(load_task(file))
    workspace = setup.observe(setup.start)
    for name, goal in workspace.goals.items():
        start = workspace.start[name]
        if goal is not start:
            alone = replace(setup.task, objects=(setup.task.object(name),))
            yield way(Workspace(alone, setup.world, {name: start}, {name: replace(goal, on=(TABLE,))}), name)


if __name__ == "__main__":
    main("reach", lambda quick: list(rows(quick)))
