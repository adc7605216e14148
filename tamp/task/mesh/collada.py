"""COLLADA files (.dae), in which many robots' meshes come: the triangles that their scene shows, and nothing else.

The file's unit is heeded, its `up_axis` is not: robots' files are made for tools that leave it out, and say Y_UP of
meshes whose z is up.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]
    Faces = NDArray[np.int64]
    Piece = tuple[Array, Faces]

MAX_BYTES = 128 * 2**20
MAX_NODES, MAX_DEPTH = 10_000, 100
"""How many nodes a scene may have, each counted as often as it is shown, and how many in each other."""
PRIMITIVES = ("triangles", "polylist", "polygons", "trifans", "tristrips")


def read_collada(path: Path) -> Piece:
    """Vertices, shape (n, 3) [m], and triangles, shape (m, 3), indices into them.

    Raises:
        ValueError: where the file is too large, is no COLLADA, or refers to what it does not have.
        OSError: where it cannot be read.
    """
    import numpy as np

    if path.stat().st_size > MAX_BYTES:
        raise ValueError(f"the file has over {MAX_BYTES // 2**20} MiB; simplify it, or convert it to STL")
    try:
        root = ElementTree.fromstring(path.read_bytes())
    except ElementTree.ParseError as error:
        raise ValueError(str(error)) from None
    if _plain(root.tag) != "COLLADA":
        raise ValueError(f"its root is <{_plain(root.tag)}>, not <COLLADA>")
    for element in root.iter():
        element.tag = _plain(element.tag)
    vertices, faces, count = [np.empty((0, 3))], [np.empty((0, 3), dtype=np.int64)], 0
    for points, triangles in _Collada(root).shown():
        vertices.append(points)
        faces.append(triangles + count)
        count += len(points)
    unit = root.find("asset/unit")
    return float("1" if unit is None else unit.get("meter", "1")) * np.concatenate(vertices), np.concatenate(faces)


@dataclass
class _Collada:
    """A file's elements by their ids, and how many nodes of its scene have been looked at."""

    root: Element
    named: dict[str, Element] = field(default_factory=dict)
    nodes: int = 0

    def __post_init__(self) -> None:
        self.named = {e.get("id", ""): e for e in self.root.iter() if e.get("id")}

    def shown(self) -> Iterator[Piece]:
        """Yield what the scene shows; all scenes or, without any, all geometry where the file does not say which."""
        import numpy as np

        scene = self.root.find("scene/instance_visual_scene")
        scenes = self.root.findall("library_visual_scenes/visual_scene") if scene is None else [self._meant(scene)]
        for top in scenes:
            for node in top.findall("node"):
                yield from self._node(node, np.eye(4), depth=1)
        if not scenes:
            for geometry in self.root.findall("library_geometries/geometry"):
                yield from self._pieces(geometry)

    def _node(self, node: Element, T: Array, depth: int) -> Iterator[Piece]:
        """Yield what a node and those in it show, moved by `T`, shape (4, 4)."""
        import numpy as np

        self.nodes += 1
        if self.nodes > MAX_NODES or depth > MAX_DEPTH:
            told = f"over {MAX_NODES:,} nodes, over {MAX_DEPTH} in each other, or one that shows itself"
            raise ValueError(f"its scene has {told}")
        for step in node:
            T = T @ _transform(step)
        for instance in node.findall("instance_geometry"):
            for points, faces in self._pieces(self._meant(instance)):
                mirrored = np.linalg.det(T[:3, :3]) < 0
                yield points @ T[:3, :3].T + T[:3, 3], faces[:, ::-1] if mirrored else faces
        for inner in (*node.findall("node"), *map(self._meant, node.findall("instance_node"))):
            yield from self._node(inner, T, depth + 1)

    def _pieces(self, geometry: Element) -> Iterator[Piece]:
        """Yield each of a geometry's lists of polygons, as triangles."""
        import numpy as np

        for mesh in geometry.findall("mesh"):
            for primitive in (element for element in mesh if element.tag in PRIMITIVES):
                inputs = primitive.findall("input")
                corner = next((i for i in inputs if i.get("semantic") == "VERTEX"), None)
                if corner is None:
                    raise ValueError(f"a <{primitive.tag}> has no input VERTEX")
                stride = 1 + max(int(i.get("offset", "0")) for i in inputs)
                polygons = [
                    _ints(p).reshape(-1, stride)[:, int(corner.get("offset", "0"))] for p in primitive.iter("p")
                ]
                points = self._positions(self._meant(corner, "source"))
                faces = np.concatenate([np.empty((0, 3), dtype=np.int64), *_triangles(primitive, polygons)])
                if len(faces) and not 0 <= faces.min() <= faces.max() < len(points):
                    raise ValueError(f"a <{primitive.tag}> refers to a vertex that is not among its {len(points)}")
                yield points, faces

    def _positions(self, vertices: Element) -> Array:
        import numpy as np

        given = next((i for i in vertices.findall("input") if i.get("semantic") == "POSITION"), None)
        if given is None:
            raise ValueError("its vertices have no input POSITION")
        source = self._meant(given, "source")
        accessor, floats = source.find("technique_common/accessor"), source.find("float_array")
        if floats is None:
            raise ValueError(f"the source {source.get('id')!r} has no <float_array>")
        stride = 3 if accessor is None else int(accessor.get("stride", "3"))
        values = np.array((floats.text or "").split(), dtype=np.float64)
        return values.reshape(-1, stride)[:, :3]

    def _meant(self, element: Element, attribute: str = "url") -> Element:
        """What an element refers to by `#ID`."""
        name = element.get(attribute, "").removeprefix("#")
        if name not in self.named:
            raise ValueError(f"<{element.tag}> refers to {name!r}, which is not in the file")
        return self.named[name]


def _triangles(primitive: Element, polygons: Sequence[Faces]) -> Iterator[Faces]:
    """Yield triangles, shape (m, 3), of a primitive whose <p> elements have these corners."""
    import numpy as np

    for corners in polygons:
        if primitive.tag == "triangles":
            yield corners.reshape(-1, 3)
        elif primitive.tag == "tristrips":
            strip = np.stack([corners[:-2], corners[1:-1], corners[2:]], axis=1)
            strip[1::2] = strip[1::2, ::-1]
            yield strip
        else:
            counts = primitive.find("vcount")
            sizes = np.array([len(corners)]) if counts is None else _ints(counts)
            if sizes.sum() != len(corners):
                raise ValueError(f"a <{primitive.tag}> has {len(corners)} corners where its <vcount> adds up otherwise")
            first = np.cumsum(sizes) - sizes
            for k in range(1, int(sizes.max(initial=2)) - 1):
                at = first[sizes > k + 1]
                yield np.stack([corners[at], corners[at + k], corners[at + k + 1]], axis=1)


def _transform(step: Element) -> Array:
    """The matrix, shape (4, 4), of a node's <matrix>, <translate>, <rotate> or <scale>; of anything else, none."""
    import numpy as np

    T = np.eye(4)
    if step.tag in ("matrix", "translate", "rotate", "scale"):
        values = np.array((step.text or "").split(), dtype=np.float64)
        if len(values) != {"matrix": 16, "rotate": 4}.get(step.tag, 3):
            raise ValueError(f"a <{step.tag}> has {len(values)} numbers")
        if step.tag == "matrix":
            T = values.reshape(4, 4)
        elif step.tag == "translate":
            T[:3, 3] = values
        elif step.tag == "scale":
            T[:3, :3] = np.diag(values)
        else:
            T[:3, :3] = _rotation(values[:3], math.radians(values[3]))
    return T


def _rotation(axis: Array, angle: float) -> Array:
    """By an angle [rad] about an axis, after Rodrigues, shape (3, 3)."""
    import numpy as np

    x, y, z = axis / (np.linalg.norm(axis) or 1.0)
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    R: Array = np.eye(3) + math.sin(angle) * K + (1.0 - math.cos(angle)) * K @ K
    return R


def _ints(element: Element) -> Faces:
    import numpy as np

    return np.array((element.text or "").split(), dtype=np.int64)


def _plain(tag: str) -> str:
    """An element's name without its namespace."""
    return tag.rpartition("}")[2]
