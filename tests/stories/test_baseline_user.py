"""Somebody wants a baseline inside a program of their own: a task built in code, a plan, trajectories as arrays."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

PROGRAM = """\
import numpy as np
import tamp

table = {"mug": ((0.05, 0.20, 0.04), (0.05, -0.20, 0.04)), "tin": ((-0.05, 0.05, 0.03), (-0.10, -0.25, 0.03))}
sizes = {"mug": (0.05, 0.05, 0.08), "tin": (0.04, 0.06, 0.06)}
objects = [
    tamp.Object(name, tamp.Box(sizes[name]), tamp.Pose(start), goal=tamp.At(tamp.Pose(goal)))
    for name, (start, goal) in table.items()
]
plan = tamp.plan(tamp.Task("baseline", tuple(objects)), seed=0, timeout=120.0)
moves = [step.trajectory for action in plan.actions for step in action.steps if isinstance(step, tamp.Move)]
q = np.concatenate([move.positions for move in moves])
print(len(plan.actions), q.shape[1], bool(np.isfinite(q).all()), round(sum(m.duration for m in moves), 1))
jumps = [np.abs(a.positions[-1] - b.positions[0]).max() for a, b in zip(moves, moves[1:])]
assert max(jumps) < 1e-6 and all((np.diff(move.times) > 0).all() for move in moves)
"""


def test_fifteen_lines_are_enough(tmp_path: Path) -> None:
    assert len([line for line in PROGRAM.splitlines() if line]) <= 15
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    actions, joints, finite, seconds = done.stdout.split()
    assert (int(actions), joints, finite) == (8, "7", "True")
    assert float(seconds) > 5.0
    assert not list(tmp_path.iterdir()), "no files are needed or left"
