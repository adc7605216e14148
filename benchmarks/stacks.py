"""Random heaps of boxes, cans and balls: is the checker's word on what stays also that of two simulators?

Each scene is dropped body by body and settled in PyBullet, and kept where the checker lets it start and MuJoCo leaves
it as it is. Of it each body is taken away once, and a few others are put where they come down first. Both simulators
then say how far anything moves. `wrong` is what the checker accepts though in both of them something goes by 2 cm at
least, or never rests; `refused` what it refuses though in both of them nothing goes by 4 mm; `falls` and `stays` are
what it has right. What they disagree on, or what moves by less, is not held against it (`half`). Of placements that it
refuses only a share is asked of the simulators.

`--output FILE` keeps every case with what the simulators said; `--again FILE` asks the checker of this revision about
them, without a simulator.
"""

from __future__ import annotations

import argparse
import json
import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.parts.harness import Row, main
from tamp.checking.actions.left_standing import check_rest, check_uncovered
from tamp.checking.geometry.solids import clearance
from tamp.checking.geometry.transforms import inverse
from tamp.checking.replay import Replay
from tamp.checking.scene import TABLE, Scene, State
from tamp.checking.start_and_goals import check_start
from tamp.checking.tolerances import DEFAULT
from tamp.execution.settling.settle import let_fall
from tamp.task import Box, Cylinder, Object, Pose, Shape, Sphere, Table, Task, load_robot

Array = NDArray[np.float64]

SCENES, QUICK = 300, 12
SIMULATORS = ("pybullet", "mujoco")
GONE, STAYS, STILL = 0.02, 0.004, 0.008
"""What is wrong moves farther, what is right less far, and what is a scene to begin with less far [m]."""
PLACED = 4
"""Placements tried in each scene."""
ASKED = 0.3
"""Share of refused placements that the simulators are asked about."""
LEANING = 0.35
"""Share of slabs, dominoes and columns that are dropped askew."""
FIRM = 2e-4
"""Bodies are dropped from so little above what they first touch [m]."""


@dataclass(frozen=True)
class Case:
    """A change to a scene at rest.

    Attributes:
        scene: number of the scene.
        change: "removal" or "placement".
        name: the object that is taken away, or put.
        objects: all of them where they stand, that one included.
        ways: how far anything moves then, in each simulator [m]; infinite where it never rests.
        said: what the checker says against it.
    """

    scene: int
    change: str
    name: str
    objects: tuple[Object, ...]
    ways: Mapping[str, float]
    said: tuple[str, ...]

    @property
    def word(self) -> str:
        """How the checker's word compares with those of the simulators."""
        if not self.ways:
            return "not asked"
        if all(way > GONE for way in self.ways.values()):
            return "wrong" if not self.said else "falls"
        if all(way < STAYS for way in self.ways.values()):
            return "refused" if self.said else "stays"
        return "half"


def rows(
    quick: bool, count: int | None, seed: int, workers: int, output: Path | None, again: Path | None
) -> Iterator[Row]:
    """One row for removals, one for placements; what is wrong or refused is printed as it comes."""
    if again is not None:
        found: Iterable[Case] = map(_judged_again, map(_read, again.read_text(encoding="utf-8").splitlines()))
        yield from _counted(found)
        return
    numbers = range(count or (QUICK if quick else SCENES))
    with ProcessPoolExecutor(workers) as pool:
        found = (case for cases in pool.map(partial(cases_of, seed), numbers) for case in cases)
        yield from _counted(_kept(found, output))


def _counted(cases: Iterable[Case]) -> Iterator[Row]:
    words = {"removal": Counter[str](), "placement": Counter[str]()}
    for case in cases:
        words[case.change][case.word] += 1
        if case.word in ("wrong", "refused"):
            ways = ", ".join(f"{1000 * way:.0f}" for way in case.ways.values())
            print(f"{case.word} {case.change} {case.scene} {case.name}: {ways} mm. {'; '.join(case.said)}", flush=True)
    for change, count in words.items():
        columns = ("wrong", "falls", "stays", "refused", "half", "not asked")
        yield {"change": change, "cases": count.total(), **{word: count[word] for word in columns}}


def _kept(cases: Iterable[Case], output: Path | None) -> Iterator[Case]:
    """The same, each written to a line of a file."""
    if output is None:
        yield from cases
        return
    with output.open("w", encoding="utf-8") as file:
        for case in cases:
            file.write(json.dumps(_record(case)) + "\n")
            yield case


def cases_of(seed: int, number: int) -> list[Case]:
    """All that is tried in one random scene; nothing where that is not at rest for everybody."""
    rng = np.random.default_rng((seed, number))
    objects = _heap(rng)
    if len(objects) < 2 or _refused_at_first(objects) or max(_ways(objects).values()) > STILL:
        return []
    found = []
    for each in objects:
        others = tuple(other for other in objects if other is not each)
        found.append(Case(number, "removal", each.name, objects, _ways(others), judged(objects, each.name, "removal")))
    for index in range(PLACED):
        more = _lowered(objects, _drawn(rng, objects, 100 + index))
        together = (*objects, more)
        said = judged(together, more.name, "placement")
        ways = _ways(together) if not said or rng.random() < ASKED else {}
        found.append(Case(number, "placement", more.name, together, ways, said))
    return found


def judged(objects: Sequence[Object], name: str, change: str) -> tuple[str, ...]:
    """What the checker says where an object is taken from among others, or has come there."""
    scene, sentences = Scene.of(Task("heap", tuple(objects))), list[str]()
    check: Callable[..., None] = check_uncovered if change == "removal" else check_rest
    check(scene, _state(objects), name, DEFAULT, lambda kind, sentence, **_: sentences.append(sentence))
    return tuple(sentences)


def _judged_again(case: Case) -> Case:
    return replace(case, said=judged(case.objects, case.name, case.change))


def _refused_at_first(objects: Sequence[Object]) -> bool:
    replay = Replay(Scene.of(Task("heap", tuple(objects))), _state(objects), DEFAULT)
    check_start(replay, None)
    return bool(replay.problems)


def _state(objects: Sequence[Object]) -> State:
    robot = load_robot("panda")
    return State({o.name: o.pose.matrix for o in objects}, np.array(robot.home), robot.gripper.stroke)


def _ways(objects: Sequence[Object]) -> dict[str, float]:
    """How far anything moves as all are let go, in each simulator [m]."""
    poses, found = {o.name: o.pose for o in objects}, {}
    for simulator in SIMULATORS:
        ends = let_fall(objects, poses, table=Table(), simulator=simulator)
        found[simulator] = math.inf if ends is None else max(_way(o, ends[o.name]) for o in objects)
    return found


def _way(thing: Object, end: Pose) -> float:
    """How far an object has gone, turns about the axis of what is round left out [m]."""
    A, B = thing.pose.matrix, end.matrix
    far = float(np.linalg.norm(A[:3, 3] - B[:3, 3]))
    if isinstance(thing.shape, Sphere):
        return far
    if isinstance(thing.shape, Cylinder):
        cosine, half = abs(float(A[:3, 2] @ B[:3, 2])), max(thing.shape.height / 2, thing.shape.radius)
    else:
        cosine, half = (float(np.trace(A[:3, :3].T @ B[:3, :3])) - 1.0) / 2.0, max(_sizes(thing.shape)) / 2
    return max(far, 0.6 * half * float(np.arccos(np.clip(cosine, -1.0, 1.0))))


def _heap(rng: np.random.Generator) -> tuple[Object, ...]:
    """Two to six bodies, dropped one after the other and settled."""
    objects: tuple[Object, ...] = ()
    for index in range(int(rng.integers(2, 7))):
        more = (*objects, _lowered(objects, _drawn(rng, objects, index)))
        ends = let_fall(more, {o.name: o.pose for o in more}, table=Table())
        if ends is not None and all(end.xyz[2] > 0.0 for end in ends.values()):
            objects = tuple(replace(o, pose=ends[o.name]) for o in more)
    return objects


def _drawn(rng: np.random.Generator, objects: Sequence[Object], index: int) -> Object:
    """Something above the table, or above one of what is there."""
    shape = _shape(rng)
    x, y = rng.uniform(-0.05, 0.12), rng.uniform(-0.12, 0.12)
    if objects and rng.random() > LEANING:
        x, y = np.array(objects[int(rng.integers(len(objects)))].pose.xyz[:2]) + rng.normal(0.0, 0.035, 2)
    rpy = [0.0, 0.0, float(rng.choice([0.0, np.pi / 2, rng.uniform(0.0, np.pi)]))]
    if isinstance(shape, Cylinder) and rng.random() < 0.5:
        rpy[0] = np.pi / 2
    elif not isinstance(shape, Sphere) and rng.random() < LEANING:
        rpy[int(rng.integers(2))] += rng.uniform(-0.6, 0.6)
    mass = float(np.exp(rng.uniform(np.log(0.03), np.log(1.5))))
    pose = Pose.from_rpy((float(x), float(y), 0.0), (rpy[0], rpy[1], rpy[2]))
    return Object(f"o{index}", shape, pose, mass=mass, friction=float(rng.choice([0.3, 0.5, 0.8, 1.0])))


def _shape(rng: np.random.Generator) -> Shape:
    def within(*bounds: tuple[float, float]) -> list[float]:
        return [float(rng.uniform(*bound)) for bound in bounds]

    slab = Box((*within((0.08, 0.25), (0.03, 0.12), (0.008, 0.03)),))  # type: ignore[arg-type]
    domino = Box((*within((0.006, 0.025), (0.03, 0.08), (0.06, 0.2)),))  # type: ignore[arg-type]
    cube = Box((*within((0.02, 0.06), (0.02, 0.06), (0.02, 0.08)),))  # type: ignore[arg-type]
    column, can = Cylinder(*within((0.01, 0.03), (0.03, 0.12))), Cylinder(*within((0.015, 0.035), (0.04, 0.12)))
    shapes: list[Shape] = [slab, slab, domino, domino, cube, cube, column, can, Sphere(*within((0.015, 0.035)))]
    return shapes[int(rng.integers(len(shapes)))]


def _lowered(objects: Sequence[Object], thing: Object) -> Object:
    """The same where it first touches something as it comes straight down."""
    scene = Scene.of(Task("heap", (*objects, thing)))
    standing = {TABLE: scene.T_world_table, **{o.name: o.pose.matrix for o in objects}}
    T = thing.pose.matrix.copy()
    T[2, 3] = 0.6
    while True:
        apart = min(
            clearance(scene.solids[name], scene.solids[thing.name], inverse(at) @ T, 0.05)
            for name, at in standing.items()
        )
        if apart < FIRM:
            return replace(thing, pose=Pose.from_matrix(T))
        T[2, 3] -= max(min(apart, 0.05) - FIRM / 2, FIRM / 2)


def _sizes(shape: Shape) -> list[float]:
    if isinstance(shape, Box):
        return list(shape.size)
    return [shape.radius, shape.height] if isinstance(shape, Cylinder) else [shape.radius]  # type: ignore[union-attr]


def _record(case: Case) -> dict[str, Any]:
    ways = {name: (None if math.isinf(way) else way) for name, way in case.ways.items()}
    objects = [
        [o.name, type(o.shape).__name__, _sizes(o.shape), o.pose.xyz, o.pose.quat, o.mass, o.friction]
        for o in case.objects
    ]
    return {**vars(case), "objects": objects, "ways": ways}


def _read(line: str) -> Case:
    record = json.loads(line)
    objects = []
    for name, kind, sizes, xyz, quat, mass, friction in record["objects"]:
        shape: Shape = {"Box": lambda *size: Box(size), "Cylinder": Cylinder, "Sphere": Sphere}[kind](*sizes)
        objects.append(Object(name, shape, Pose(tuple(xyz), tuple(quat)), mass=mass, friction=friction))
    ways = {name: (math.inf if way is None else way) for name, way in record["ways"].items()}
    return Case(**{**record, "objects": tuple(objects), "ways": ways, "said": tuple(record["said"])})


def _options() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--count", type=int, metavar="N", help=f"scenes (default {SCENES})")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="of the scenes (default 0)")
    parser.add_argument("--workers", type=int, default=1, metavar="N", help="processes (default 1)")
    parser.add_argument("--output", type=Path, metavar="FILE", help="keep all cases there")
    parser.add_argument("--again", type=Path, metavar="FILE", help="ask about the cases of such a file again")
    return parser


if __name__ == "__main__":
    main("stacks", lambda quick, **options: list(rows(quick, **options)), extra=_options())
