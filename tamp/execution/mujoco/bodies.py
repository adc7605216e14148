"""Rigid bodies in MuJoCo: a shape becomes one geom a convex part, on a body with the mass properties of its parts.

Contacts are stiff and hardly slip: elliptic friction cones with friction that counts 400 times the normal
force's regularization (set in the simulator), and the impedance below. With MuJoCo's defaults a held block creeps by
2.5 mm/s.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import mujoco

from tamp.execution.robot.links import principal
from tamp.task import Object, Pose
from tamp.task.mesh.parts import Part, parts
from tamp.task.model import Box, Capsule, Cylinder, Shape, Sphere
from tamp.world.geometry.object_geometry import load_geometry

SOLREF = (0.005, 1.0)
"""Time constant [s] and damping ratio of a contact."""

SOLIMP = (0.95, 0.99, 0.0002, 0.5, 2.0)
"""Impedance of a contact: its least and largest value, the penetration between the two [m], middle and power.

A contact is as soft as what touches is light: with the largest value at a millimetre, fingers sink by 0.7 mm each into
0.1 kg that they squeeze with 100 N. With it at once, what slides touches in two of three steps.
"""

SPINNING_FRICTION = 0.1
"""Moment with which a contact resists turning about its normal, for each newton that it is pressed with [m].

That of two objects in the physics that plans are made for; a real patch has a tenth of it.
"""

ROLLING_FRICTION = 1e-4
"""Resistance against rolling [m]: what lets a lying can come to rest."""

STICKS = 30.0
"""Coefficient of friction from which on nothing slips: with the cone of 10,000 a held box is thrown 60 m away."""

MOVING, ROBOT = 1, 2
"""Collision groups: the robot meets what is of the first one, not itself."""


@dataclass(frozen=True)
class Friction:
    """Of a contact MuJoCo takes the larger coefficients, where a contact here has the product of its two bodies'.

    Table and robot, whose own coefficients are 1, therefore get none: against them an object's own counts, as it
    should. Between two objects the product is put in step by step, see `tamp.execution.mujoco.friction`.
    """

    lateral: float = 0.0
    group: int = MOVING


SOLID = Friction()


def add_geoms(spec: Any, body: Any, shape: Shape, friction: Friction) -> None:
    """Give a body of a model in the making the geometry of a shape, in the body's frame.

    Raises:
        TaskError: where the shape's mesh cannot be used.
    """
    geom = mujoco.mjtGeom
    if isinstance(shape, Box):
        _add(body, friction, geom.mjGEOM_BOX, [side / 2 for side in shape.size])
    elif isinstance(shape, Sphere):
        _add(body, friction, geom.mjGEOM_SPHERE, [shape.radius, 0.0, 0.0])
    elif isinstance(shape, Cylinder):
        _add(body, friction, geom.mjGEOM_CYLINDER, [shape.radius, shape.height / 2, 0.0])
    elif isinstance(shape, Capsule):
        _add(body, friction, geom.mjGEOM_CAPSULE, [shape.radius, shape.height / 2, 0.0])
    else:
        for part in parts(shape):
            add_hull(spec, body, part, friction)


def add_hull(spec: Any, body: Any, part: Part, friction: Friction) -> None:
    """Give a body of a model in the making a convex part, in the body's frame."""
    name = f"hull_{len(spec.meshes)}"
    # The body has its own inertia; that of the mesh only moves its frame about.
    spec.add_mesh(
        name=name,
        uservert=part.vertices.ravel().tolist(),
        userface=part.faces.ravel().tolist(),
        inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX,
    )
    _add(body, friction, mujoco.mjtGeom.mjGEOM_MESH, None, meshname=name)


def _add(body: Any, friction: Friction, kind: Any, size: list[float] | None, **more: Any) -> None:
    if size is not None:
        more["size"] = size
    body.add_geom(
        type=kind,
        mass=0.0,
        friction=[friction.lateral, SPINNING_FRICTION, ROLLING_FRICTION],
        condim=6,
        contype=friction.group,
        conaffinity=MOVING,
        solref=list(SOLREF),
        solimp=list(SOLIMP),
        **more,
    )


def add_object(spec: Any, item: Object, name: str, pose: Pose) -> None:
    """Add an object that moves freely.

    Args:
        spec: the model in the making.
        item: geometry, mass and friction.
        name: of the body in the model.
        pose: where it starts (world frame).

    Raises:
        TaskError: where the object's mesh cannot be used.
    """
    body = spec.worldbody.add_body(name=name, pos=pose.xyz, quat=wxyz(pose))
    body.add_joint(type=mujoco.mjtJoint.mjJNT_FREE, align=0)
    frame, moments = mass_properties(item.shape)
    moments = tuple(item.mass * moment for moment in moments)
    if item.inertia is not None:
        frame, moments = item.inertia.frame, item.inertia.moments
    set_inertia(body, item.mass, frame, moments)
    add_geoms(spec, body, item.shape, Friction(min(item.friction, STICKS)))


def set_inertia(body: Any, mass: float, frame: Pose, moments: tuple[float, ...]) -> None:
    """Give a body its mass [kg], centre of mass and principal axes, and the moments about them [kg m^2]."""
    body.explicitinertial = True
    body.mass, body.ipos, body.iquat, body.inertia = mass, frame.xyz, wxyz(frame), moments


def wxyz(pose: Pose) -> tuple[float, float, float, float]:
    """The orientation as MuJoCo writes it."""
    x, y, z, w = pose.quat
    return w, x, y, z


@lru_cache(maxsize=1024)
def mass_properties(shape: Shape) -> tuple[Pose, tuple[float, ...]]:
    """Centre of mass with principal axes, and the principal moments of inertia for a mass of one kilogram [m^2]."""
    geometry = load_geometry(shape)
    return principal(geometry.center_of_mass, geometry.inertia)
