"""Scenes that rounding has upset come to rest as near to where they were given as they can."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.execution.settling.rounding import AIM, DEEP, FAR, nearest_rest, parted
from tamp.execution.settling.settle import settle
from tamp.task import Box, Mesh, Object, Pose, Task
from tamp.world.geometry.convex_union import overlap, relative, solid
from tamp.world.geometry.object_geometry import geometry_of_object
from tests.task.meshes import parts_obj

FLAT = Box((0.12, 0.09, 0.02))
depths = st.floats(0.003, 0.009)


def deep(task: Task, poses: dict[str, Pose]) -> bool:
    bodies = {item.name: solid(geometry_of_object(item).parts) for item in task.objects}
    (a, T_a), (b, T_b) = ((name, pose.matrix) for name, pose in poses.items())
    return overlap(bodies[a], bodies[b], relative(T_a, T_b), -DEEP)


def two(depth: float, aside: float) -> tuple[Task, dict[str, Pose]]:
    """A plate that begins so deep in the one that it lies on."""
    poses = {"lower": Pose((0.0, 0.0, 0.01)), "upper": Pose((aside, 0.0, 0.03 - depth))}
    return Task("two", tuple(Object(name, FLAT, pose) for name, pose in poses.items())), poses


@given(depth=depths, aside=st.floats(-0.02, 0.02))
@settings(max_examples=20, deadline=None)
def test_what_is_deep_in_another_is_moved_by_as_little_as_parts_them(depth: float, aside: float) -> None:
    task, poses = two(depth, aside)
    assert deep(task, poses)
    found = parted(task.objects, poses)
    assert not deep(task, found)
    assert found["lower"] == poses["lower"], "what is lower stays"
    assert math.dist(found["upper"].xyz, poses["upper"].xyz) <= depth - DEEP + 0.0011 <= FAR
    assert found["upper"].quat == poses["upper"].quat


def test_what_touches_or_is_far_too_deep_stays() -> None:
    task, poses = two(0.001, 0.0)
    assert parted(task.objects, poses) == poses
    task, poses = two(0.018, 0.0)
    thick = Task("two", tuple(Object(name, Box((0.12, 0.09, 0.08)), pose) for name, pose in poses.items()))
    assert parted(thick.objects, poses) == poses


def test_a_nested_stack_that_rounding_jams_rests_where_it_was_given(tmp_path) -> None:
    # Three trays, each of a floor and four walls, one in the other: the upper two 6 mm too low.
    walls = [
        ((-0.06, -0.06, 0.0), (0.06, 0.06, 0.004)),
        ((-0.07, -0.07, 0.004), (-0.06, 0.07, 0.03)),
        ((0.06, -0.07, 0.004), (0.07, 0.07, 0.03)),
        ((-0.06, -0.07, 0.004), (0.06, -0.06, 0.03)),
        ((-0.06, 0.06, 0.004), (0.06, 0.07, 0.03)),
    ]
    (tmp_path / "tray.obj").write_text(parts_obj(walls))
    heights = (0.0, 0.03 - 0.006, 0.06 - 0.012)
    trays = [Object(f"tray{i}", Mesh(tmp_path / "tray.obj"), Pose((0.0, 0.0, z))) for i, z in enumerate(heights)]
    task = Task("trays", tuple(trays))
    poses = {item.name: item.pose for item in trays}
    rest = nearest_rest(task, poses)
    assert rest.resting
    for name, pose in rest.poses.items():
        assert math.dist(pose.xyz[:2], poses[name].xyz[:2]) < AIM


def test_what_rests_is_settled_once_and_as_ever() -> None:
    task, poses = two(0.0, 0.01)
    assert nearest_rest(task, poses) == settle(task, poses)


@pytest.mark.parametrize(("x", "stays"), [(0.0, True), (0.0001, False)])
def test_what_rounding_put_just_over_an_edge_rests_on_it_and_what_is_written_finer_falls(x, stays) -> None:
    # The upper block's middle is 3 mm beside the lower one.
    poses = {"lower": Pose((x, 0.0, 0.05)), "upper": Pose((x + 0.03, 0.0, 0.13))}
    shapes = {"lower": Box((0.054, 0.04, 0.1)), "upper": Box((0.04, 0.04, 0.06))}
    task = Task("edge", tuple(Object(name, shapes[name], pose) for name, pose in poses.items()))
    assert settle(task, poses).poses["upper"].xyz[2] < 0.1
    assert (nearest_rest(task, poses).poses["upper"].xyz[2] > 0.12) == stays
