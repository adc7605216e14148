"""Unions of convex parts as Coal sees them: exact overlap and signed distance of two, boxes first and GJK after."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any

import coal
import numpy as np

from tamp.task.mesh.parts import Part, convex_hull
from tamp.world.geometry.half_spaces import half_spaces, joined, placed_planes, shifted_ends
from tamp.world.geometry.separating_faces import CLEAR, HIT, UNKNOWN, sieve, sieve_each

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.world.geometry.half_spaces import Planes
    from tamp.world.geometry.separating_faces import Bodies, Corners

    Matrix = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Solid:
    """Convex parts rigidly joined, with the boxes that tell most of them apart at once.

    Attributes:
        pieces: the parts.
        parts: a `coal.Convex` for each of them.
        hull: the `coal.Convex` hull of all of them; the part itself where there is one.
        outline: the hull, in the solid's frame.
        tree: a `coal.DynamicAABBTreeCollisionManager` of the parts in the solid's frame.
        center: centre of each part's bounding box, shape (n, 3) [m], in the solid's frame.
        half: half the size of each part's bounding box, shape (n, 3) [m].
    """

    pieces: tuple[Part, ...]
    parts: tuple[Any, ...]
    hull: Any
    outline: Part
    tree: Any
    center: Matrix
    half: Matrix

    @cached_property
    def box(self) -> tuple[Matrix, Matrix]:
        """Lower and upper corner of the box round all parts, shape (3,) each [m], in the solid's frame."""
        return (self.center - self.half).min(axis=0), (self.center + self.half).max(axis=0)

    @cached_property
    def ball(self) -> tuple[Matrix, float]:
        """Centre, shape (3,), and radius of a ball round all parts [m], in the solid's frame."""
        center = (self.box[0] + self.box[1]) / 2
        return center, float(np.linalg.norm(self.outline.vertices - center, axis=1).max())

    @property
    def convex(self) -> bool:
        """Whether the solid is one convex part, and so its own hull."""
        return len(self.parts) == 1

    @cached_property
    def planes(self) -> Planes:
        """The parts as half-spaces, in the solid's frame."""
        return joined(half_spaces(part) for part in self.pieces)

    @cached_property
    def corners(self) -> Corners:
        """The parts' vertices, in the solid's frame."""
        each = [part.vertices for part in self.pieces]
        return np.concatenate(each), np.cumsum([len(one) for one in each], dtype=np.int64)

    @cached_property
    def thickness(self) -> Matrix:
        """Least distance of two parallel planes with a part in between, one of them on a face of it, shape (n,) [m]."""
        return np.array([_thickness(part) for part in self.pieces])


def solid(parts: Sequence[Part]) -> Solid:
    """The solid that convex parts make up."""
    shapes = tuple(_convex(part) for part in parts)
    outline = parts[0] if len(parts) == 1 else convex_hull(np.concatenate([part.vertices for part in parts]))
    hull = shapes[0] if len(shapes) == 1 else _convex(outline)
    lower = np.array([part.vertices.min(axis=0) for part in parts])
    upper = np.array([part.vertices.max(axis=0) for part in parts])
    tree = coal.DynamicAABBTreeCollisionManager()
    for shape in shapes:
        tree.registerObject(coal.CollisionObject(shape))
    tree.setup()
    box = (lower + upper) / 2, (upper - lower) / 2
    return Solid(tuple(parts), shapes, hull, outline, tree, *box)


def overlap(a: Solid, b: Solid, T_a_b: Matrix, margin: float) -> bool:
    """Whether two solids come closer than `margin` [m]; a negative margin tolerates that much penetration."""
    if a.convex and b.convex:
        request, result = coal.CollisionRequest(), coal.CollisionResult()
        request.security_margin = margin
        pose = coal.Transform3s(T_a_b[:3, :3], T_a_b[:3, 3])
        return bool(coal.collide(a.hull, coal.Transform3s(), b.hull, pose, request, result))
    if len(b.parts) > len(a.parts):
        a, b, T_a_b = b, a, relative(T_a_b, np.eye(4))
    callback = coal.CollisionCallBackDefault()
    callback.data.request.security_margin = margin
    pose = coal.Transform3s(T_a_b[:3, :3], T_a_b[:3, 3])
    for j in _parts_near(a, b, T_a_b, max(margin, 0.0)):
        probe = coal.CollisionObject(b.parts[j], pose)
        probe.getAABB().expand(max(margin, 0.0))
        a.tree.collide(probe, callback)
        if callback.data.result.isCollision():
            return True
    return False


def crossed(a: Solid, b: Solid, T_a_b: Matrix) -> bool:
    """Whether two parts are in each other by more than a quarter of what they are thick together.

    Nobody knows there on which side of each other two thin walls are: they are never deeper in each other than half of
    that, whichever side they came from.
    """
    allowed = (a.thickness[:, None] + b.thickness[None]) / 4
    if not overlap(a, b, T_a_b, -float(allowed.min())):
        return False
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    pose_a, pose_b = coal.Transform3s(), coal.Transform3s(T_a_b[:3, :3], T_a_b[:3, 3])
    for i, j in np.argwhere(_box_gaps(a, b, T_a_b) <= 0.0):
        result.clear()
        if coal.distance(a.parts[i], pose_a, b.parts[j], pose_b, request, result) < -allowed[i, j]:
            return True
    return False


def near(a: Solid, T: Matrix, b: Solid, T_b: Matrix, margin: float) -> NDArray[np.int64]:
    """Which of the poses T of `a`, shape (n, 4, 4), may bring it closer than `margin` [m] to `b` at `T_b`, ascending.

    At all others the ball round the one is beyond the box round the other.
    """
    center, radius = a.ball
    seen = (T[:, :3, :3] @ center + T[:, :3, 3] - T_b[:3, 3]) @ T_b[:3, :3]
    beyond = np.maximum(np.maximum(b.box[0] - seen, seen - b.box[1]), 0.0)
    reach = max(radius + margin, 0.0)
    found: NDArray[np.int64] = np.flatnonzero(np.einsum("ni,ni->n", beyond, beyond) <= reach * reach)
    return found


def _parts_near(a: Solid, b: Solid, T_a_b: Matrix, margin: float) -> list[int]:
    """Parts of `b` whose boxes come within `margin` of the box round all of `a`."""
    if b.convex:
        return [0]
    center = b.center @ T_a_b[:3, :3].T + T_a_b[:3, 3]
    half = b.half @ np.abs(T_a_b[:3, :3]).T + margin
    lower, upper = a.box
    found: list[int] = np.flatnonzero(((center + half >= lower) & (center - half <= upper)).all(axis=1)).tolist()
    return found


def separation(a: Solid, b: Solid, T_a_b: Matrix) -> float:
    """Signed distance of two solids [m]: minus the deepest penetration of two of their parts where they overlap."""
    gap = _box_gaps(a, b, T_a_b)
    order = np.argsort(gap, axis=None, kind="stable")
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    pose_a, pose_b = coal.Transform3s(), coal.Transform3s(T_a_b[:3, :3], T_a_b[:3, 3])
    nearest = np.inf
    for flat in order:
        i, j = divmod(int(flat), len(b.parts))
        if gap[i, j] > max(nearest, 0.0):
            break
        result.clear()
        nearest = min(nearest, coal.distance(a.parts[i], pose_a, b.parts[j], pose_b, request, result))
    return float(nearest)


def contacts(a: Solid, b: Solid, T_a_b: Matrix, gap: float) -> tuple[Matrix, Matrix]:
    """For each two parts nearer to each other than a gap [m]: the point of `b` there, and the unit normal to `a`.

    Both in the frame of `a`, shape (n, 3).
    """
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    pose_a, pose_b = coal.Transform3s(), coal.Transform3s(T_a_b[:3, :3], T_a_b[:3, 3])
    points, normals = [np.zeros((0, 3))], [np.zeros((0, 3))]
    for i, j in np.argwhere(_box_gaps(a, b, T_a_b) < gap):
        result.clear()
        if coal.distance(a.parts[i], pose_a, b.parts[j], pose_b, request, result) < gap:
            points.append(np.array(result.getNearestPoint2())[None])
            normals.append(-np.array(result.normal)[None])
    return np.vstack(points), np.vstack(normals)


def relative(T_world_a: Matrix, T_world_b: Matrix) -> Matrix:
    """`T_a_b` of two poses, shape (4, 4)."""
    T = np.empty((4, 4))
    R = T_world_a[:3, :3].T
    T[:3, :3] = R @ T_world_b[:3, :3]
    T[:3, 3] = R @ (T_world_b[:3, 3] - T_world_a[:3, 3])
    T[3] = (0.0, 0.0, 0.0, 1.0)
    return T


class Crowd:
    """Solids that keep still, asked about one convex body after another. Belongs to one thread."""

    def __init__(self, standing: Iterable[tuple[Solid, Matrix]], margin: float) -> None:
        """Take solids, each with its `T_world_solid`, and how near is too near [m], 0 or more."""
        self._standing, self._margin = tuple(standing), margin
        self._callback = coal.CollisionCallBackDefault()
        self._callback.data.request.security_margin = margin
        planes = placed_planes([(one.planes, T) for one, T in self._standing])
        corners = _placed_corners([(one.corners, T) for one, T in self._standing])
        self._others = planes, corners, _boxes(corners)

    @cached_property
    def _tree(self) -> Any:
        tree = coal.DynamicAABBTreeCollisionManager()
        for one, T in self._standing:
            pose = coal.Transform3s(T[:3, :3], T[:3, 3])
            for shape in one.parts:
                tree.registerObject(coal.CollisionObject(shape, pose))
        tree.setup()
        return tree

    def meets(self, probe: Probe, k: int, R: Matrix, t: Matrix) -> NDArray[np.bool_]:
        """Whether a body at each of some poses in the world comes too close to any of them, shape (n,).

        Args:
            probe: some bodies.
            k: which of them.
            R: its orientations, shape (n, 3, 3).
            t: its positions, shape (n, 3) [m].
        """
        verdicts = sieve(self._others, probe.shapes, k, np.array(R, order="C"), np.array(t, order="C"), self._margin)
        for index in np.flatnonzero(verdicts == UNKNOWN):
            verdicts[index] = HIT if self._collides(probe.bodies[k], R[index], t[index]) else CLEAR
        hit: NDArray[np.bool_] = verdicts == HIT
        return hit

    def meets_any(self, probe: Probe, R: Matrix, t: Matrix) -> bool:
        """Whether any of some bodies comes too close to any of them, each at a pose of its own.

        Args:
            probe: the bodies.
            R: their orientations, shape (bodies, 3, 3), in C order.
            t: their positions, shape (bodies, 3) [m], likewise.
        """
        verdicts = sieve_each(self._others, probe.shapes, R, t, self._margin).tolist()
        if HIT in verdicts:
            return True
        unknown = (k for k, verdict in enumerate(verdicts) if verdict == UNKNOWN)
        return any(self._collides(probe.bodies[k], R[k], t[k]) for k in unknown)

    def _collides(self, body: Any, R: Matrix, t: Matrix) -> bool:
        body.setTransform(coal.Transform3s(R, t))
        body.computeAABB()
        body.getAABB().expand(self._margin)
        self._tree.collide(body, self._callback)
        return bool(self._callback.data.result.isCollision())


class Probe:
    """Bodies that are moved about in a crowd: the hulls of solids. Belongs to one thread."""

    def __init__(self, *solids: Solid) -> None:
        self.bodies, self.shapes = [coal.CollisionObject(one.hull) for one in solids], _shapes(solids)


@lru_cache(maxsize=64)
def _shapes(solids: tuple[Solid, ...]) -> Bodies:
    """What is asked of bodies by their faces and corners alone."""
    each = [one.outline.vertices for one in solids]
    corners = np.concatenate(each), np.cumsum([len(points) for points in each], dtype=np.int64)
    centers = np.array([(points.min(axis=0) + points.max(axis=0)) / 2 for points in each])
    reach = zip(each, centers, strict=True)
    radii = np.array([np.linalg.norm(points - center, axis=1).max() for points, center in reach])
    return joined(half_spaces(one.outline) for one in solids), corners, (centers, radii)


@lru_cache(maxsize=4096)
def _thickness(part: Part) -> float:
    normals, offsets = half_spaces(part)[:2]
    return float((offsets - (normals @ part.vertices.T).min(axis=1)).min())


def _placed_corners(each: Sequence[tuple[Corners, Matrix]]) -> Corners:
    points = [corners @ T[:3, :3].T + T[:3, 3] for (corners, _), T in each]
    return np.concatenate([np.zeros((0, 3)), *points]), shifted_ends([ends for (_, ends), _ in each])


def _boxes(corners: Corners) -> tuple[Matrix, Matrix]:
    """Lower and upper corners of the boxes round parts, shape (parts, 3) each."""
    points, ends = corners
    if not len(ends):
        return np.empty((0, 3)), np.empty((0, 3))
    first = np.concatenate([[0], ends[:-1]])
    return np.minimum.reduceat(points, first), np.maximum.reduceat(points, first)


def _box_gaps(a: Solid, b: Solid, T_a_b: Matrix) -> Matrix:
    """Lower bounds of the distances of the parts of `a` to those of `b`, shape (n_a, n_b) [m]: their boxes'."""
    R = T_a_b[:3, :3]
    center = b.center @ R.T + T_a_b[:3, 3]
    half = b.half @ np.abs(R).T
    apart = np.abs(a.center[:, None] - center[None]) - a.half[:, None] - half[None]
    np.maximum(apart, 0.0, out=apart)
    gaps: Matrix = np.sqrt(np.einsum("ijk,ijk->ij", apart, apart))
    return gaps


@lru_cache(maxsize=4096)
def _convex(part: Part) -> Any:
    """Coal's form of a part; it is never changed, so equal objects of many worlds share it."""
    points = coal.StdVec_Vec3s()
    points.extend(list(part.vertices))
    triangles = coal.StdVec_Triangle()
    triangles.extend([coal.Triangle(*map(int, face)) for face in part.faces])
    return coal.Convex(points, triangles)
