"""What physics has at rest, the checker lets rest: starts and goals of many tables, settled in the simulator.

Each object of each settled scene is asked about as the checker asks after a release. `refused` would be sent back if a
plan put it there, although it rests; `unseen` counts pairs of which the simulator has one carry the other and the
checker does not. The tables are OCRTOC's public ones, and those of `benchmarks.unseen`.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

from benchmarks.ocrtoc import DATA
from benchmarks.parts.harness import Row, main
from benchmarks.parts.unseen_tables import family, write_tables
from tamp.checking.physics.giving_way import on_edge
from tamp.checking.physics.round_bodies.perching import on_rollers, perched
from tamp.checking.physics.round_bodies.rocking import rocked
from tamp.checking.physics.stacks import off_balance, stack_of
from tamp.checking.physics.support import carriers, unrest
from tamp.checking.scene import Scene, State
from tamp.checking.tolerances import DEFAULT
from tamp.execution.settling.cache import settle_once
from tamp.formats.pairs import read_pair
from tamp.task import At

COUNT, QUICK = 200, 4
"""Drawn tables."""


def rows(quick: bool, count: int | None, tables_seed: int, workers: int, output: Path | None) -> Iterator[Row]:
    """One row for each family, drawn and public; what is refused is printed as it comes."""
    data = DATA / "2021"
    if not data.is_dir():
        sys.exit(f"OCRTOC's models are not there: {data}")
    with tempfile.TemporaryDirectory() as scratch:
        folder = output or Path(scratch)
        names = write_tables(data, folder, range(count or (QUICK if quick else COUNT)), tables_seed)
        public = sorted((data / "scenes").glob("*.yaml"))[: QUICK if quick else None]
        drawn = [folder / "scenes" / f"{name}.yaml" for name in names]
        with ProcessPoolExecutor(workers) as pool:
            for kind, scenes in (("drawn", drawn), ("public", public)):
                yield from _by_family(kind, scenes, list(pool.map(judged, scenes)))


def _by_family(kind: str, scenes: list[Path], found: list[Row]) -> Iterator[Row]:
    for name in sorted({family(scene.stem) for scene in scenes}):
        mine = [row for scene, row in zip(scenes, found, strict=True) if family(scene.stem) == name]
        yield {"tables": f"{kind} {name}", **{key: sum(row[key] for row in mine) for key in mine[0]}}
    yield {"tables": f"{kind}, all", **{key: sum(row[key] for row in found) for key in found[0]}}


def judged(path: Path) -> Row:
    """How many objects of a task's two settled scenes there are, and what the checker says of them."""
    folder = path.parent.parent
    task = read_pair(path, folder / "targets" / path.name, folder / "models", {})
    counts = {"objects": 0, "refused": 0, "pairs": 0, "unseen": 0}
    goals = {item.name: item.goal.pose for item in task.objects if isinstance(item.goal, At)}
    for end, poses in (("start", {item.name: item.pose for item in task.objects}), ("goal", goals)):
        rest = settle_once(task, poses)
        if not rest.resting:
            continue
        scene = Scene.of(task)
        state = State({name: pose.matrix for name, pose in rest.poses.items()}, np.zeros(0))
        for name in rest.poses:
            said = next(_refusals(scene, state, name), None)
            counts["objects"] += 1
            counts["refused"] += said is not None
            if said is not None:
                print(f"{task.name}, {end}: {said[0]}", flush=True)
            below = carriers(scene, state, name, DEFAULT).bodies
            counts["pairs"] += len(pairs := [carrier for above, carrier in rest.supports if above == name])
            counts["unseen"] += sum(carrier not in below for carrier in pairs)
    return counts


def _refusals(scene: Scene, state: State, name: str) -> Iterator[tuple[str, ...]]:
    """What the checker would say of an object that a plan put where it is, as far as that is about it alone."""
    yield from ((sentence,) for sentence, _, _ in unrest(scene, state, name, DEFAULT))
    yield from ((sentence,) for sentence, _ in perched(scene, state, name, DEFAULT))
    yield from ((sentence,) for sentence, _ in on_rollers(scene, state, name, DEFAULT))
    yield from ((sentence,) for sentence, _ in rocked(scene, state, [name], DEFAULT))
    stack = stack_of(scene, state, name, DEFAULT)
    for other, far in off_balance(scene, state, stack).items():
        if other == name and far > DEFAULT.balance:
            yield (f"{name} is {1000 * far:.0f} mm off balance among {', '.join(stack.names)}",)
    if on_edge(scene, state, name, DEFAULT):
        yield (f"{name} stands on the very edge of what carries it",)


def _options() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--count", type=int, metavar="N", help=f"drawn tables (default {COUNT})")
    parser.add_argument("--tables-seed", type=int, default=0, metavar="N", help="of the tables (default 0)")
    parser.add_argument("--workers", type=int, default=1, metavar="N", help="processes (default 1)")
    parser.add_argument("--output", type=Path, metavar="DIR", help="keep the tables there")
    return parser


if __name__ == "__main__":
    main("at_rest", lambda quick, **options: list(rows(quick, **options)), extra=_options())
