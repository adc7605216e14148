"""One plan a task: the same seed gives the same plan_sha256 with any workers, threads and order of tasks.

Twenty tasks are planned three times each in every arrangement; `hashes` is the largest number of different plans that
any task got, and must be 1.
"""

from __future__ import annotations

import tempfile
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from random import Random

from benchmarks.parts.harness import Row, main
from benchmarks.parts.small_tasks import small_tasks
from tamp.batch import Batch
from tamp.task import Task
from tamp.task.files.load import load_task
from tamp.task.files.save import save_task

ARRANGEMENTS = (("in order", 1, 1), ("in order", 2, 1), ("in order", 1, 2), ("shuffled", 1, 1), ("shuffled", 2, 1))


def run(quick: bool) -> Sequence[Row]:
    count, rounds = (4, 1) if quick else (20, 3)
    rows, every = [], defaultdict[str, set[str]](set)
    with tempfile.TemporaryDirectory() as folder:
        tasks = [_filed(task, Path(folder)) for task in small_tasks(count)]
        for order, workers, threads in ARRANGEMENTS:
            found = defaultdict[str, set[str]](set)
            planned = 0
            for number in range(rounds):
                arranged = Random(number).sample(tasks, len(tasks)) if order == "shuffled" else tasks
                options = {"execute": False, "threads": threads}
                for result in Batch(arranged, options=options, workers=workers).run():
                    found[result.task].add(result.plan_sha256)
                    planned += result.status == "planned"
            for task, hashes in found.items():
                every[task] |= hashes
            rows.append(_row(f"{order}, workers: {workers}, threads: {threads}", rounds * count, planned, found))
    return [*rows, _row("all together", len(rows) * rounds * count, sum(row["planned"] for row in rows), every)]


def _row(title: str, runs: int, planned: int, found: dict[str, set[str]]) -> Row:
    for task in sorted(task for task in found if len(found[task]) > 1):
        print(f"{title}: {task} got {len(found[task])} plans")
    hashes = max(len(hashes) for hashes in found.values())
    return {"arrangement": title, "runs": runs, "planned": planned, "tasks": len(found), "hashes": hashes}


def _filed(task: Task, folder: Path) -> Task:
    """The task from a file; workers read it there."""
    if task.path is not None:
        return task
    save_task(task, folder / f"{task.name}.yaml")
    return load_task(folder / f"{task.name}.yaml")


if __name__ == "__main__":
    main("determinism", run)
