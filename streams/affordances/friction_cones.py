"""Does friction, and do walls, hold a pile at rest? Forces within the friction cones of all contacts that balance it.

The static equilibrium of several bodies is a linear program over the edges of linearised cones (Mattikalli, Baraff and
Khosla, "Finding all stable orientations of assemblies with friction", IEEE Transactions on Robotics and Automation
12(2), 1996). Such forces may exist though rigid bodies would not settle on them, so that this is asked of piles that
stood, and of what changes in them.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations, product
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.hand.finger_closing import felt
from tamp.streams.values import Placement
from tamp.streams.workspace import TABLE, Workspace
from tamp.task.model import TABLE_FRICTION
from tamp.task.robot import PAD_FRICTION
from tamp.world.geometry.half_spaces import half_spaces

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.task.mesh.parts import Part

    Array = NDArray[np.float64]

NEAR = 0.004  # surface this near to another body may press on it [m]
AROUND = 5e-4  # and no farther beside the face that it presses on [m]
FAR = 3 * NEAR  # what is farther than this from the box around a part is not near to it, however sharp its edges [m]
EDGES = 8  # of a linearised cone, which lies inside the true one
DIRECTIONS = 8  # in which the outermost contacts of one direction are kept: those between them change nothing
ENOUGH = 64  # contacts that mostly hold what all of them hold
FIRM = 0.74  # share of the friction of pads that a push may call on
LENGTH = 0.05  # by which moments are divided, so that they are of the order of the forces [m]
GIVEN = 5e-4  # how far elsewhere the centres of mass may lie, all together [m]


def in_equilibrium(
    workspace: Workspace,
    places: Mapping[str, Placement],
    fixed: Mapping[str, Placement] = MappingProxyType({}),
    margin: float = 0.0,
    centers: Mapping[str, Array] = MappingProxyType({}),
    near: float = NEAR,
) -> bool:
    """Whether forces within the friction cones of all contacts balance the weights of bodies at these placements.

    Args:
        workspace: the bodies.
        places: where those are that must be at rest.
        fixed: other bodies, which do not give way.
        margin: how far along x and y their centres of mass may shift, all alike [m].
        centers: body -> where its centre of mass is with all that it bears, (3,), if not where its own is.
        near: surface this near to another body may press on it [m].
    """
    names = sorted(places)
    row = {name: 6 * index for index, name in enumerate(names)}
    mass = np.array([workspace.task.object(name).mass for name in names])
    at = {name: centers.get(name, center_at(workspace, name, places[name])) for name in names}
    pushes = []
    standing = {**fixed, **places}
    for a, b in (*combinations(names, 2), *product(names, (*sorted(fixed), TABLE))):
        points, normals = touching(workspace, a, places[a], b, standing.get(b), near)
        if len(points):
            forces = _cones(normals, friction_of(workspace, a) * friction_of(workspace, b))
            pushes.append(_wrenches(at, row, {a: 1.0, b: -1.0}, points, forces))
    contacts = np.hstack([np.zeros((6 * len(names), 0)), *pushes]).reshape(6 * len(names), -1, EDGES)
    shifts, cost = np.zeros((6 * len(names), 4 * len(names))), np.repeat(LENGTH * mass.mean() / mass, 4)
    for index in range(len(names)):
        block = shifts[6 * index + 3 : 6 * index + 5, 4 * index : 4 * index + 4]
        block[:] = [[1.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0]]
    wanted = np.zeros((len(names), 6))
    wanted[:, 2] = mass / mass.mean()

    def held(some: Array) -> bool:
        columns = np.hstack([some.reshape(len(some), -1), shifts])
        costs = np.concatenate([np.zeros(columns.shape[1] - len(cost)), cost])
        for x, y in product(*[(-margin, margin)] * 2) if margin else [(0.0, 0.0)]:
            wanted[:, 3:5] = wanted[:, 2:3] * np.array([y, -x]) / LENGTH
            if least(costs, columns, wanted.reshape(-1)) > GIVEN:
                return False
        return True

    # What some of the contacts hold all of them hold; a bowl in another has over a thousand.
    stride = contacts.shape[1] // ENOUGH
    return (stride > 1 and held(contacts[:, ::stride])) or held(contacts)


def least(cost: Array, columns: Array, wanted: Array) -> float:
    """Least cost @ x where columns @ x == wanted and x >= 0; infinite where there is no such x."""
    from scipy.optimize import linprog

    found = linprog(cost, A_eq=columns, b_eq=wanted, method="highs")
    return float(found.fun) if found.status == 0 else np.inf


def touching(
    workspace: Workspace, a: str, at: Placement, b: str, there: Placement | None, near: float = NEAR
) -> tuple[Array, Array]:
    """Where two bodies press on each other: points, and unit normals into the first, each of shape (n, 3), world.

    Args:
        workspace: the bodies.
        a: the first.
        at: where it stands.
        b: the second.
        there: where that stands; None for the table.
        near: how far apart they may be [m].
    """

    def found() -> tuple[Array, Array]:
        if there is None:
            return _on_table(workspace, a, at, near)
        onto, back = _pressing(workspace, a, at, b, there, near), _pressing(workspace, b, there, a, at, near)
        points, normals = np.vstack([onto[0], back[0]]), np.vstack([onto[1], -back[1]])
        kept = _outermost(points, normals)
        return points[kept], normals[kept]

    return workspace.cache.value(("presses on", a, at, b, there, near), found)


def _on_table(workspace: Workspace, name: str, at: Placement, near: float) -> tuple[Array, Array]:
    points = workspace.points(name) @ at.pose.matrix[:3, :3].T + at.pose.matrix[:3, 3]
    points = points[points[:, 2] < near]
    normals = np.tile([0.0, 0.0, 1.0], (len(points), 1))
    kept = _outermost(points, normals)
    return points[kept], normals[kept]


def _pressing(
    workspace: Workspace, one: str, at: Placement, other: str, there: Placement, gap: float
) -> tuple[Array, Array]:
    """Points of a body on faces of another that part it from a convex part of the first, and the faces' normals."""
    T, T_other = at.pose.matrix, there.pose.matrix
    R, t = T_other[:3, :3].T @ T[:3, :3], (T[:3, 3] - T_other[:3, 3]) @ T_other[:3, :3]
    corners = [part.vertices @ R.T + t for part in workspace.world.geometries[one].parts]
    local = np.vstack([*corners, felt(workspace, one) @ R.T + t])
    near, normals = [np.zeros((0, 3))], [np.zeros((0, 3))]
    for part in workspace.world.geometries[other].parts:
        A, b = half_spaces(part)
        beside = local[around(part, local)]
        beyond = beside @ A.T - b
        within = (beyond < gap).all(axis=1)
        beside, beyond = beside[within], beyond[within]
        if not len(beside):
            continue
        lowest = np.stack([(A @ corner.T).min(axis=1) for corner in corners])
        parting = (lowest > b - gap).any(axis=0) & (beyond > -gap).any(axis=0)
        for face in np.flatnonzero(parting):
            above = np.flatnonzero(beyond[:, face] > -gap)
            onto = beyond[above] - np.outer(beyond[above, face], A @ A[face])  # moved onto the face
            on = beside[above[(onto < AROUND).all(axis=1)]]
            near.append(on @ T_other[:3, :3].T + T_other[:3, 3])
            normals.append(np.tile(T_other[:3, :3] @ A[face], (len(on), 1)))
    return np.vstack(near), np.vstack(normals)


def around(part: Part, points: Array) -> NDArray[np.bool_]:
    """Which points (n, 3) are in the box around a convex part, or a little beside it: most are far from it."""
    lower, upper = part.vertices.min(axis=0) - FAR, part.vertices.max(axis=0) + FAR
    near: NDArray[np.bool_] = ((points > lower) & (points < upper)).all(axis=1)
    return near


def _outermost(points: Array, normals: Array) -> NDArray[np.int64]:
    """Indices of the contacts that span those with about the same normal."""
    _, group = np.unique(np.round(normals, 1), axis=0, return_inverse=True)
    kept = [np.zeros(0, dtype=np.int64)]
    for members in (np.flatnonzero(group.reshape(-1) == k) for k in range(group.max(initial=-1) + 1)):
        along, across = _tangents(normals[members[:1]])
        angle = np.linspace(0.0, 2 * np.pi, DIRECTIONS, endpoint=False)[:, None]
        kept.append(
            members[np.unique((points[members] @ (np.cos(angle) * along + np.sin(angle) * across).T).argmax(0))]
        )
    return np.concatenate(kept)


def _tangents(normals: Array) -> tuple[Array, Array]:
    """Two unit vectors across each normal and each other, each of shape (n, 3)."""
    helper = np.where(np.abs(normals[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    along = np.cross(helper, normals)
    along /= np.linalg.norm(along, axis=1)[:, None]
    return along, np.cross(normals, along)


def _cones(normals: Array, friction: float) -> Array:
    """Forces along the edges of each contact's cone, shape (n, EDGES, 3)."""
    along, across = _tangents(normals)
    angle = np.linspace(0.0, 2 * np.pi, EDGES, endpoint=False)[None, :, None]
    forces: Array = normals[:, None] + friction * (np.cos(angle) * along[:, None] + np.sin(angle) * across[:, None])
    return forces


def _wrenches(
    centers: Mapping[str, Array], row: Mapping[str, int], signs: Mapping[str, float], points: Array, forces: Array
) -> Array:
    """What unit pushes add to the balance of each body: forces and scaled moments about its centre of mass."""
    block = np.zeros((6 * len(row), forces.shape[0] * EDGES))
    for name, sign in signs.items():
        if name in row:
            moments = np.cross((points - centers[name])[:, None], forces) / LENGTH
            wrench = np.concatenate([forces, moments], axis=2).reshape(-1, 6).T
            block[row[name] : row[name] + 6] = sign * wrench
    return block


def center_at(workspace: Workspace, name: str, place: Placement) -> Array:
    """Where the centre of mass of a body is that stands at a placement, shape (3,)."""
    T = place.pose.matrix
    center: Array = T[:3, :3] @ workspace.world.geometries[name].center_of_mass + T[:3, 3]
    return center


def pad_cone(workspace: Workspace, obj: str) -> float:
    """How far off a flank's normal fingers are counted on to push an object without slipping along there [rad]."""
    return float(np.arctan(FIRM * PAD_FRICTION * friction_of(workspace, obj)))


def sliding_share(workspace: Workspace, obj: str, on: tuple[str, ...]) -> float:
    """The share of its weight that pushes an object along what it stands on."""
    return friction_of(workspace, obj) * min((friction_of(workspace, name) for name in on), default=0.0)


def friction_of(workspace: Workspace, name: str) -> float:
    """The coefficient of an object or of the table; that of a contact is the product of two."""
    return TABLE_FRICTION if name == TABLE else workspace.task.object(name).friction
