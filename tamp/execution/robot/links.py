"""A robot's links as a physics engine needs them: a tree of hulls with inertia, and the joints that move them.

Inertia is that of the hulls, with the URDF's masses: URDFs have stand-ins in its place. The Panda's in pybullet_data
gives every link, fingers included, 0.1 kg m^2 about each axis.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal
from xml.etree import ElementTree

import numpy as np

from tamp.task import Pose, RobotSpec
from tamp.task.mesh.parts import Part
from tamp.world.geometry.object_geometry import geometry_of
from tamp.world.robot.urdf import LinkShape, link_shapes

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

DENSITY = 1000.0
"""Of a link of which the URDF gives no mass [kg/m^3]."""

LEAST_MASS, LEAST_MOMENT = 0.001, 1e-6
"""Of a link that moves and has no hull [kg], [kg m^2]: no physics engine moves what has no mass."""

Kind = Literal["fixed", "revolute", "prismatic"]


@dataclass(frozen=True)
class Joint:
    """What joins a link to its parent.

    Attributes:
        name: as in the URDF.
        kind: "fixed" also for joints that the robot does not drive: what nothing drives stands still.
        axis: in the link's frame.
        lower, upper: limits, [rad] or [m].
        effort: largest torque or force, [N m] or [N]; None where the URDF gives none.
    """

    name: str
    kind: Kind
    axis: tuple[float, ...]
    lower: float
    upper: float
    effort: float | None


@dataclass(frozen=True, eq=False)
class Link:
    """A link of a robot.

    Attributes:
        name: as in the URDF.
        parent: of the link that carries it; None for the base.
        pose: of its frame in the parent's with the joint at 0; of the base in the world.
        joint: to the parent; None for the base.
        hulls: convex parts in its frame.
        mass: [kg]; 0 for a frame without hulls.
        frame, moments: centre of mass and principal axes in its frame, and the moments about them [kg m^2].
    """

    name: str
    parent: str | None
    pose: Pose
    joint: Joint | None
    hulls: tuple[Part, ...]
    mass: float
    frame: Pose
    moments: tuple[float, ...]


def robot_links(robot: RobotSpec) -> Iterator[Link]:
    """Yield a robot's links, each after its parent.

    Raises:
        RobotError: where the URDF cannot be used.
    """
    shapes = link_shapes(robot)
    root = ElementTree.fromstring(robot.description)
    links = {link.get("name", ""): link for link in root.findall("link")}
    joints = root.findall("joint")
    children = {_end(joint, "child") for joint in joints}
    waiting: list[tuple[str, ElementTree.Element | None]] = [(name, None) for name in links if name not in children]
    while waiting:
        name, joint = waiting.pop()
        pose = robot.T_world_base if joint is None else _origin(joint)
        hulls, mass, frame, moments = _solid(links[name], [shape for shape in shapes if shape.link == name])
        made = None if joint is None else _joint(joint, robot)
        yield Link(name, None if joint is None else _end(joint, "parent"), pose, made, hulls, mass, frame, moments)
        waiting += [(_end(j, "child"), j) for j in joints if _end(j, "parent") == name]


def merged_fingers(robot: RobotSpec) -> tuple[tuple[Link, ...], dict[str, str]]:
    """The links with all that is fixed to a moving part of the gripper made one with it.

    Returns:
        The links, each after its parent, and for each link of the URDF the name of the one that it is part of.
    """
    made: dict[str, Link] = {}
    part_of: dict[str, str] = {}
    place: dict[str, Pose] = {}  # of each link of the URDF in the one that it is part of
    swinging: set[str] = set()
    for link in robot_links(robot):
        carrier = None if link.parent is None else part_of[link.parent]
        pose = link.pose if link.parent is None else place[link.parent] @ link.pose
        if carrier in swinging and link.joint is not None and link.joint.kind == "fixed":
            part_of[link.name], place[link.name] = carrier, pose
            made[carrier] = _joined(made[carrier], link, pose)
            continue
        part_of[link.name], place[link.name] = link.name, Pose()
        made[link.name] = replace(link, parent=carrier, pose=pose)
        if carrier in swinging or (link.joint is not None and link.joint.name in robot.gripper.joints):
            swinging.add(link.name)
    return tuple(made.values()), part_of


def _joined(link: Link, other: Link, T_link_other: Pose) -> Link:
    """A link with another's hulls as its own, the mass of both spread over them evenly."""
    T = T_link_other.matrix
    moved = tuple(Part(hull.vertices @ T[:3, :3].T + T[:3, 3], hull.faces) for hull in other.hulls)
    hulls, mass = (*link.hulls, *moved), link.mass + other.mass
    if not hulls:
        return link
    solid = geometry_of(hulls)
    frame, moments = principal(solid.center_of_mass, mass * solid.inertia)
    return replace(link, hulls=hulls, mass=mass, frame=frame, moments=moments)


def _end(joint: ElementTree.Element, role: str) -> str:
    element = joint.find(role)
    return "" if element is None else element.get("link", "")


def _origin(joint: ElementTree.Element) -> Pose:
    origin = joint.find("origin")
    if origin is None:
        return Pose()
    x, y, z = map(float, origin.get("xyz", "0 0 0").split())
    roll, pitch, yaw = map(float, origin.get("rpy", "0 0 0").split())
    return Pose.from_rpy((x, y, z), (roll, pitch, yaw))


def _joint(joint: ElementTree.Element, robot: RobotSpec) -> Joint:
    name, given = joint.get("name", ""), joint.get("type", "")
    kind: Kind = "fixed"
    if name in (*robot.joints, *robot.gripper.joints):
        kind = "prismatic" if given == "prismatic" else "revolute"
    axis, limit = joint.find("axis"), joint.find("limit")
    ends = {} if limit is None else dict(limit.items())
    return Joint(
        name=name,
        kind=kind,
        axis=(1.0, 0.0, 0.0) if axis is None else tuple(map(float, axis.get("xyz", "1 0 0").split())),
        lower=float(ends.get("lower", "-inf")),
        upper=float(ends.get("upper", "inf")),
        effort=float(ends["effort"]) if "effort" in ends else None,
    )


def _solid(
    link: ElementTree.Element, shapes: list[LinkShape]
) -> tuple[tuple[Part, ...], float, Pose, tuple[float, ...]]:
    if not shapes:
        return (), 0.0, Pose(), (0.0, 0.0, 0.0)
    hulls = tuple(shape.hull for shape in shapes)
    solid, given = geometry_of(hulls), link.find("inertial/mass")
    mass = DENSITY * solid.volume if given is None else float(given.get("value", ""))
    frame, moments = principal(solid.center_of_mass, mass * solid.inertia)
    return hulls, mass, frame, moments


def principal(center: Array, inertia: Array) -> tuple[Pose, tuple[float, ...]]:
    """A centre of mass, (3,) [m], and an inertia about it, (3, 3), as a frame of principal axes and the moments."""
    moments, axes = np.linalg.eigh(inertia)
    T = np.eye(4)
    T[:3, :3] = axes if np.linalg.det(axes) > 0 else axes @ np.diag([1.0, 1.0, -1.0])
    T[:3, 3] = center
    return Pose.from_matrix(T), tuple(float(v) for v in moments)
