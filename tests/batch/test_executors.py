"""The same batch on a Dask cluster and through submitit: same results file, same resume, deaths survived."""

from __future__ import annotations

import importlib.util
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from tamp.batch import RESULTS, Batch
from tamp.batch.pool import Outcome
from tamp.cli import main
from tamp.errors import TampError
from tamp.results import Result, read_results
from tamp.task import Task

WORK = "tests.batch.toys:work"
ROOT = Path(__file__).parents[2]

needs_dask = pytest.mark.skipif(importlib.util.find_spec("distributed") is None, reason="the extra 'dask' is missing")
needs_submitit = pytest.mark.skipif(importlib.util.find_spec("submitit") is None, reason="the extra 'slurm' is missing")


def run(executor: Callable[..., Iterator[Outcome]], names: list[str], output: Path, **more: Any) -> dict[str, Result]:
    tasks = [Task(name, (), path=Path(f"{name}.yaml")) for name in names]
    batch = Batch(tasks, work=WORK, output=output, executor=executor, **more)
    results = list(batch.run())
    assert sorted(r.task for r in results) == sorted(names), "every task has exactly one result"
    return {result.task: result for result in results}


@pytest.fixture(autouse=True)
def importable(monkeypatch: pytest.MonkeyPatch) -> None:
    """Workers find the toys."""
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    monkeypatch.chdir(ROOT)


@needs_dask
def test_dask_finishes_a_batch_one_of_whose_workers_is_killed(tmp_path: Path) -> None:
    from distributed import Client, LocalCluster

    from tamp.batch.dask import run_on_dask

    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, silence_logs=50) as cluster:
        with Client(cluster) as client:
            pids = list(client.run(os.getpid).values())
        killed = threading.Event()

        def kill_one_at_work() -> None:
            while not (tmp_path / "ran").exists():
                time.sleep(0.05)
            os.kill(pids[0], signal.SIGKILL)
            killed.set()

        killer = threading.Thread(target=kill_one_at_work)
        killer.start()
        executor = partial(run_on_dask, address=cluster.scheduler_address)
        names = [f"slow_{i}" for i in range(4)] + ["raise", "crash"]
        results = run(executor, names, tmp_path, options={"ran": str(tmp_path / "ran"), "sleep": 0.5})
        killer.join()
    assert killed.is_set()
    assert all(results[f"slow_{i}"].solved for i in range(4))
    assert results["raise"].message == "ValueError: a bug in two lines"
    assert results["crash"].message == "the worker was ended by SIGABRT"
    assert len(read_results(tmp_path / RESULTS)) == 6


@needs_dask
def test_nobody_at_the_address_is_said(tmp_path: Path) -> None:
    from tamp.batch.dask import run_on_dask

    with pytest.raises(TampError, match="no Dask scheduler answers at"):
        run(partial(run_on_dask, address="nonsense://x"), ["ok"], tmp_path)


@needs_submitit
def test_submitit_runs_and_resumes(tmp_path: Path) -> None:
    from tamp.batch.slurm import run_on_slurm

    executor = partial(run_on_slurm, folder=tmp_path / "jobs", cluster="local")
    ran = tmp_path / "ran"
    results = run(executor, ["ok", "kill"], tmp_path, workers=2, options={"ran": str(ran)}, time_limit_s=60.0)
    assert results["ok"].solved
    assert results["kill"].message == "the worker was ended by SIGKILL"
    again = run(executor, ["ok", "kill", "more"], tmp_path, workers=2, options={"ran": str(ran)}, resume=True)
    assert again["more"].solved
    assert ran.read_text(encoding="utf-8").split() in (
        ["ok:0", "kill:0", "more:0"],
        ["kill:0", "ok:0", "more:0"],
    ), "what was done is not done again"


def test_submitit_needs_a_folder_for_its_logs(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["solve", str(ROOT / "scenarios" / "one_object.yaml"), "--executor", "submitit"]) == 2
    assert "--executor submitit needs --output" in capsys.readouterr().err
