"""The checker's proof: what a slow oracle calls wrong is not accepted, and no plan of the planner's is rejected.

Plans small tasks, corrupts each plan in every way that tests/checking/mutations knows, and asks both the checker
and tests/checking/oracle. The first row is about the plans as they are, with the actions that they have; the last is
the sum of all mutants; in between each row is one kind of corruption. `wrong_accepted` must be 0, and so must
`rejected` of the plans as they are, `unseen`, the kinds of which the oracle called no mutant wrong, and `untried`, the
actions that the checker has rules for and no plan has. Kinds that are for one skill come first of each plan's, so that
few mutants have them too. Mutants of one plan follow each other, so that the oracle need not look again at what they
share.

    python -m benchmarks.checker --count 20000 --output mutants.jsonl

judges 20,000 mutants, about eighteen a second and process. Each plan's counts are a line of the output as soon as they
are known; the same command goes on where it was interrupted. Another --seed makes other mutants.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from itertools import chain, count, islice
from pathlib import Path
from typing import Any

import numpy as np

import tamp
from benchmarks.parts.harness import Row, main, percentile
from benchmarks.parts.small_tasks import small_tasks
from tamp.checking import check
from tamp.checking.actions.tabletop import TABLETOP
from tamp.errors import PlanningFailure, TampError
from tamp.task import At, Plan, Pose, Task
from tamp.task.model import Goal
from tests.checking.handmade import scales
from tests.checking.mutations import FALLS, MUTATIONS, PUSHES, STACKS, TOPPLES
from tests.checking.oracle import Oracle

COUNT, QUICK = 20_000, 250
"""Mutants."""
PLANS, FEW = 40, 4
"""Plans besides the special ones."""
LONG = 4
"""Plans of all kinds: stacks, objects carried twice. The others carry one object: each mutant is checked whole."""
SPECIAL = (
    "slide_box", "topple_pail", "lay_book", "drop_into_corner", "nudge_in_crate", "slide_to_goal", "turn_over",
    "lay_aside", "regrasp_into_box",
)  # fmt: skip
"""Scenarios whose plans push things along the table or over, nudge them, let them fall, or grasp them anew."""
MOVED = ((0.0, 0.0), (0.02, 0.015))
"""Each of them once as it is and once with all that is in it elsewhere, by so much along x and y [m]."""
ASLANT = 0.06
"""How far aside of straight ahead a box is pushed as well [m]."""
OF_SKILLS = {**PUSHES, **FALLS, **TOPPLES, **STACKS}
CORRUPTIONS = {m.__name__: (m, kinds) for m, kinds in {**MUTATIONS, **OF_SKILLS}.items()}
FIRST = {m.__name__ for m in OF_SKILLS}
VALID = "valid"

Counts = dict[str, dict[str, Any]]


def run(quick: bool, count: int | None, seed: int, workers: int, output: Path | None) -> Sequence[Row]:
    """Rows of what was judged, as the module says; plans that the output already has are not judged again."""
    wanted = count or (QUICK if quick else COUNT)
    tasks = _tasks(FEW if quick else PLANS)
    share = -(-wanted // len(tasks))
    made_by = {"seed": seed, "mutants": share, "plans": len(tasks)}
    known = _known(output, made_by)
    waiting = [(seed, index, share, len(tasks)) for index in range(len(tasks)) if index not in known]
    judged = dict(known)
    for index, counts in _judged(waiting, workers):
        judged[index] = counts
        if output is not None:
            with output.open("a", encoding="utf-8") as file:
                file.write(json.dumps({**made_by, "plan": index, "counts": counts}) + "\n")
        done = [row for each in judged.values() for kind, row in each.items() if kind != VALID]
        mutants, accepted = (sum(row[key] for row in done) for key in ("judged", "wrong_accepted"))
        told = f"plan {len(judged)} of {len(tasks)}: {mutants} mutants, {accepted} wrong accepted"
        print(told, file=sys.stderr, flush=True)
    return _rows([judged[index] for index in sorted(judged)])


def _tasks(count: int) -> list[tuple[Task, Plan | None]]:
    """So many small tasks and the special ones; with its plan where that is made by hand."""
    tasks = small_tasks(10 * count)
    short = (task for task in tasks[LONG:] if sum(thing.goal is not None for thing in task.objects) == 1)
    planned = islice(chain(_special(), tasks[:LONG], short), count + sum(1 for _ in _special()))
    return [scales(), *((task, None) for task in planned)]


def _special() -> Iterator[Task]:
    """The scenarios of `SPECIAL`, and one of which the goal is moved so that a flank is pushed aslant."""
    scenarios = [tamp.load_task(f"scenarios/{name}.yaml") for name in SPECIAL]
    for by in MOVED:
        for task in scenarios:
            objects = tuple(replace(o, pose=_aside(o.pose, by), goal=_goal_aside(o.goal, by)) for o in task.objects)
            yield replace(task, objects=objects)
    straight = tamp.load_task("scenarios/slide_to_goal.yaml")
    objects = tuple(replace(o, goal=_goal_aside(o.goal, (ASLANT, 0.0))) for o in straight.objects)
    yield replace(straight, objects=objects)


def _goal_aside(goal: Goal | None, by: tuple[float, float]) -> Goal | None:
    return At(_aside(goal.pose, by)) if isinstance(goal, At) else goal


def _aside(pose: Pose, by: tuple[float, float]) -> Pose:
    x, y, z = pose.xyz
    return Pose((x + by[0], y + by[1], z), pose.quat)


def _known(output: Path | None, made_by: dict[str, int]) -> dict[int, Counts]:
    """What an earlier run has judged, by the number of the plan."""
    if output is None or not output.is_file():
        return {}
    lines = [json.loads(line) for line in output.read_text(encoding="utf-8").splitlines()]
    if any(line[key] != value for line in lines for key, value in made_by.items()):
        sys.exit(f"{output} was made with another --seed or --count: name another file")
    return {line["plan"]: line["counts"] for line in lines}


def _judged(waiting: Sequence[tuple[int, int, int, int]], workers: int) -> Iterator[tuple[int, Counts]]:
    """The counts of each plan, as they come."""
    if workers == 1:
        yield from map(_judge_plan, waiting)
        return
    with ProcessPoolExecutor(workers) as pool:
        yield from pool.map(_judge_plan, waiting)


def _judge_plan(asked: tuple[int, int, int, int]) -> tuple[int, Counts]:
    """Plan the task of a number and judge about so many mutants of the plan, all kinds in turn."""
    seed, index, share, plans = asked
    task, made = _tasks(plans - 1 - sum(1 for _ in _special()))[index]
    plan = made or _plan(task)
    counts: Counts = {}
    if plan is None:
        return index, counts
    oracle = Oracle()
    _judge(counts, VALID, oracle, (task, plan))
    counts[VALID]["actions"] = dict(Counter(action.name for action in plan.actions))
    drawn = np.random.default_rng((seed, index)).permutation(list(CORRUPTIONS))
    kinds = sorted(drawn, key=lambda kind: kind not in FIRST)
    for mutant, kind in islice(_mutants(task, plan, (seed, index), kinds), share):
        _judge(counts, kind, oracle, mutant)
    return index, counts


def _mutants(
    task: Task, plan: Plan, seed: tuple[int, int], kinds: Iterable[str]
) -> Iterator[tuple[tuple[Task, Plan], str]]:
    """Mutants without end, one of each kind in each round; none where the plan gives nothing to corrupt."""
    for number in count():
        found = False
        for kind in kinds:
            mutant = CORRUPTIONS[kind][0](task, plan, np.random.default_rng((*seed, number)))
            if mutant is not None:
                found = True
                yield mutant, str(kind)
        if not found:
            return


def _plan(task: Task) -> Plan | None:
    try:
        return tamp.plan(task, seed=0)
    except PlanningFailure as failure:
        print(f"{task.name}: no plan: {failure}")
        return None


def _judge(counts: Counts, kind: str, oracle: Oracle, pair: tuple[Task, Plan]) -> None:
    """Have the checker and the oracle say what they think of a plan, and count it."""
    start = time.process_time()
    kinds, rejected = verdict(*pair)
    took = time.process_time() - start
    wrong = oracle.wrong(*pair)
    row = counts.setdefault(kind, _empty())
    row["check_s"].append(round(took, 4))
    row["judged"] += 1
    row["rejected"] += rejected
    row["right_reason"] += kind != VALID and bool(kinds & set(CORRUPTIONS[kind][1]))
    row["oracle_wrong"] += wrong is not None
    row["wrong_accepted"] += wrong is not None and not rejected
    if wrong is not None and not rejected:
        print(f"accepted: {kind} of {pair[0].name}: {wrong}", flush=True)
    if kind == VALID and rejected:
        print(f"rejected: the plan of {pair[0].name}: {', '.join(sorted(kinds))}", flush=True)


COUNTED = ("judged", "oracle_wrong", "rejected", "wrong_accepted", "right_reason")


def _empty() -> dict[str, Any]:
    return {**dict.fromkeys(COUNTED, 0), "check_s": []}


def _rows(judged: Sequence[Counts]) -> Sequence[Row]:
    rows = []
    for kind in (VALID, *CORRUPTIONS):
        found = [counts[kind] for counts in judged if kind in counts]
        seconds = [s for row in found for s in row["check_s"]]
        sums = {key: sum(row[key] for row in found) for key in COUNTED}
        rows.append({"plans": kind, **sums, "check_s": percentile(seconds, 50) if seconds else 0.0})
    unseen = [row["plans"] for row in rows[1:] if not row["oracle_wrong"]]
    done: Counter[str] = Counter()
    for counts in judged:
        done.update(counts.get(VALID, {}).get("actions", {}))
    untried = sorted(TABLETOP.keys() - done.keys())
    print(f"actions: {', '.join(f'{name} {number}' for name, number in sorted(done.items()))}")
    for title, names in (("not called wrong once", unseen), ("in no plan", untried)):
        if names:
            print(f"{title}: {', '.join(names)}")
    mutants = {key: sum(row[key] for row in rows[1:]) for key in COUNTED}
    return [*rows, {"plans": "all mutants", **mutants, "unseen": len(unseen), "untried": len(untried)}]


def verdict(task: Task, plan: Plan) -> tuple[set[str], bool]:
    """Kinds of problem that the checker finds, and whether it rejects."""
    try:
        said = check(task, plan)
    except TampError:
        return {"refused"}, True
    return {problem.kind for problem in said.problems}, not said.accepted


def _options() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--count", type=int, metavar="N", help=f"mutants in all (default {COUNT})")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="of the corruptions (default 0)")
    parser.add_argument("--workers", type=int, default=1, metavar="N", help="processes (default 1)")
    parser.add_argument("--output", type=Path, metavar="FILE", help="a line a plan; what it has is not judged again")
    return parser


if __name__ == "__main__":
    asked = "0 wrong accepted, 0 valid rejected; at full size 0 unseen, 0 untried"
    main("checker", run, extra=_options(), asked=asked)
