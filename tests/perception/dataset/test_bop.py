"""Data sets in BOP's layout: what is written comes back, labels fit the pictures, and a run can be resumed."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from tamp.errors import TaskError
from tamp.perception.cameras.camera import Intrinsics, StereoNoise, looking_at
from tamp.perception.dataset.bop import read_scene, write_models, write_scene
from tamp.perception.dataset.frames import LabelledFrame, object_pose, steps
from tamp.perception.dataset.generate import around, labelled, write_dataset
from tamp.perception.rendering.surface import plain, read_surface
from tamp.task import Box, Cylinder, Pose, Table

pytest.importorskip("embreex", reason="the extra perception is not installed")

SMALL = Intrinsics.from_field_of_view(160, 120, math.radians(45))
OBJECTS = {"box": plain(Box((0.1, 0.06, 0.05)), (200, 40, 40)), "can": plain(Cylinder(0.03, 0.12), (40, 80, 200))}
POSES = {"box": Pose.from_rpy((-0.1, 0.1, 0.025), (0, 0, 0.4)), "can": Pose((-0.12, 0.0, 0.06))}


def _frames(noise: StereoNoise | None = None) -> list[LabelledFrame]:
    rng = np.random.default_rng(0)
    cameras = list(around(Table(), 4, rng))
    return list(labelled(OBJECTS, POSES, cameras, SMALL, noise, Table(), rng))


def test_a_scene_comes_back_as_it_was(tmp_path: Path) -> None:
    frames = _frames(StereoNoise())
    write_models(OBJECTS, tmp_path)
    write_scene(frames, tmp_path, 3)
    back = list(read_scene(tmp_path, 3))
    assert len(back) == len(frames)
    for a, b in zip(frames, back, strict=True):
        assert a.intrinsics == b.intrinsics
        assert np.array_equal(a.color, b.color)
        assert np.array_equal(a.depth, b.depth)
        assert np.allclose(a.T_world_camera, b.T_world_camera, atol=1e-12)
        for x, y in zip(a.labels, b.labels, strict=True):
            assert x.name == y.name
            assert np.allclose(x.T_camera_object, y.T_camera_object, atol=1e-12)
            assert np.array_equal(x.whole, y.whole)
            assert np.array_equal(x.visible, y.visible)


def test_labels_project_onto_what_they_label() -> None:
    for frame in _frames():
        for label in frame.labels:
            assert not (label.visible & ~label.whole).any(), "what is seen is part of the whole"
            pose = object_pose(frame, label)
            assert pose.xyz == pytest.approx(POSES[label.name].xyz, abs=1e-9)
            points = SMALL.points((frame.depth * 1e-4).astype(np.float32))[label.visible].astype(np.float64)
            T = np.linalg.inv(label.T_camera_object)
            local = points @ T[:3, :3].T + T[:3, 3]
            vertices = OBJECTS[label.name].vertices
            assert (local > vertices.min(axis=0) - 1e-3).all()
            assert (local < vertices.max(axis=0) + 1e-3).all()


def test_every_object_is_seen_whole_somewhere() -> None:
    frames = _frames()
    for place in range(len(OBJECTS)):
        assert any(f.labels[place].visible.sum() > 0.9 * f.labels[place].whole.sum() > 50 for f in frames)


def test_models_are_in_millimetres(tmp_path: Path) -> None:
    write_models(OBJECTS, tmp_path)
    mesh = read_surface(tmp_path / "models" / "obj_000001.ply")
    assert np.allclose(mesh.vertices / 1000, OBJECTS["box"].vertices, atol=1e-6)
    assert mesh.colors[0].tolist() == [200, 40, 40]
    info = json.loads((tmp_path / "models" / "models_info.json").read_text(encoding="utf-8"))
    assert info["1"]["size_x"] == pytest.approx(100)


def test_a_run_is_resumed_and_repeats(tmp_path: Path) -> None:
    said: list[tuple[int, bool]] = []

    def run(folder: Path, scenes: int) -> None:
        write_dataset(
            [POSES] * scenes, OBJECTS, folder, views=2, intrinsics=SMALL, progress=lambda n, old: said.append((n, old))
        )

    run(tmp_path / "a", 1)
    half = tmp_path / "a" / "train" / ".000001"
    half.mkdir()
    run(tmp_path / "a", 2)
    assert said == [(0, False), (0, True), (1, False)]
    assert not half.exists()
    run(tmp_path / "b", 2)
    for scene in range(2):
        for a, b in zip(read_scene(tmp_path / "a", scene), read_scene(tmp_path / "b", scene), strict=True):
            assert np.array_equal(a.depth, b.depth)


def test_depth_in_steps() -> None:
    depth = np.array([[0.0, 0.5, 1.23456, 7.0]], dtype=np.float32)
    assert steps(depth).tolist() == [[0, 5000, 12346, 0]]


def test_a_camera_looks_where_it_should() -> None:
    T = looking_at(np.array([0.3, 0.2, 0.8]), np.array([0.0, 0.0, 0.0]))
    assert np.allclose(T[:3, :3] @ T[:3, :3].T, np.eye(3))
    assert np.linalg.det(T[:3, :3]) == pytest.approx(1.0)
    pixels, depth = SMALL.project((np.linalg.inv(T) @ [0, 0, 0, 1])[None, :3])
    assert pixels[0] == pytest.approx((80, 60))
    assert depth[0] > 0
    assert T[2, 1] < 0, "down in the picture is down"


def test_what_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(TaskError, match=r"holds no models/names.json"):
        write_scene(_frames()[:1], tmp_path, 0)
    write_models(OBJECTS, tmp_path)
    with pytest.raises(TaskError, match="there is no such scene"):
        next(read_scene(tmp_path, 9))
