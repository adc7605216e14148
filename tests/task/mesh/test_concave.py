"""What is not convex must at least be a solid."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tamp.errors import TaskError
from tamp.task import Mesh
from tamp.task.mesh.parts import bounds, parts
from tests.task.meshes import parts_obj

DENTED = """v 0 0 0
v 0.1 0 0
v 0.1 0.1 0
v 0 0.1 0
v 0 0 0.1
v 0.1 0 0.1
v 0.03 0.03 0.03
v 0 0.1 0.1
f 4 3 2 1
f 5 6 7
f 5 7 8
f 1 2 6 5
f 2 3 7
f 2 7 6
f 3 4 8
f 3 8 7
"""
"""A cube with one corner pushed in; the side x = 0 is missing."""


def test_a_dented_surface_with_a_hole_has_no_inside(tmp_path: Path) -> None:
    path = tmp_path / "dented.obj"
    path.write_text(DENTED)
    with pytest.raises(TaskError, match="neither convex nor closed"):
        parts(Mesh(path))


def test_a_surface_that_cuts_through_itself_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "turned.obj"
    path.write_text(DENTED.replace("v 0.03 0.03 0.03", "v -0.05 0.02 0.05") + "f 4 1 5 8\n")
    with pytest.raises(TaskError, match="intersects itself"):
        parts(Mesh(path))


def _boxes(path: Path, *boxes: tuple[tuple[float, float, float], tuple[float, float, float]]) -> Mesh:
    """A mesh file with boxes in one group, each by its corners."""
    lines = parts_obj(boxes).splitlines()
    path.write_text("\n".join(line for line in lines if line[0] not in "go") + "\n")
    return Mesh(path)


def test_shells_that_cut_through_each_other_are_each_a_solid(tmp_path: Path) -> None:
    bars = ((-0.05, -0.01, -0.01), (0.05, 0.01, 0.01)), ((-0.01, -0.05, -0.012), (0.01, 0.05, 0.012))
    cross = parts(_boxes(tmp_path / "cross.obj", *bars))
    assert sorted(tuple(np.ptp(part.vertices, axis=0).round(6)) for part in cross) == [
        (0.02, 0.1, 0.024),
        (0.1, 0.02, 0.02),
    ]


def test_shells_that_cut_through_each_other_in_an_stl(tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    bars = [trimesh.creation.box((0.1, 0.02, 0.02)), trimesh.creation.box((0.02, 0.1, 0.025))]
    trimesh.util.concatenate(bars).export(tmp_path / "cross.stl")
    assert len(parts(Mesh(tmp_path / "cross.stl"))) == 2


def test_shells_that_share_a_face_are_each_a_solid(tmp_path: Path) -> None:
    step = (
        ((0.0, 0.0, 0.0), (0.05, 0.05, 0.02)),
        ((0.05, 0.0, 0.0), (0.1, 0.05, 0.02)),
        ((0.05, 0.0, 0.02), (0.1, 0.05, 0.06)),
    )
    shape = _boxes(tmp_path / "step.obj", *step)
    assert len(parts(shape)) == 3
    assert np.allclose(np.concatenate(bounds(shape)), (0.0, 0.0, 0.0, 0.1, 0.05, 0.06))


def test_an_open_shell_among_closed_ones_has_no_inside(tmp_path: Path) -> None:
    bars = ((-0.05, -0.01, -0.01), (0.05, 0.01, 0.01)), ((-0.01, -0.05, -0.012), (0.01, 0.05, 0.012))
    shape = _boxes(tmp_path / "cross.obj", *bars)
    shape.path.write_text(shape.path.read_text().rsplit("f ", 1)[0])
    with pytest.raises(TaskError, match="neither convex nor closed"):
        parts(shape)
