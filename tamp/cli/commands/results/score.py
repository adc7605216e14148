"""`tamp score`: final poses by any metric, or a ranking of solutions."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from tamp.cli.options import add_json, add_trust, command, load, natural, positive_int
from tamp.cli.output import to_stdout, write_json
from tamp.cli.paths import distinct
from tamp.cli.status import SOLVED, UNSOLVED
from tamp.errors import TampError
from tamp.results import Result, percent, read_results
from tamp.task.files.regular_file import followed

if TYPE_CHECKING:
    from tamp.cli.options import Commands
    from tamp.scoring import Evaluation, Score
    from tamp.scoring.ranking import Mean, Standing
    from tamp.task import Pose, Task


def add(commands: Commands) -> None:
    """`score`."""
    parser = command(commands, "score", score, "score final poses from any source, or rank solutions")
    add = parser.add_argument
    add("task", type=Path, nargs="?", metavar="TASK.yaml")
    add("poses", type=Path, nargs="?", metavar="POSES.json")
    add("--metric", default="ede", metavar="NAME", help="ede (default), ocrtoc2020, ocrtoc2021, ocrtoc2024")
    several = "rank solutions: folders with a results.jsonl each; DIR+DIR are runs of one, as in two simulators"
    add("--leaderboard", type=_solution, nargs="+", metavar="DIR", help=several)
    add("--tasks", type=Path, nargs="+", metavar="TASK.yaml", help="the set to rank by; default: all that were run")
    best = "of a task's first K runs the best counts, and the better of simulators over all tasks; default: mean"
    add("--best-of", type=positive_int, metavar="K", help=best)
    add("--seed", type=natural, default=0, metavar="N", help="of the confidence intervals")
    add_trust(parser)
    add_json(parser)


def score(options: argparse.Namespace) -> int:
    """Print a score, object by object, or a ranking, and write it; exit status 1 where goals are not reached."""
    if options.leaderboard is not None:
        return _leaderboard(options)
    from tamp.scoring import evaluate, metric, score
    from tamp.task.files.poses_file import load_poses

    if options.task is None or options.poses is None:
        raise TampError("score needs TASK.yaml and POSES.json, or --leaderboard DIR ...")
    task = load(options.task, options)
    poses: dict[str, Pose | None] = load_poses(options.poses)
    whole, evaluation = score(task, poses), evaluate(task, poses, metric(options.metric))
    if not to_stdout(options):
        print("\n".join(_lines(whole, evaluation)), file=options.out)
    write_json(options, {**whole.as_dict(), **_named(evaluation)})
    return SOLVED if whole.solved else UNSOLVED


def _named(evaluation: Evaluation) -> dict[str, object]:
    """Nothing for the score's own metric, which stands there already; any other under its name."""
    return {} if evaluation.metric == "ede" else {"metric": evaluation.metric, evaluation.metric: evaluation.as_dict()}


def _lines(whole: Score, evaluation: Evaluation) -> list[str]:
    factor, unit, title = (100, " cm", "EDE" if evaluation.metric == "ede" else "error")
    if evaluation.unit != "m":
        factor, unit = 1, ""
    lines = []
    for o in evaluation.objects:
        told = f"{o.name:24s} {title} {factor * o.error:7.2f}{unit}  bound {factor * o.bound:6.1f}{unit}"
        exchanged = "" if o.goal_of == o.name else f"  at the goal of {o.goal_of}"
        lines.append(f"{told}{exchanged}{'  lost' if o.lost else ''}")
    scored = {o.name for o in evaluation.objects}
    lines += [f"{n:24s} goal {'met' if met else 'not met'}" for n, met in whole.goals_met.items() if n not in scored]
    lines += [f"{name:24s} lost" for name in evaluation.lost if name not in scored]
    if evaluation.error is not None and evaluation.do_nothing is not None and evaluation.bound is not None:
        told = f"mean {factor * evaluation.error:.2f}{unit}; doing nothing {factor * evaluation.do_nothing:.2f}{unit}"
        better = "" if evaluation.improvement is None else f" (improvement {percent(evaluation.improvement)})"
        lines.append(f"{told}{better}; mean bound {factor * evaluation.bound:.2f}{unit}")
    if evaluation.unit != "m" and evaluation.objects:
        shares = (f"{share:.0%} over {threshold}" for threshold, share in evaluation.in_place().items())
        lines.append(f"objects by overlap: {', '.join(shares)}")
    return [*lines, "solved" if whole.solved else "not solved"]


def _leaderboard(options: argparse.Namespace) -> int:
    from tamp.scoring.ranking import measure, rank, recall

    if options.task is not None:
        raise TampError("--leaderboard takes folders of results; give the set of tasks by --tasks")
    if options.metric != "ede":
        raise TampError("--leaderboard ranks by the metric ede, the one that results record")
    solutions = dict(zip(_names(options.leaderboard), map(_results, options.leaderboard), strict=True))
    if not any(solutions.values()):
        raise TampError(f"there are no results in {', '.join(str(f) for fs in options.leaderboard for f in fs)}")
    if options.tasks:
        tasks = measure(_distinct([load(path, options) for path in options.tasks]))
    else:
        tasks = recall(r for results in solutions.values() for r in results)
    _say_what_is_left_out(solutions, {task.task for task in tasks})
    standings = rank(solutions, tasks, best_of=options.best_of, seed=options.seed)
    if not to_stdout(options):
        print("\n".join(_table(standings)), file=options.out)
    write_json(options, [s.as_dict() for s in standings])
    return SOLVED


def _say_what_is_left_out(solutions: Mapping[str, Sequence[Result]], ranked: set[str]) -> None:
    run = {r.task for results in solutions.values() for r in results}
    if left := sorted(run - ranked):
        why = "not in --tasks, without goal poses, or without a result that says what doing nothing scores"
        print(f"tamp: note: left out {', '.join(left)}: {why}", file=sys.stderr)


def _solution(text: str) -> tuple[Path, ...]:
    """The folders of one solution."""
    return (Path(text),) if Path(text).exists() else tuple(map(Path, text.split("+")))


def _results(folders: Sequence[Path]) -> Sequence[Result]:
    paths = [folder / "results.jsonl" for folder in folders]
    for folder, path in zip(folders, paths, strict=True):
        if not path.is_file():
            raise TampError(f"{folder}: holds no results.jsonl; expected a folder that `tamp solve --output` wrote")
    return [result for path in paths for result in read_results(path)]


def _names(solutions: Sequence[Sequence[Path]]) -> list[str]:
    """The folders' last parts where they differ, else the folders as they were given."""
    folders = [folder for solution in solutions for folder in solution]
    if len(distinct(folders)) < len(folders):
        raise TampError("--leaderboard names a folder twice")
    names = ["+".join(followed(folder).name for folder in solution) for solution in solutions]
    return names if len(set(names)) == len(names) else ["+".join(map(str, solution)) for solution in solutions]


def _distinct(tasks: Sequence[Task]) -> Sequence[Task]:
    names = [task.name for task in tasks]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise TampError(f"--tasks: several files call their task {', '.join(twice)}; names must differ")
    return tasks


def _table(standings: Sequence[Standing]) -> list[str]:
    levels = list(standings[0].levels) if standings else []
    rows = [("rank", "solution", "error cm", "95 % interval", "improvement", "vs. UEB", "grasps", "time s", "attempted",
             "solved", *(f"level {level}" for level in levels))]  # fmt: skip
    for s in standings:
        low, high = s.interval_m
        rows.append((
            str(s.rank), s.solution, f"{100 * s.mean.error_m:.2f}", f"{100 * low:.2f}-{100 * high:.2f}",
            percent(s.mean.improvement), percent(s.mean.improvement_ueb), percent(s.grasp_success),
            "-" if s.execution_s is None else f"{s.execution_s:.1f}", f"{s.attempted} of {s.mean.tasks}",
            str(s.solved), *(_level(s.levels[level]) for level in levels),
        ))  # fmt: skip
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)).rstrip() for row in rows]


def _level(mean: Mean) -> str:
    return f"{100 * mean.error_m:.2f} ({percent(mean.improvement)})"
