"""All runs of a solution: each task, each simulator, as often as the rules say."""

from __future__ import annotations

import json
import logging
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from tamp.contest.evaluation.standings import counting, improvement, standings
from tamp.contest.evaluation.trial import NotBegunError, Trial, cannot_load, run_trial
from tamp.contest.package import Package, unpack
from tamp.contest.rules import Rules
from tamp.contest.sandbox.isolation import Sandbox, visible
from tamp.errors import TampError
from tamp.execution.simulators import require
from tamp.results import Result, percent, to_json
from tamp.scoring.ranking import Standing, Yardstick, measure
from tamp.task import Task

LOG = logging.getLogger(__name__)
SAMPLES = Path(__file__).parents[1] / "samples"


def solution_path(text: str) -> Path:
    """A file or folder, or the name of a sample.

    Raises:
        TampError: where there is none.
    """
    names = sorted(path.stem for path in SAMPLES.glob("*.py") if path.stem != "__init__")
    if text in names:
        return SAMPLES / f"{text}.py"
    if not Path(text).exists():
        raise TampError(f"there is no solution {text!r}; give a .py, a folder, a .zip, a .whl or {', '.join(names)}")
    return Path(text)


def evaluate(
    solution: Path,
    tasks: Sequence[Task],
    rules: Rules,
    sandbox: Sandbox,
    seen: Callable[[Trial], None] | None = None,
    known: Sequence[Result] = (),
) -> tuple[Result, ...]:
    """Run a solution on every task, in every simulator, as often as the rules say.

    Args:
        solution: as `tamp.contest.package.unpack` takes it.
        tasks: with different names.
        rules: of the contest.
        sandbox: where it runs.
        seen: called with each run as it ends.
        known: results of runs that were done before, which are not repeated.

    Raises:
        TampError: where solution, tasks or rules cannot be used, or the solution cannot be made; what it does when it
            is run raises nothing.
    """
    names = [task.name for task in tasks]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise TampError(f"two tasks are called {twice!r}; results are filed under a task's name")
    if not measure(tasks):
        raise TampError("none of the tasks has a goal pose, by which a solution is scored")
    for name in rules.simulators:
        require(name)
    with tempfile.TemporaryDirectory(prefix="tamp-solution-") as folder:
        package = unpack(solution, Path(folder) / "solution", rules.uploads)
        before = {(result.task, result.simulator, result.seed): result for result in known}
        if not before.keys() >= {(task.name, simulator, run) for task, simulator, run in combinations(tasks, rules)}:
            _require_loadable(solution.name, package, rules, sandbox)
        results = []
        for task, simulator, run in combinations(tasks, rules):
            if (task.name, simulator, run) in before:
                results.append(before[task.name, simulator, run])
                continue
            trial = run_trial(task, package, rules=rules, simulator=simulator, run=run, sandbox=sandbox)
            LOG.info("%s, %s, run %d: %s", task.name, simulator, run, trial.ending.reason)
            results.append(trial.result)
            if seen is not None:
                seen(trial)
    return tuple(results)


def _require_loadable(name: str, package: Package, rules: Rules, sandbox: Sandbox) -> None:
    wrong, log = cannot_load(package, rules, sandbox)
    if wrong:
        for line in log.decode("utf-8", errors="replace").splitlines():
            LOG.info("%s", visible(line))
        raise TampError(f"{name} cannot be loaded, and was not run: {wrong} (-v shows what it printed)")


def require_doable(task: Task, rules: Rules, sandbox: Sandbox) -> None:
    """Make sure that solutions can be run at all: the sample that does nothing is run on a task.

    Raises:
        TampError: where it does not end well; by the rules or on this machine, no solution could.
    """
    with tempfile.TemporaryDirectory(prefix="tamp-solution-") as folder:
        package = unpack(SAMPLES / "nothing.py", Path(folder) / "solution")
        try:
            trial = run_trial(task, package, rules=rules, simulator=rules.simulators[0], run=0, sandbox=sandbox)
        except OSError as error:  # the machine has no process, memory or room to spare
            why = error.strerror or str(error)
        except NotBegunError as error:
            why = str(error)
        else:
            if trial.ending.reason == "finished":
                return
            printed = visible(trial.log.decode("utf-8", errors="replace").strip().rpartition("\n")[2])
            why = ": ".join(filter(None, (trial.ending.reason, trial.ending.message, printed)))
    raise TampError(
        f"{rules.path or 'the rules'}: no solution can be run, since even one that does nothing ends by {why}; raise "
        "what stops it under 'limits', or give the machine what it lacks"
    )


def combinations(tasks: Sequence[Task], rules: Rules) -> Iterator[tuple[Task, str, int]]:
    """Every run that the rules ask for: task, simulator, number."""
    return ((task, simulator, run) for task in tasks for simulator in rules.simulators for run in range(rules.runs))


def summary(name: str, results: Sequence[Result], tasks: Sequence[Task], rules: Rules) -> dict[str, Any]:
    """What came of a solution as JSON-like values: its standing, what counted of each task, all runs.

    Raises:
        TampError: where no task has a goal pose.
    """
    yardsticks = measure(tasks)
    standing = standings({name: results}, yardsticks, rules)[0]
    return {
        "solution": name,
        "standing": _standing(standing, rules),
        "counting": [json.loads(to_json(result)) for result in counting(results, yardsticks, rules)],
        "runs": [json.loads(to_json(result)) for result in results],
    }


def _standing(standing: Standing, rules: Rules) -> dict[str, Any]:
    return {**standing.as_dict(), "improvement": improvement(standing, rules), "baseline": rules.baseline}


def table(results: Sequence[Result], tasks: Sequence[Task], rules: Rules) -> list[str]:
    """A line a task with what counted, and a line for all."""
    yardsticks: tuple[Yardstick, ...] = measure(tasks)
    kept = counting(results, yardsticks, rules)
    standing = standings({"solution": results}, yardsticks, rules)[0]
    width = max(len(task.name) for task in tasks)
    lines = [f"{'task':{width}s}  simulator  run  error cm  default cm  better  grasps   sim s  ended"]
    for r in kept:
        default = r.mean_ueb_m if rules.baseline == "ueb" else r.do_nothing_ede_m
        better = r.improvement_ueb if rules.baseline == "ueb" else r.improvement
        numbers = ["-" if value is None else f"{100 * value:.2f}" for value in (r.ede_m, default)]
        lines.append(
            f"{r.task:{width}s}  {r.simulator:9s}  {r.seed:3d}  {numbers[0]:>8s}  {numbers[1]:>10s}  "
            f"{percent(better, 0):>6s}  {f'{r.grasps_succeeded}/{r.grasps_attempted}':>6s}  {r.execution_sim_s:6.1f}  "
            f"{r.settings['ended']}"
        )
    lines += sorted({f"{r.task}, {r.simulator}, run {r.seed}: {r.message}" for r in results if r.message})
    grasps = "none" if standing.grasp_success is None else percent(standing.grasp_success)
    lines.append(
        f"mean error {100 * standing.mean.error_m:.2f} cm, improvement over the default error "
        f"{percent(improvement(standing, rules))}, grasp success "
        f"{grasps} ({standing.grasps_succeeded}/{standing.grasps_attempted}), "
        f"{standing.solved} of {len(yardsticks)} tasks solved"
    )
    return lines
