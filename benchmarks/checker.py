"""The checker's proof: what a slow oracle calls wrong is not accepted.

Plans small tasks, corrupts each plan in every way that tests/checking/mutations knows, and asks both the checker
and tests/checking/oracle. The first row is about the plans as they are, the last the sum of all mutants; in between
each row is one kind of corruption. `wrong_accepted` must be 0. Mutants of one plan follow each other, so that the
oracle need not look again at what they share.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Sequence
from itertools import islice, product

import numpy as np

import tamp
from benchmarks.harness import Row, main, percentile
from benchmarks.small_tasks import small_tasks
from tamp.checking import check
from tamp.errors import PlanningFailure, TampError
from tamp.task import Plan, Task
from tests.checking.handmade import scales
from tests.checking.mutations import FALLS, MUTATIONS, PUSHES, STACKS, TOPPLES, Mutation
from tests.checking.oracle import Oracle

PLANS = 40
ROUNDS = 10
"""Mutants a kind and plan: with 57 kinds and 45 plans, less what a plan gives nothing to corrupt for, over 10,000."""
LONG = 4
"""Plans of all kinds: stacks, objects carried twice. The others carry one object: each mutant is checked whole."""
SPECIAL = ("slide_box", "topple_pail", "lay_book", "drop_into_corner")
"""Scenarios whose plans push something along the table or over, or let it fall; besides the others."""
CORRUPTIONS = {**MUTATIONS, **PUSHES, **FALLS, **TOPPLES, **STACKS}


def run(quick: bool) -> Sequence[Row]:
    rows = {mutation: _empty(mutation.__name__) for mutation in CORRUPTIONS}
    valid = {**_empty("valid"), "oracle_wrong": 0}
    count = 4 if quick else PLANS
    for index, (task, plan) in enumerate(plans(count)):
        oracle = Oracle()
        _judge(valid, oracle, (task, plan))
        for mutation, number in product(CORRUPTIONS, range(1 if quick else ROUNDS)):
            mutant = mutation(task, plan, np.random.default_rng((index, number)))
            if mutant is not None:
                _judge(rows[mutation], oracle, mutant, mutation)
        judged, accepted = (sum(row[key] for row in rows.values()) for key in ("judged", "wrong_accepted"))
        print(
            f"plan {index + 1} of {count + len(SPECIAL) + 1}: {judged} mutants, {accepted} wrong accepted",
            file=sys.stderr,
            flush=True,
        )
    counts = ("judged", "oracle_wrong", "rejected", "wrong_accepted", "right_reason")
    total = {"plans": "all mutants", **{key: sum(row[key] for row in rows.values()) for key in counts}}
    return [_closed(row) for row in (valid, *rows.values())] + [total]


def plans(count: int) -> Iterator[tuple[Task, Plan]]:
    """So many plans of small tasks; a task that the planner finds no plan for is left out and said."""
    tasks = small_tasks(10 * count)
    short = [task for task in tasks[LONG:] if sum(thing.goal is not None for thing in task.objects) == 1]
    special = [tamp.load_task(f"scenarios/{name}.yaml") for name in SPECIAL]
    yield scales()
    found = ((task, _plan(task)) for task in special + tasks[:LONG] + short)
    yield from islice(((task, plan) for task, plan in found if plan is not None), count + len(special))


def _plan(task: Task) -> Plan | None:
    try:
        return tamp.plan(task, seed=0)
    except PlanningFailure as failure:
        print(f"{task.name}: no plan: {failure}")
        return None


def _empty(name: str) -> Row:
    return {
        "plans": name, "judged": 0, "oracle_wrong": 0, "rejected": 0, "wrong_accepted": 0, "right_reason": 0,
        "check_s": [],
    }  # fmt: skip


def _judge(row: Row, oracle: Oracle, pair: tuple[Task, Plan], mutation: Mutation | None = None) -> None:
    """Have the checker and the oracle say what they think of a plan, and count it."""
    start = time.process_time()
    kinds, rejected = verdict(*pair)
    row["check_s"].append(time.process_time() - start)
    wrong = oracle.wrong(*pair)
    row["judged"] += 1
    row["rejected"] += rejected
    row["right_reason"] += mutation is not None and bool(kinds & set(CORRUPTIONS[mutation]))
    row["oracle_wrong"] += wrong is not None
    row["wrong_accepted"] += wrong is not None and not rejected
    if wrong is not None and not rejected:
        print(f"accepted: {row['plans']} of {pair[0].name}: {wrong}")


def _closed(row: Row) -> Row:
    return {**row, "check_s": percentile(row["check_s"], 50) if row["check_s"] else 0.0}


def verdict(task: Task, plan: Plan) -> tuple[set[str], bool]:
    """Kinds of problem that the checker finds, and whether it rejects."""
    try:
        said = check(task, plan)
    except TampError:
        return {"refused"}, True
    return {problem.kind for problem in said.problems}, not said.accepted


if __name__ == "__main__":
    main("checker", run)
