"""Next views: what the set-up's own views hardly show, and how much of it is found once the arm has looked further.

Tables settle and stand in a simulated workcell with OCRTOC 2021's cameras and their noise; an observer looks, for all
objects. Counted are those of which the set-up's views show fewer than 100 points of 4 mm, before and after the further
views; errors are EDE over the mesh's own symmetries. With --viewpoints the arm has only its first N viewpoints, with
--cameras only these look, so that much is hidden at first. With --drawn the tables are those of
`benchmarks.parts.unseen_tables`, with --families of these alone. Where nothing is hidden, nobody looks.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.ocrtoc import DATA
from benchmarks.parts.cameras import some_cameras
from benchmarks.parts.harness import Row, main
from benchmarks.parts.unseen_tables import write_tables
from tamp.execution.settling.settle import settle
from tamp.execution.simulators import make_simulator
from tamp.formats.models import read_symmetries
from tamp.formats.pairs import read_pair
from tamp.perception.belief.observer import Observer
from tamp.perception.cameras.camera import Camera, Frame
from tamp.perception.cameras.capture import shoot, views
from tamp.perception.cameras.setup import load_setup
from tamp.perception.estimate import Estimate
from tamp.perception.estimation.estimator import see
from tamp.perception.evaluation import pose_errors
from tamp.perception.perceiver import load_perceiver
from tamp.perception.rendering.scene import surfaces
from tamp.perception.rendering.surface import Surface
from tamp.perception.workcell.simulated import SimulatedWorkcell
from tamp.pipeline.perceived.knowledge import blindfolded
from tamp.task import Pose, Task, load_robot
from tamp.world.geometry.object_geometry import geometry_of_object
from tamp.world.robot.model import robot_model
from tamp.world.world import World

BOXES = ("1-5-1", "1-5-2", "3-2-1", "4-1-1", "4-2-1", "4-2-2", "4-2-3", "4-2-4")
"""Tables with boxes that hide what is in or behind them."""

SEEN = 100
"""Fewer points than this are no sight of an object."""

FOUND = 0.02
"""An object is found within this of where it is [m]."""

LIMIT_S = 600.0


@dataclass(frozen=True)
class _Hidden:
    """An object that the set-up's views hardly show: its points there, and its errors before and after [m]."""

    name: str
    points: int
    before: float | None
    after: float | None
    confidence: float


def rows(
    quick: bool,
    tasks: Sequence[str],
    seed: int,
    viewpoints: int,
    drawn: int,
    tables_seed: int,
    families: Sequence[str],
    cameras: Sequence[str],
) -> Iterator[Row]:
    """One row for each table, and one for all."""
    data = DATA / "2021"
    if not data.is_dir():
        sys.exit(f"the tasks are not there: {data}")
    looking = some_cameras(load_setup(), cameras, viewpoints)
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) if drawn else data
        drawing = (write_tables(data, folder, (n,), tables_seed, families)[0] for n in range(drawn))
        names = drawing if drawn else tasks or BOXES[: 1 if quick else None]
        everything: list[_Hidden] = []
        for name in names:
            hidden, taken = _measure(folder, name, seed, looking)
            everything += hidden
            print(f"  {name}: {len(hidden)} hidden, {taken} views", flush=True)
            for case in hidden:
                print(f"  {name} {case}", flush=True)
            yield {"table": name, "views": taken, **_row(hidden)}
        yield {"table": "all", "views": "-", **_row(everything)}


def _measure(data: Path, name: str, seed: int, cameras: tuple[Camera, ...]) -> tuple[list[_Hidden], str]:
    models = DATA / "2021" / "models"
    task = read_pair(
        data / "scenes" / f"{name}.yaml",
        data / "targets" / f"{name}.yaml",
        models,
        read_symmetries(models / "models.yaml"),
    )
    looks = surfaces(task, DATA / "2021" / "visual")
    start = settle(task).poses
    points = _points(task, looks, start, cameras, seed)
    if min(points.values()) >= SEEN:
        return [], "-"
    answers: list[Mapping[str, Estimate]] = []
    pictures: list[int] = []
    perceive = load_perceiver("fit")

    def watched(frames: Sequence[Frame], *given: object, **named: object) -> Mapping[str, Estimate]:
        pictures.append(len(frames))
        answers.append(perceive(frames, *given, **named))  # type: ignore[arg-type]
        return answers[-1]

    blind = blindfolded(task)
    world = World(
        robot_model(load_robot(task.robot)), {o.name: geometry_of_object(o) for o in task.objects}, task.table
    )
    with make_simulator("pybullet", task.objects, start, table=task.table, robot=load_robot(task.robot)) as simulator:
        cell = SimulatedWorkcell(simulator, looks, cameras, task.table, seed=seed)
        belief = Observer(cell, blind, looks, world, watched, seed, LIMIT_S).look(wanted=tuple(looks))
        truth = simulator.poses()
    before, after = (pose_errors(found, truth, looks) for found in (answers[0], belief.estimates))
    hidden = [
        _Hidden(n, points[n], before[n].symmetric, after[n].symmetric, after[n].confidence)
        for n in looks
        if points[n] < SEEN
    ]
    return hidden, f"{pictures[0]} + {len(belief.frames) - pictures[0]}"


def _points(
    task: Task, looks: Mapping[str, Surface], poses: Mapping[str, Pose], cameras: Sequence[Camera], seed: int
) -> dict[str, int]:
    """How many points of 4 mm the set-up's own views show of each object."""
    robot = load_robot(task.robot)
    shots = shoot(looks, poses, views(tuple(cameras), robot), robot, table=task.table, seed=seed, masks=True)
    scene = see([shot.frame for shot in shots], task.table)
    labels = None if scene is None else scene.cloud.instances
    return {name: 0 if labels is None else int((labels == i).sum()) for i, name in enumerate(looks)}


def _row(hidden: Sequence[_Hidden]) -> Row:
    found = [sum(e is not None and e < FOUND for e in some) for some in _errors(hidden)]
    shares = [f"{count / len(hidden):.0%}" if hidden else "-" for count in found]
    errors = [e for e in _errors(hidden)[1] if e is not None]
    return {
        "hidden": len(hidden),
        "found_before": shares[0],
        "found_after": shares[1],
        "median_cm": 100 * float(np.median(errors)) if errors else "-",
    }


def _errors(hidden: Sequence[_Hidden]) -> tuple[list[float | None], list[float | None]]:
    return [case.before for case in hidden], [case.after for case in hidden]


def _options() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--tasks", nargs="*", default=(), metavar="NAME", help="only these, such as 4-2-1")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="of the noise and all choices (default 0)")
    parser.add_argument("--viewpoints", type=int, default=0, metavar="N", help="the arm's first N (default all)")
    parser.add_argument("--cameras", nargs="*", default=(), metavar="NAME", help="of OCRTOC's set-up (default all)")
    parser.add_argument("--drawn", type=int, default=0, metavar="N", help="so many drawn tables instead")
    parser.add_argument("--tables-seed", type=int, default=0, metavar="N", help="of those (default 0)")
    parser.add_argument("--families", nargs="*", default=(), metavar="NAME", help="of the drawn ones, such as 4-2")
    return parser


if __name__ == "__main__":
    asked = "60 % of what the set-up's views do not see found within 2 cm"
    main("next_views", lambda quick, **options: list(rows(quick, **options)), extra=_options(), asked=asked)
