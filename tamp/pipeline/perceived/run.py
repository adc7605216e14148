"""A run in which poses are perceived: the true world on one side, the loop that works it through cameras on the other.

This is the one place that sees both sides. The loop is given a workcell and a task without start poses; the truth is
read here for the record alone.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tamp.execution.log import Execution
from tamp.execution.simulator import STEP
from tamp.execution.simulators import make_simulator
from tamp.perception.belief.belief import Belief
from tamp.perception.belief.observer import Observer
from tamp.perception.cameras.setup import OCRTOC_2021, load_setup
from tamp.perception.estimation.models.object_model import object_model
from tamp.perception.evaluation import pose_error
from tamp.perception.overlay import overlay, save_picture
from tamp.perception.perceiver import load_perceiver
from tamp.perception.poses_file import save_estimates
from tamp.perception.rendering.scene import surfaces
from tamp.perception.rendering.surface import Surface
from tamp.perception.workcell.simulated import SimulatedWorkcell
from tamp.perception.workcell.workcell import Workcell
from tamp.pipeline.options.settings import Settings
from tamp.pipeline.perceived.knowledge import Knowledge, blindfolded
from tamp.pipeline.perceived.loop import Loop, Planner
from tamp.pipeline.perceived.outcome import as_dicts, identities, outcomes
from tamp.scoring import Score
from tamp.task import At, Plan, Pose, Task, task_robot

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

SETTLE_S = 1.0
"""How long the scene settles at the end [s]."""

PICTURES = 3
"""Frames of a look that are kept as pictures, spread over all of them."""

SHRUNK = 2
"""So much narrower and lower they are kept."""


@dataclass(frozen=True, eq=False)
class Look:
    """A look as it is recorded.

    Attributes:
        belief: what was believed after it, without its frames.
        truth: object -> where it truly was (world frame).
        errors: object -> how far its estimate is off, over the mesh's symmetries [m]; what was not found is absent.
        pictures: camera and number -> a frame with the estimates drawn over it, shape (height, width, 3).
    """

    belief: Belief
    truth: Mapping[str, Pose]
    errors: Mapping[str, float]
    pictures: Mapping[str, NDArray[np.uint8]]

    def save(self, folder: Path, number: int) -> None:
        """Write look-N.json, its details with the truth, and look-N-VIEW.png for each picture."""
        save_estimates(self.belief.estimates, folder / f"look-{number}.json", self.truth, self.errors)
        for view, picture in self.pictures.items():
            save_picture(picture, folder / f"look-{number}-{view}.png")


@dataclass(frozen=True, eq=False)
class Perceived:
    """What a run with perceived poses leaves behind.

    Attributes:
        final_poses: object -> where it truly is at the end (world frame), by the names that were perceived.
        looks: what was seen, in order.
        surfaces: object -> what it looks like.
        goals: object with a goal pose -> that pose.
        perceiving_s: time that estimating poses took [s], on the clock of the settings.
        sim_s: simulated time of everything, looking included [s].
    """

    final_poses: Mapping[str, Pose]
    looks: tuple[Look, ...]
    surfaces: Mapping[str, Surface]
    goals: Mapping[str, Pose]
    perceiving_s: float
    sim_s: float

    @property
    def unseen(self) -> tuple[str, ...]:
        """Objects that no look has found."""
        found = {name for look in self.looks for name in look.belief.poses}
        return tuple(name for name in self.surfaces if name not in found)

    def outcomes(
        self, plans: Sequence[Plan], executions: Sequence[Execution], reached: Score
    ) -> tuple[dict[str, Any], ...]:
        """What became of every object, JSON-like; see `tamp.pipeline.perceived.outcome`."""
        grasped: Counter[str] = Counter()
        for plan, execution in zip(plans, executions, strict=False):
            for action, entry in zip(plan.actions, execution.log, strict=False):
                if entry.grasps_attempted:
                    grasped[action.arguments[0]] += entry.grasps_succeeded
        beliefs, truths = [look.belief for look in self.looks], [look.truth for look in self.looks]
        ends = {name: (self.final_poses[name], goal) for name, goal in self.goals.items()}
        return as_dicts(outcomes(beliefs, truths, plans, reached, self.surfaces, grasped, ends))


def loop_for(
    task: Task, cell: Workcell, surfaces: Mapping[str, Surface], planner: Planner, settings: Settings, seed: int
) -> Loop:
    """The loop that rearranges what a workcell's cameras see.

    Args:
        task: what is asked for; its start poses are taken off before anything looks at it.
        cell: the workcell, simulated or not.
        surfaces: object -> what it looks like.
        planner: makes plans.
        settings: how it is planned; all of them said, with the name of a perceiver.
        seed: decides every random choice.
    """
    blind = blindfolded(task)
    knowledge = Knowledge.of(blind, settings)
    observer = Observer(
        cell,
        blind,
        surfaces,
        knowledge.world,
        load_perceiver(settings.perceive or ""),
        seed,
        blind.limits.execution_sim_s,
        settings.settling,
    )
    return Loop(cell, knowledge, observer, planner)


@dataclass
class _Record:
    """Keeps what is seen, and the truth at that time."""

    surfaces: Mapping[str, Surface]
    looks: list[Look] = field(default_factory=list)
    names: dict[str, str] = field(default_factory=dict)
    """Believed name -> true one, as the first look has it."""

    def add(self, belief: Belief, truth: Mapping[str, Pose]) -> None:
        self.names = self.names or identities([belief], truth, self.surfaces)
        named = {name: truth[true] for name, true in self.names.items()}
        errors = {
            name: pose_error(object_model(self.surfaces[name]), pose, named[name])[0]
            for name, pose in belief.poses.items()
        }
        count = len(belief.frames)
        chosen = sorted({round(i * (count - 1) / max(1, PICTURES - 1)) for i in range(PICTURES)}) if count else []
        pictures = {}
        for number in chosen:
            frame = belief.frames[number]
            picture = overlay(frame, self.surfaces, belief.estimates, errors=errors, shrink=SHRUNK)
            pictures[f"{number:02}-{frame.camera}"] = picture
        self.looks.append(Look(Belief(belief.estimates), named, errors, pictures))


def perceive_and_rearrange(
    planner: Planner, task: Task, start: Mapping[str, Pose], settings: Settings, seed: int, *, execute: bool
) -> Perceived:
    """Put a task's objects into a simulated workcell and have them rearranged by what its cameras see.

    Args:
        planner: makes plans; told the task as far as it is known, and never more.
        task: the task.
        start: object -> where it truly stands (world frame), at rest.
        settings: how it is planned and carried out; all of them said.
        seed: decides every random choice, sensor noise included.
        execute: whether plans are carried out.

    Raises:
        TampError: where perceiver, cameras, meshes, renderer or simulator cannot be used.
    """
    robot = task_robot(task)
    cameras = load_setup(Path(settings.cameras) if settings.cameras else OCRTOC_2021, robot)
    looks = surfaces(task)
    record = _Record(looks)
    with make_simulator(settings.chosen("simulator"), task.objects, start, table=task.table, robot=robot) as world:
        cell = SimulatedWorkcell(world, looks, cameras, task.table, seed=seed)
        loop = loop_for(task, cell, looks, planner, settings, seed)
        loop.on_look = lambda belief: record.add(belief, world.poses())
        loop.run(execute=execute)
        world.step(round(SETTLE_S / STEP))
        final, sim_s = world.poses(), world.time
    names = record.names or identities((), start, looks)
    return Perceived(
        {name: final[true] for name, true in names.items()},
        tuple(record.looks),
        looks,
        {obj.name: obj.goal.pose for obj in task.objects if isinstance(obj.goal, At)},
        loop.observer.spent_s,
        sim_s,
    )
