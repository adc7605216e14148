"""Rigid bodies in SAPIEN: a shape becomes one collision shape a convex part, with the mass properties of its parts."""

from __future__ import annotations

from typing import Any

import numpy as np

from tamp.execution.robot.links import principal
from tamp.execution.sapien.client import physx, sapien
from tamp.task import Object, Pose
from tamp.task.mesh.parts import Part, parts
from tamp.task.model import Box, Capsule, Shape, Sphere
from tamp.world.geometry.object_geometry import load_geometry

FIXED_FRICTION = 0.5
"""Of table and robot, as PhysX counts it: a contact has the mean of its two bodies' coefficients."""

CONTACT_OFFSET = 0.002
"""How near bodies come before a contact is prepared [m]."""

REST_OFFSET = 0.00005
"""Half of the distance at which bodies rest [m].

PhysX measures how far bodies are apart well, and how deep they are in each other badly: of a finger that just touched a
thin wall it found 15 mm along the wall once, and kicked the cup away.
"""

PATCH = 0.01
"""Radius of the patch that resists turning about a contact's normal [m]."""

PARTING_SPEED = 0.5
"""How fast bodies that are in each other part at most [m/s]."""

ROBOT_GROUP = 1 << 4
"""Bit of the collision groups that keeps the robot's links from meeting each other."""


def material(friction: float) -> Any:
    """An object's material: with table and pads, whose own coefficients are 1, a contact has the object's friction.

    That asks for the mean of this and `FIXED_FRICTION`; below half of the latter it cannot be had.
    """
    own = max(0.0, 2.0 * friction - FIXED_FRICTION)
    return physx.PhysxMaterial(own, own, 0.0)


def fixed_material() -> Any:
    """The material of table and robot."""
    return physx.PhysxMaterial(FIXED_FRICTION, FIXED_FRICTION, 0.0)


def add_shapes(body: Any, shape: Shape, surface: Any) -> None:
    """Give a body the geometry of a shape, in the body's frame.

    Raises:
        TaskError: where the shape's mesh cannot be used.
    """
    if isinstance(shape, Box):
        _attach(body, physx.PhysxCollisionShapeBox([side / 2 for side in shape.size], surface))
    elif isinstance(shape, Sphere):
        _attach(body, physx.PhysxCollisionShapeSphere(shape.radius, surface))
    elif isinstance(shape, Capsule):
        along = physx.PhysxCollisionShapeCapsule(shape.radius, shape.height / 2, surface)
        along.local_pose = sapien.Pose(q=[np.sqrt(0.5), 0.0, -np.sqrt(0.5), 0.0])  # PhysX has them along x
        _attach(body, along)
    else:
        for part in parts(shape):
            add_hull(body, part, surface)


def add_hull(body: Any, part: Part, surface: Any, group: int = 0) -> None:
    """Give a body a convex part, in the body's frame."""
    hull = physx.PhysxCollisionShapeConvexMesh(part.vertices.astype(np.float32), [1.0, 1.0, 1.0], surface)
    hull.set_collision_groups([1, 1, group, 0])
    _attach(body, hull)


def _attach(body: Any, shape: Any) -> None:
    shape.contact_offset, shape.rest_offset = CONTACT_OFFSET, REST_OFFSET
    shape.patch_radius = shape.min_patch_radius = PATCH
    body.attach(shape)


def add_object(scene: Any, item: Object, pose: Pose) -> Any:
    """Add an object that moves freely; the body.

    Raises:
        TaskError: where the object's mesh cannot be used.
    """
    body = physx.PhysxRigidDynamicComponent()
    add_shapes(body, item.shape, material(item.friction))
    geometry = load_geometry(item.shape)
    frame, moments = principal(geometry.center_of_mass, item.mass * geometry.inertia)
    if item.inertia is not None:
        frame, moments = item.inertia.frame, item.inertia.moments
    set_inertia(body, item.mass, frame, moments)
    body.linear_damping = body.angular_damping = 0.0
    add_body(scene, body, pose)
    return body


def add_fixed(scene: Any, shape: Shape, pose: Pose) -> Any:
    """Add what does not move; the body."""
    body = physx.PhysxRigidStaticComponent()
    add_shapes(body, shape, fixed_material())
    add_body(scene, body, pose)
    return body


def add_body(scene: Any, body: Any, pose: Pose) -> None:
    """Put a body into a scene."""
    entity = sapien.Entity()
    entity.add_component(body)
    entity.pose = to_sapien(pose)
    scene.add_entity(entity)


def set_inertia(body: Any, mass: float, frame: Pose, moments: tuple[float, ...]) -> None:
    """Give a body its mass [kg], centre of mass and principal axes, and the moments about them [kg m^2]."""
    body.max_depenetration_velocity = PARTING_SPEED
    body.mass = mass
    body.cmass_local_pose = to_sapien(frame)
    body.inertia = list(moments)


def to_sapien(pose: Pose) -> Any:
    """A pose as SAPIEN has it."""
    x, y, z, w = pose.quat
    return sapien.Pose(list(pose.xyz), [w, x, y, z])


def from_sapien(pose: Any) -> Pose:
    """A pose of SAPIEN's, which has single precision."""
    w, x, y, z = pose.q.tolist()
    px, py, pz = pose.p.tolist()
    return Pose((px, py, pz), (x, y, z, w))
