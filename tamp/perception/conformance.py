"""Holding a perceiver against what is asked of one: its call, its answers, the same seed twice, and a simple scene."""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tamp.errors import TampError
from tamp.perception.cameras.camera import Frame
from tamp.perception.cameras.capture import shoot, views
from tamp.perception.cameras.setup import load_setup
from tamp.perception.estimate import Estimate
from tamp.perception.perceiver import Perceiver, ask, load_perceiver, misfit
from tamp.perception.rendering.surface import plain
from tamp.task.model import Box, Table
from tamp.task.pose import Pose
from tamp.task.robot import DEFAULT_ROBOT
from tamp.task.robots import load_robot

LOOKS = {
    "brick": plain(Box((0.16, 0.09, 0.05)), (190, 60, 50)),
    "block": plain(Box((0.06, 0.07, 0.11)), (60, 90, 190)),
    "absent": plain(Box((0.2, 0.14, 0.03)), (190, 190, 60)),
}
POSES = {
    "brick": Pose.from_rpy((-0.05, 0.12, 0.025), (0.0, 0.0, 0.5)),
    "block": Pose.from_rpy((-0.1, -0.15, 0.055), (0.0, 0.0, 1.2)),
}

NEAR = 0.02
"""An object that stands in the open is to be found within this [m]."""

FAR = 3.0
"""No camera sees so far past the table: an estimate that far off is in other units, or in another frame [m]."""


@dataclass(frozen=True)
class Finding:
    """What a check has found: outcome is "ok", "note" or "wrong"."""

    check: str
    outcome: str
    text: str

    def __str__(self) -> str:
        return f"{self.outcome:5} {self.check}: {self.text}"


def check_perceiver(perceiver: str | Perceiver, *, seed: int = 0) -> tuple[Finding, ...]:
    """Try a perceiver on a rendered scene of two boxes, with a third that is not there.

    What is wrong ends the checks, since later ones would mean nothing; a note says what it does worse than it could.

    Args:
        perceiver: a function, an installed name, or "package.module:function".
        seed: decides noise and guesses.

    Raises:
        TampError: where a name says no perceiver.
    """
    function: Any = load_perceiver(perceiver) if isinstance(perceiver, str) else perceiver
    reason = misfit(function)
    if reason:
        return (Finding("call", "wrong", reason),)
    findings = [Finding("call", "ok", "takes (frames, objects, *, table, seed)")]
    frames = _frames(seed)
    theirs = copy.deepcopy(frames)
    try:
        found, again = (ask(function, theirs, dict(LOOKS), table=Table(), seed=seed) for _ in range(2))
        ask(function, [], dict(LOOKS), table=Table(), seed=seed)
    except TampError as error:
        return (*findings, Finding("answer", "wrong", str(error)))
    findings.append(Finding("answer", "ok", "an estimate for every object, also for no frames at all"))
    if changed := [name for name in ("color", "depth") if _differ(frames, theirs, name)]:
        findings.append(Finding("frames", "wrong", f"it changed their {' and '.join(changed)}; copy what is changed"))
    same = found == again
    text = "the same seed gives the same answer" if same else "two calls with one seed differ; draw from the seed alone"
    findings.append(Finding("seed", "ok" if same else "wrong", text))
    return (*findings, *_accuracy(found))


def _differ(frames: list[Frame], others: list[Frame], name: str) -> bool:
    """Whether pictures are not what they were."""
    return any(not np.array_equal(getattr(a, name), getattr(b, name)) for a, b in zip(frames, others, strict=True))


def _frames(seed: int) -> list[Frame]:
    robot = load_robot(DEFAULT_ROBOT)
    cameras = [replace(camera, intrinsics=camera.intrinsics.scaled(0.5)) for camera in load_setup()]
    return [shot.frame for shot in shoot(LOOKS, POSES, views(cameras, robot), robot, seed=seed)]


def _accuracy(found: Mapping[str, Estimate]) -> list[Finding]:
    findings = []
    for name, true in POSES.items():
        pose = found[name].pose
        off = math.inf if pose is None else math.dist(pose.xyz, true.xyz)
        text = "was not seen" if pose is None else f"is {100 * off:.1f} cm off"
        outcome = "ok" if off < NEAR else "note"
        if FAR < off < math.inf:
            outcome, text = "wrong", f"{text}: poses are T_world_object, in metres"
        findings.append(Finding("accuracy", outcome, f"{name}, which stands in the open, {text}"))
    ghost = found["absent"]
    if ghost.pose is not None:
        text = f"an object that is not there was seen, with a confidence of {ghost.confidence:.2f}"
        findings.append(Finding("accuracy", "note", text))
    return findings
