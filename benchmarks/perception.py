"""Poses estimated from OCRTOC 2021's two cameras: recall, error, time and honesty, with masks and without.

The start scene of each task settles, is rendered with the sensors' noise, and given to the perceiver; only objects of
which at least 100 points of 4 mm were seen are counted. Errors are EDE over the mesh's own symmetries, and raw. With
--drawn the tables are those of `benchmarks.parts.unseen_tables`, which nobody has tuned for, after what --tasks names.
With --cameras only these look, with --viewpoints from their first viewpoints alone. Honesty is asked of every pose
that is said, also of what hardly shows; what is not found is no estimate.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from benchmarks.ocrtoc import DATA
from benchmarks.parts.cameras import some_cameras
from benchmarks.parts.harness import Row, main
from benchmarks.parts.unseen_tables import write_tables
from tamp.execution.settling.settle import settle
from tamp.formats.models import read_symmetries
from tamp.formats.pairs import read_pair
from tamp.perception.cameras.camera import Camera
from tamp.perception.cameras.capture import shoot, views
from tamp.perception.cameras.setup import load_setup
from tamp.perception.estimation.estimator import see
from tamp.perception.estimation.models.object_model import object_model
from tamp.perception.evaluation import PoseError, pose_errors
from tamp.perception.perceiver import Perceiver, load_perceiver
from tamp.perception.rendering.scene import surfaces
from tamp.task import load_robot

TUNED = ("1-1-1", "1-4-1", "2-1-1", "4-2-1", "5-1-1", "6-2-1")
UNSEEN = (
    "1-5-1", "2-2-1", "3-1-1", "4-3-1", "6-1-1", "6-3-1", "1-2-1", "1-3-1", "3-2-1", "3-3-1", "4-1-1", "5-2-1", "5-3-1",
    "2-1-2", "3-1-2", "4-1-2", "5-1-2", "6-1-2",
)  # fmt: skip
"""Tasks that the perceiver was tuned on, and tasks that it was not."""
SEEN = 100
"""Fewer points than this are no sight of an object."""

UNCERTAIN = 0.3
"""An estimate of lower confidence is said to be uncertain."""


@dataclass(frozen=True)
class _Case:
    """One object in one scene."""

    error: PoseError
    points: int
    colored: bool


def rows(
    quick: bool,
    tasks: Sequence[str],
    seeds: Sequence[int],
    regimes: Sequence[str],
    perceiver: str,
    drawn: int,
    tables_seed: int,
    cameras: Sequence[str],
    viewpoints: int,
) -> Iterator[Row]:
    """One row for each task, seed and regime, and one for all of a regime."""
    data = DATA / "2021"
    if not data.is_dir():
        sys.exit(f"the tasks are not there: {data}")
    public = tasks or (() if drawn else TUNED[:1] if quick else (*TUNED, *UNSEEN))
    looking = some_cameras(load_setup(), cameras, viewpoints)
    with tempfile.TemporaryDirectory() as scratch:
        new = write_tables(data, Path(scratch), range(drawn), tables_seed) if drawn else ()
        tables = [*((data, name) for name in public), *((Path(scratch), name) for name in new)]
        yield from _of_tables(tables, seeds, regimes, perceiver, looking)


def _of_tables(
    tables: Sequence[tuple[Path, str]],
    seeds: Sequence[int],
    regimes: Sequence[str],
    perceiver: str,
    cameras: tuple[Camera, ...],
) -> Iterator[Row]:
    function = load_perceiver(perceiver)
    for regime in regimes:
        everything: list[_Case] = []
        spent = objects = 0.0
        for data, task in tables:
            for seed in seeds:
                cases, seconds = _measure(data, task, seed, regime == "masks", function, cameras)
                everything += cases
                spent, objects = spent + seconds, objects + len(cases)
                yield {"task": task, "seed": seed, "regime": regime, **_row(cases, seconds / len(cases))}
        yield {"task": "all", "regime": regime, **_row(everything, spent / max(objects, 1))}


def _measure(
    data: Path, name: str, seed: int, masks: bool, function: Perceiver, cameras: tuple[Camera, ...]
) -> tuple[list[_Case], float]:
    models = data / "models"
    symmetries = read_symmetries(models / "models.yaml")
    task = read_pair(data / "scenes" / f"{name}.yaml", data / "targets" / f"{name}.yaml", models, symmetries)
    robot, poses = load_robot(task.robot), settle(task).poses
    looks = surfaces(task, data / "visual")
    shots = shoot(looks, poses, views(cameras, robot), robot, table=task.table, seed=seed, masks=True)
    labelled = [shot.frame for shot in shots]
    scene = see(labelled, task.table)
    labels = np.array([]) if scene is None or scene.cloud.instances is None else scene.cloud.instances
    frames = labelled if masks else [replace(frame, instances=None) for frame in labelled]
    for surface in looks.values():
        object_model(surface)  # once for a mesh, not for a scene
    start = time.process_time()
    found = function(frames, looks, table=task.table, seed=seed)
    seconds = time.process_time() - start
    errors = pose_errors(found, poses, looks)
    cases = [
        _Case(errors[name], int((labels == i).sum()), surface.colored)
        for i, (name, surface) in enumerate(looks.items())
    ]
    for name, case in zip(looks, cases, strict=True):
        print(f"  {task.name} {name}: {case}", flush=True)
    return cases, seconds


def _row(cases: Sequence[_Case], seconds: float) -> Row:
    """What the issue asks for, of the objects that were seen; honesty of all poses that were said."""
    seen = [case for case in cases if case.points >= SEEN]
    far = 10.0
    errors = [far if c.error.symmetric is None else c.error.symmetric for c in seen]
    raw = [far if c.error.raw is None else c.error.raw for c in seen if c.colored]
    said = [(c.error.symmetric, c.error.confidence) for c in cases if c.error.symmetric is not None]
    wrong, right = ([c for e, c in said if e > 0.05], [c for e, c in said if e < 0.02])
    return {
        "objects": len(cases),
        "seen": len(seen),
        "recall_1cm": _share(sum(e < 0.01 for e in errors), len(seen)),
        "recall_2cm": _share(sum(e < 0.02 for e in errors), len(seen)),
        "median_cm": 100 * float(np.median(errors)) if errors else "-",
        "raw_1cm": _share(sum(e < 0.01 for e in raw), len(raw)),
        "not_found": sum(c.error.symmetric is None for c in seen),
        "over_5cm": len(wrong),
        "doubted": _share(sum(c < UNCERTAIN for c in wrong), len(wrong)),
        "right": len(right),
        "right_trusted": _share(sum(c >= UNCERTAIN for c in right), len(right)),
        "cpu_s": seconds,
    }


def _share(part: int, whole: int) -> str:
    return f"{part / whole:.0%}" if whole else "-"


def _options() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--tasks", nargs="*", default=(), metavar="NAME", help="only these, such as 1-1-1")
    parser.add_argument("--seed", dest="seeds", type=int, nargs="*", default=(0,), metavar="N", help="of the noise")
    parser.add_argument("--regimes", nargs="*", choices=("masks", "none"), default=("none", "masks"))
    parser.add_argument("--drawn", type=int, default=0, metavar="N", help="so many drawn tables, too; alone: instead")
    parser.add_argument("--tables-seed", type=int, default=0, metavar="N", help="of those (default 0)")
    parser.add_argument("--cameras", nargs="*", default=(), metavar="NAME", help="of OCRTOC's set-up (default all)")
    parser.add_argument("--viewpoints", type=int, default=0, metavar="N", help="the arm's first N (default all)")
    parser.add_argument("--perceiver", default="fit", metavar="NAME", help="a name or package.module:function")
    return parser


if __name__ == "__main__":
    main("perception", lambda quick, **options: list(rows(quick, **options)), extra=_options())
