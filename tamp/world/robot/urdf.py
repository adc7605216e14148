"""What a URDF says about the shapes of links, read without a robotics library."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree

from tamp.errors import RobotError, TaskError
from tamp.task.mesh.mesh_file import read_mesh
from tamp.task.mesh.parts import Part, convex_hull, parts
from tamp.task.model import Box, Capsule, Cylinder, Sphere
from tamp.task.pose import Pose
from tamp.task.robot import RobotSpec

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Matrix = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class LinkShape:
    """One convex hull of a link's collision geometry.

    Attributes:
        link: the link's name.
        hull: in the link's frame.
    """

    link: str
    hull: Part


@lru_cache(maxsize=8)
def link_shapes(spec: RobotSpec) -> tuple[LinkShape, ...]:
    """The convex hull of each `<collision>` of the robot's URDF, in file order.

    Raises:
        RobotError: for a URDF with geometry that is incomplete, or a mesh that is missing or unusable.
    """
    root = ElementTree.fromstring(spec.description)
    found = []
    for link in root.iter("link"):
        for collision in link.findall("collision"):
            name = link.get("name", "")
            points = _points(collision, spec, name) @ _origin(collision)[:3, :3].T + _origin(collision)[:3, 3]
            try:
                found.append(LinkShape(name, convex_hull(points)))
            except ValueError as error:
                raise RobotError(f"{spec.urdf}: link {name!r}: of its <collision> {error}") from None
    return tuple(found)


def without_shapes(description: str) -> str:
    """A description's links and joints alone: a reader of kinematics complains of shapes that it does not know."""
    root = ElementTree.fromstring(description)
    for link in root.iter("link"):
        for shape in (*link.findall("visual"), *link.findall("collision")):
            link.remove(shape)
    return ElementTree.tostring(root, encoding="unicode")


def carried(description: str, links: tuple[str, ...]) -> frozenset[str]:
    """The nearest link that carries all of some links, and all that it carries: of tool and fingers, the hand."""
    joints = ElementTree.fromstring(description).findall("joint")
    parent = {_end(joint, "child"): _end(joint, "parent") for joint in joints}
    ways = []
    for link in links:
        way = [link]
        while way[-1] in parent:
            way.append(parent[way[-1]])
        ways.append(way)
    found = {next(link for link in ways[0] if all(link in way for way in ways))}
    while more := {child for child, above in parent.items() if above in found} - found:
        found |= more
    return frozenset(found)


def _end(joint: ElementTree.Element, role: str) -> str:
    element = joint.find(role)
    return "" if element is None else element.get("link", "")


def _points(collision: ElementTree.Element, spec: RobotSpec, link: str) -> Matrix:
    """Points whose hull is the geometry, before its origin is applied, shape (n, 3) [m]."""
    geometry = collision.find("geometry")
    kind = geometry[0] if geometry is not None and len(geometry) else None
    if kind is None:
        raise RobotError(f"{spec.urdf}: link {link!r} has a <collision> without geometry")
    if kind.tag == "mesh":
        x, y, z = _numbers(kind.get("scale", "1 1 1"))
        try:
            return read_mesh(Path(kind.get("filename", "")), (x, y, z)).vertices
        except TaskError as error:
            raise RobotError(f"{spec.urdf}: link {link!r}: {error}") from error
    if kind.tag == "box":
        x, y, z = _numbers(kind.get("size", ""))
        return parts(Box((x, y, z)))[0].vertices
    if kind.tag == "cylinder":
        return parts(Cylinder(float(kind.get("radius", "")), float(kind.get("length", ""))))[0].vertices
    if kind.tag == "sphere":
        return parts(Sphere(float(kind.get("radius", ""))))[0].vertices
    if kind.tag == "capsule":
        return parts(Capsule(float(kind.get("radius", "")), float(kind.get("length", ""))))[0].vertices
    valid = "mesh, box, cylinder, sphere and capsule"
    raise RobotError(f"{spec.urdf}: link {link!r} has geometry <{kind.tag}>; valid are {valid}")


def _origin(element: ElementTree.Element) -> Matrix:
    origin = element.find("origin")
    if origin is None:
        return Pose().matrix
    x, y, z = _numbers(origin.get("xyz", "0 0 0"))
    roll, pitch, yaw = _numbers(origin.get("rpy", "0 0 0"))
    return Pose.from_rpy((x, y, z), (roll, pitch, yaw)).matrix


def _numbers(text: str) -> list[float]:
    return [float(field) for field in text.split()]
