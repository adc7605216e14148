"""What is seen of a robot in PyBullet: also meshes in formats that it does not read."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tamp.execution.pybullet.client import pybullet
from tamp.execution.pybullet.robot import load_robot_body
from tamp.task.files.robot.robot_file import read_robot
from tests.task.scara import ARM, write

CORNERS = np.array([[-50, -50, 0], [50, -50, 0], [0, 50, 0], [0, 0, 380]], float)
FACES = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))
"""A pyramid in millimetres."""


def stl() -> str:
    facets = (
        "facet normal 0 0 0\nouter loop\n"
        + "\n".join(f"vertex {x:g} {y:g} {z:g}" for x, y, z in CORNERS[list(face)])
        + "\nendloop\nendfacet"
        for face in FACES
    )
    return "\n".join(("solid pyramid", *facets, "endsolid pyramid", ""))


def ply() -> str:
    header = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    header += "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
    rows = [" ".join(f"{v:g}" for v in row) for row in CORNERS] + [f"3 {a} {b} {c}" for a, b, c in FACES]
    return header + "\n".join(rows) + "\n"


def shown(folder: Path, name: str, text: str) -> list[bytes]:
    """The files of the column's visual shapes that PyBullet knows, of a mesh of that name and text."""
    visual = f'<visual><geometry><mesh filename="{name}" scale="0.001 0.001 0.001"/></geometry></visual></link>'
    path = write(folder, arm=ARM.replace("</link>", visual, 1))
    (folder / name).write_text(text)
    client = pybullet.connect(pybullet.DIRECT)
    try:
        made = folder / "made"
        made.mkdir()
        spec = read_robot(path)
        body = load_robot_body(client, made, spec, spec.home, visible=True)
        found = [shape for shape in pybullet.getVisualShapeData(body.id, physicsClientId=client) if shape[1] == -1]
        return [shape[4] for shape in found]
    finally:
        pybullet.disconnect(client)


def extent(file: bytes) -> np.ndarray:
    """The size of what an OBJ file has, shape (3,) [m]."""
    lines = Path(file.decode()).read_text().splitlines()
    return np.ptp([list(map(float, line.split()[1:])) for line in lines if line.startswith("v ")], axis=0)


@pytest.mark.parametrize(("name", "text"), [("column.stl", stl()), ("column.ply", ply())])
def test_meshes_that_pybullet_does_not_read_are_shown(tmp_path: Path, name: str, text: str) -> None:
    (file,) = shown(tmp_path, name, text)
    assert np.allclose(extent(file), (0.1, 0.1, 0.38), atol=1e-6)


def test_of_a_link_whose_visual_mesh_is_none_the_hull_is_shown(tmp_path: Path) -> None:
    (file,) = shown(tmp_path, "column.ply", "no mesh")
    assert np.allclose(extent(file), (0.098, 0.098, 0.378), atol=1e-6)
