"""The signed distance between two solids, by python-fcl (GJK)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import fcl
import numpy as np
from scipy.spatial import ConvexHull

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.checking.solids import Piece, Solid
    from tamp.task.mesh import Part

    Array = NDArray[np.float64]


def collision_object(part: Part) -> Any:
    """A convex part as fcl sees it."""
    faces = np.column_stack([np.full(len(part.faces), 3), part.faces]).ravel().astype(np.int64)
    return fcl.CollisionObject(fcl.Convex(np.array(part.vertices), len(part.faces), faces))


def clearance(a: Solid, b: Solid, T_a_b: Array, tolerance: float) -> float:
    """A lower bound of the signed distance between two solids [m]; negative values are depths.

    Where the hulls are apart it is their distance, else the least over pairs of pieces. Depths up to `tolerance` are
    fcl's, which never understate; deeper ones are computed exactly before anybody is accused.

    Args:
        a: one solid.
        b: the other.
        T_a_b: frame of b in the frame of a, shape (4, 4).
        tolerance: depth from which it must be exact [m].
    """
    transform = fcl.Transform(T_a_b[:3, :3], T_a_b[:3, 3])
    if len(a.pieces) > 1 or len(b.pieces) > 1:
        apart = _gap(a.hull, b.hull, transform, T_a_b)
        if apart > 0.0:
            return apart
    centers = b.centers @ T_a_b[:3, :3].T + T_a_b[:3, 3]
    gaps = np.linalg.norm(a.centers[:, None] - centers[None], axis=2) - a.radii[:, None] - b.radii[None]
    least = np.inf
    for flat in np.argsort(gaps, axis=None):
        i, j = divmod(int(flat), len(b.pieces))
        if gaps[i, j] >= max(least, 0.0):
            break
        least = min(least, _signed(a.pieces[i], b.pieces[j], transform, T_a_b, tolerance))
    return float(least) if np.isfinite(least) else float(gaps.min())


def _gap(a: Piece, b: Piece, transform: Any, T_a_b: Array) -> float:
    """A lower bound of the distance between two pieces, and the distance almost always; -1 where they may touch.

    fcl sometimes stops early and overstates a distance by some percent. The line between the nearest points it names
    is the normal of a slab, and what lies between the pieces along it is a distance that is certain.
    """
    b.moving.setTransform(transform)
    result = fcl.DistanceResult()
    if fcl.distance(a.still, b.moving, fcl.DistanceRequest(enable_nearest_points=True), result) <= 0.0:
        return -1.0
    on_a, on_b = result.nearest_points
    normal = on_b - on_a
    normal = normal / np.linalg.norm(normal)
    nearest = (b.part.vertices @ (T_a_b[:3, :3].T @ normal)).min() + normal @ T_a_b[:3, 3]
    certain = float(nearest - (a.part.vertices @ normal).max())
    return certain if certain > 0.0 else -1.0


def _signed(a: Piece, b: Piece, transform: Any, T_a_b: Array, tolerance: float) -> float:
    apart = _gap(a, b, transform, T_a_b)
    if apart > 0.0:
        return apart
    result = fcl.CollisionResult()
    if not fcl.collide(a.still, b.moving, fcl.CollisionRequest(num_max_contacts=1, enable_contact=True), result):
        return 0.0
    depth = float(result.contacts[0].penetration_depth)
    return -depth if depth <= tolerance else -penetration(a.part, b.part, T_a_b)


def penetration(a: Part, b: Part, T_a_b: Array) -> float:
    """Depth to which two convex parts interpenetrate [m]; negative where they are apart.

    The distance of the origin from the boundary of their Minkowski difference (Cameron and Culley, "Determining the
    minimum translational distance between two convex polyhedra", ICRA 1986), whose hull is computed outright.
    """
    moved = b.vertices @ T_a_b[:3, :3].T + T_a_b[:3, 3]
    difference = (a.vertices[:, None] - moved[None]).reshape(-1, 3)
    return float(-ConvexHull(difference).equations[:, 3].max())
