"""OCRTOC's public tasks of 2021 or 2020, from settled start scenes to a score, and the means that rank a solution.

Every result is on disk before the next task begins; with --output, a run that was interrupted goes on where it was, and
with --pictures each task's start, goal and end are rendered side by side beside it. With --perceive no poses are given.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from benchmarks.parts.harness import Row, main
from tamp.batch.run import Batch
from tamp.execution.simulators import DEFAULT
from tamp.formats.ocrtoc import import_ocrtoc
from tamp.results import Result
from tamp.task import Task
from tamp.task.files.load import load_task

DATA = Path(__file__).parents[2] / "shared" / "ocrtoc"
FOUND = ("reached", "no goal")
"""What becomes of an object that is not lost."""

QUICK = {2020: ("1-24", "1-26", "1-241"), 2021: ("0-0", "1-1-1", "6-1-1")}


def rows(
    quick: bool,
    year: int,
    levels: Sequence[int],
    tasks: Sequence[str],
    output: Path | None,
    perceive: str | None,
    own_robot: bool,
    **how: Any,
) -> Iterator[Row]:
    """One row for each task and seed, and the means over each level and all; reasons are printed as they come."""
    data = DATA / str(year)
    if not data.is_dir():
        sys.exit(f"the tasks are not there: {data}")
    with tempfile.TemporaryDirectory() as scratch:
        folder = output or Path(scratch)
        import_ocrtoc(data, folder / "tasks", own_robot=own_robot)
        wanted = set(tasks or (QUICK[year] if quick else ()))
        files = [f for f in sorted((folder / "tasks").glob("*.yaml")) if not wanted or f.stem in wanted]
        loaded = [task for task in map(load_task, files) if not levels or task.level in levels]
        eyes = {"perceive": perceive} if perceive else {}
        yield from solved(loaded, folder, lambda result: result.level and f"level {result.level}", **how, **eyes)


def solved(
    tasks: Sequence[Task],
    folder: Path,
    group: Callable[[Result], str | None],
    seeds: Sequence[int],
    workers: int,
    pictures: bool,
    **options: Any,
) -> Iterator[Row]:
    """Solve tasks, their runs kept in a folder and resumed from it: a row each, and the means of each group and all."""
    batch = Batch(tasks, seeds, options, workers=workers, output=folder, resume=True)
    by_name, results = {task.name: task for task in tasks}, []
    for result in batch.run():
        results.append(result)
        yield _row(result)
        print(f"{result.task} (seed {result.seed}): {result.status}. {result.message}", flush=True)
        if pictures:
            _picture(by_name[result.task], result, folder)
    for name in sorted({of for result in results if (of := group(result))}):
        yield _means(name, [result for result in results if group(result) == name])
    yield _means("all", results)


def _row(result: Result) -> Row:
    return {
        "task": result.task,
        "seed": result.seed,
        "status": result.status,
        "actions": result.n_actions,
        "replans": result.n_replans,
        "grasps": f"{result.grasps_succeeded}/{result.grasps_attempted}",
        "plan_s": result.planning_s,
        "sim_s": result.execution_sim_s,
        "ede_cm": "-" if result.ede_m is None else 100 * result.ede_m,
        "idle_cm": "-" if result.do_nothing_ede_m is None else 100 * result.do_nothing_ede_m,
        "improvement": "-" if result.improvement is None else f"{result.improvement:.1%}",
        "left": ", ".join(f"{o['name']} {100 * o['error_m']:.0f} cm" for o in result.objects if o["error_m"] > 0.03),
        **(_sight(result) if result.perceived else {}),
    }


def _sight(result: Result) -> Row:
    """What perceiving cost, the error over the meshes' own symmetries, and what became of what is lost."""
    told = [f"{o['name']}: {o['fate']}" for o in result.perception if o["fate"] not in FOUND]
    mean = _symmetric(result)
    return {
        "see_s": result.perceiving_s,
        "symmetric_cm": "-" if mean is None else 100 * mean,
        "lost": ", ".join(told),
    }


def _symmetric(result: Result) -> float | None:
    """A task's mean error over the meshes' own symmetries [m]; None where nothing has a goal pose."""
    ends = [
        min(o["end_m"], u["ueb_m"])
        for o in result.perception
        for u in result.objects
        if o["name"] == u["name"] and o["end_m"] is not None
    ]
    return sum(ends) / len(ends) if ends else None


def _sights(results: Sequence[Result]) -> Row:
    """The same of many tasks: the most that perceiving cost, the mean error, and how many objects have each fate."""
    fates = Counter(o["fate"] for result in results for o in result.perception if o["fate"] not in FOUND)
    means = [mean for result in results if (mean := _symmetric(result)) is not None]
    return {
        "see_s": max(result.perceiving_s for result in results),
        "symmetric_cm": 100 * sum(means) / len(means) if means else "-",
        "lost": ", ".join(f"{count} {fate}" for fate, count in fates.most_common()),
    }


def _means(name: str, results: Sequence[Result]) -> Row:
    """What a solution is ranked by. A task without a score counts as untouched."""
    idle = [r.do_nothing_ede_m for r in results if r.do_nothing_ede_m is not None]
    error = [r.do_nothing_ede_m if r.ede_m is None else r.ede_m for r in results if r.do_nothing_ede_m is not None]
    attempted = sum(r.grasps_attempted for r in results)
    return {
        "task": name,
        "status": f"{sum(r.status == 'solved' for r in results)} of {len(results)}",
        "grasps": f"{sum(r.grasps_succeeded for r in results) / max(attempted, 1):.1%}",
        "plan_s": max((r.planning_s for r in results), default=0.0),
        "sim_s": max((r.execution_sim_s for r in results), default=0.0),
        "ede_cm": 100 * sum(error) / max(len(error), 1),
        "idle_cm": 100 * sum(idle) / max(len(idle), 1),
        "improvement": f"{1 - sum(error) / sum(idle):.1%}" if sum(idle) > 0 else "-",
        **(_sights(seen) if (seen := [r for r in results if r.perceived]) else {}),
    }


def _picture(task: Task, result: Result, folder: Path) -> None:
    """Start, goal and end side by side, in the folder of pictures."""
    import numpy as np

    from tamp.report.rendering.images import save_image
    from tamp.report.rendering.scene import Stage, goal_poses
    from tamp.task.files.poses_file import load_poses

    path, poses = folder / "pictures" / f"{result.task}-{result.seed}.png", _run(folder, result) / "poses.json"
    if path.exists() or not poses.exists():
        return
    start = {obj.name: obj.pose for obj in task.objects}
    end = {name: pose for name, pose in load_poses(poses).items() if pose is not None}
    with Stage(task) as stage:
        save_image(np.hstack([stage.picture({**start, **scene}) for scene in ({}, goal_poses(task), end)]), path)


def _run(folder: Path, result: Result) -> Path:
    """Where the batch keeps a run."""
    return folder / f"{result.task}-{result.seed}"


def _options() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--year", type=int, choices=sorted(QUICK), default=2021, help="the contest's")
    parser.add_argument("--levels", type=int, nargs="*", default=(), metavar="N", help="only these; 2020 has 1 to 5")
    parser.add_argument("--tasks", nargs="*", default=(), metavar="NAME", help="only these, such as 1-1-1")
    eyes = "estimate poses from the two cameras, by a perceiver's name; alone: fit"
    parser.add_argument("--perceive", nargs="?", const="fit", metavar="NAME", help=eyes)
    own = "of 2020: that year's UR5e with a 2F-85 where it stood, not the Panda"
    parser.add_argument("--own-robot", action="store_true", help=own)
    add_batch_options(parser)
    return parser


def add_batch_options(parser: argparse.ArgumentParser) -> None:
    """The options of `solved`."""
    parser.add_argument("--seed", dest="seeds", type=int, nargs="*", default=(0,), metavar="N")
    parser.add_argument("--timeout", type=float, default=60.0, metavar="SECONDS", help="planning a task")
    parser.add_argument("--clock", choices=("wall", "processor"), default="wall", help="on which that is kept")
    parser.add_argument("--simulator", default=DEFAULT, metavar="NAME", help="in which plans are carried out")
    parser.add_argument("--workers", type=int, default=1, metavar="N", help="tasks at the same time")
    parser.add_argument("--output", type=Path, metavar="DIR", help="keep results and runs there, and resume from them")
    parser.add_argument("--threads", type=int, default=1, metavar="N", help="processor cores that planning one may use")
    parser.add_argument("--pictures", action="store_true", help="render start, goal and end of each run into DIR")


if __name__ == "__main__":
    main("ocrtoc", lambda quick, **options: list(rows(quick, **options)), extra=_options())
