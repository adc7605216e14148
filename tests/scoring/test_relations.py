"""In a hollow, or merely within its box; on a body, or merely beside it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tamp.scoring.relations import holds
from tamp.task import Box, In, Mesh, Object, On, Pose, Task
from tamp.task.mesh.enclosure import meet
from tests.task.meshes import parts_obj

FLOOR = ((-0.1, -0.1, 0.0), (0.1, 0.1, 0.01))
LEFT, RIGHT = ((-0.1, -0.1, 0.0), (-0.09, 0.1, 0.1)), ((0.09, -0.1, 0.0), (0.1, 0.1, 0.1))
FRONT, BACK = ((-0.1, -0.1, 0.0), (0.1, -0.09, 0.1)), ((-0.1, 0.09, 0.0), (0.1, 0.1, 0.1))
CRATE = [FLOOR, LEFT, RIGHT, FRONT, BACK]
CORNER = [LEFT, FRONT]
CUBE = Box((0.04, 0.04, 0.04))
TURNED = (1.0, 0.0, 0.0, 0.0)


def shaped(path: Path, boxes: list) -> Mesh:
    path.write_text(parts_obj(boxes))
    return Mesh(path)


def relation(tmp_path: Path, boxes, goal, at: Pose, container: Pose | None = None) -> bool:
    mesh = shaped(tmp_path / "holder.obj", boxes)
    where = {"cube": at, "holder": container or Pose((0.0, 0.0, 0.0))}
    task = Task("t", (Object("cube", CUBE, at, goal), Object("holder", mesh, where["holder"])))
    return holds(task, "cube", goal, where)


@pytest.mark.parametrize(
    ("at", "inside"),
    [((0, 0, 0.03), True), ((0.06, -0.06, 0.03), True), ((0, 0, 0.12), False), ((0.12, 0, 0.02), False)],
)
def test_what_lies_between_all_walls_is_in(tmp_path, at, inside):
    assert relation(tmp_path, CRATE, In("holder"), Pose(at)) is inside


def test_what_stands_in_the_corner_of_an_l_is_neither_in_it_nor_on_it(tmp_path):
    assert not relation(tmp_path, CORNER, In("holder"), Pose((0.0, 0.0, 0.02)))
    assert not relation(tmp_path, CORNER, In("holder"), Pose((-0.07, -0.07, 0.02)))
    assert not relation(tmp_path, CORNER, On("holder"), Pose((0.0, 0.0, 0.02)))
    assert relation(tmp_path, CORNER, On("holder"), Pose((-0.09, 0.0, 0.12)))


def test_what_is_under_a_crate_turned_over_is_not_in_it(tmp_path):
    assert not relation(tmp_path, CRATE, In("holder"), Pose((0, 0, 0.02)), Pose((0, 0, 0.1), TURNED))


def test_a_ring_is_not_in_the_peg_that_stands_in_it(tmp_path):
    ring = shaped(tmp_path / "ring.obj", CRATE[1:])
    where = {"ring": Pose((0, 0, 0)), "peg": Pose((0, 0, 0.1))}
    goal = In("peg")
    task = Task("t", (Object("ring", ring, where["ring"], goal), Object("peg", Box((0.1, 0.1, 0.2)), where["peg"])))
    assert not holds(task, "ring", goal, where)


def test_a_goal_in_an_object_follows_the_container(tmp_path):
    assert relation(tmp_path, CRATE, In("holder"), Pose((0.3, 0, 0.03)), Pose((0.3, 0, 0)))
    assert not relation(tmp_path, CRATE, In("holder"), Pose((0, 0, 0.03)), Pose((0.3, 0, 0)))


@pytest.mark.parametrize("seed", range(40))
def test_boxes_meet_where_no_plane_parts_them(seed):
    rng = np.random.default_rng(seed)
    sizes = [tuple(rng.uniform(0.02, 0.2, 3)) for _ in range(2)]
    T_a, T_b = (Pose.from_rpy(rng.uniform(-0.1, 0.1, 3), rng.uniform(-np.pi, np.pi, 3)).matrix for _ in range(2))
    assert meet(Box(sizes[0]), T_a, Box(sizes[1]), T_b) == (parted_by(sizes, T_a, T_b) <= 0.0)


def parted_by(sizes: list, T_a: np.ndarray, T_b: np.ndarray) -> float:
    """How far two boxes are apart along the best of the axes that can part them; the separating axis theorem."""
    A, B = T_a[:3, :3].T, T_b[:3, :3].T
    axes = [*A, *B, *(np.cross(u, v) for u in A for v in B)]
    half = [np.array(size) / 2 for size in sizes]
    return max(
        abs((T_b[:3, 3] - T_a[:3, 3]) @ axis) - abs(A @ axis) @ half[0] - abs(B @ axis) @ half[1] for axis in axes
    )
