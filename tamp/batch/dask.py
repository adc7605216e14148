"""Jobs on a Dask cluster: an existing one by its address, or one started here."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import asdict
from typing import Any

from tamp.batch.pool import Job, Outcome
from tamp.batch.remote import Limits, crashed, outcome_of, run_remotely
from tamp.errors import TampError
from tamp.versions import how_to_install


def run_on_dask(
    jobs: Iterable[Job],
    work: str,
    *,
    workers: int = 1,
    time_limit_s: float | None = None,
    memory_limit: int | None = None,
    preload: object = (),
    address: str | None = None,
) -> Iterator[Outcome]:
    """Run jobs as `run_jobs` does, on the workers of a Dask cluster.

    A job whose worker dies is run again elsewhere; Dask gives it up after some deaths, and its outcome says so.

    Args:
        jobs: what to run.
        work: the work function as "package.module:function".
        workers: how many processes to start where no address is given.
        time_limit_s: per job, enforced where it runs [s].
        memory_limit: per job, enforced where it runs [bytes].
        preload: of no use here.
        address: of a scheduler, such as "tcp://host:8786"; None starts a cluster on this machine.

    Raises:
        TampError: where the extra is not installed, or nobody answers at the address.
    """
    limits = asdict(Limits(time_limit_s, memory_limit))
    with _client(address, workers) as client:
        from distributed import as_completed

        running = {
            client.submit(run_remotely, job.key, dict(job.arguments), work, limits, pure=False): job for job in jobs
        }
        for future in as_completed(list(running)):
            job = running[future]
            yield outcome_of(job, future.result()) if future.status == "finished" else crashed(job, future.exception())
            future.release()


@contextmanager
def _client(address: str | None, workers: int) -> Iterator[Any]:
    try:
        from distributed import Client, LocalCluster
    except ModuleNotFoundError:
        raise TampError(f"the executor dask is an extra: {how_to_install('dask')}") from None
    if address is None:
        local = LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None, silence_logs=50)
        with local as cluster, Client(cluster) as client:
            yield client
        return
    try:
        client = Client(address, timeout="20s")
    except (OSError, ValueError) as error:
        raise TampError(f"no Dask scheduler answers at {address}: {error}") from None
    with client:
        yield client
