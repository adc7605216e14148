"""What objects look like, from their files."""

from __future__ import annotations

from pathlib import Path

import pytest

from tamp.errors import TampError
from tamp.perception.rendering.scene import surfaces
from tamp.perception.rendering.surface import plain, write_ply
from tamp.task import Box, Mesh, Object, Pose, Task


def _mesh(folder: Path, name: str, size: tuple[float, float, float], color: tuple[int, int, int]) -> Object:
    (folder / name).mkdir()
    for file in ("collision.ply", "visual.ply"):
        write_ply(plain(Box(size), color), folder / name / file)
    return Object(name, Mesh(folder / name / "collision.ply"), Pose())


def test_what_looks_the_same_has_one_surface_whatever_its_files_are_called(tmp_path: Path) -> None:
    size, grey = (0.2, 0.1, 0.03), (180, 180, 180)
    objects = (
        _mesh(tmp_path, "one", size, grey),
        _mesh(tmp_path, "same", size, grey),
        _mesh(tmp_path, "red", size, (180, 20, 20)),
        _mesh(tmp_path, "thicker", (0.2, 0.1, 0.04), grey),
    )
    looks = surfaces(Task("books", objects))
    assert looks["one"] is looks["same"]
    assert len({id(surface) for surface in looks.values()}) == 3


def test_a_folder_of_coloured_meshes_that_is_not_there_is_refused(tmp_path: Path) -> None:
    task = Task("one", (Object("box", Box((0.05, 0.05, 0.05)), Pose()),))
    assert set(surfaces(task, tmp_path)) == {"box"}
    with pytest.raises(TampError, match="visaul: there is no such folder of coloured meshes"):
        surfaces(task, tmp_path / "visaul")
