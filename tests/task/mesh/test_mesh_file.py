"""Bad meshes: one clear sentence each."""

from __future__ import annotations

import numpy as np
import pytest

from tamp.errors import TaskError
from tamp.task import Mesh
from tamp.task.mesh.mesh_file import read_mesh
from tamp.task.mesh.parts import parts

TETRAHEDRON = "v 0 0 0\nv {s} 0 0\nv 0 {s} 0\nv 0 0 {s}\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\n", "no faces"),
        ("", "no faces"),
        (TETRAHEDRON.format(s=150), "150 m large.*millimetres"),
        (TETRAHEDRON.format(s=1e-5), "a wrong unit"),
        (TETRAHEDRON.format(s="nan"), "not finite"),
        ("v 0 0 0\nf 1 2 9\n", "a vertex that is not among"),
        ("v 0 0 0\nf 1 x 1\n", r"mesh\.obj:2: cannot read the face"),
        ("v 0 0 0\nf 1 1\n", r"mesh\.obj:2: cannot read the face"),
        ("v 0 0 0\nf 1 1 99999999999999999999\n", r"mesh\.obj:2: cannot read the face"),
        ("v 0 0\nv 0 0 1\nf 1 2 1\n", "three coordinates"),
        ("v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0.1 0.1 0\nf 1 2 3\nf 2 4 3\n", "degenerate"),
    ],
)
def test_an_unusable_obj_is_refused_in_one_sentence(tmp_path, text, complaint):
    path = tmp_path / "mesh.obj"
    path.write_text(text)
    with pytest.raises(TaskError, match=complaint) as error:
        parts(Mesh(path))
    assert str(path) in str(error.value)
    assert "\n" not in str(error.value)


def test_two_million_faces_are_too_many(tmp_path):
    path = tmp_path / "dense.obj"
    path.write_text("v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\n" + "f 1 2 3\n" * 2_000_000)
    with pytest.raises(TaskError, match=r"2,000,000 faces; at most 1,000,000"):
        read_mesh(path)


def _binary_stl(faces: int) -> bytes:
    return bytes(80) + faces.to_bytes(4, "little")


PLY = "ply\nformat ascii 1.0\ncomment TextureFile {texture}\nelement vertex 3\nproperty float x\nproperty float y\n"
PLY += "property float z\nelement face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
PLY += "0 0 0\n0.1 0 0\n0 0.1 0\n3 0 1 2\n"


def test_ten_million_faces_are_refused_before_they_are_read_in(tmp_path, monkeypatch):
    monkeypatch.setattr("tamp.task.mesh.mesh_file._read_with_trimesh", None)
    monkeypatch.setattr("tamp.task.mesh.mesh_file._read_obj", None)
    (tmp_path / "a.stl").write_bytes(_binary_stl(10_000_000))
    with (tmp_path / "a.stl").open("r+b") as file:
        file.truncate(84 + 50 * 10_000_000)  # sparse: it takes no room
    (tmp_path / "b.ply").write_text(PLY.format(texture="t.png", faces=10_000_000))
    (tmp_path / "c.stl").write_text("solid\n" + "facet normal 0 0 1\nendfacet\n" * 1_100_000)
    for name in ("b.ply", "c.stl"):
        with pytest.raises(TaskError, match=r"faces; at most 1,000,000"):
            read_mesh(tmp_path / name)
    with (tmp_path / "d.obj").open("wb") as file:
        file.truncate(600 * 2**20)
    with pytest.raises(TaskError, match="600 MiB; at most 512"):
        read_mesh(tmp_path / "d.obj")
    with pytest.raises(TaskError, match="faces; at most 1,000,000"):
        read_mesh(tmp_path / "a.stl")


def test_five_thousand_groups_are_refused_with_the_line(tmp_path):
    path = tmp_path / "parts.obj"
    triangles = "".join(f"g part{i}\nf 1 2 3\n" for i in range(5000))
    path.write_text("v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\n" + triangles)
    with pytest.raises(TaskError, match=r"parts\.obj:2\d+: the mesh has over 1,000 groups"):
        read_mesh(path)


def test_a_polygon_of_a_million_corners_is_too_many_faces(tmp_path):
    path = tmp_path / "fan.obj"
    path.write_text("v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nf" + " 1 2 3" * 400_000 + "\n")
    with pytest.raises(TaskError, match="at most 1,000,000"):
        read_mesh(path)


def test_a_texture_outside_is_not_opened(tmp_path, caplog):
    path = tmp_path / "mesh.ply"
    path.write_text(PLY.format(texture="/etc/passwd", faces=1))
    assert len(read_mesh(path).groups[0]) == 1
    assert not caplog.records


def test_a_missing_file_and_an_unknown_format_are_named(tmp_path):
    with pytest.raises(TaskError, match="no such mesh file"):
        read_mesh(tmp_path / "absent.obj")
    with pytest.raises(TaskError, match=r"unknown mesh format '.step'; valid are .obj, .stl, .ply"):
        read_mesh(tmp_path / "part.step")
    (tmp_path / "broken.stl").write_bytes(b"solid nothing")
    with pytest.raises(TaskError, match=r"broken\.stl"):
        read_mesh(tmp_path / "broken.stl")


def test_stl_corners_are_welded(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    path = tmp_path / "box.stl"
    trimesh.creation.box((0.1, 0.1, 0.1)).export(path)
    raw = read_mesh(path)
    assert raw.vertices.shape == (8, 3)
    assert np.isfinite(raw.vertices).all()
