"""One run as other programs ask for it: a task and a seed in, a JSON-like result and its files out."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tamp.errors import PlanningFailure
from tamp.execution.log import Execution
from tamp.pipeline.options.own_code import code_files, named_parts
from tamp.pipeline.solving.words import sentences
from tamp.planning import Report
from tamp.results import Result, to_json
from tamp.task import Mesh, Plan, Pose, Task
from tamp.task.files.plan_file import save_plan
from tamp.task.files.regular_file import unlinked

if TYPE_CHECKING:
    from tamp.pipeline.perceived.run import Look


@dataclass(frozen=True)
class Run:
    """Everything a run left behind.

    Attributes:
        result: the record.
        plans: all plans, in order.
        executions: one for each plan that was carried out.
        final_poses: object -> pose (world frame) at the end.
        failure: why planning gave up the last time, or None.
        rejections: the verdict on each piece of a plan that the checker sent back.
        words: action -> what it does, as the domain says, for reports.
        looks: what was seen, where poses were perceived.
        searches: the planner's report on each search for a plan, in order, those in vain included.
    """

    result: Result
    plans: tuple[Plan, ...]
    executions: tuple[Execution, ...]
    final_poses: Mapping[str, Pose]
    failure: PlanningFailure | None = None
    rejections: tuple[str, ...] = ()
    words: Mapping[str, str] = field(default_factory=dict)
    looks: tuple[Look, ...] = ()
    searches: tuple[Report, ...] = ()


def save_run(run: Run, task: Task, configuration: Mapping[str, Any], folder: Path) -> None:
    """Write a run's files into `folder`: plan-N, manifest, result, poses, actions, searches as .json, and report.txt.

    Where poses were perceived also look-N.json, look-N.details.json and the pictures look-N-VIEW.png.

    Args:
        run: what came of it.
        task: what was asked.
        configuration: the arguments it was run with.
        folder: made where absent; files of an earlier run in it are replaced, and so are links, wherever they lead.
    """
    unlinked(folder).mkdir(parents=True, exist_ok=True)
    for entry in folder.iterdir():
        unlinked(entry)
    (folder / "result.json").write_text(to_json(run.result) + "\n", encoding="utf-8")
    save_poses(run.final_poses, folder / "poses.json")
    for pattern in ("plan-*.json", "look-*"):
        for stale in folder.glob(pattern):
            stale.unlink()
    for number, plan in enumerate(run.plans):
        save_plan(plan, folder / f"plan-{number}.json")
    _write_json(folder / "actions.json", [sentences(plan, run.words) for plan in run.plans])
    _write_json(folder / "searches.json", [_times(report) for report in run.searches])
    for number, look in enumerate(run.looks):
        look.save(folder, number)
    _write_json(folder / "manifest.json", manifest(task, configuration, run))
    (folder / "report.txt").write_text(_report(run), encoding="utf-8")


def save_poses(poses: Mapping[str, Pose], path: Path) -> None:
    """Write final poses as {"name": {"xyz": [m], "quat": [x, y, z, w]}}, the form that `tamp score` reads."""
    _write_json(path, {name: {"xyz": list(pose.xyz), "quat": list(pose.quat)} for name, pose in poses.items()})


def manifest(task: Task, configuration: Mapping[str, Any], run: Run) -> dict[str, Any]:
    """What a run depends on: versions, seed, configuration, and a hash of each input file.

    Input files are the task's, its meshes, and the files of the user's own code.
    """
    inputs = {o.shape.path for o in task.objects if isinstance(o.shape, Mesh)}
    inputs |= {*code_files(named_parts(configuration, task))}
    if task.path is not None:
        inputs.add(task.path)
    return {
        "format": "tamp-manifest",
        "version": 1,
        "task": task.name,
        "task_path": "" if task.path is None else str(task.path),
        "seed": run.result.seed,
        "configuration": dict(configuration),
        "versions": dict(run.result.versions),
        "plan_sha256": run.result.plan_sha256,
        "inputs": {str(path): hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(inputs)},
    }


def _times(report: Report) -> dict[str, Any]:
    """How a search ended, where its time went, and how its streams did."""
    told = report.as_dict()
    return {name: told[name] for name in ("status", "message", "total_s", "seconds", "counts", "streams")}


def _report(run: Run) -> str:
    lines = [f"{run.result.task}, seed {run.result.seed}: {run.result.status}", run.result.message, *run.result.remarks]
    for number, plan in enumerate(run.plans):
        lines += ["", f"plan {number}:", *(f"  {i}. {action}" for i, action in enumerate(plan.actions))]
    for number, execution in enumerate(run.executions):
        why = "" if execution.deviation is None else f"; {execution.deviation}"
        lines += ["", f"execution {number}: {execution.status} after {execution.sim_s:.1f} s{why}"]
        lines += [f"  {entry.name}: {entry.sim_s:.1f} s" for entry in execution.log]
    whose = "of your samplers or of the planner" if run.result.configuration.get("samplers") else "of the planner"
    for verdict in run.rejections:
        lines += ["", f"A plan that the checker sent back, which is a bug {whose}:", verdict]
    if run.failure is not None:
        lines += ["", str(run.failure)]
    return "\n".join(lines) + "\n"


def _write_json(path: Path, data: Any) -> None:
    path.write_text(json.dumps(data, indent=1, allow_nan=False) + "\n", encoding="utf-8")
