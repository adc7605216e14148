"""The checker's proof: plans of ours are accepted, corrupted ones that a slow oracle calls wrong are not.

Plans built-in scenarios, corrupts each plan in every way that tests/checking/mutations.py knows, and asks both the
checker and tests/checking/oracle.py. The first row is about the plans as they are, the last the sum of all mutants; in
between each row is one kind of corruption. `wrong_accepted` must be 0.
"""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np

import tamp
from benchmarks.harness import Row, main, percentile
from tamp.checking import check
from tamp.errors import PlanningFailure, TampError
from tamp.task import Plan, Task
from tests.checking.mutations import MUTATIONS, Mutation
from tests.checking.oracle import wrong

QUICK = ("occupied_goal", "mug_onto_tray")
FULL = ("one_object", "occupied_goal", "swap", "build_tower", "stand_up_can", "on_region", "mug_onto_tray", "in_box")
ROUNDS = 40
"""Mutants a kind and plan in the full benchmark: 33 kinds on 8 plans make 10,560."""


def run(quick: bool) -> Sequence[Row]:
    valid = plans(QUICK if quick else FULL)
    mutants = [judged(mutation, valid, 1 if quick else ROUNDS) for mutation in MUTATIONS]
    counts = ("judged", "oracle_wrong", "rejected", "wrong_accepted", "right_reason")
    total = {"plans": "all mutants", **{key: sum(row[key] for row in mutants) for key in counts}}
    return [accepted(valid), *mutants, total]


def plans(names: Sequence[str]) -> list[tuple[Task, Plan]]:
    """Plans of scenarios; one that the planner does not find is left out and said."""
    found = []
    for name in names:
        task = tamp.load_task(f"scenarios/{name}.yaml")
        try:
            found.append((task, tamp.plan(task, seed=0)))
        except PlanningFailure as failure:
            print(f"{name}: no plan: {failure}")
    return found


def accepted(valid: Sequence[tuple[Task, Plan]]) -> Row:
    """How the plans as they are fare, and how long the checker takes for one."""
    times, good = [], 0
    for task, plan in valid:
        start = time.perf_counter()
        good += check(task, plan).accepted
        times.append(time.perf_counter() - start)
    called_wrong = sum(wrong(task, plan) is not None for task, plan in valid)
    row = {"plans": "valid", "judged": len(valid), "oracle_wrong": called_wrong, "rejected": len(valid) - good}
    return {**row, "check_s": percentile(times, 50)}


def judged(mutation: Mutation, valid: Sequence[tuple[Task, Plan]], rounds: int) -> Row:
    """How many mutants of a kind the oracle and the checker call wrong, and how often they disagree."""
    row: Row = {"plans": mutation.__name__, "judged": 0, "oracle_wrong": 0, "rejected": 0}
    row |= {"wrong_accepted": 0, "right_reason": 0, "check_s": 0.0}
    times = []
    for index, (task, plan) in enumerate(valid):
        for number in range(rounds):
            mutant = mutation(task, plan, np.random.default_rng((index, number)))
            if mutant is None:
                continue
            start = time.perf_counter()
            kinds, rejected = verdict(*mutant)
            times.append(time.perf_counter() - start)
            row["judged"] += 1
            row["rejected"] += rejected
            row["right_reason"] += bool(kinds & set(MUTATIONS[mutation]))
            is_wrong = wrong(*mutant) is not None
            row["oracle_wrong"] += is_wrong
            row["wrong_accepted"] += is_wrong and not rejected
    row["check_s"] = percentile(times, 50) if times else 0.0
    return row


def verdict(task: Task, plan: Plan) -> tuple[set[str], bool]:
    """Kinds of problem that the checker finds, and whether it rejects."""
    try:
        said = check(task, plan)
    except TampError:
        return {"refused"}, True
    return {problem.kind for problem in said.problems}, not said.accepted


if __name__ == "__main__":
    main("checker", run)
