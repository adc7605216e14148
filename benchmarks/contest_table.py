"""The OCRTOC paper's table of its simulation contest, rebuilt: solutions on contest tasks that were generated for it.

    python -m benchmarks.contest_table --output DIR [--tasks N] [--runs N] [--simulators NAME ...] [--seed N]

By default it is the paper's: 100 contest tasks, each solution in two simulators, the better one of them over all tasks,
of each task the best of three runs, 600 s each. Solutions are run as `tamp contest run` runs them. Every result is on
disk before the next run begins: with --output, what was interrupted goes on where it was, several processes share the
work (--share 1/2 and --share 2/2), and --show prints the table of what is there.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import asdict, replace
from pathlib import Path

from benchmarks.parts.harness import Row, main
from tamp.contest.evaluation.evaluate import evaluate, solution_path
from tamp.contest.evaluation.standings import counting, standings
from tamp.contest.evaluation.trial import Trial
from tamp.contest.rules import Rules
from tamp.contest.sandbox.choice import choose
from tamp.errors import TampError
from tamp.generate.run import copy_library, make_tasks, recipes
from tamp.results import Result, from_json, percent, to_json
from tamp.scenarios.library.model import FOLDER, SETS
from tamp.scoring.ranking import Mean, Standing, Yardstick, measure
from tamp.task import Task
from tamp.task.files.load import load_task

TASKS, RUNS = 100, 3
SIMULATORS = ("pybullet", "mujoco")
SOLUTIONS = ("nothing", "planner")
LIBRARIES = ("tabletop-tamp[perception]",)
"""What `planner` needs beside NumPy; offered to all."""


def rows(
    quick: bool,
    tasks: int | None,
    runs: int | None,
    simulators: Sequence[str],
    solutions: Sequence[str],
    seed: int,
    processor: float,
    share: tuple[int, int],
    output: Path | None,
    show: bool,
) -> list[Row]:
    """A row for each solution, over all tasks and over each level, the best first."""
    rules = Rules(
        simulators=tuple(simulators) or (SIMULATORS[:1] if quick else SIMULATORS),
        runs=runs or (1 if quick else RUNS),
        libraries=LIBRARIES,
    )
    rules = replace(rules, limits=replace(rules.limits, processor_s=processor, wall_s=6 * processor))
    chosen = tuple(solutions) or (SOLUTIONS[:1] if quick else SOLUTIONS)
    with tempfile.TemporaryDirectory() as scratch:
        folder = output or Path(scratch)
        table = generated(folder / "tasks", tasks or (1 if quick else TASKS), seed)
        if not show:
            for name in chosen:
                _evaluate(name, table[share[0] - 1 :: share[1]], rules, folder)
        found = {name: _results(folder, name, table, rules) for name in chosen}
        return list(_table(found, table, rules))


def generated(folder: Path, count: int, seed: int) -> list[Task]:
    """The first contest tasks of a seed, made where they are not there yet.

    Raises:
        TampError: where the folder has tasks of another seed.
    """
    wanted = [recipe for recipe in recipes(5 * count, seed) if recipe.set == SETS[1]][:count]
    note = folder / "seed.json"
    if not note.exists():
        copy_library(FOLDER, folder)
        note.write_text(json.dumps(seed), encoding="utf-8")
    elif json.loads(note.read_text(encoding="utf-8")) != seed:
        raise TampError(f"{folder}: has tasks of seed {note.read_text(encoding='utf-8')}; give another --output")
    missing = [recipe for recipe in wanted if not (folder / f"{recipe.name}.yaml").exists()]
    for recipe in missing:
        make_tasks(str(folder), [asdict(recipe)])
    return [load_task(folder / f"{recipe.name}.yaml") for recipe in wanted]


def _evaluate(name: str, tasks: Sequence[Task], rules: Rules, folder: Path) -> None:
    """Do what is not done yet, with each result on disk before the next run."""

    def keep(trial: Trial) -> None:
        file = _file(folder, name, trial.result.task, trial.result.simulator, trial.result.seed)
        file.parent.mkdir(parents=True, exist_ok=True)
        file.with_suffix(".log").write_bytes(trial.log)
        half = file.with_suffix(".part")
        half.write_text(to_json(trial.result) + "\n", encoding="utf-8")
        half.replace(file)
        r = trial.result
        print(f"{name}, {r.task}, {r.simulator}, run {r.seed}: {r.status}. {r.message}", flush=True)

    evaluate(solution_path(name), tasks, rules, choose(), keep, _results(folder, name, tasks, rules))


def _results(folder: Path, name: str, tasks: Sequence[Task], rules: Rules) -> list[Result]:
    """What is on disk of the runs that the rules ask for."""
    names = [
        (task.name, simulator, run) for task in tasks for simulator in rules.simulators for run in range(rules.runs)
    ]
    files = [_file(folder, name, *which) for which in names]
    return [from_json(file.read_text(encoding="utf-8"), str(file)) for file in files if file.exists()]


def _file(folder: Path, name: str, task: str, simulator: str, run: int) -> Path:
    return folder / "results" / Path(name).stem / f"{task}-{simulator}-{run}.json"


def _table(found: dict[str, list[Result]], tasks: Sequence[Task], rules: Rules) -> Iterator[Row]:
    yardsticks = measure(tasks)
    expected = len(tasks) * len(rules.simulators) * rules.runs
    for standing in standings(found, yardsticks, rules):
        results = found[standing.solution]
        yield {
            "rank": standing.rank,
            **_all(standing, results, yardsticks, rules),
            "runs": f"{len(results)}/{expected}",
        }
        kept = counting(results, yardsticks, rules)
        for level, mean in sorted(standing.levels.items()):
            of_level = [result for result in kept if result.level == level]
            yield {"rank": standing.rank, **_row(standing.solution, f"level {level}", mean, of_level)}


def _all(standing: Standing, results: Sequence[Result], tasks: Sequence[Yardstick], rules: Rules) -> Row:
    return _row(standing.solution, "all", standing.mean, counting(results, tasks, rules))


def _row(solution: str, tasks: str, mean: Mean, kept: Sequence[Result]) -> Row:
    """What a solution did on some tasks, by the runs that count; times are simulated."""
    attempted = sum(result.grasps_attempted for result in kept)
    grasps = sum(result.grasps_succeeded for result in kept)
    return {
        "solution": solution,
        "over": tasks,
        "tasks": mean.tasks,
        "error cm": round(100 * mean.error_m, 2),
        "improvement": percent(mean.improvement_ueb),
        "over doing nothing": percent(mean.improvement),
        "grasps": f"{grasps}/{attempted}",
        "grasp success": percent(grasps / attempted if attempted else None),
        "sim s": round(statistics.fmean(result.execution_sim_s for result in kept), 1) if kept else "-",
        "solved": sum(result.status == "solved" for result in kept),
    }


def a_share(text: str) -> tuple[int, int]:
    """Which part of how many: "1/2" is the first half of the tasks."""
    first, _, parts = text.partition("/")
    if not (first.isdecimal() and parts.isdecimal() and 1 <= int(first) <= int(parts)):
        raise argparse.ArgumentTypeError(f"{text!r} is no share; 1/2 and 2/2 are")
    return int(first), int(parts)


def options() -> argparse.ArgumentParser:
    """What this benchmark takes beside what all do."""
    parser = argparse.ArgumentParser(add_help=False)
    add = parser.add_argument
    add("--tasks", type=int, metavar="N", help=f"default {TASKS}")
    add("--runs", type=int, metavar="N", help=f"on each task and simulator; default {RUNS}")
    add("--simulators", nargs="+", default=(), metavar="NAME", help=f"default {' '.join(SIMULATORS)}")
    add("--solutions", nargs="+", default=(), metavar="SOLUTION", help=f"default {' '.join(SOLUTIONS)}")
    add("--seed", type=int, default=0, metavar="N", help="of the tasks")
    add("--processor", type=float, default=2400.0, metavar="SECONDS", help="processor time of a run; default 2400")
    add("--share", type=a_share, default=(1, 1), metavar="K/N", help="do every Nth task only, from the Kth on")
    add("--output", type=Path, metavar="DIR", help="tasks and results, to go on with; default: forgotten at the end")
    add("--show", action="store_true", help="run nothing; show what is there")
    return parser


if __name__ == "__main__":
    try:
        main(
            "contest_table",
            rows,
            extra=options(),
            asked="planner far below nothing in error; the paper's best team had 29.21 cm and improved by 10.3%",
        )
    except TampError as error:
        sys.exit(str(error))
