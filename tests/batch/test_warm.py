"""The process that workers are forked from: it has loaded what runs need, and nothing of it shows in a plan."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tamp.batch.pool import SINGLE_THREADED
from tamp.batch.processes import available
from tamp.batch.robots import MOST, VARIABLE, tell, told
from tamp.task import Pose, Task, task_robot

ROOT = Path(__file__).parents[2]

RUNS = """
import json, os, sys
FRESH, TASK = sys.argv[1] == "fresh", sys.argv[2]
if not FRESH:
    import tamp.batch.warm
from tamp.batch.work import solve_file
threads = len(os.listdir("/proc/self/task"))
loaded = set(sys.modules)
found = {}
for times in (0,) if FRESH else (0, 1):  # forked from the same process: after no run of its own, and after one
    read, write = os.pipe()
    if os.fork() == 0:
        for seed in range(times):
            solve_file("before", TASK, 7 + seed, execute=False)
        result = solve_file("one", TASK, 0, execute=False)
        new = sorted(set(sys.modules) - loaded)
        os.write(write, json.dumps({"plan": result["plan_sha256"], "threads": threads, "new": new}).encode())
        os._exit(0)
    os.close(write)
    with os.fdopen(read) as answer:
        found[times] = json.load(answer)
    os.wait()
print(json.dumps(found))
"""


def _runs(kind: str) -> Any:
    """What a run finds that is forked from a fresh process, or a warm one."""
    environment = {**os.environ, **dict.fromkeys(SINGLE_THREADED, "1"), "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-c", RUNS, kind, str(ROOT / "scenarios" / "one_object.yaml")]
    done = subprocess.run(command, env=environment, check=True, capture_output=True, text=True, cwd=ROOT)
    return json.loads(done.stdout.splitlines()[-1])


@pytest.mark.skipif(not available(), reason="this system has no /proc")
def test_a_warm_process_lends_its_libraries_and_nothing_else() -> None:
    fresh, warm = _runs("fresh"), _runs("warm")
    assert warm["0"]["threads"] == 1, "a fork copies the thread that forks, and the locks of all others"
    assert warm["0"]["new"] == [], "imported anew in every run"
    assert len({run["plan"] for runs in (fresh, warm) for run in runs.values()}) == 1
    assert warm["0"]["plan"]


def test_the_robots_of_a_batch_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """As their own tasks would read them, to the last bit: tables are kept by what a robot is and where it stands."""
    monkeypatch.setenv(VARIABLE, "[]")
    assert [task.robot for task in told()] == [Task("one", ()).robot]
    base = Pose((-0.41, 0.1, 0.003), (0.0, 0.0, 0.3, 0.9))
    home = (0.1, 0.0, 0.0, -1.5, 0.0, 1.5, 0.7)
    tasks = [
        Task("a", ()),
        Task("b", (), base=base, home=home),
        Task("a again", ()),
        Task("c", (), robot="./mine/robot.yaml"),
    ]
    tell(tasks, None)
    assert [task_robot(task) for task in told()] == [task_robot(tasks[0]), task_robot(tasks[1])]
    tell(tasks, "nobody")
    assert {task.robot for task in told()} == {"nobody"}, "its runs say what is wrong with it"
    tell([Task(str(i), (), base=Pose((i / 10, 0.0, 0.0))) for i in range(9)], None)
    assert len(told()) == MOST
