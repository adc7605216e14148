"""Tables that nobody has tuned for, in the manner of OCRTOC 2021: its own tasks with other models, elsewhere, settled.

A table is drawn from a public task. Each object may give way to another of its kind (a can to a can, a clamp to a
clamp); what touches at the start, or at the goal, moves as one group to another spot and another heading; what lies in
a crate is dropped into it anew, in another order. Physics lets both scenes settle, and poses are rounded to 0.01 as the
contest's are, so that some objects overlap a little. A draw is dropped where something does not stay as it was meant.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import yaml
from numpy.typing import NDArray

from tamp.execution.settling.settle import settle
from tamp.formats.angles import roll_pitch_yaw
from tamp.formats.models import COLLISION, model_name, read_symmetries
from tamp.formats.pairs import read_pairs
from tamp.generate.placement.contact import hits, lowered
from tamp.generate.placement.object_model import Thing, transform, yawed
from tamp.generate.reach import base, reachable
from tamp.task import At, Mesh, Object, Pose, Table, Task
from tamp.world.geometry.convex_union import solid
from tamp.world.geometry.object_geometry import geometry_of_object

Array = NDArray[np.float64]
Placed = dict[str, Array]
"""Object -> pose, shape (4, 4)."""

KINDS = (
    ("suger_1", "suger_2", "suger_3"),
    ("potato_chip_1", "potato_chip_2", "potato_chip_3"),
    ("orion_pie", "lipton_tea"),
    ("cracker_box", "sugar_box"),
    ("gelatin_box", "pudding_box"),
    ("poker_1", "soap"),
    ("remote_controller_1", "remote_controller_2"),
    ("blue_cup", "yellow_cup", "orange_cup", "green_cup", "mug"),
    ("blue_tea_box", "pink_tea_box"),
    ("plastic_apple", "plastic_orange", "plastic_peach", "plastic_plum", "plastic_lemon", "plastic_strawberry"),
    ("green_bowl", "yellow_bowl"),
    ("square_plate_1", "square_plate_2", "square_plate_3", "square_plate_4"),
    ("round_plate_1", "round_plate_2", "round_plate_3", "round_plate_4"),
    ("blue_plate", "grey_plate"),
    ("flat_screwdriver", "phillips_screwdriver"),
    ("extra_large_clamp", "large_clamp", "medium_clamp", "small_clamp"),
    ("mini_claw_hammer_1", "two_color_hammer"),
    ("fork", "knife", "spoon"),
    ("large_marker", "small_marker", "red_marker", "black_marker", "blue_marker"),
    ("bleach_cleanser", "blue_moon", "cleanser", "magic_clean", "conditioner", "repellent", "glue_2"),
    ("book_1", "book_2", "book_3"),
    ("book_4", "book_5", "book_6"),
)
"""Models that stand in for each other."""

CRATES = ("clear_box", "clear_box_1", "clear_box_2")
WALL = 0.02
"""How far from a crate's walls the middle of what is dropped into it stays, besides half of its least side [m]."""
APART = 0.01
"""Least room between groups [m]."""
DEEP = 0.003
"""What is deeper in others where a public task has it is let down onto them instead [m]."""
SAME = 0.02
"""What is nearer than this to its goal in a public task stays where it is [m]."""
SLIPS, TURNS = 0.03, 0.35
"""How far settling may move and turn what does not lie in a crate [m], [rad]."""
SPOTS, SCENES, TABLES = 60, 6, 60
"""Draws of a group's spot, of a scene, of a table, before the next greater is drawn anew."""


@dataclass(frozen=True, eq=False)
class Scene:
    """A public scene at rest.

    Attributes:
        poses: object -> pose, shape (4, 4).
        groups: objects that touch, each group from the lowest up.
    """

    poses: Mapping[str, Array]
    groups: tuple[tuple[str, ...], ...]


def family(task: str) -> str:
    """The set of a public or a drawn task: "4-3" of "4-3-2"."""
    return "-".join(task.split("-")[:2])


def write_tables(
    data: Path, folder: Path, numbers: Sequence[int], seed: int, families: Collection[str] = ()
) -> list[str]:
    """Write `folder`/scenes, targets and models as OCRTOC 2021 has them, and return the names of the tables.

    Args:
        data: OCRTOC 2021.
        folder: a new one, or one with tables of the same seed, which are kept.
        numbers: of the tables; families take turns.
        seed: the same seed and number, the same table, of the same families.
        families: those that take turns, as "4-3"; none is all of more than one object.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for name in ("models", "visual"):
        if not (folder / name).exists():
            (folder / name).symlink_to((data / name).resolve())
    public = read_pairs(data)
    known = sorted({family(task.name) for task in public if len(task.objects) > 1})
    if unknown := sorted(set(families) - set(known)):
        sys.exit(f"no family of tables is called {unknown[0]!r}; there are: {', '.join(known)}")
    turns = [name for name in known if not families or name in families]
    names = [f"{turns[number % len(turns)]}-u{number:03d}" for number in numbers]
    for number, name in zip(numbers, names, strict=True):
        if not (folder / "targets" / f"{name}.yaml").exists():
            likes = [task for task in public if family(task.name) == family(name)]
            _write(draw_table(name, likes, data / "models", np.random.default_rng((seed, number))), folder)
    return names


def draw_table(name: str, likes: Sequence[Task], models: Path, rng: np.random.Generator) -> Task:
    """A table like one of the public tasks given.

    Raises:
        RuntimeError: where no draw stays as it was meant.
    """
    for _ in range(TABLES):
        like = likes[rng.integers(len(likes))]
        task = _substituted(like, models, rng)
        start = _scene(task, _settled(like, "start"), {}, rng)
        if start is None:
            continue
        fixed = {o.name: start[o.name] for o in like.objects if _stays(o)}
        goal = _scene(task, _settled(like, "goal"), fixed, rng)
        if goal is not None:
            ends = {o: (Pose.from_matrix(start[o]), At(Pose.from_matrix(goal[o]))) for o in start}
            objects = [replace(o, pose=ends[o.name][0], goal=ends[o.name][1]) for o in task.objects]
            return replace(task, name=name, objects=tuple(objects))
    raise RuntimeError(f"{name}: no table in {TABLES} draws")


def _stays(item: Object) -> bool:
    assert isinstance(item.goal, At)
    return math.dist(item.pose.xyz, item.goal.pose.xyz) < SAME


def _substituted(task: Task, models: Path, rng: np.random.Generator) -> Task:
    """Each object another of its kind, or itself; objects keep the names that they have in the public task."""
    symmetries = read_symmetries(models / "models.yaml")
    taken: set[str] = set()
    objects = []
    for item in task.objects:
        model = _model(item)
        kind = next((kind for kind in KINDS if model in kind), (model,))
        others = [name for name in kind if name not in taken and (models / name / COLLISION).exists()]
        chosen = str(rng.choice(others)) if others else model
        taken.add(chosen)
        shape, symmetry = Mesh(models / chosen / COLLISION), symmetries.get(chosen, item.symmetry)
        objects.append(replace(item, shape=shape, symmetry=symmetry))
    return replace(task, objects=tuple(objects))


def _model(item: Object) -> str:
    assert isinstance(item.shape, Mesh)
    return model_name(item.shape)


def _settled(task: Task, end: str) -> Scene:
    """The start or the goal of a public task at rest, in groups."""
    poses = {o.name: o.pose if end == "start" else _goal(o) for o in task.objects}
    rest = settle(task, poses)
    root = {name: name for name in poses}
    for above, below in rest.supports:
        if below in root:
            joined, old = root[below], root[above]
            root = {name: joined if of == old else of for name, of in root.items()}
    bottom = {o.name: _thing(o).bottom(rest.poses[o.name].matrix[:3, :3]) for o in task.objects}
    low = {name: rest.poses[name].xyz[2] + bottom[name] for name in root}
    low |= {o.name: -1.0 for o in task.objects if _model(o) in CRATES}
    groups = [sorted((n for n in root if root[n] == of), key=low.__getitem__) for of in sorted({*root.values()})]
    return Scene({name: pose.matrix for name, pose in rest.poses.items()}, tuple(map(tuple, groups)))


def _goal(item: Object) -> Pose:
    assert isinstance(item.goal, At)
    return item.goal.pose


def _scene(task: Task, like: Scene, fixed: Mapping[str, Array], rng: np.random.Generator) -> Placed | None:
    """The scene with the task's models, its groups elsewhere, at rest and rounded; None where no draw stays."""
    things = {o.name: _thing(o) for o in task.objects}
    crates = {o.name for o in task.objects if _model(o) in CRATES}
    for _ in range(SCENES):
        drawn: Placed = {}
        for group in sorted(like.groups, key=lambda names: (not fixed.keys() & {*names}, -len(names))):
            placed = next(_spots(group, like, things, crates, fixed, drawn, rng), None)
            if placed is None:
                break
            drawn |= placed
        else:
            rest = settle(task, {name: Pose.from_matrix(T) for name, T in drawn.items()})
            end = {name: pose.matrix for name, pose in rest.poses.items()}
            loose = {name for group in like.groups if crates & {*group} for name in group} - crates
            if rest.resting and all(_kept(drawn[n], end[n], n in loose) for n in end) and _in_reach(things, end):
                return {name: _rounded(T) for name, T in end.items()}
    return None


def _thing(item: Object) -> Thing:
    """The geometry of an object; its ways to rest are not asked for."""
    geometry = geometry_of_object(item)
    return Thing(None, solid(geometry.parts), geometry.hull.vertices, ())  # type: ignore[arg-type]


def _spots(
    group: Sequence[str],
    like: Scene,
    things: Mapping[str, Thing],
    crates: set[str],
    fixed: Mapping[str, Array],
    drawn: Placed,
    rng: np.random.Generator,
) -> Iterator[Placed]:
    """The group at spots drawn anew, clear of what is there, on the table and within reach."""
    root = next((name for name in group if name in fixed), group[0])
    middle = like.poses[root][:2, 3]
    for _ in range(SPOTS):
        if root in fixed:
            R = fixed[root][:3, :3] @ like.poses[root][:3, :3].T
            turn, spot = math.atan2(R[1, 0], R[0, 0]), fixed[root][:2, 3]
        else:
            turn = float(rng.integers(4) * math.pi / 2 + (rng.uniform(-0.8, 0.8) if rng.random() < 0.5 else 0.0))
            spot = np.array(base()) + rng.uniform((0.1, -0.65), (0.68, 0.65))
        turned = yawed(np.eye(3), turn)
        placed: Placed = {}
        loose = {*group[1:]} if group[0] in crates else set()
        for name in [group[0], *(rng.permutation(group[1:]) if loose else group[1:])]:
            R, over = turned @ like.poses[name][:3, :3], spot + turned[:2, :2] @ (like.poses[name][:2, 3] - middle)
            if name in loose:
                R, over = _dropped(things[name], R, things[group[0]], placed[group[0]], rng)
            others = [(things[o], T) for o, T in placed.items()]
            height = float(like.poses[name][2, 3]) if others else -things[name].bottom(R)
            placed[name] = transform(R, (float(over[0]), float(over[1]), height))
            if others and (name in loose or hits(things[name], placed[name], others, -DEEP)):
                placed[name] = lowered(things[name], R, over, others)
        there = [(things[o], T) for o, T in drawn.items()]
        clear = not any(hits(things[name], T, there, APART) for name, T in placed.items())
        if clear and _in_reach(things, placed):
            yield placed


def _dropped(thing: Thing, R: Array, crate: Thing, T_crate: Array, rng: np.random.Generator) -> tuple[Array, Array]:
    """A heading and a point over a crate's floor for what is dropped into it."""
    R = yawed(R, float(rng.uniform(-math.pi, math.pi)))
    sides = np.ptp(crate.points, axis=0)[:2] / 2 - WALL
    room = np.maximum(0.0, sides - thing.outline(R)[:2].min() / 2)
    middle = (crate.points.max(axis=0) + crate.points.min(axis=0)) / 2
    inside = np.array([*(middle[:2] + rng.uniform(-room, room)), 0.0])
    center = R @ (thing.points.max(axis=0) + thing.points.min(axis=0)) / 2
    over: Array = (T_crate[:3, :3] @ inside + T_crate[:3, 3] - center)[:2]
    return R, over


def _kept(drawn: Array, end: Array, loose: bool) -> bool:
    """Whether settling left something as it was meant; what was dropped into a crate may roll."""
    moved = float(np.linalg.norm(end[:3, 3] - drawn[:3, 3]))
    turned = math.acos(float(np.clip((np.trace(drawn[:3, :3].T @ end[:3, :3]) - 1) / 2, -1.0, 1.0)))
    return moved < 0.2 if loose else moved < SLIPS and turned < TURNS


def _in_reach(things: Mapping[str, Thing], poses: Placed) -> bool:
    """Whether everything is over the table, and where the hand comes down to it."""
    return all(_over_table(things[name], T) and reachable(things[name], T) for name, T in poses.items())


def _over_table(thing: Thing, T: Array) -> bool:
    table, points = Table(), thing.points @ T[:2, :3].T + T[:2, 3]
    return bool((np.abs(points - np.array(table.center)) < np.array(table.size) / 2).all())


def _rounded(T: Array) -> Array:
    pose = Pose.from_matrix(T)
    rows = [round(value, 2) for value in (*pose.xyz, *roll_pitch_yaw(pose))]
    matrix: Array = Pose.from_rpy(rows[:3], rows[3:]).matrix
    return matrix


def _write(task: Task, folder: Path) -> None:
    """The pair of files of a table, `model: list of [x, y, z, roll, pitch, yaw]`."""
    for end in ("scenes", "targets"):
        rows: dict[str, list[list[float]]] = {}
        for item in task.objects:
            pose = item.pose if end == "scenes" else _goal(item)
            row = [round(float(value), 2) for value in (*pose.xyz, *roll_pitch_yaw(pose))]
            rows.setdefault(_model(item), []).append(row)
        path = folder / end / f"{task.name}.yaml"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(yaml.safe_dump(rows, sort_keys=False), encoding="utf-8")
