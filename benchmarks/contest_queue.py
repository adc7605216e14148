"""The contest's queue under fire: server and workers are killed, and every run is evaluated once all the same.

    python -m benchmarks.contest_queue [--teams N] [--each N] [--tasks N] [--server-kills N] [--worker-kills N]
                                       [--databases URL URL]

The same submissions are handed in twice: to a service that is left alone, and to one whose processes are killed while
they work, at even shares of the work. Shown is, for each, how often runs were begun and recorded, and whether both
rankings, and the error and the time of every single run, are the same.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from benchmarks.parts.harness import Row, main
from tamp.contest.sandbox.reaper import children
from tamp.results import from_json

PORT = 8765
LEASE_S = 6.0
WORKERS = 2

TASK = """\
name: push_{number}
level: {level}
objects:
  - name: red
    shape: {{box: [0.05, 0.05, 0.06]}}
    pose: {{xyz: [{x}, 0.1, 0.03]}}
    goal: {{pose: {{xyz: [{x}, -0.1, 0.03]}}}}
"""

RULES = """\
name: queue
contest: [push_*.yaml]
runs: 1
execution_s: 60
uploads: {a_month: 1000, a_minute: 1000}
"""

SOLUTION = '''\
"""Pushes the box by {push} m towards its goal."""
import numpy as np


class Solution:
    def run(self, goal, robot):
        x = goal.objects["red"].pose[0, 3]
        tool = np.diag([1.0, -1.0, -1.0, 1.0])
        robot.gripper.go_to(0.0)
        for y, z in ((0.2, 0.2), (0.2, 0.03), (0.1 - {push} + 0.04, 0.03)):
            tool[:3, 3] = x, y, z
            robot.arm.move_pose(tool, speed=0.5, straight=False)
'''


def run(
    quick: bool,
    teams: int | None,
    each: int,
    tasks: int | None,
    server_kills: int | None,
    worker_kills: int | None,
    databases: Sequence[str] | None,
) -> list[Row]:
    """A row for each of both services, and one that compares them."""
    teams = teams or (2 if quick else 12)
    tasks = tasks or (1 if quick else 5)
    kills = (1 if quick else 5) if server_kills is None else server_kills
    worker_kills = (1 if quick else 10) if worker_kills is None else worker_kills
    rows, boards, results = [], [], []
    services = (("undisturbed", (0, 0)), ("under fire", (kills, worker_kills)))
    for (name, fire), database in zip(services, databases or (None, None), strict=True):
        with tempfile.TemporaryDirectory(prefix="contest-queue-") as folder:
            service = Service(Path(folder), tasks, database)
            began = time.monotonic()
            try:
                counted = service.contest(teams, each, *fire)
            finally:
                service.stop()
            rows.append({"service": name, **counted, "seconds": round(time.monotonic() - began, 1)})
            boards.append(service.board)
            results.append(service.results)
    rows.append({"service": "rankings identical", "submissions": boards[0] == boards[1]})
    rows.append({"service": "runs identical", "submissions": results[0] == results[1]})
    return rows


class Service:
    """A service in a folder, and those who use and disturb it."""

    def __init__(self, data: Path, tasks: int, database: str | None) -> None:
        from tamp.contest.service.store import open_store

        self._data, self._tasks, self._server, self._store = data, tasks, None, open_store(data, database)
        self._place = ["--data", str(data), *([] if database is None else ["--database", database])]
        (data / "contest.yaml").write_text(RULES)
        for number in range(tasks):
            x = -0.1 + 0.2 * number / max(1, tasks - 1)
            (data / f"push_{number}.yaml").write_text(TASK.format(number=number, level=1 + number % 3, x=round(x, 3)))
        self.board: list[Any] = []
        self.results: dict[tuple[str, ...], tuple[float | None, float]] = {}

    def contest(self, teams: int, each: int, server_kills: int, worker_kills: int) -> Row:
        """Hand in, disturb, wait; how often what was done."""
        tokens = [self._tamp("team", f"team {number:02}").strip() for number in range(teams)]
        jobs = [
            (token, SOLUTION.format(push=round(0.02 + 0.17 * (each * t + e) / (teams * each), 4)))
            for t, token in enumerate(tokens)
            for e in range(each)
        ]
        self._start()
        rng = random.Random(0)
        shots = ["server"] * server_kills + ["worker"] * worker_kills
        rng.shuffle(shots)
        numbers = [self._hand_in(token, code) for token, code in jobs]
        # Every submission comes twice, as from an impatient browser.
        again = [self._hand_in(token, code) for token, code in jobs]
        killed: list[str] = []
        while (count := self._count())["done"] < len(numbers) * self._tasks:
            due = count["done"] / (len(numbers) * self._tasks) >= len(killed) / max(1, len(shots))
            # Only who works is disturbed.
            if len(killed) < len(shots) and due and count["running"] and self._shoot(shots[len(killed)], rng):
                killed.append(shots[len(killed)])
            time.sleep(rng.uniform(0.2, 1.5))
        state = self._recorded()
        self.board = self._ranking()
        return {
            "submissions": len(set(numbers)),
            "double uploads": sum(a != b for a, b in zip(numbers, again, strict=True)),
            **state,
            "server killed": killed.count("server"),
            "workers killed": killed.count("worker"),
        }

    def _shoot(self, target: str, rng: random.Random) -> bool:
        """Kill the server, which is started again, or one of its workers; whether there was one."""
        assert self._server is not None
        if target == "server":
            self._server.kill()
            self._server.wait()
            self._start()
            return True
        workers = children(self._server.pid)
        if not workers:
            return False
        with suppress(OSError):
            os.kill(rng.choice(workers), signal.SIGKILL)
        return True

    def _start(self) -> None:
        command = [sys.executable, "-m", "tamp", "-q", "contest", "serve", *self._place]
        command += ["--port", str(PORT), "--workers", str(WORKERS), "--lease", str(LEASE_S)]
        self._server = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        self._patiently(lambda: urllib.request.urlopen(f"http://127.0.0.1:{PORT}/rules").read())

    def stop(self) -> None:
        """End the service."""
        if self._server is not None:
            self._server.send_signal(signal.SIGINT)
            self._server.wait(30)
        self._store.close()

    def _tamp(self, *arguments: str) -> str:
        command = [sys.executable, "-m", "tamp", "contest", *arguments, *self._place]
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout

    def _hand_in(self, token: str, code: str) -> str:
        url = f"http://127.0.0.1:{PORT}/api/submissions?name=solution.py&kind=contest"
        headers = {"Authorization": f"Bearer {token}"}

        def ask() -> str:
            request = urllib.request.Request(url, code.encode(), headers, method="POST")
            return str(json.load(urllib.request.urlopen(request))["id"])

        return self._patiently(ask)

    def _patiently(self, ask: Callable[[], Any]) -> Any:
        for _ in range(600):
            try:
                return ask()
            except (urllib.error.URLError, ConnectionError):  # noqa: PERF203  it is being started
                time.sleep(0.2)
        raise RuntimeError("the service does not come back")

    def _count(self) -> dict[str, int]:
        """State -> how many runs are in it."""
        from sqlalchemy import func, select

        from tamp.contest.service.store import TRIALS

        with self._store.look() as connection:
            rows = connection.execute(select(TRIALS.c.state, func.count()).group_by(TRIALS.c.state)).all()
        return {"done": 0, "running": 0, **dict(rows)}

    def _recorded(self) -> dict[str, int]:
        """What the database has of all runs; each run's error and time are kept, by team, package and task."""
        from sqlalchemy import select

        from tamp.contest.service.store import SUBMISSIONS, TEAMS, TRIALS

        with self._store.look() as connection:
            joined = TRIALS.join(SUBMISSIONS).join(TEAMS)
            rows = connection.execute(select(TRIALS, TEAMS.c.name, SUBMISSIONS.c.sha256).select_from(joined)).all()
        found = [from_json(row.result) for row in rows]
        for row, result in zip(rows, found, strict=True):
            self.results[row.name, row.sha256, row.task] = result.ede_m, result.execution_sim_s
        assert len(self.results) == len(rows)
        return {
            "runs": len(rows),
            "begun": sum(row.claims for row in rows),
            "recorded once": sum(row.evaluations == 1 for row in rows),
            "ended well": sum(result.message == "" for result in found),
        }

    def _ranking(self) -> list[Any]:
        answer = self._patiently(lambda: urllib.request.urlopen(f"http://127.0.0.1:{PORT}/api/leaderboard").read())
        places: Sequence[Any] = json.loads(answer)["places"]
        return [[p["rank"], p["team"], p["mean"]["error_m"], p["execution_s"], p["tasks"]] for p in places]


if __name__ == "__main__":
    options = argparse.ArgumentParser(add_help=False)
    options.add_argument("--teams", type=int, metavar="N", help="default 12")
    options.add_argument("--each", type=int, default=1, metavar="N", help="submissions of each team; default 1")
    options.add_argument("--tasks", type=int, metavar="N", help="default 5")
    options.add_argument("--server-kills", type=int, metavar="N", help="default 5")
    options.add_argument("--worker-kills", type=int, metavar="N", help="default 10")
    text = "two empty databases; default: SQLite"
    options.add_argument("--databases", nargs=2, metavar="URL", help=text)
    asked = "every run recorded once, rankings identical"
    main("contest_queue", run, extra=options, asked=asked)
