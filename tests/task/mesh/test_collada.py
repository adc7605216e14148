"""COLLADA files: what their scene shows, in metres, and broken ones in one sentence."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tamp.errors import TaskError
from tamp.task.mesh.mesh_file import read_mesh

CORNERS = "0 0 0 0.1 0 0 0 0.2 0 0 0 0.3"
TRIANGLES = '<triangles count="4">{inputs}<p>0 9 2 9 1 9 0 9 1 9 3 9 0 9 3 9 2 9 1 9 2 9 3 9</p></triangles>'
INPUTS = '<input semantic="VERTEX" source="#v" offset="0"/><input semantic="NORMAL" source="#n" offset="1"/>'
FILE = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
 <asset><unit name="unit" meter="{unit}"/><up_axis>Y_UP</up_axis></asset>
 <library_geometries><geometry id="g"><mesh>
  <source id="s"><float_array id="a" count="12">{corners}</float_array>
   <technique_common><accessor source="#a" count="4" stride="3"/></technique_common></source>
  <source id="n"><float_array id="b" count="0"/></source>
  <vertices id="v"><input semantic="POSITION" source="#s"/></vertices>{polygons}</mesh></geometry></library_geometries>
 <library_nodes><node id="shared">{geometry}</node></library_nodes>
 <library_visual_scenes><visual_scene id="scene">{nodes}</visual_scene></library_visual_scenes>
 <scene><instance_visual_scene url="#scene"/></scene></COLLADA>"""
SHARED = '<instance_node url="#shared"/>'
GEOMETRY = '<instance_geometry url="#g"/>'
PARTS = {
    "unit": "1", "corners": CORNERS, "polygons": TRIANGLES.format(inputs=INPUTS), "geometry": GEOMETRY,
    "nodes": f'<node id="one">{GEOMETRY}</node>',
}  # fmt: skip


def write(folder: Path, **parts: str) -> Path:
    """A tetrahedron of 0.1 x 0.2 x 0.3 units, with parts of the file in place of the usual ones."""
    path = folder / "mesh.dae"
    path.write_text(FILE.format(**{**PARTS, **parts}))
    return path


def size(path: Path, scale: float = 1.0) -> np.ndarray:
    """Of the bounding box [m]."""
    return np.ptp(read_mesh(path, scale).vertices, axis=0)


def test_the_unit_is_heeded_and_the_axis_that_is_up_is_not(tmp_path: Path) -> None:
    assert size(write(tmp_path)) == pytest.approx([0.1, 0.2, 0.3])
    assert size(write(tmp_path, unit="0.0254"), 10.0) == pytest.approx([0.0254, 0.0508, 0.0762])


@pytest.mark.parametrize(
    ("polygons", "faces"),
    [
        (f'<polylist count="1">{INPUTS}<vcount>4</vcount><p>0 9 1 9 3 9 2 9</p></polylist>', 2),
        (f"<polygons>{INPUTS}<p>0 9 1 9 3 9 2 9</p><p>0 9 1 9 2 9</p></polygons>", 3),
        (f"<trifans>{INPUTS}<p>0 9 1 9 3 9 2 9</p></trifans>", 2),
        (f"<tristrips>{INPUTS}<p>0 9 1 9 2 9 3 9</p></tristrips>", 2),
        (TRIANGLES.format(inputs=INPUTS), 4),
    ],
)
def test_polygons_of_every_kind_become_triangles(tmp_path: Path, polygons: str, faces: int) -> None:
    mesh = read_mesh(write(tmp_path, polygons=polygons))
    assert sum(map(len, mesh.groups)) == faces and np.ptp(mesh.vertices, axis=0) == pytest.approx([0.1, 0.2, 0.3])


def test_nodes_move_what_is_in_them(tmp_path: Path) -> None:
    turned = f"<node><translate>0 0 0.5</translate><rotate>0 0 1 90</rotate><node>{PARTS['nodes']}</node></node>"
    vertices = read_mesh(write(tmp_path, nodes=turned)).vertices
    assert vertices.min(0) == pytest.approx([-0.2, 0.0, 0.5]) and vertices.max(0) == pytest.approx([0.0, 0.1, 0.8])
    twice = (
        '<node><instance_node url="#shared"/></node><node><scale>-1 1 1</scale><instance_node url="#shared"/></node>'
    )
    mesh = read_mesh(write(tmp_path, nodes=twice))
    assert len(mesh.groups[0]) == 8 and np.ptp(mesh.vertices, axis=0) == pytest.approx([0.2, 0.2, 0.3])
    corners = mesh.vertices[mesh.groups[0]]
    volume = np.einsum("ni,ni->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    assert volume == pytest.approx(2 * 0.1 * 0.2 * 0.3 / 6)  # the mirrored one is not inside out


@pytest.mark.parametrize(
    ("parts", "complaint"),
    [
        ({"nodes": '<node><instance_geometry url="#h"/></node>'}, "<instance_geometry> refers to 'h', which is not in"),
        (
            {"nodes": '<node><instance_node url="#shared"/></node>', "geometry": '<instance_node url="#shared"/>'},
            "shows itself",
        ),
        ({"nodes": f"<node><matrix>1 0 0</matrix>{GEOMETRY}</node>"}, "a <matrix> has 3 numbers"),
        ({"nodes": ""}, "the mesh has no faces"),
        ({"corners": "0 0 0 0.1 0 0 0 0.2 0"}, "a vertex that is not among its 3"),
        ({"corners": "0 0 0 x"}, "could not convert string"),
        ({"corners": CORNERS.replace("0.3", "nan")}, "not finite"),
        ({"polygons": TRIANGLES.format(inputs="")}, "no input VERTEX"),
        (
            {"polygons": f"<polylist>{INPUTS}<vcount>3</vcount><p>0 9</p></polylist>"},
            "has 1 corners where its <vcount>",
        ),
        ({"unit": "0"}, "a wrong unit"),
        ({"unit": "metre"}, "could not convert string"),
    ],
)
def test_a_broken_file_is_refused_in_one_sentence(tmp_path: Path, parts: dict[str, str], complaint: str) -> None:
    with pytest.raises(TaskError, match=complaint) as error:
        read_mesh(write(tmp_path, **parts))
    assert "mesh.dae: " in str(error.value) and "\n" not in str(error.value)


@pytest.mark.parametrize(("text", "complaint"), [("", "no element found"), ("<obj/>", "its root is <obj>")])
def test_what_is_no_collada_is_refused(tmp_path: Path, text: str, complaint: str) -> None:
    (tmp_path / "mesh.dae").write_text(text)
    with pytest.raises(TaskError, match=complaint):
        read_mesh(tmp_path / "mesh.dae")
