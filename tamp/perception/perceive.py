"""From a task to estimated poses: let it settle, take pictures, ask a perceiver. What `tamp perceive` calls."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from tamp.execution.settling.settle import settle
from tamp.perception.cameras.camera import Frame
from tamp.perception.cameras.capture import shoot, views
from tamp.perception.cameras.setup import OCRTOC_2021, load_setup
from tamp.perception.estimate import Estimate
from tamp.perception.evaluation import pose_errors
from tamp.perception.overlay import overlay, save_picture
from tamp.perception.perceiver import ask, load_perceiver
from tamp.perception.poses_file import details_path, save_estimates
from tamp.perception.rendering.scene import surfaces
from tamp.task.model import Task
from tamp.task.pose import Pose
from tamp.task.robots import task_robot

if TYPE_CHECKING:
    from tamp.perception.rendering.surface import Surface


@dataclass(frozen=True, eq=False)
class Sight:
    """What was seen of a task's start, and the truth.

    Attributes:
        frames: what the perceiver was given.
        objects: object -> mesh, what it was given too.
        estimates: what it said.
        truth: object -> pose; nothing that plans may look at it.
    """

    frames: tuple[Frame, ...]
    objects: Mapping[str, Surface]
    estimates: Mapping[str, Estimate]
    truth: Mapping[str, Pose]


def perceive_task(
    task: Task,
    *,
    perceiver: str = "fit",
    setup: Path = OCRTOC_2021,
    visuals: Path | None = None,
    masks: bool = False,
    seed: int = 0,
    renderer: str = "raycast",
) -> Sight:
    """Look at a task's start as a set-up's cameras would, and estimate where everything is.

    Args:
        task: its start poses are let settle first.
        perceiver: an installed name or "package.module:function".
        setup: a file of cameras.
        visuals: folder of coloured meshes, MODEL.ply; without it, visual.ply beside each mesh, or the mesh in grey.
        masks: whether the perceiver is told which object each pixel shows.
        seed: decides noise and guesses.
        renderer: "raycast" or "software".

    Raises:
        TampError: where set-up, perceiver, meshes or renderer cannot be used; says which and why.
    """
    function, robot = load_perceiver(perceiver), task_robot(task)
    cameras = load_setup(setup, robot)
    looks, truth = surfaces(task, visuals), settle(task).poses
    taken = shoot(
        looks, truth, views(cameras, robot), robot, table=task.table, seed=seed, masks=masks, renderer=renderer
    )
    frames = tuple(shot.frame for shot in taken)
    return Sight(frames, looks, ask(function, frames, looks, table=task.table, seed=seed), truth)


def report(sight: Sight) -> list[str]:
    """A line an object: whether it was seen, how sure that is, and, against the truth, how far it is off."""
    errors = _errors(sight)
    lines = []
    for name, estimate in sight.estimates.items():
        if estimate.pose is None or name not in errors:
            lines.append(f"{name:24s} not seen")
        else:
            others = f", {len(estimate.alternatives)} alternatives" if estimate.alternatives else ""
            lines.append(f"{name:24s} {100 * errors[name]:6.2f} cm off, confidence {estimate.confidence:.2f}{others}")
    return lines


def save_sight(sight: Sight, output: Path, pictures: Path | None = None) -> list[Path]:
    """Write poses, their details, and where asked each frame with the estimates over it; returns all paths."""
    save_estimates(sight.estimates, output)
    paths = [output, details_path(output)]
    errors = _errors(sight)
    for number, frame in enumerate(sight.frames if pictures is not None else ()):
        assert pictures is not None
        paths.append(pictures / f"{number:02}-{frame.camera}.png")
        save_picture(overlay(frame, sight.objects, sight.estimates, errors=errors), paths[-1])
    return paths


def _errors(sight: Sight) -> dict[str, float]:
    """Estimate -> how far it is off, over the mesh's symmetries [m]; what was not seen is absent."""
    found = pose_errors(sight.estimates, sight.truth, sight.objects).values()
    return {error.said: error.symmetric for error in found if error.symmetric is not None}
