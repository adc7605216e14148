"""The robot's links as they look, and where they and a camera on one of them are at a configuration."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree

import numpy as np

from tamp.errors import RobotError
from tamp.perception.cameras.camera import WORLD, Camera
from tamp.perception.rendering.surface import Surface, read_surface
from tamp.task.pose import Pose
from tamp.task.robot import RobotSpec
from tamp.world.robot.model import RobotModel, robot_model

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class LinkSurface:
    """The look of a link.

    Attributes:
        link: its name.
        surface: in the link's frame.
    """

    link: str
    surface: Surface


def link_pose(robot: RobotModel, link: str, q: Sequence[float], opening: float) -> Array:
    """`T_world_link`, shape (4, 4).

    Raises:
        RobotError: where the robot has no such link.
    """
    if not robot.model.existBodyName(link):
        names = sorted(name for name in {frame.name for frame in robot.model.frames} if robot.model.existBodyName(name))
        raise RobotError(f"{robot.spec.urdf}: there is no link {link!r}; the URDF has {', '.join(names)}")
    frame = robot.model.frames[robot.model.getBodyId(link)]
    joints = robot.joint_poses(np.array([q], dtype=np.float64), opening)[0]
    T: Array = joints[frame.parentJoint] @ frame.placement.homogeneous
    return T


def camera_pose(camera: Camera, spec: RobotSpec, q: Sequence[float]) -> Array:
    """`T_world_camera` of the optical frame with the arm at `q` [rad], shape (4, 4).

    Raises:
        RobotError: where the camera is mounted on a link that the robot does not have.
    """
    if camera.parent == WORLD:
        return camera.T_parent_camera.matrix
    return link_pose(robot_model(spec), camera.parent, q, spec.gripper.stroke) @ camera.T_parent_camera.matrix


@cache
def link_surfaces(spec: RobotSpec) -> tuple[LinkSurface, ...]:
    """Every visual mesh of the robot's URDF; shapes other than meshes are left out of pictures.

    Raises:
        RobotError: where the URDF cannot be read.
        TaskError: where a mesh cannot.
    """
    root = ElementTree.fromstring(spec.description)
    found = []
    for link in root.iter("link"):
        for visual in link.findall("visual"):
            mesh = visual.find("geometry/mesh")
            if mesh is not None:
                surface = read_surface(Path(mesh.get("filename", "")))
                found.append(LinkSurface(link.get("name", ""), _moved(surface, visual, mesh)))
    return tuple(found)


def robot_surface(spec: RobotSpec, q: Sequence[float], opening: float) -> Surface:
    """All links in the world frame as one surface."""
    robot = robot_model(spec)
    pieces = link_surfaces(spec)
    first = np.cumsum([0, *(len(piece.surface.vertices) for piece in pieces)])
    poses = {name: link_pose(robot, name, q, opening) for name in dict.fromkeys(piece.link for piece in pieces)}
    placed = [p.surface.vertices @ poses[p.link][:3, :3].T + poses[p.link][:3, 3] for p in pieces]
    return Surface(
        np.concatenate(placed),
        np.concatenate([piece.surface.faces + start for piece, start in zip(pieces, first, strict=False)]),
        np.concatenate([piece.surface.colors for piece in pieces]),
    )


def _moved(surface: Surface, visual: ElementTree.Element, mesh: ElementTree.Element) -> Surface:
    scale = np.array([float(v) for v in mesh.get("scale", "1 1 1").split()])
    origin = visual.find("origin")
    T = np.eye(4)
    if origin is not None:
        xyz, rpy = ([float(v) for v in origin.get(key, "0 0 0").split()] for key in ("xyz", "rpy"))
        T = Pose.from_rpy((xyz[0], xyz[1], xyz[2]), (rpy[0], rpy[1], rpy[2])).matrix
    return Surface((surface.vertices * scale) @ T[:3, :3].T + T[:3, 3], surface.faces, surface.colors)
