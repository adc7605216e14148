"""Jobs of a SLURM cluster through submitit, or of submitit's own executor where there is no SLURM."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict
from pathlib import Path
from types import ModuleType
from typing import Any

from tamp.batch.pool import Job, Outcome
from tamp.batch.remote import Limits, crashed, outcome_of, run_remotely
from tamp.errors import TampError
from tamp.versions import how_to_install

LOOK_S = 0.5
"""How often the cluster is asked how jobs are doing [s]."""

BEYOND_S = 300.0
"""What the cluster grants a job beyond its own limit, for starting and ending [s]."""


def run_on_slurm(
    jobs: Iterable[Job],
    work: str,
    *,
    workers: int = 1,
    time_limit_s: float | None = None,
    memory_limit: int | None = None,
    preload: object = (),
    folder: Path,
    cluster: str | None = None,
    parameters: Mapping[str, str] | None = None,
) -> Iterator[Outcome]:
    """Run jobs as `run_jobs` does, each as a job of the cluster. Closing the iterator cancels what runs.

    Args:
        jobs: what to run.
        work: the work function as "package.module:function".
        workers: how many jobs the cluster has at the same time.
        time_limit_s: per job, enforced where it runs [s].
        memory_limit: per job, enforced where it runs [bytes].
        preload: of no use here.
        folder: where submitit keeps its files and logs; seen from all machines.
        cluster: "slurm" or "local"; None takes SLURM where there is one.
        parameters: of SLURM, such as {"partition": "cpu"}.

    Raises:
        TampError: where the extra is not installed, or SLURM is asked for and is not there.
    """
    executor = _executor(folder, cluster, time_limit_s, memory_limit, parameters or {})
    limits = asdict(Limits(time_limit_s, memory_limit))
    waiting = list(jobs)[::-1]
    running: dict[str, tuple[Job, Any]] = {}
    try:
        while waiting or running:
            while waiting and len(running) < workers:
                job = waiting.pop()
                running[job.key] = (job, executor.submit(run_remotely, job.key, dict(job.arguments), work, limits))
            done = [key for key, (_, submitted) in running.items() if submitted.done()]
            for key in done:
                job, submitted = running.pop(key)
                failure = submitted.exception()
                yield crashed(job, failure) if failure is not None else outcome_of(job, submitted.result())
            if not done:
                time.sleep(LOOK_S)
    finally:
        for _, submitted in running.values():
            submitted.cancel()


def _executor(
    folder: Path,
    cluster: str | None,
    time_limit_s: float | None,
    memory_limit: int | None,
    parameters: Mapping[str, str],
) -> Any:
    submitit = _submitit()
    try:
        executor = submitit.AutoExecutor(folder=folder, cluster=cluster)
    except RuntimeError as error:
        raise TampError(f"submitit cannot use {cluster or 'the cluster'}: {error}") from None
    asked: dict[str, Any] = {f"slurm_{name}": value for name, value in parameters.items()}
    if time_limit_s is not None:
        asked["timeout_min"] = math.ceil((time_limit_s + BEYOND_S) / 60)
    if memory_limit is not None:
        asked["mem_gb"] = memory_limit / 2**30
    executor.update_parameters(**asked)
    return executor


def _submitit() -> ModuleType:
    try:
        import submitit
    except ModuleNotFoundError:
        raise TampError(f"the executor submitit is an extra: {how_to_install('slurm')}") from None
    module: ModuleType = submitit
    return module
