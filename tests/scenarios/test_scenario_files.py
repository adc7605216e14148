from __future__ import annotations

import math
from itertools import combinations
from pathlib import Path

import pytest

import tamp
from tamp.scenarios import make_objects
from tamp.task import At, In, Mesh, On, Task
from tamp.task.mesh.parts import bounds

from .solids import bottom, overlap, placed

FOLDER = Path(make_objects.__file__).resolve().parent
FILES = sorted(FOLDER.glob("*.yaml"))
ASKED_FOR = {
    "one_object", "five_apart", "build_tower", "take_down_tower", "reverse_tower", "occupied_goal", "swap", "cycle",
    "ringed", "stand_up_can", "mug_onto_tray", "clutter_ten", "on_region", "in_box",
}  # fmt: skip
TOUCHING = 1e-5
BASE = (-0.42, 0.0)


@pytest.fixture(params=FILES, ids=lambda path: path.stem)
def task(request) -> Task:
    return tamp.load_task(request.param)


def test_all_that_were_asked_for_are_there():
    assert {path.stem for path in FILES} >= ASKED_FOR


def test_every_object_of_ours_is_used():
    used = {o.shape.path.parent.name for f in FILES for o in tamp.load_task(f).objects if isinstance(o.shape, Mesh)}
    assert used == set(make_objects.OBJECTS)


def test_readme_has_a_line_for_each():
    text = (FOLDER / "README.md").read_text(encoding="utf-8")
    assert [path.stem for path in FILES if f"`{path.stem}`" not in text] == []


def test_named_after_its_file(task):
    assert task.path is not None
    assert task.name == task.path.stem


def test_something_is_to_be_done(task):
    goals = [o for o in task.objects if o.goal is not None]
    assert goals or task.goal
    assert all(o.goal.pose != o.pose for o in goals if isinstance(o.goal, At)) or task.name == "reverse_tower"


def test_start_is_apart_supported_and_reachable(task):
    bodies = {o.name: placed(o.shape, o.pose) for o in task.objects}
    assert_apart(bodies)
    assert_supported(bodies)
    for o in task.objects:
        assert 0.30 < math.dist(o.pose.xyz[:2], BASE) < 0.72


def test_goal_poses_are_apart_supported_and_reachable(task):
    bodies = {o.name: placed(o.shape, o.goal.pose) for o in task.objects if isinstance(o.goal, At)}
    assert_apart(bodies)
    assert_supported(with_what_may_stay(task, bodies))
    for o in task.objects:
        if isinstance(o.goal, At):
            assert 0.30 < math.dist(o.goal.pose.xyz[:2], BASE) < 0.72


def test_regions_are_free_at_the_start_and_have_room(task):
    for region in task.regions:
        (x, y), (width, depth) = region.center, region.size
        guests = [o for o in task.objects if isinstance(o.goal, On) and o.goal.target == region.name]
        lengths = [max((bounds(o.shape)[1] - bounds(o.shape)[0])[:2]) for o in guests]
        assert sum((a + 0.04) ** 2 for a in lengths) < width * depth
        for o in task.objects:
            for corners in placed(o.shape, o.pose):
                inside = (abs(corners[:, 0] - x) < width / 2) & (abs(corners[:, 1] - y) < depth / 2)
                assert not inside.any()


def test_containers_are_wide_enough(task):
    for o in task.objects:
        if isinstance(o.goal, In):
            room, guest = (bounds(shape) for shape in (task.object(o.goal.target).shape, o.shape))
            assert (guest[1] - guest[0])[:2].max() + 0.03 < (room[1] - room[0])[:2].min()


def with_what_may_stay(task: Task, ends):
    """The goals' bodies and those of the objects without a goal that stand in no goal's way, nor on what leaves."""
    staying = {o.name: placed(o.shape, o.pose) for o in task.objects if o.goal is None}
    free = {name: body for name, body in staying.items() if all(overlap(body, end) < TOUCHING for end in ends.values())}
    return ends | {name: body for name, body in free.items() if is_supported(name, free)}


def assert_apart(bodies) -> None:
    for (name, body), (other, second) in combinations(bodies.items(), 2):
        assert overlap(body, second) < TOUCHING, f"{name} and {other} lie in each other"


def assert_supported(bodies) -> None:
    """Each body's lowest point lies on the table, or it is carried by another."""
    for name, body in bodies.items():
        height = bottom(body)
        assert height > -TOUCHING, f"{name} reaches into the table"
        assert is_supported(name, bodies), f"{name} floats"


def is_supported(name: str, bodies) -> bool:
    """Whether a body stands on the table or meets another one when it is pushed down by a tenth of a millimetre."""
    pushed = [corners - (0.0, 0.0, 1e-4) for corners in bodies[name]]
    others = (other for key, other in bodies.items() if key != name)
    return bottom(bodies[name]) < TOUCHING or any(overlap(pushed, other) > 5e-5 for other in others)
