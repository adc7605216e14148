"""Every hostile solution of the tests handed in to one service: each is stopped and named, and costs nobody anything.

An honest team hands in the same solution before, among and after those of a hostile team; two workers evaluate all of
them. Shown is how each ended, and whether the honest scores are the same and nothing is left of anybody.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from benchmarks.parts.harness import Row, main
from tamp.results import from_json

HOSTILE = Path(__file__).parents[1] / "tests" / "contest" / "hostile"
QUICK = ("reads_passwd", "fork_bomb", "endless_output", "huge_frame")
WORKERS = 2

TASK = """\
name: push
objects:
  - name: red
    shape: {box: [0.05, 0.05, 0.06]}
    pose: {xyz: [0.0, 0.1, 0.03]}
    goal: {pose: {xyz: [0.0, -0.1, 0.03]}}
"""

RULES = """\
name: hostile
contest: [push.yaml]
runs: 1
execution_s: 60
limits: {processor_s: 10, idle_s: 5, wall_s: 1200, memory_mb: 400, processes: 24, output_kb: 64, scratch_mb: 16}
uploads: {a_month: 1000, a_minute: 1000}
"""

HONEST = '''\
"""Pushes the box towards its goal."""
import numpy as np


class Solution:
    def run(self, goal, robot):
        tool = np.diag([1.0, -1.0, -1.0, 1.0])
        robot.gripper.go_to(0.0)
        for y, z in ((0.2, 0.2), (0.2, 0.03), (0.05, 0.03)):
            tool[:3, 3] = 0.0, y, z
            robot.arm.move_pose(tool, speed=0.5, straight=False)
'''


def rows(quick: bool) -> Iterator[Row]:
    """A row for each hostile solution, and one for the honest ones."""
    names = sorted(path.stem for path in HOSTILE.glob("*.py") if path.stem != "__init__")
    names = [name for name in names if not quick or name in QUICK]
    with tempfile.TemporaryDirectory(prefix="contest-hostile-") as folder:
        data = Path(folder)
        (data / "contest.yaml").write_text(RULES)
        (data / "push.yaml").write_text(TASK)
        handed = _hand_in(data, names)
        work = [sys.executable, "-m", "tamp", "-q", "contest", "work", "--data", folder, "--until-empty"]
        began = time.monotonic()
        workers = [subprocess.Popen(work) for _ in range(WORKERS)]
        statuses = [worker.wait() for worker in workers]
        seconds, found = time.monotonic() - began, _results(data)
    honest = set()
    for name, number in handed:
        result = found[number]
        if name == "honest":
            honest.add((result.ede_m, result.execution_sim_s, result.message))
        else:
            yield {"solution": name, "ended": result.settings["ended"], "said": result.message[:90]}
    same = "the same" if len(honest) == 1 and not next(iter(honest))[2] else f"different: {honest}"
    left = [word for word in _commands() if "contest-hostile-" in word]
    said = f"honest scores {same}; workers ended with {statuses}; {len(left)} processes left"
    yield {"solution": "all", "ended": f"{len(handed)} in {seconds:.0f} s", "said": said}


def _hand_in(data: Path, names: list[str]) -> list[tuple[str, str]]:
    """Hand everything in; name and number of each submission."""
    from tamp.contest.service.contest import load_contest
    from tamp.contest.service.scratch import scratch_folder
    from tamp.contest.service.store import open_store
    from tamp.contest.service.submissions import accept
    from tamp.contest.service.teams import add_team, team_of

    store, contest = open_store(data), load_contest(data / "contest.yaml")
    teams = {name: team_of(store, add_team(store, name)) for name in ("honest", "hostile")}
    handed = []
    for place, name in enumerate(["honest", *names[: len(names) // 2], "honest", *names[len(names) // 2 :], "honest"]):
        team = teams["honest" if name == "honest" else "hostile"]
        assert team is not None
        code = f"{HONEST}# {place}\n" if name == "honest" else (HOSTILE / f"{name}.py").read_text(encoding="utf-8")
        with scratch_folder(data) as folder:
            upload = folder / "upload"
            upload.write_text(code, encoding="utf-8")
            handed.append((name, accept(store, contest, data, team, "contest", f"{name}.py", upload).id))
    store.close()
    return handed


def _results(data: Path) -> dict[str, Any]:
    from sqlalchemy import select

    from tamp.contest.service.store import TRIALS, open_store

    store = open_store(data)
    with store.look() as connection:
        rows = connection.execute(select(TRIALS.c.submission, TRIALS.c.result, TRIALS.c.evaluations)).all()
    store.close()
    assert all(row.evaluations == 1 for row in rows), json.dumps([tuple(row) for row in rows])
    return {row.submission: from_json(row.result) for row in rows}


def _commands() -> list[str]:
    """The command lines of all processes."""
    found = []
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            found.append(path.read_bytes().decode("utf-8", errors="replace"))
        except OSError:  # noqa: PERF203  it has ended
            continue
    return found


if __name__ == "__main__":
    main(
        "contest_hostile",
        lambda quick: list(rows(quick)),
        asked="each stopped by what it tried; honest scores the same",
    )
