"""Where what is perfectly round comes to rest: friction, which holds all else, lets it roll.

A ball is at rest just if the weight lies in the cone of the normals of its contacts, without friction: on one level
face, in a level groove, on three points round its middle. What of the weight they leave takes it on: the projection
of gravity onto the cone of the ways that they leave free (Moreau, "Decomposition orthogonale d'un espace hilbertien
selon deux cones mutuellement polaires", C. R. Acad. Sci. 255, 1962). It is followed so from where it is said to be, and
from a little aside, as it is never exactly on a ridge. A can that lies does the same across its axis.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.geometry.transforms import inverse
from tamp.checking.physics.least_squares import nnls
from tamp.task.model import Sphere

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from tamp.checking.scene import Scene, State
    from tamp.checking.tolerances import Tolerances
    from tamp.task.model import Capsule, Cylinder

    Array = NDArray[np.float64]

SLOPE = 0.005
"""Down which everything rolls that is perfectly round [rad]."""
LYING = 0.1
"""Level share of the axis of what lies is more than that of its square."""
STEP = 5e-4
"""Between two looks at what rolls [m]."""
LOOKS = 20
TOUCHES = 5e-5
"""What is nearer than this touches [m]."""
NEAR = 1e-6
"""To which it comes down, or out of what it is in [m]."""
ASIDE = 8
"""Ways from which it is followed besides."""
UP = np.array([0.0, 0.0, 1.0])


def rolls_down(scene: Scene, state: State, name: str, shape: Sphere | Cylinder | Capsule, allow: Tolerances) -> bool:
    """Whether what is perfectly round rolls farther than gaps may be wide before it comes to rest, if it does."""
    T = state.poses[name]
    along = None if isinstance(shape, Sphere) else T[:3, 2]
    if along is not None and abs(along[2]) > LYING:
        return False
    if along is not None and _on_slope(scene, state, name, along, shape.radius, allow):
        return True
    half = 0.0 if isinstance(shape, Sphere) else shape.height / 2
    up = UP if along is None else UP - along[2] * along
    near = list(_near(scene, state, name, along, half, 2 * allow.standing))
    angles = np.linspace(0.0, 2 * np.pi, ASIDE, endpoint=False)
    level = [np.zeros(3), *(allow.balance * np.array([np.cos(a), np.sin(a), 0.0]) for a in angles)]
    starts = {tuple(off if along is None else off - (off @ along) * along) for off in level}
    return any(_goes(near, shape.radius, up, np.array(off), allow.standing) for off in sorted(starts))


def _on_slope(scene: Scene, state: State, name: str, along: Array, radius: float, allow: Tolerances) -> bool:
    """Whether what lies `along` a unit vector does so on one flat face that slopes across it.

    Where such a face slopes along it too it touches that at one end only, as what it lies on seen from there does not
    tell.
    """
    faces: list[Array] = []
    room = 2 * allow.standing
    for other, T in state.standing(scene).items():
        local = (inverse(T) @ state.poses[name][:, 3])[:3]
        for piece in scene.solids[other].pieces if other != name else ():
            normals, offsets = piece.planes
            above = normals @ local - offsets
            if abs(float(above.max()) - radius) < room and _reaches(piece.corners, local, radius + room):
                faces.append(T[:3, :3] @ normals[above.argmax()])
    return len(faces) == 1 and faces[0][2] > LYING and abs(float(np.cross(along, faces[0])[2])) > SLOPE


def _reaches(corners: Array, point: Array, far: float) -> bool:
    """Whether a point is no farther than this from a box round corners, shape (n, 3) [m]."""
    off = np.maximum(np.maximum(corners.min(axis=0) - point, point - corners.max(axis=0)), 0.0)
    return float(np.linalg.norm(off)) < far


def _near(scene: Scene, state: State, name: str, along: Array | None, half: float, room: float) -> Iterator[Array]:
    """Corners of all convex pieces in reach of what is round, from its middle, shape (n, 3) each [m].

    Of what lies `along` a unit vector, by `half` its length to each side, only what is beside it, as seen that way.
    """
    solid, T = scene.solids[name], state.poses[name]
    for other, T_other in state.standing(scene).items():
        body = scene.solids[other]
        local = (inverse(T_other) @ T[:, 3])[:3]
        for k in np.flatnonzero(np.linalg.norm(body.centers - local, axis=1) < body.radii + solid.radius + room):
            if other == name:
                continue
            part = body.pieces[k].part
            corners = part.vertices @ T_other[:3, :3].T + T_other[:3, 3] - T[:3, 3]
            if along is not None:
                corners = _beside(corners, part.faces, along, half)
            if len(corners):
                yield corners


def _beside(corners: Array, faces: NDArray[np.int64], along: Array, half: float) -> Array:
    """A convex piece cut off by `half` [m] before and behind, and flattened along a unit vector, by its corners."""
    at = corners @ along
    ends = [corners[np.abs(at) <= half]]
    sides = np.unique(np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1), axis=0)
    a, b = sides.T
    for cut in (-half, half):
        crossed = (at[a] - cut) * (at[b] - cut) < 0.0
        i, j = a[crossed], b[crossed]
        share = (cut - at[i]) / (at[j] - at[i])
        ends.append(corners[i] + share[:, None] * (corners[j] - corners[i]))
    cut_off = np.concatenate(ends)
    flat: Array = cut_off - np.outer(cut_off @ along, along)
    return flat


def _goes(near: list[Array], radius: float, up: Array, start: Array, far: float) -> bool:
    """Whether what is round rolls farther than this from where it starts; it does where nothing carries it."""
    at, high = _settled(near, radius, up, start), np.inf
    for _ in range(LOOKS):
        gaps, normals = _gaps(near, radius, at)
        touching = normals[gaps < TOUCHES]
        left = up - touching.T @ nnls(touching.T, up)[0] if len(touching) else up
        steep = float(np.linalg.norm(left))
        if steep <= SLOPE or at @ up > high - SLOPE * STEP / 2:
            return False
        high, at = float(at @ up), _settled(near, radius, up, at - STEP / steep * left)
        if np.linalg.norm((at - start)[:2]) > far:
            return True
    return True


def _settled(near: list[Array], radius: float, up: Array, at: Array) -> Array:
    """Where what is round is once it is out of what it is in, and has come down to what is below it, shape (3,)."""
    for _ in range(LOOKS):
        gaps, normals = _gaps(near, radius, at)
        below = normals @ up > LYING
        if (gaps < -NEAR).any():
            first = int(gaps.argmin())
            at = at - gaps[first] * normals[first]
        elif below.any() and (down := float((gaps[below] / (normals[below] @ up)).min())) > NEAR:
            at = at - down * up
        else:
            break
    return at


def _gaps(near: list[Array], radius: float, at: Array) -> tuple[Array, Array]:
    """How far what is round is from each piece, shape (n,) [m], and the unit normals towards it, shape (n, 3)."""
    away = np.array([at - _nearest(corners - at) - at for corners in near]).reshape(-1, 3)
    length = np.linalg.norm(away, axis=1)
    outside = length > TOUCHES  # what its middle is in nobody can lead it out of
    return length[outside] - radius, away[outside] / length[outside, None]


def _nearest(corners: Array) -> Array:
    """The point of the convex hull of corners, shape (n, 3), that is nearest to the origin, shape (3,).

    Weights of corners that make both their sum one and the point none are, but for a factor, those of that point.
    """
    scale = float(np.linalg.norm(corners, axis=1).min()) + TOUCHES
    weights, _ = nnls(np.vstack([corners.T / scale, np.ones(len(corners))]), np.array([0.0, 0.0, 0.0, 1.0]))
    point: Array = corners.T @ weights / weights.sum()
    return point
