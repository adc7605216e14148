"""The stream planner by itself, without a robot: blocksworld, blocks on a line and in a plane, discs on a table.

The problems are the tests'; samplers take next to no time, so that what is measured is the planner. Every plan of up to
20 objects is replayed by the tests' independent validator. For permutations, `extra` counts placements beyond one for
each object and one buffer.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from benchmarks.parts.harness import Row, main, percentile
from tamp.planning import Problem, Solution, solve
from tests.planning.oracles.validator import validate
from tests.planning.problems import blocksworld, continuous, tabletop

FAMILIES: dict[str, tuple[Callable[[int], Problem], tuple[int, ...], tuple[int, ...]]] = {
    "blocksworld inversion": (blocksworld.inversion, (10, 40), (5, 10, 20, 40)),
    "line": (continuous.line, (5,), (1, 2, 4, 6, 8, 10)),
    "plane": (continuous.plane, (5,), (1, 2, 4, 6, 8, 10)),
    "discs sort": (tabletop.sort, (5, 40), (1, 2, 5, 10, 20, 40)),
    "discs clutter": (tabletop.clutter, (9,), (4, 9, 16, 25)),
    "discs permutation": (tabletop.permutation, (4, 16), (2, 4, 8, 12, 16, 20, 40)),
}
"""Name -> problem of a size, sizes of a quick run, all sizes."""

VALIDATED_UP_TO = 20
TIMEOUT_S = 60.0


def run(quick: bool) -> Iterator[Row]:
    for name, (make, small, sizes) in FAMILIES.items():
        for n in small if quick else sizes:
            yield _row(name, n, make, range(1 if quick else 6))


def _row(name: str, n: int, make: Callable[[int], Problem], seeds: range) -> Row:
    runs = []
    for seed in seeds:
        problem = make(n)
        solution = solve(problem, seed=seed, timeout=TIMEOUT_S)
        if solution.plan is not None and n <= VALIDATED_UP_TO:
            _validate(problem, solution)
        runs.append(solution)
    seconds = [s.report.total_s for s in runs]
    row: Row = {
        "family": name,
        "n": n,
        "solved": f"{sum(s.solved for s in runs)}/{len(runs)}",
        "median_s": percentile(seconds, 50),
        "max_s": max(seconds),
        "ms_per_object": 1e3 * percentile(seconds, 50) / n,
    }
    for phase in ("grounding", "search", "binding", "sampling"):
        row[f"{phase}_s"] = percentile([s.report.seconds[phase] for s in runs], 50)
    row["searches"] = percentile([float(s.report.counts["iterations"]) for s in runs], 50)
    if name.endswith("permutation"):
        row["extra"] = max(sum(a.name == "place" for a in s.plan or ()) - n - 1 for s in runs)
    return row


def _validate(problem: Problem, solution: Solution) -> None:
    plan = [(action.name, action.args) for action in solution.plan or ()]
    facts = [*problem.init, *solution.certified]
    validate(problem.parsed_domain, facts, plan, problem.goal, problem.parsed_streams, problem.samplers)


if __name__ == "__main__":
    main("planner_symbolic", run)
