"""One body as three collision libraries have it, and the bodies that they are asked about."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

import numpy as np
from numpy.typing import NDArray

from tamp.checking.geometry.solids import Solid as FclSolid
from tamp.checking.geometry.solids import clearance
from tamp.checking.robot.links import read_links
from tamp.execution.pybullet.bodies import hulls_as_obj
from tamp.execution.pybullet.client import pybullet
from tamp.task import Box, Capsule, Cylinder, Mesh, Pose, Shape, Sphere, load_robot
from tamp.task.files.load import load_task
from tamp.task.mesh.parts import Part, parts
from tamp.world.geometry.convex_union import Solid, separation, solid

Array = NDArray[np.float64]

FAR = 0.05
"""Beyond this PyBullet is not asked for a distance [m]."""
BULLET_MARGIN = 0.001
"""How far outside its vertices PyBullet lets each hull begin [m]."""


@dataclass(frozen=True, eq=False)
class Body:
    """Convex parts, and what coal and fcl make of them; links have no shape of a task's."""

    name: str
    shape: Shape | None
    parts: tuple[Part, ...]
    for_coal: Solid
    for_fcl: tuple[FclSolid, ...]
    center: Array
    radius: float

    @staticmethod
    def of(name: str, pieces: Sequence[Part], shape: Shape | None = None) -> Body:
        """The body of convex parts."""
        every = np.vstack([part.vertices for part in pieces])
        center = (every.min(axis=0) + every.max(axis=0)) / 2
        single = tuple(FclSolid.of(name, [part]) for part in pieces)
        radius = float(np.linalg.norm(every - center, axis=1).max())
        return Body(name, shape, tuple(pieces), solid(pieces), single, center, radius)

    def coal(self, other: Body, T: Array) -> float:
        """Signed distance [m] as tamp.world has it; T is the other's frame in this one's."""
        return separation(self.for_coal, other.for_coal, T)

    def fcl(self, other: Body, T: Array) -> float:
        """Signed distance [m] part by part: certain distances as the checker computes them, and fcl's own depths."""
        centers = np.array([two.center for two in other.for_fcl]) @ T[:3, :3].T + T[:3, 3]
        apart = np.array([one.center for one in self.for_fcl])[:, None] - centers[None]
        radii = np.array([one.radius for one in self.for_fcl])[:, None] + [two.radius for two in other.for_fcl]
        gaps, least = np.linalg.norm(apart, axis=2) - radii, np.inf
        for flat in np.argsort(gaps, axis=None):
            i, j = divmod(int(flat), len(other.for_fcl))
            if gaps[i, j] >= max(least, 0.0):
                break
            least = min(least, clearance(self.for_fcl[i], other.for_fcl[j], T, np.inf))
        return least if np.isfinite(least) else float(gaps.min())


class Library:
    """PyBullet with two copies of each body, of which any two can be held against each other; a context manager."""

    def __init__(self, bodies: Sequence[Body]) -> None:
        self._bodies = bodies

    def __enter__(self) -> Library:
        self._client = pybullet.connect(pybullet.DIRECT)
        with tempfile.TemporaryDirectory() as folder:
            self._ids = {
                (body.name, copy): self._load(body, Path(folder) / f"{copy}-{i}.obj")
                for i, body in enumerate(self._bodies)
                for copy in (0, 1)
            }
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        pybullet.disconnect(self._client)

    def _load(self, body: Body, file: Path) -> int:
        file.write_text(hulls_as_obj(body.parts, margin=0.0), encoding="utf-8")
        shape = pybullet.createCollisionShape(pybullet.GEOM_MESH, fileName=str(file), physicsClientId=self._client)
        number: int = pybullet.createMultiBody(0.0, shape, physicsClientId=self._client)
        return number

    def bullet(self, a: Body, b: Body, T: Array) -> float:
        """Signed distance [m] less the margins that PyBullet puts round hulls; at most FAR."""
        centers = np.linalg.norm(T[:3, :3] @ b.center + T[:3, 3] - a.center)
        if centers > a.radius + b.radius + FAR:
            return FAR
        first, second = self._ids[a.name, 0], self._ids[b.name, 1]
        for number, pose in ((first, Pose()), (second, Pose.from_matrix(T))):
            pybullet.resetBasePositionAndOrientation(number, pose.xyz, pose.quat, physicsClientId=self._client)
        points = pybullet.getClosestPoints(first, second, FAR, physicsClientId=self._client)
        return min((float(point[8]) for point in points), default=FAR) + 2 * BULLET_MARGIN


def random_convex(rng: np.random.Generator, count: int) -> tuple[Body, ...]:
    """Boxes, cylinders, spheres and capsules of random sizes."""
    shapes: list[Shape] = []
    for i in range(count):
        a, b, c = (float(v) for v in rng.uniform(0.01, 0.1, size=3))
        shapes.append((Box((a, b, c)), Cylinder(a, b), Sphere(a), Capsule(a, b))[i % 4])
    return tuple(Body.of(f"convex_{i}", parts(shape), shape) for i, shape in enumerate(shapes))


def bodies_of_scenarios() -> tuple[Body, ...]:
    """The meshes of the built-in scenarios, each a union of convex parts."""
    tasks = [load_task(file) for file in sorted(Path("scenarios").glob("*.yaml"))]
    shapes = {thing.shape for task in tasks for thing in task.objects if isinstance(thing.shape, Mesh)}
    ordered = sorted(shapes, key=lambda shape: (shape.path, shape.scale))
    return tuple(Body.of(f"mesh_{i}", parts(shape), shape) for i, shape in enumerate(ordered))


def links() -> tuple[Body, ...]:
    """The robot's links as hulls."""
    return tuple(Body.of(s.name, [piece.part for piece in s.pieces]) for s in read_links(load_robot("panda")).solids)
