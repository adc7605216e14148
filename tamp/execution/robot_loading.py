"""Bringing a robot into a PyBullet world: its URDF with the hulls that the planner sees, its fingers coupled."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from xml.etree import ElementTree

from tamp.errors import RobotError
from tamp.execution.bodies import hulls_as_obj, write_obj
from tamp.execution.bullet import pybullet
from tamp.execution.robot_body import RobotBody
from tamp.task import RobotSpec
from tamp.task.robot import PAD_FRICTION
from tamp.world.urdf import link_shapes

SPINNING_FRICTION = 0.1
"""Resistance of a pad against turning about the contact's normal, as PyBullet counts it."""

COUPLING_FORCE = 200.0
"""Largest force of the gear that keeps two fingers at equal distances from the middle [N]."""


def load_robot_body(
    client: int, folder: Path, spec: RobotSpec, q: Sequence[float], *, visible: bool = False
) -> RobotBody:
    """Add a robot to a world, its base fixed, its arm at `q` [rad], its fingers open.

    Args:
        client: PyBullet's number of the world.
        folder: where files for PyBullet may be written; must live as long as the world.
        spec: the robot as data.
        q: arm configuration to start from [rad].
        visible: whether it can be drawn; its visual meshes take a second to load.

    Raises:
        RobotError: where the URDF cannot be read or lacks a joint or link that the robot names.
    """
    try:
        robot = pybullet.loadURDF(
            str(_resolved_urdf(folder, spec)),
            spec.T_world_base.xyz,
            spec.T_world_base.quat,
            useFixedBase=True,
            flags=0 if visible else pybullet.URDF_IGNORE_VISUAL_SHAPES,
            physicsClientId=client,
        )
    except pybullet.error as error:
        raise RobotError(f"{spec.urdf}: PyBullet cannot load it: {error}") from error
    infos = [
        pybullet.getJointInfo(robot, joint, physicsClientId=client)
        for joint in range(pybullet.getNumJoints(robot, physicsClientId=client))
    ]
    joints = {info[1].decode(): info[0] for info in infos}
    links = {info[12].decode(): info[0] for info in infos}
    for name, known in (*((j, joints) for j in (*spec.joints, *spec.gripper.joints)), (spec.tool_parent, links)):
        if name not in known:
            raise RobotError(f"{spec.urdf}: there is no {name!r}; the URDF has {', '.join(sorted(known))}")
    arm = tuple(joints[name] for name in spec.joints)
    body = RobotBody(
        spec=spec,
        client=client,
        id=robot,
        arm=arm,
        fingers=tuple(joints[name] for name in spec.gripper.joints),
        tool_parent=links[spec.tool_parent],
        effort=tuple(float(infos[joint][10]) for joint in arm),
    )
    _set_up(body, q)
    return body


def _set_up(body: RobotBody, q: Sequence[float]) -> None:
    body.set_state(q, body.spec.gripper.stroke)
    for finger in body.fingers:
        pybullet.changeDynamics(
            body.id,
            finger,
            lateralFriction=PAD_FRICTION,
            spinningFriction=SPINNING_FRICTION,
            physicsClientId=body.client,
        )
    if len(body.fingers) == 2:
        _couple(body)
    body.command(q)
    body.open_to(body.spec.gripper.stroke)


def _couple(body: RobotBody) -> None:
    """Keep both fingers at the same distance from the middle: without it the stronger pushes the object aside."""
    left, right = body.fingers
    gear = pybullet.createConstraint(
        body.id,
        left,
        body.id,
        right,
        pybullet.JOINT_GEAR,
        jointAxis=[1, 0, 0],
        parentFramePosition=[0, 0, 0],
        childFramePosition=[0, 0, 0],
        physicsClientId=body.client,
    )
    pybullet.changeConstraint(gear, gearRatio=-1, erp=0.1, maxForce=COUPLING_FORCE, physicsClientId=body.client)


def _resolved_urdf(folder: Path, spec: RobotSpec) -> Path:
    """A copy of the URDF as PyBullet should read it.

    Each collision shape becomes the convex hull that the planner sees too, less PyBullet's margin: with it, fingers
    would be 2 mm closer to each other than planned. Visual meshes get absolute paths: PyBullet guesses what
    `package://` means.
    """
    hulls = iter(_hulls(spec))
    tree = ElementTree.parse(spec.urdf)
    for link in tree.iter("link"):
        for collision in link.findall("collision"):
            path = write_obj(folder, next(hulls))
            collision.clear()
            geometry = ElementTree.SubElement(collision, "geometry")
            ElementTree.SubElement(geometry, "mesh", filename=str(path))
        for mesh in link.iterfind("visual/geometry/mesh"):
            name = mesh.get("filename", "")
            root = spec.mesh_root if name.startswith("package://") else spec.urdf.parent
            mesh.set("filename", str(root / name.removeprefix("package://")))
    path = folder / "robot.urdf"
    tree.write(path, encoding="unicode")
    return path


@lru_cache(maxsize=16)
def _hulls(spec: RobotSpec) -> tuple[str, ...]:
    """An OBJ file for each collision shape of the URDF, in file order."""
    return tuple(hulls_as_obj((shape.hull,)) for shape in link_shapes(spec))
