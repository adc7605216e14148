"""Rigid bodies in PyBullet: a shape becomes a compound of convex pieces with the mass properties of its parts.

A mesh goes to PyBullet as an OBJ file with one group per convex part: that is its only way to a body of more than
sixteen pieces.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tamp.execution.pybullet.client import pybullet
from tamp.execution.renderer import Color
from tamp.task.mesh.parts import Part, convex_hull, parts
from tamp.task.model import Box, Capsule, Cylinder, Inertia, Mesh, Shape, Sphere
from tamp.task.pose import Pose
from tamp.world.geometry.object_geometry import load_geometry

if TYPE_CHECKING:
    from numpy.typing import NDArray

SPINNING_FRICTION = 0.1
"""Resistance of a contact patch against turning about its normal, as PyBullet counts it; without it grasps pivot."""

ROLLING_FRICTION = 1e-4
"""Resistance against rolling: what lets a lying can come to rest."""


MARGIN = 0.001
"""How far outside its vertices PyBullet lets a hull begin [m]."""


SLIVER = 1e-6
"""Share of the largest face's area below which a face has no direction."""

STIFF = 1e-6
"""How little a vertex moves along what the faces around it do not tell, beside what they tell."""

OFF = 0.05
"""Of the margin, by which a face may miss where it should be moved to."""

FARTHEST = 4.0
"""Of the margin, which a vertex moves at most: the tip of a wedge would go far."""


@dataclass(frozen=True)
class Material:
    """What a body's surface and bulk are.

    Attributes:
        mass: [kg]; 0 for what cannot move.
        friction: coefficient of lateral friction; a contact has the product of its two bodies'.
        color: red, green, blue, opacity in 0..1, or None for a body that is never drawn.
        inertia: how the mass is spread; None is evenly.
    """

    mass: float
    friction: float
    color: Color | None = None
    inertia: Inertia | None = None


@dataclass(frozen=True)
class Body:
    """A body in a PyBullet world.

    Attributes:
        id: PyBullet's number of it.
        mass: [kg]; 0 for what cannot move.
        friction: coefficient of lateral friction.
        T_object_inertial: centre of mass and principal axes in the object's frame, the frame PyBullet reports.
    """

    id: int
    mass: float
    friction: float
    T_object_inertial: Pose

    def pose(self, client: int) -> Pose:
        """Where the object's frame stands in the world."""
        T_world_inertial = Pose(*pybullet.getBasePositionAndOrientation(self.id, physicsClientId=client))
        return T_world_inertial @ self.T_object_inertial.inverse()

    def place(self, client: int, T_world_object: Pose) -> None:
        """Put the body at rest at a pose. For building a scene, never for moving what a robot should move."""
        T = T_world_object @ self.T_object_inertial
        pybullet.resetBasePositionAndOrientation(self.id, T.xyz, T.quat, physicsClientId=client)


def create_body(client: int, folder: Path, shape: Shape, material: Material, T_world_object: Pose) -> Body:
    """Add a shape to a world.

    Args:
        client: PyBullet's number of the world.
        folder: where mesh files for PyBullet may be written; must live as long as the world.
        shape: the geometry.
        material: mass, friction and colour.
        T_world_object: where it starts.

    Raises:
        TaskError: where the shape's mesh cannot be used.
    """
    T_object_inertial, principal = _mass_properties(shape)
    moments = [material.mass * value for value in principal]
    if material.inertia is not None:
        T_object_inertial, moments = material.inertia.frame, list(material.inertia.moments)
    geometry = _geometry(folder, shape, MARGIN)
    visual = -1
    if material.color is not None:
        exact = _geometry(folder, shape, 0.0)
        looks = {"length" if key == "height" else key: value for key, value in exact.items()}
        visual = pybullet.createVisualShape(**looks, rgbaColor=material.color, physicsClientId=client)
    body = pybullet.createMultiBody(
        baseMass=material.mass,
        baseCollisionShapeIndex=pybullet.createCollisionShape(**geometry, physicsClientId=client),
        baseVisualShapeIndex=visual,
        basePosition=T_world_object.xyz,
        baseOrientation=T_world_object.quat,
        baseInertialFramePosition=T_object_inertial.xyz,
        baseInertialFrameOrientation=T_object_inertial.quat,
        physicsClientId=client,
    )
    dynamics = {"localInertiaDiagonal": moments} if material.mass > 0 else {}
    pybullet.changeDynamics(
        body,
        -1,
        lateralFriction=material.friction,
        spinningFriction=SPINNING_FRICTION,
        rollingFriction=ROLLING_FRICTION,
        physicsClientId=client,
        **dynamics,
    )
    return Body(body, material.mass, material.friction, T_object_inertial)


@lru_cache(maxsize=1024)
def _mass_properties(shape: Shape) -> tuple[Pose, tuple[float, ...]]:
    """Centre of mass with principal axes, and the principal moments of inertia for a mass of one kilogram."""
    geometry = load_geometry(shape)
    moments, axes = np.linalg.eigh(geometry.inertia)
    T = np.eye(4)
    T[:3, :3] = axes if np.linalg.det(axes) > 0 else axes @ np.diag([1.0, 1.0, -1.0])
    T[:3, 3] = geometry.center_of_mass
    return Pose.from_matrix(T), tuple(float(v) for v in moments)


def _geometry(folder: Path, shape: Shape, margin: float) -> dict[str, object]:
    """The arguments that describe a shape to PyBullet, a mesh less `margin` [m]."""
    if isinstance(shape, Box):
        return {"shapeType": pybullet.GEOM_BOX, "halfExtents": [side / 2 for side in shape.size]}
    if isinstance(shape, Sphere):
        return {"shapeType": pybullet.GEOM_SPHERE, "radius": shape.radius}
    if isinstance(shape, Cylinder):
        return {"shapeType": pybullet.GEOM_CYLINDER, "radius": shape.radius, "height": shape.height}
    if isinstance(shape, Capsule):
        return {"shapeType": pybullet.GEOM_CAPSULE, "radius": shape.radius, "height": shape.height}
    return {"shapeType": pybullet.GEOM_MESH, "fileName": str(write_obj(folder, _obj_text(shape, margin)))}


@lru_cache(maxsize=256)
def _obj_text(shape: Mesh, margin: float) -> str:
    return hulls_as_obj(parts(shape), margin)


def hulls_as_obj(pieces: tuple[Part, ...], margin: float = MARGIN) -> str:
    """An OBJ file with one group per convex part, each drawn in by `margin` [m]: the one that PyBullet adds to it."""
    lines: list[str] = []
    first = 1
    draw = _drawn_in if len(pieces) == 1 else _along_axes
    for number, part in enumerate(pieces):
        lines.append(f"o part_{number}")
        lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in draw(part, margin).tolist()]
        lines += [f"f {a + first} {b + first} {c + first}" for a, b, c in part.faces.tolist()]
        first += len(part.vertices)
    return "\n".join(lines) + "\n"


def write_obj(folder: Path, text: str) -> Path:
    """Write an OBJ file under a name that the folder does not have yet."""
    path = folder / f"body_{sum(1 for _ in folder.iterdir())}.obj"
    path.write_text(text, encoding="utf-8")
    return path


def _drawn_in(part: Part, margin: float) -> NDArray[np.float64]:
    """The vertices, shape (n, 3) [m], of a convex object moved inwards by `margin` [m].

    Exact where the faces that meet at a vertex all can be moved by that much, as at a brick's, be it slanted: what is
    broad stays level, which decides whether it stands. Else they move along the principal axes of their cloud.
    """
    moved = _with_faces(part, margin)
    return _along_axes(part, margin) if moved is None else moved


def _with_faces(part: Part, margin: float) -> NDArray[np.float64] | None:
    """The vertices where each moves as the faces around it do; None where these do not meet in one point after that."""
    faces, normals, areas = _broad_faces(part)
    moved = np.minimum(margin, np.ptp(part.vertices @ normals.T, axis=0) / 4)
    weights, wanted = np.zeros((len(part.vertices), 3, 3)), np.zeros((len(part.vertices), 3))
    for column in faces.T:
        np.add.at(weights, column, areas[:, None, None] * normals[:, :, None] * normals[:, None, :])
        np.add.at(wanted, column, -(areas * moved)[:, None] * normals)
    weights += STIFF * np.maximum(np.trace(weights, axis1=1, axis2=2), 1e-12)[:, None, None] * np.eye(3)
    shifts = np.linalg.solve(weights, wanted[:, :, None])[:, :, 0]
    off = np.abs(np.einsum("fkx,fx->fk", shifts[faces], normals) + moved[:, None]).max()
    far = np.linalg.norm(shifts, axis=1).max()
    return np.asarray(part.vertices + shifts) if off <= OFF * margin and far <= FARTHEST * margin else None


def _along_axes(part: Part, margin: float) -> NDArray[np.float64]:
    """The vertices moved along the principal axes of their cloud, which is within a fraction of the margin.

    `eroded` is exact, with several times the vertices. What is thinner than four times the margin keeps half of its
    thickness. Between fingers a wall of pieces drawn in like this, each by itself, is held more firmly than an exact
    one, whose contacts wander.
    """
    vertices = part.vertices
    center = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
    _, axes = np.linalg.eigh(np.cov((vertices - center).T))
    local = (vertices - center) @ axes
    low, high = local.min(axis=0), local.max(axis=0)
    middle, half = (low + high) / 2, (high - low) / 2
    shrunk = middle + (local - middle) * np.maximum(0.5, 1 - margin / half)
    return np.asarray(shrunk @ axes.T + center)


def _broad_faces(part: Part) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """The faces of a convex part but for slivers, (m, 3), their outward unit normals, (m, 3), and twice their areas."""
    a, b, c = (part.vertices[part.faces[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    areas = np.linalg.norm(normals, axis=1)
    broad = areas > SLIVER * areas.max()
    return part.faces[broad], normals[broad] / areas[broad, None], areas[broad]


def eroded(part: Part, margin: float = MARGIN) -> Part:
    """What is left of a convex part when each of its faces moves inwards by `margin` [m], so that none is tilted.

    The vertices of an intersection of half-spaces are the faces of the hull of their dual points n / d, for planes
    n x = d around the origin. What is thinner than twice the margin keeps about half of its thickness.
    """
    faces, normals, _ = _broad_faces(part)
    center = part.vertices.mean(axis=0)
    distances = np.einsum("ij,ij->i", normals, part.vertices[faces[:, 0]] - center)
    moved = distances - min(margin, distances.min() / 2)
    points = normals / moved[:, None]
    _, kept = np.unique(np.round(points / np.abs(points).max(), 9), axis=0, return_index=True)
    dual = convex_hull(points[np.sort(kept)])  # of faces in one plane a single one: between two the direction is lost
    p, q, r = (dual.vertices[dual.faces[:, i]] for i in range(3))
    planes = np.cross(q - p, r - p)
    return convex_hull(planes / np.einsum("ij,ij->i", planes, p)[:, None] + center)
