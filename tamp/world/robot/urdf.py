"""What a URDF says about the shapes of links, read without a robotics library."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree

from tamp.errors import RobotError, TaskError
from tamp.task.mesh.mesh_file import read_mesh
from tamp.task.mesh.parts import Part, convex_hull, parts
from tamp.task.model import Box, Cylinder, Sphere
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


def link_shapes(spec: RobotSpec) -> tuple[LinkShape, ...]:
    """The convex hull of each `<collision>` of the robot's URDF, in file order.

    Raises:
        RobotError: for a URDF that is missing or malformed, lacks a joint the robot names, has a joint without limits,
            or refers to a mesh that is missing or unusable.
    """
    root = _parse(spec.urdf)
    _check_joints(root, spec)
    found = []
    for link in root.iter("link"):
        for collision in link.findall("collision"):
            name = link.get("name", "")
            points = _points(collision, spec, name) @ _origin(collision)[:3, :3].T + _origin(collision)[:3, 3]
            found.append(LinkShape(name, convex_hull(points)))
    return tuple(found)


def _parse(path: Path) -> ElementTree.Element:
    if not path.is_file():
        raise RobotError(f"{path}: no such URDF")
    try:
        return ElementTree.parse(path).getroot()
    except ElementTree.ParseError as error:
        raise RobotError(f"{path}: not a URDF: {error}") from error


def _check_joints(root: ElementTree.Element, spec: RobotSpec) -> None:
    joints = {joint.get("name", ""): joint for joint in root.findall("joint")}
    for name in (*spec.joints, *spec.gripper.joints):
        if name not in joints:
            raise RobotError(f"{spec.urdf}: there is no joint {name!r}; the URDF has {', '.join(sorted(joints))}")
    links = {link.get("name", "") for link in root.findall("link")}
    for name in (spec.tool_parent, *spec.gripper.fingers):
        if name not in links:
            raise RobotError(f"{spec.urdf}: there is no link {name!r}; the URDF has {', '.join(sorted(links))}")
    for name, joint in joints.items():
        limit = joint.find("limit")
        if joint.get("type") not in ("revolute", "prismatic"):
            continue
        if limit is None or limit.get("lower") is None or limit.get("upper") is None:
            raise RobotError(f"{spec.urdf}: joint {name!r} has no limits; <limit lower=... upper=...> is needed")


def _points(collision: ElementTree.Element, spec: RobotSpec, link: str) -> Matrix:
    """Points whose hull is the geometry, before its origin is applied, shape (n, 3) [m]."""
    import numpy as np

    geometry = collision.find("geometry")
    kind = geometry[0] if geometry is not None and len(geometry) else None
    if kind is None:
        raise RobotError(f"{spec.urdf}: link {link!r} has a <collision> without geometry")
    if kind.tag == "mesh":
        path = _mesh_path(kind.get("filename", ""), spec)
        try:
            scaled: Matrix = read_mesh(path).vertices * np.array(_numbers(kind.get("scale", "1 1 1")))
        except TaskError as error:
            raise RobotError(f"{spec.urdf}: link {link!r}: {error}") from error
        return scaled
    if kind.tag == "box":
        x, y, z = _numbers(kind.get("size", ""))
        return parts(Box((x, y, z)))[0].vertices
    if kind.tag == "cylinder":
        return parts(Cylinder(float(kind.get("radius", "")), float(kind.get("length", ""))))[0].vertices
    if kind.tag == "sphere":
        return parts(Sphere(float(kind.get("radius", ""))))[0].vertices
    raise RobotError(f"{spec.urdf}: link {link!r} has geometry <{kind.tag}>; valid are mesh, box, cylinder and sphere")


def _mesh_path(filename: str, spec: RobotSpec) -> Path:
    """`package://` stands for the robot's mesh folder; any other path is relative to the URDF."""
    if filename.startswith("package://"):
        return spec.mesh_root / filename.removeprefix("package://")
    return spec.urdf.parent / filename.removeprefix("file://")


def _origin(element: ElementTree.Element) -> Matrix:
    origin = element.find("origin")
    if origin is None:
        return Pose().matrix
    x, y, z = _numbers(origin.get("xyz", "0 0 0"))
    roll, pitch, yaw = _numbers(origin.get("rpy", "0 0 0"))
    return Pose.from_rpy((x, y, z), (roll, pitch, yaw)).matrix


def _numbers(text: str) -> list[float]:
    return [float(field) for field in text.split()]
