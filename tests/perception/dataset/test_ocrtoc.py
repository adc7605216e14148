"""Data sets in OCRTOC's own layout come back as they were written, and hold what its toolkit asks for."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from tamp.errors import TampError, TaskError
from tamp.perception.cameras.camera import Intrinsics
from tamp.perception.dataset.frames import LabelledFrame, load_image
from tamp.perception.dataset.generate import around, labelled
from tamp.perception.dataset.layouts import LAYOUTS, layout, read_scene
from tamp.perception.dataset.scenes import random_scene
from tamp.perception.rendering.surface import plain, read_surface
from tamp.task import Box, Cylinder, Object, Pose, Table

pytest.importorskip("embreex", reason="the extra perception is not installed")

K = Intrinsics.from_field_of_view(160, 120, math.radians(45))
OBJECTS = {"box": plain(Box((0.1, 0.06, 0.05)), (200, 40, 40)), "can": plain(Cylinder(0.03, 0.12), (40, 80, 200))}
POSES = {"box": Pose.from_rpy((-0.1, 0.1, 0.025), (0, 0, 0.4)), "can": Pose((-0.12, 0.0, 0.06))}
OCRTOC = layout("ocrtoc")


@pytest.fixture(scope="module")
def frames() -> list[LabelledFrame]:
    rng = np.random.default_rng(0)
    cameras = list(around(Table(), 3, rng))
    return list(labelled(OBJECTS, POSES, cameras, K, None, Table(), rng, depth_step=OCRTOC.depth_step))


@pytest.fixture
def written(frames: list[LabelledFrame], tmp_path: Path) -> Path:
    OCRTOC.write_models(OBJECTS, tmp_path)
    OCRTOC.write_scene(frames, tmp_path, 7)
    return tmp_path


def test_a_scene_comes_back_as_it_was(frames: list[LabelledFrame], written: Path) -> None:
    back = list(OCRTOC.read_scene(written, 7))
    assert len(back) == len(frames)
    for a, b in zip(frames, back, strict=True):
        assert a.intrinsics == b.intrinsics
        assert np.array_equal(a.color, b.color)
        assert np.array_equal(a.depth, b.depth)
        assert np.array_equal(a.T_world_camera, b.T_world_camera)
        for x, y in zip(a.labels, b.labels, strict=True):
            assert x.name == y.name
            assert np.allclose(x.T_camera_object, y.T_camera_object, atol=1e-12)
            assert np.array_equal(x.whole, y.whole)
            assert np.array_equal(x.visible, y.visible)


@pytest.mark.parametrize("name", LAYOUTS)
def test_a_scene_is_read_in_whichever_layout_it_is(name: str, frames: list[LabelledFrame], tmp_path: Path) -> None:
    how = layout(name)
    how.write_models(OBJECTS, tmp_path)
    how.write_scene(frames, tmp_path, 3)
    back = list(read_scene(tmp_path, 3))
    assert [np.array_equal(a.depth, b.depth) for a, b in zip(frames, back, strict=True)] == [True] * 3
    assert len(list(read_scene(str(tmp_path), 3))) == 3
    with pytest.raises(TaskError, match=r"there is no scene 4: neither .*000004 nor .*000004 is there$"):
        read_scene(tmp_path, 4)


def test_meshes_project_back_onto_their_masks(written: Path) -> None:
    """By the files alone: K, camera and object poses, and meshes put every vertex where the masks have the object."""
    scene, names = written / "scenes" / "000007", ["box", "can"]
    K_ = np.load(scene / "color_camK.npy")
    for index in range(3):
        T = np.linalg.inv(np.load(scene / "camera_poses" / f"{index:04}.npy"))
        masks = np.load(scene / "seg_masks" / f"{index:04}.npy")
        depth = load_image(scene / "depth_undistort" / f"{index:04}.png") / 1000
        for number, name in enumerate(names, start=1):
            mesh = read_surface(written / "rgb_pcd" / f"{name}.ply")
            T_camera_object = T @ np.load(scene / "object_poses" / f"{name}.npy")
            points = mesh.vertices @ T_camera_object[:3, :3].T + T_camera_object[:3, 3]
            pixels = points @ K_.T
            pixels = pixels[:, :2] / pixels[:, 2:]
            rows, columns = np.nonzero(masks == number)
            seen = np.column_stack([columns, rows])
            assert (seen >= pixels.min(axis=0) - 1.5).all()
            assert (seen <= pixels.max(axis=0) + 1.5).all()
            measured = depth[rows, columns]
            measured = measured[measured > 0]
            assert points[:, 2].min() - 0.001 < measured.min()
            assert measured.max() < points[:, 2].max() + 0.001


def test_what_is_not_there_is_said() -> None:
    with pytest.raises(TampError, match="unknown format 'coco'; valid are bop, ocrtoc"):
        layout("coco")


def test_a_folder_without_names_is_no_data_set(tmp_path: Path) -> None:
    (tmp_path / "scenes" / "000000").mkdir(parents=True)
    with pytest.raises(TaskError, match=r"object_name_list\.txt"):
        next(OCRTOC.read_scene(tmp_path, 0))
    with pytest.raises(TaskError, match="no such scene"):
        next(OCRTOC.read_scene(tmp_path, 1))


def test_random_scenes_rest_on_the_table_and_repeat() -> None:
    objects = [Object(f"b{i}", Box((0.06, 0.05, 0.04)), Pose()) for i in range(4)]
    first, again, other = (random_scene(objects, 3, Table(), np.random.default_rng(seed)) for seed in (1, 1, 2))
    assert first == again
    assert first != other
    assert 1 <= len(first) <= 3
    assert all(0.0 < pose.xyz[2] < 0.2 for pose in first.values())
