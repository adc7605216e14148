"""A batch that somebody shoots at: every task has exactly one result, whoever dies.

Tiny tasks are planned by `tamp solve` on two workers while a random worker is killed every second or two; then while
the server that workers are forked from is killed as well, and with it both of them; then while the batch itself is
killed too, five times, and resumed. `lost` and `doubled` must be 0.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from random import Random

from benchmarks.parts.harness import Row, main
from tamp.batch import RESULTS
from tamp.batch.processes import PROC, tree
from tamp.results import read_results
from tamp.scenarios.families import FAMILIES
from tamp.task.files.save import save_task

PAUSE_S = (0.5, 4.0)
"""Least and longest time between two shots."""
SERVER_SHARE = 0.3
"""Of the shots go to the fork server, where it is a victim."""


def run(quick: bool) -> Sequence[Row]:
    count, deaths = (16, 1) if quick else (300, 5)
    return [
        _batch("workers killed", count, 0, servers=False),
        _batch("workers and fork servers killed", count, 0, servers=True),
        _batch("workers, fork servers and batch killed", count, deaths, servers=True),
    ]


def _batch(title: str, count: int, deaths: int, *, servers: bool) -> Row:
    """Run `count` tasks to their end, with so many deaths of the batch on the way."""
    with tempfile.TemporaryDirectory() as folder:
        tasks = [FAMILIES[("sort", "clutter")[i % 2]](1, i) for i in range(count)]
        files = [Path(folder) / f"{task.name}.yaml" for task in tasks]
        for task, file in zip(tasks, files, strict=True):
            save_task(task, file)
        output = Path(folder) / "out"
        killer = _Killer(Random(title), [count * (i + 1) // (deaths + 1) for i in range(deaths)], servers)
        while killer.watch(_solve(files, output), output / RESULTS):
            pass
        results = read_results(output / RESULTS)
    found = Counter(result.task for result in results)
    return {
        "batch": title,
        "tasks": count,
        "results": len(results),
        "lost": sum(task.name not in found for task in tasks),
        "doubled": sum(number > 1 for number in found.values()),
        "planned": sum(result.status == "planned" for result in results),
        "errors": sum(result.status == "error" for result in results),
        "workers_killed": killer.workers,
        "servers_killed": killer.server_deaths,
        "batches_killed": killer.batches,
    }


def _solve(files: Sequence[Path], output: Path) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "tamp.cli", "solve", *map(str, files), "--workers", "2", "--no-execute"]
    return subprocess.Popen(
        [*command, "--output", str(output), "--resume"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )


@dataclass
class _Killer:
    """Shoots at workers and fork servers, and at the batch once it has so many results as `dooms` says next."""

    random: Random
    dooms: list[int]
    servers: bool
    workers: int = 0
    server_deaths: int = 0
    batches: int = 0

    def watch(self, batch: subprocess.Popen[bytes], results: Path) -> bool:
        """Shoot until the batch has ended; whether it must be resumed."""
        while True:
            try:
                batch.wait(self.random.uniform(*PAUSE_S))
                return False
            except subprocess.TimeoutExpired:
                self._shoot(batch.pid)
            if self.dooms and results.is_file() and results.read_bytes().count(b"\n") >= self.dooms[0]:
                del self.dooms[0]
                batch.kill()
                batch.wait()
                self.batches += 1
                return True

    def _shoot(self, batch: int) -> None:
        """End one process below the batch: one that leads a session of its own, as workers do, or a fork server."""
        leaders, servers = [], []
        for pid in sorted(tree(batch)):
            with suppress(OSError):
                if pid != batch and os.getsid(pid) == pid:
                    leaders.append(pid)
                elif b"multiprocessing.forkserver" in (PROC / str(pid) / "cmdline").read_bytes():
                    servers.append(pid)
        server = self.servers and bool(servers) and self.random.random() < SERVER_SHARE
        if victims := servers if server else leaders:
            with suppress(ProcessLookupError):
                os.kill(self.random.choice(victims), signal.SIGKILL)
                self.server_deaths += server
                self.workers += not server


if __name__ == "__main__":
    main("chaos", run)
