"""The executor's view of accepted plans: every object ends in the simulator where the plan says that it does.

Makes random tasks as `tamp generate` does, plans each, has the checker judge the plan from the task alone, carries
every accepted plan out without a monitor, and compares where objects end with where the plan leaves them (the score's
displacement). What ends farther off than `BOUND_M` is `astray`, and counted by what explains it: the first action after
which it was off. `let_go`, `fell` and `pushed` are of the action that handled the object, `with_support` follows what
it stands on, or was put on what was astray, `touched` was moved by an action on something else, which no accepted plan
should do. `unsteady` is what was let go, or fell, and comes to rest that far off by itself as well, as
benchmarks.parts.steadiness has it: where it ends is chance, within what the checker allows. Plans that the planner
returns and the checker rejects from the task alone are `rejected`.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np

import tamp
from benchmarks.parts.harness import Row, main, percentile
from benchmarks.parts.steadiness import expected, spread
from tamp.checking import check
from tamp.checking.robot.links import read_links
from tamp.cli import main as command
from tamp.errors import PlanningFailure
from tamp.execution import executor
from tamp.execution.log import Execution
from tamp.scoring.ede import ede, mean_edge
from tamp.task import Action, Fall, Move, Plan, Pose, Task, load_robot
from tamp.task.files.load import load_task

BOUND_M = 0.01
NUMBER = 1000
BATCH = 50
REASONS = ("in_hand", "unsteady", "let_go", "fell", "pushed", "with_support", "touched")
FRAME_S = 0.1


@dataclass(frozen=True)
class End:
    """Where one object ended: how far off [m], and of what is astray the first action after which it was, and why."""

    name: str
    off: float
    action: str = ""
    why: str = ""


def run(quick: bool, number: int | None, seed: int, seconds: float, workers: int) -> Sequence[Row]:
    count = number or (3 if quick else NUMBER)
    seeds = np.random.default_rng(seed).integers(2**31, size=-(-count // BATCH))
    batches = [(i, min(BATCH, count - i * BATCH), int(drawn), seconds) for i, drawn in enumerate(seeds)]
    outcomes: Counter[str] = Counter()
    ends: list[End] = []
    with ProcessPoolExecutor(workers, get_context("spawn")) as pool:
        for done in as_completed([pool.submit(_batch, *batch) for batch in batches]):
            became, found = done.result()
            outcomes.update(became)
            ends += found
            print(f"{outcomes.total()} of {count} tasks: {dict(outcomes)}", file=sys.stderr, flush=True)
    why = Counter(end.why for end in ends)
    offs = [end.off for end in ends] or [0.0]
    return [
        {
            "tasks": count,
            **{outcome: outcomes[outcome] for outcome in ("executed", "unplanned", "rejected")},
            "objects": len(ends),
            "off_m": percentile(offs, 50),
            "off_99_m": percentile(offs, 99),
            "astray": len(ends) - why[""],
            **{reason: why[reason] for reason in REASONS},
        }
    ]


def _batch(batch: int, size: int, seed: int, seconds: float) -> tuple[Counter[str], list[End]]:
    """What became of a batch of tasks."""
    outcomes: Counter[str] = Counter()
    ends: list[End] = []
    for task in drawn(batch, size, seed):
        outcome, found = judged(task, seconds)
        outcomes[outcome] += 1
        ends += found
        for end in found:
            if end.why:
                print(f"{task.name}: {end.name} {1000 * end.off:.0f} mm off: {end.why}, {end.action}", flush=True)
    return outcomes, ends


def drawn(batch: int, size: int, seed: int) -> Iterator[Task]:
    """So many tasks as `tamp generate` makes them, each named after its batch."""
    with tempfile.TemporaryDirectory() as name:
        if command(["generate", "-n", str(size), "--seed", str(seed), "-o", name]) != 0:
            sys.exit("tamp generate failed")
        for file in sorted(Path(name).glob("*.yaml")):
            task = load_task(file)
            yield replace(task, name=f"{batch}-{task.name}")


def judged(task: Task, seconds: float) -> tuple[str, list[End]]:
    """What became of a task: "unplanned", "rejected", or "executed" and where each object ended."""
    try:
        plan = tamp.plan(task, seed=0, timeout=seconds)
    except PlanningFailure:
        return "unplanned", []
    if not (verdict := check(task, plan)).accepted:
        print(f"{task.name}: {verdict}", flush=True)
        return "rejected", []
    return "executed", list(compared(task, plan, executor.execute(task, plan, monitor=None, frame_s=FRAME_S)))


def compared(task: Task, plan: Plan, execution: Execution) -> Iterator[End]:
    """Each object's end, against the plan's; what is astray with what explains it."""
    meant = list(expected(plan))
    were = [entry.poses for entry in execution.log]
    loose = list(moved_in_hand(task, plan, execution))
    for thing in task.objects:
        edge = mean_edge(thing.shape)
        off = ede(edge, execution.final_poses[thing.name], meant[-1][thing.name])
        if off <= BOUND_M:
            yield End(thing.name, off)
            continue
        pairs = zip(were, meant[1:], strict=False)
        gone = [ede(edge, there[thing.name], said[thing.name]) > BOUND_M for there, said in pairs]
        held = [_holds(plan.actions[: k + 1], thing.name) for k in range(len(gone))]
        first = next((k for k, far in enumerate(gone) if far and not held[k]), len(gone) - 1)
        carried = max(loose[max(0, first - 1) : first + 1]) > BOUND_M
        why = "in_hand" if carried else _why(plan.actions[first], thing.name, plan.actions[:first])
        if why in ("let_go", "fell"):
            why = _by_itself(task, plan, first, were[first], meant[first + 1]) or why
        yield End(thing.name, off, str(plan.actions[first]), why)


def _by_itself(task: Task, plan: Plan, index: int, there: Mapping[str, Pose], said: Mapping[str, Pose]) -> str:
    """What brings elsewhere what an action lets go, besides the hand, where objects are and are said to be; or ""."""
    under = (task.object(name) for name in plan.actions[index].arguments[1:] if name in said)
    if any(ede(mean_edge(o.shape), there[o.name], said[o.name]) > BOUND_M for o in under):
        return "with_support"
    return "unsteady" if max(spread(task, plan, index), default=0.0) > BOUND_M else ""


def _why(action: Action, name: str, before: Sequence[Action]) -> str:
    if action.arguments[:1] == (name,):
        if any(isinstance(step, Fall) for step in action.steps):
            return "fell"
        return "pushed" if any(isinstance(step, Move) and step.pushed for step in action.steps) else "let_go"
    stands = next((a.arguments[1:] for a in reversed(before) if a.arguments[:1] == (name,)), ())
    return "with_support" if {*stands} & {*action.arguments} - {"table"} else "touched"


def moved_in_hand(task: Task, plan: Plan, execution: Execution) -> Iterator[float]:
    """For each action that was carried out how far what the arm carried throughout it was off in the hand, at most."""
    tree, frames = read_links(load_robot(plan.robot)).tree, list(execution.frames)
    end = frames[0].time
    for action, entry in zip(plan.actions, execution.log, strict=False):
        begin, end = end, end + entry.sim_s
        held = [step.held if isinstance(step, Move) else None for step in action.steps]
        offs = [0.0]
        if held and (attachment := held[0]) is not None and None not in held:
            edge = mean_edge(task.object(attachment.object).shape)
            for frame in (frame for frame in frames if begin < frame.time <= end):
                meant = Pose.from_matrix(tree.tool(np.array([frame.configuration]))[0]) @ attachment.T_tool_object
                offs.append(ede(edge, frame.poses[attachment.object], meant))
        yield max(offs)


def _holds(actions: Sequence[Action], name: str) -> bool:
    """Whether an object is in the hand after some actions: then it is where the hand is."""
    handled = [action.name for action in actions if action.name != "move" and action.arguments[:1] == (name,)]
    return handled[-1:] in (["pick"], ["unstack"])


def _options() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--number", type=int, metavar="N", help=f"how many tasks; default {NUMBER}")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="of the tasks")
    parser.add_argument("--seconds", type=float, default=20.0, metavar="S", help="limit for each plan [s]")
    parser.add_argument("--workers", type=int, default=1, metavar="N", help="processes; default 1")
    return parser


if __name__ == "__main__":
    main("ends", run, extra=_options(), asked="0 rejected, 0 touched")
