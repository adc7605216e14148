"""Rigid bodies made of convex parts: surfaces, centres of mass, and the signed distance of two, by python-fcl (GJK)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import fcl
import numpy as np

from tamp.checking.geometry.polyhedra import parting
from tamp.checking.geometry.surface import surface_points
from tamp.checking.geometry.transforms import inverse
from tamp.task.mesh.parts import Part, convex_hull

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    Array = NDArray[np.float64]
    Mask = NDArray[np.bool_]


FAR_OFF = 100.0
"""From there on fcl is not asked: the squares of what it computes with overflow in the end [m]."""


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
    return parted(a, b, T_a_b, tolerance)[0]


def parted(a: Solid, b: Solid, T_a_b: Array, tolerance: float) -> tuple[float, Array]:
    """The `clearance` of two solids [m], and the unit normal of a plane between their hulls.

    The normal points from a to b, in the frame of a, shape (3,); zeros where the hulls are not known to be apart.
    """
    if np.abs(T_a_b[:3, 3]).max() > FAR_OFF:
        room = float(np.hypot.reduce(T_a_b[:3, 3]) - a.reach - b.reach)
        if room > 0.0:
            return room, np.zeros(3)
    transform = fcl.Transform(T_a_b[:3, :3], T_a_b[:3, 3])
    apart, normal = _gap(a.hull, b.hull, transform, T_a_b)
    if apart > 0.0:
        return apart, normal
    if len(a.pieces) == len(b.pieces) == 1:
        return -_depth(a.hull, b.hull, transform, T_a_b, tolerance), normal
    return _least(a, b, transform, T_a_b, tolerance), normal


def deeper(a: Solid, b: Solid, T_a_b: Array, depth: float) -> bool:
    """Whether two solids are deeper in each other than this, at least 0 [m]; `clearance` finds it too, in more time."""
    transform = fcl.Transform(T_a_b[:3, :3], T_a_b[:3, 3])
    if _gap(a.hull, b.hull, transform, T_a_b)[0] > 0.0:
        return False
    close = np.argwhere(_gaps_at_least(a, b, T_a_b) < 0.0)
    return any(_deeper(a.pieces[i], b.pieces[j], transform, T_a_b, depth) for i, j in close)


def crossed(a: Solid, b: Solid, T_a_b: Array) -> bool:
    """Whether two pieces are in each other by more than a quarter of what they are thick together.

    Two slabs are nowhere deeper in each other than half of that, whichever side they came from: near there nobody knows
    on which side of each other they are, and by how much either would have to move to be out of the other.
    """
    transform = fcl.Transform(T_a_b[:3, :3], T_a_b[:3, 3])
    for i, j in np.argwhere(_gaps_at_least(a, b, T_a_b) < 0.0):
        one, other = a.pieces[i], b.pieces[j]
        if _deeper(one, other, transform, T_a_b, (one.thickness + other.thickness) / 4):
            return True
    return False


def _deeper(a: Piece, b: Piece, transform: Any, T_a_b: Array, depth: float) -> bool:
    if _gap(a, b, transform, T_a_b)[0] > 0.0 or _depth(a, b, transform, T_a_b, np.inf) <= depth:
        return False
    # Out of a piece that has a corner of the other so far inside, the way is no shorter.
    if max(_reach_into(a, b, T_a_b), _reach_into(b, a, inverse(T_a_b))) > depth:
        return True
    return penetration(a, b, T_a_b) > depth


def _reach_into(a: Piece, b: Piece, T_a_b: Array) -> float:
    """How far inside the first piece the innermost corner of the second is [m]; negative where all are outside."""
    normals, offsets = a.planes
    return float((offsets - (b.corners @ T_a_b[:3, :3].T + T_a_b[:3, 3]) @ normals.T).min(axis=1).max())


def _least(a: Solid, b: Solid, transform: Any, T_a_b: Array, tolerance: float) -> float:
    """The least signed distance of the pieces of two solids [m], or a lower bound where all are apart."""
    gaps = _gaps_at_least(a, b, T_a_b)
    least = np.inf
    for flat in np.argsort(gaps, axis=None):
        i, j = divmod(int(flat), len(b.pieces))
        if gaps[i, j] >= max(least, 0.0):
            break
        least = min(least, _signed(a.pieces[i], b.pieces[j], transform, T_a_b, tolerance))
    return float(least) if np.isfinite(least) else float(gaps.min())


def _gaps_at_least(a: Solid, b: Solid, T_a_b: Array) -> Array:
    """Lower bounds of the distances of the pieces of two solids, shape (pieces of a, pieces of b) [m].

    By their spheres, and by their boxes along the axes of a.
    """
    R, t = T_a_b[:3, :3], T_a_b[:3, 3]
    gaps: Array = np.linalg.norm(a.centers[:, None] - (b.centers @ R.T + t)[None], axis=2)
    gaps -= a.radii[:, None] + b.radii[None]
    (lower_a, upper_a), (lower_b, upper_b) = a.boxes, b.boxes
    middle, half = (lower_b + upper_b) / 2 @ R.T + t, (upper_b - lower_b) / 2 @ np.abs(R).T
    apart = np.maximum((middle - half)[None] - upper_a[:, None], lower_a[:, None] - (middle + half)[None])
    return np.where((apart > 0.0).any(axis=2), np.maximum(gaps, np.linalg.norm(apart.clip(0.0), axis=2)), gaps)


def _gap(a: Piece, b: Piece, transform: Any, T_a_b: Array) -> tuple[float, Array]:
    """A lower bound of the distance between two pieces, and the distance almost always; -1 where they may touch.

    The unit normal of a plane that parts them comes with it, shape (3,), from a to b; zeros where they may touch.

    fcl sometimes stops early and overstates a distance by some percent. The line between the nearest points it names
    is the normal of a slab, and what lies between the pieces along it is a distance that is certain.
    """
    b.moving.setTransform(transform)
    result = fcl.DistanceResult()
    if fcl.distance(a.still, b.moving, fcl.DistanceRequest(enable_nearest_points=True), result) <= 0.0:
        return -1.0, np.zeros(3)
    on_a, on_b = result.nearest_points
    normal = on_b - on_a
    length = float(np.linalg.norm(normal))
    if length == 0.0:
        return -1.0, normal
    normal = normal / length
    nearest = (b.part.vertices @ (T_a_b[:3, :3].T @ normal)).min() + normal @ T_a_b[:3, 3]
    certain = float(nearest - (a.part.vertices @ normal).max())
    return (certain, normal) if certain > 0.0 else (-1.0, np.zeros(3))


def _signed(a: Piece, b: Piece, transform: Any, T_a_b: Array, tolerance: float) -> float:
    apart, _ = _gap(a, b, transform, T_a_b)
    return apart if apart > 0.0 else -_depth(a, b, transform, T_a_b, tolerance)


def _depth(a: Piece, b: Piece, transform: Any, T_a_b: Array, tolerance: float) -> float:
    """How deep two pieces that may touch are in each other [m]; `b.moving` is at `transform`."""
    result = fcl.CollisionResult()
    if not fcl.collide(a.still, b.moving, fcl.CollisionRequest(num_max_contacts=1, enable_contact=True), result):
        return 0.0
    depth = float(result.contacts[0].penetration_depth)
    return depth if depth <= tolerance else penetration(a, b, T_a_b)


def penetration(a: Piece, b: Piece, T_a_b: Array) -> float:
    """Depth to which two convex pieces interpenetrate [m]; negative where they are apart.

    The distance of the origin from the boundary of their Minkowski difference (Cameron and Culley, "Determining the
    minimum translational distance between two convex polyhedra", ICRA 1986), of whose faces each is looked at.
    """
    return -_parting(a, b, T_a_b)[0]


def parting_normals(a: Solid, b: Solid, T_a_b: Array) -> Iterator[Array]:
    """The `parting_normal` of each two pieces of two solids that are in each other."""
    for i, j in np.argwhere(_gaps_at_least(a, b, T_a_b) <= 0.0):
        apart, normal = _parting(a.pieces[i], b.pieces[j], T_a_b)
        if apart < 0.0:
            yield normal


def parting_normal(a: Piece, b: Piece, T_a_b: Array) -> Array:
    """Unit normal, shape (3,), in the frame of `a`, from `b` into `a`, of the plane that best parts two convex ones."""
    return _parting(a, b, T_a_b)[1]


def _parting(a: Piece, b: Piece, T_a_b: Array) -> tuple[float, Array]:
    """What `parting` says of two pieces, in the frame of the first."""
    R, t = T_a_b[:3, :3], T_a_b[:3, 3]
    normals, offsets = b.planes
    turned = normals @ R.T
    return parting(a.corners, a.edges, a.planes, b.corners @ R.T + t, b.edges, (turned, offsets + turned @ t))


@dataclass(frozen=True, eq=False)
class Piece:
    """One convex part as fcl sees it, with its bounding sphere.

    fcl measures in the frame of the first body of a pair, which therefore never moves: each piece keeps one collision
    object that stays at the identity and one that is moved.
    """

    part: Part
    center: Array
    radius: float
    still: Any
    moving: Any

    @staticmethod
    def of(part: Part) -> Piece:
        """The piece of a convex part."""
        center = (part.vertices.min(axis=0) + part.vertices.max(axis=0)) / 2
        radius = float(np.linalg.norm(part.vertices - center, axis=1).max())
        return Piece(part, center, radius, collision_object(part), collision_object(part))

    @cached_property
    def corners(self) -> Array:
        """The vertices for compiled loops, shape (n, 3): in C order and not read-only."""
        return np.array(self.part.vertices, order="C")

    @cached_property
    def edges(self) -> NDArray[np.int64]:
        """The corners at both ends of each edge, and of the two triangles beside it the third ones, shape (m, 4).

        Such as lie within a flat face are among them. Where two triangles are not what lies beside an edge, its first
        end stands for the third corners.
        """
        turns = [self.part.faces[:, [i, i - 2, i - 1]] for i in range(3)]
        sides = np.concatenate(turns).astype(np.int64)
        ends, first, edge, count = np.unique(
            np.sort(sides[:, :2], axis=1), axis=0, return_index=True, return_inverse=True, return_counts=True
        )
        edge = edge.reshape(-1)
        third = np.bincount(edge, weights=sides[:, 2]).astype(np.int64)  # the sum of the third corners
        beside = np.column_stack([sides[first, 2], third - sides[first, 2]])
        beside[count != 2] = ends[count != 2, :1]
        return np.column_stack([ends, beside])

    @cached_property
    def planes(self) -> tuple[Array, Array]:
        """Outward unit normals, shape (m, 3), and offsets, shape (m,), of the faces; slivers left out."""
        a, b, c = (self.part.vertices[self.part.faces[:, i]] for i in range(3))
        normals = np.cross(b - a, c - a)
        length = np.linalg.norm(normals, axis=1)
        wide = length > 1e-14
        normals = normals[wide] / length[wide, None]
        return normals, np.einsum("ij,ij->i", normals, a[wide])

    @cached_property
    def thickness(self) -> float:
        """Least distance of two parallel planes with the piece in between, one of them on a face [m]."""
        normals, offsets = self.planes
        return float((offsets - (normals @ self.part.vertices.T).min(axis=1)).min())

    @cached_property
    def surface(self) -> tuple[Array, Array, Mask]:
        """Points all over the surface, and what is known of each, see `surface_points`."""
        return surface_points(self.part)

    @cached_property
    def volume_and_centroid(self) -> tuple[float, Array]:
        """Volume [m^3] and centroid, shape (3,): the sum of tetrahedra from one inner point."""
        inner = self.part.vertices.mean(axis=0)
        a, b, c = (self.part.vertices[self.part.faces[:, i]] - inner for i in range(3))
        volume = np.abs(np.einsum("ij,ij->i", a, np.cross(b, c))) / 6
        return float(volume.sum()), inner + (volume[:, None] * (a + b + c) / 4).sum(axis=0) / volume.sum()

    @cached_property
    def spread(self) -> Array:
        """Integral of x x' over the volume about its centroid, shape (3, 3) [m^5].

        The sum over tetrahedra from the centroid, whose corners a, b, c and their sum s each give
        V / 20 (aa' + bb' + cc' + ss').
        """
        _, centroid = self.volume_and_centroid
        corners = self.part.vertices[self.part.faces] - centroid
        volumes = np.abs(np.linalg.det(corners)) / 6
        points = np.concatenate([corners, corners.sum(axis=1, keepdims=True)], axis=1)
        found: Array = np.einsum("t,tki,tkj->ij", volumes / 20, points, points)
        return found


@dataclass(frozen=True, eq=False)
class Solid:
    """A rigid body: its pieces, the hull of all of them, and a sphere round it (centre in the body's frame)."""

    name: str
    pieces: tuple[Piece, ...]
    hull: Piece

    @staticmethod
    def of(name: str, parts: Sequence[Part]) -> Solid:
        """The solid of convex parts."""
        pieces = tuple(Piece.of(part) for part in parts)
        if len(pieces) == 1:
            return Solid(name, pieces, pieces[0])
        return Solid(name, pieces, Piece.of(convex_hull(np.concatenate([part.vertices for part in parts]))))

    @property
    def center(self) -> Array:
        """Centre of the bounding sphere, shape (3,)."""
        return self.hull.center

    @property
    def radius(self) -> float:
        """Radius of the bounding sphere [m]."""
        return self.hull.radius

    @property
    def reach(self) -> float:
        """How far the farthest point is from the origin, at most [m]."""
        return float(np.linalg.norm(self.center)) + self.radius

    @cached_property
    def thinnest(self) -> float:
        """Thickness of the thinnest piece [m]."""
        return min(piece.thickness for piece in self.pieces)

    @cached_property
    def centers(self) -> Array:
        """Centres of the pieces' spheres, shape (pieces, 3)."""
        return np.array([piece.center for piece in self.pieces])

    @cached_property
    def radii(self) -> Array:
        """Radii of the pieces' spheres, shape (pieces,)."""
        return np.array([piece.radius for piece in self.pieces])

    @cached_property
    def corners(self) -> tuple[Array, NDArray[np.int64]]:
        """Vertices of all pieces, shape (n, 3), and where each piece's begin among them, shape (pieces,)."""
        counts = [len(piece.part.vertices) for piece in self.pieces]
        return np.concatenate([piece.part.vertices for piece in self.pieces]), np.cumsum([0, *counts[:-1]])

    @cached_property
    def planes(self) -> tuple[Array, Array, NDArray[np.int64]]:
        """The planes of all pieces, and where each piece's begin among them and the last one's end, (pieces + 1,)."""
        normals, offsets = zip(*(piece.planes for piece in self.pieces), strict=True)
        return np.concatenate(normals), np.concatenate(offsets), np.cumsum([0, *map(len, offsets)])

    @cached_property
    def boxes(self) -> tuple[Array, Array]:
        """Lower and upper corners of the pieces' bounding boxes in the body's frame, each of shape (pieces, 3)."""
        lower = np.array([piece.part.vertices.min(axis=0) for piece in self.pieces])
        return lower, np.array([piece.part.vertices.max(axis=0) for piece in self.pieces])

    @cached_property
    def center_of_mass(self) -> Array:
        """Centre of mass, shape (3,), of uniform pieces whose overlaps count twice."""
        volumes, centers = zip(*(piece.volume_and_centroid for piece in self.pieces), strict=True)
        center: Array = np.average(np.array(centers), axis=0, weights=np.array(volumes))
        return center

    @cached_property
    def inertia(self) -> Array:
        """Tensor of inertia about `center_of_mass` of a kilogram spread as evenly, shape (3, 3) [m^2]."""
        total, spread = 0.0, np.zeros((3, 3))
        for piece in self.pieces:
            volume, centroid = piece.volume_and_centroid
            away = centroid - self.center_of_mass
            total, spread = total + volume, spread + piece.spread + volume * np.outer(away, away)
        found: Array = (np.trace(spread) * np.eye(3) - spread) / total
        return found

    @cached_property
    def lower(self) -> Array:
        """Lower corner of the bounding box in the body's frame."""
        corner: Array = self.hull.part.vertices.min(axis=0)
        return corner

    @cached_property
    def upper(self) -> Array:
        """Upper corner of the bounding box in the body's frame."""
        corner: Array = self.hull.part.vertices.max(axis=0)
        return corner
