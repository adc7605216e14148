"""Plans as files: versioned JSON that any program can read. Loading executes nothing and trusts nothing.

    {"format": "tamp-plan", "version": 1,
     "task": "tower", "robot": "panda", "seed": 0,
     "start": {"red": {"xyz": [x, y, z], "quat": [x, y, z, w]}, ...},
     "home": [q1, ...],
     "goals": {"red": POSE, ...},
     "actions": [{"name": "pick", "arguments": ["red"], "steps": [
         {"move": {"phase": "approach", "opening": 0.08, "held": null, "contacts": [["robot", "red"]],
                   "times": [0.0, ...], "positions": [[q1, ...], ...], "velocities": [[v1, ...], ...]}},
         {"grip": {"object": "red", "T_tool_object": POSE, "width": 0.05}},
         {"release": {"object": "red", "pose": POSE, "opening": 0.08}},
         {"fall": {"object": "red", "pose": POSE}}]}, ...],
     "report": {...}}

Metres, radians, seconds, as in tamp.task.plan. Numbers are written so that they read back to the last bit. `report` is
free JSON and no part of a plan's identity. A move that pushes an object has it as `pushed`, written as `held` is.
Everything else is required, and nothing else is allowed.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
from contextlib import suppress
from pathlib import Path
from typing import Any

from tamp.errors import PlanError
from tamp.task.files.plan_reader import FORMAT, VERSION, PlanReader
from tamp.task.files.regular_file import read_regular
from tamp.task.plan import Attachment, Fall, Grip, Plan, Release, Step
from tamp.task.pose import Pose

MAX_DEPTH = 32


def save_plan(plan: Plan, path: Path | str) -> None:
    """Write a plan, folders and all; the file appears whole or not at all.

    Raises:
        OSError: where it cannot be written.
    """
    path = Path(path)
    document = {"format": FORMAT, "version": VERSION, **_content(plan), "report": dict(plan.report)}
    text = json.dumps(document, allow_nan=False, separators=(",", ":"))
    new = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        new.write_text(text + "\n", encoding="utf-8")
        new.replace(path)
    except BaseException as error:
        with suppress(OSError):
            new.unlink()
        if isinstance(error, OSError):  # whoever asked knows no other name
            raise OSError(error.errno, error.strerror, str(path)) from error
        raise


def load_plan(path: Path | str) -> Plan:
    """Read a plan.

    Raises:
        PlanError: for a file that is missing, too large or no such plan; names the file and the field.
    """
    path = Path(path)
    try:
        text = read_regular(path).decode("utf-8")
    except OSError as error:
        raise PlanError(f"{path}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise PlanError(f"{path}: not UTF-8 text (byte {error.start})") from error
    _check_depth(text, path)
    try:
        document = json.loads(text, parse_constant=_refuse_constant, object_pairs_hook=_refuse_duplicates)
    except ValueError as error:
        raise PlanError(f"{path}: not a plan, which is JSON as `tamp plan -o` writes it: {error}") from error
    return PlanReader(path).plan(document)


def plan_sha256(plan: Plan) -> str:
    """Hash of what a plan does: of its canonical JSON (sorted keys, no spaces) without the report."""
    text = json.dumps(_content(plan), allow_nan=False, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def _content(plan: Plan) -> dict[str, Any]:
    return {
        "task": plan.task,
        "robot": plan.robot,
        "seed": plan.seed,
        "start": {name: _pose(plan.start[name]) for name in sorted(plan.start)},
        "home": [float(value) for value in plan.home],
        "goals": {name: _pose(plan.goals[name]) for name in sorted(plan.goals)},
        "actions": [
            {"name": a.name, "arguments": list(a.arguments), "steps": [_step(step) for step in a.steps]}
            for a in plan.actions
        ],
    }


def _pose(pose: Pose) -> dict[str, Any]:
    return {"xyz": list(pose.xyz), "quat": list(pose.quat)}


def _attachment(attachment: Attachment) -> dict[str, Any]:
    return {"object": attachment.object, "T_tool_object": _pose(attachment.T_tool_object)}


def _step(step: Step) -> dict[str, Any]:
    if isinstance(step, Grip):
        force = {} if step.force is None else {"force": float(step.force)}
        return {"grip": {**_attachment(step.attachment), "width": float(step.width), **force}}
    if isinstance(step, Release):
        return {"release": {"object": step.object, "pose": _pose(step.pose), "opening": float(step.opening)}}
    if isinstance(step, Fall):
        return {"fall": {"object": step.object, "pose": _pose(step.pose)}}
    return {
        "move": {
            "phase": step.phase,
            "opening": float(step.opening),
            "held": None if step.held is None else _attachment(step.held),
            "contacts": sorted(list(pair) for pair in step.contacts),
            "times": step.trajectory.times.tolist(),
            "positions": step.trajectory.positions.tolist(),
            "velocities": step.trajectory.velocities.tolist(),
            **({} if step.pushed is None else {"pushed": _attachment(step.pushed)}),
        }
    }


def _check_depth(text: str, path: Path) -> None:
    """Refuse nesting that could exhaust the parser's stack; brackets within strings count, which only errs safely."""
    depth = 0
    for bracket in re.finditer(r"[\[\]{}]", text):
        depth += 1 if bracket.group() in "[{" else -1
        if depth > MAX_DEPTH:
            raise PlanError(f"{path}: nested more than {MAX_DEPTH} levels deep")


def _refuse_constant(name: str) -> float:
    raise ValueError(f"{name} is not a number")


def _refuse_duplicates(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        raise ValueError("a mapping has the same key twice")
    return found
