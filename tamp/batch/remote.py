"""One job on another machine, or in another's process: run there as at home, with the same limits, in its own process.

A worker of Dask or SLURM calls `run_remotely`, which starts `python -m tamp.batch.remote` and talks JSON with it: such
workers may not have children of multiprocessing's, and a job that crashes must not take its worker along.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from tamp.batch.pool import Job, Outcome, run_jobs
from tamp.parent import end_with_parent


@dataclass(frozen=True)
class Limits:
    """What a job may take: see `run_jobs`."""

    time_limit_s: float | None = None
    memory_limit: int | None = None


def run_remotely(key: str, arguments: Mapping[str, Any], work: str, limits: Mapping[str, Any]) -> dict[str, Any]:
    """Run a job in a process of its own and say how it ended, JSON-like; `outcome_of` reads it."""
    request = {"key": key, "arguments": dict(arguments), "work": work, "limits": dict(limits)}
    command = [sys.executable, "-m", "tamp.batch.remote"]
    done = subprocess.run(command, input=json.dumps(request), stdout=subprocess.PIPE, text=True)
    if done.returncode != 0 or not done.stdout:
        return {"ended": "crashed", "value": None, "message": f"exit status {done.returncode}", "wall_s": 0.0}
    answer: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return answer


def outcome_of(job: Job, answer: Mapping[str, Any]) -> Outcome:
    """What `run_remotely` answered, as an outcome."""
    return Outcome(job, answer["ended"], answer["value"], answer["message"], answer["wall_s"])


def crashed(job: Job, why: object) -> Outcome:
    """The outcome of a job whose worker is gone."""
    return Outcome(job, "crashed", None, f"the worker is gone: {' '.join(str(why).split())[:500]}", 0.0)


def main() -> None:
    """Read a request, run it, write the answer as the last line."""
    end_with_parent()
    request = json.load(sys.stdin)
    job = Job(request["key"], request["arguments"])
    (outcome,) = run_jobs([job], request["work"], **request["limits"])
    answer = {"ended": outcome.ended, "value": outcome.value, "message": outcome.message, "wall_s": outcome.wall_s}
    print(json.dumps(answer))


if __name__ == "__main__":
    main()
