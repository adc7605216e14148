"""The whole robot at random configurations among a few random objects, as tamp.world asks about it and as others do."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from benchmarks.parts.agreement_bodies import FAR, Body, Library
from tamp.checking.geometry.transforms import inverse
from tamp.checking.robot.links import read_links
from tamp.task import load_robot
from tamp.world.geometry.object_geometry import load_geometry
from tamp.world.robot.model import robot_model
from tamp.world.scene import Scene
from tamp.world.world import World

Array = NDArray[np.float64]
Pair = tuple[Body, Body, Array]

MARGIN = 0.005
"""The clearance that coal's broadphase is asked for [m]."""
OPENING = 0.08
OBJECTS = 3


class Scenes:
    """Asks all three libraries about one random scene after the other.

    Args:
        library: PyBullet with all the bodies.
        robot: the links.
        objects: what may stand, or hang, near the robot.
    """

    def __init__(self, library: Library, robot: Sequence[Body], objects: Sequence[Body]) -> None:
        self._library = library
        spec = load_robot("panda")
        self._model = robot_model(spec)
        self._tree = read_links(spec).tree
        self._links = [link for link in robot if self._tree.path_to(link.name)]
        self._objects = objects
        geometries = {body.name: load_geometry(body.shape) for body in objects if body.shape is not None}
        self._world = World(self._model, geometries)

    def ask(self, rng: np.random.Generator) -> tuple[bool, Mapping[str, tuple[float, Pair]]]:
        """Of a new scene: whether coal calls the robot free by MARGIN; what the others call nearest, and how near."""
        spec = self._tree.spec
        alone = self._world.checker(Scene(opening=OPENING), margin=MARGIN)
        q = rng.uniform(spec.lower, spec.upper)
        while not alone.free(q):
            q = rng.uniform(spec.lower, spec.upper)
        T_world_link = {name: T[0] for name, T in self._tree.forward(q[None], OPENING).items()}
        chosen = [self._objects[i] for i in rng.choice(len(self._objects), OBJECTS, replace=False)]
        poses = {body.name: self._near(rng, body, T_world_link) for body in chosen}
        free = self._world.checker(Scene(poses=poses, opening=OPENING), margin=MARGIN).free(q)
        pairs = [
            (link, body, inverse(T_world_link[link.name]) @ poses[body.name]) for link in self._links for body in chosen
        ]
        near = [pair for pair in pairs if _apart(*pair) < FAR] or pairs[:1]
        by_fcl = min(((link.fcl(body, T), (link, body, T)) for link, body, T in near), key=lambda said: said[0])
        by_bullet = min(
            ((self._library.bullet(link, body, T), (link, body, T)) for link, body, T in near), key=lambda said: said[0]
        )
        return free, {"fcl": by_fcl, "bullet": by_bullet}

    def _near(self, rng: np.random.Generator, body: Body, T_world_link: Mapping[str, Array]) -> Array:
        """T_world_object of an object pushed to about MARGIN from a random link."""
        link = self._links[rng.integers(len(self._links))]
        return np.asarray(T_world_link[link.name] @ pushed(rng, link, body, MARGIN + rng.uniform(-0.01, 0.01)))


def pushed(rng: np.random.Generator, a: Body, b: Body, distance: float) -> Array:
    """A random T_a_b: b turned at random and pushed towards a until coal says about `distance` [m]."""
    T, along = np.eye(4), rng.normal(size=3)
    rotation, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    T[:3, :3] = rotation * np.sign(np.linalg.det(rotation))
    along /= np.linalg.norm(along)
    T[:3, 3] = a.center - T[:3, :3] @ b.center + along * (a.radius + b.radius)
    for _ in range(12):
        T[:3, 3] -= along * (a.coal(b, T) - distance)
    return T


def _apart(a: Body, b: Body, T: Array) -> float:
    return float(np.linalg.norm(T[:3, :3] @ b.center + T[:3, 3] - a.center)) - a.radius - b.radius
