"""A private PyBullet world: the table, the objects on it, and, where there is one, the robot."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType, TracebackType

import numpy as np

from tamp.execution.monitor import angle_between
from tamp.execution.pybullet.bodies import Body, Material, create_body
from tamp.execution.pybullet.client import pybullet
from tamp.execution.pybullet.robot import RobotBody, load_robot_body
from tamp.execution.simulator import FLOOR_BELOW, GRAVITY, ROBOT, STEP, TABLE, Touch
from tamp.task import Box, Object, Pose, RobotSpec, Table
from tamp.task.model import TABLE_FRICTION

CONTACT_BREAKING = 0.01
"""How far a remembered contact point may drift before it is dropped, as a share of the smaller body's size.

Bullet multiplies it by how far the body's bounding sphere reaches from its frame: 0.4 mm for a block of 4 cm. Bullet's
own 0.02 keeps so many points of a held object that after half a turn they lock the fingers. With 0.004 fingers lose
their points as fast as they find them where the hand tilts: what they hold rattles, and slips by a centimetre or falls.
With 0.001 a mesh that comes down a little askew rattles from corner to corner, 5 mm deep in the table, and creeps.
"""

STALE = 0.2
"""How far the hand turns before the fingers' contact points are forgotten [rad].

Bullet keeps the normal of a remembered point in the world's frame, and only forgets a point that drifts away from one
of its two bodies. What the hand holds and turns stays in touch at the same points, whose old normals become a couple
that tips it over by a degree or two while it is held. Points that are found anew at every step would be too few: one
for each finger, on which the object turns.
"""

SOLVER_ITERATIONS = 200
"""Of the contact solver.

With PyBullet's 50 a squeezed object creeps, as with 100 a cup does that is lifted by its rim: it turns by 4 degrees.
With 200 it stays as it is, as in MuJoCo.
"""


class PyBulletSimulator:
    """The simulator's protocol in PyBullet; see tamp.execution.simulator.

    Build a new world rather than restoring an old one, which PyBullet does not do exactly.
    """

    def __init__(
        self,
        objects: Iterable[Object],
        poses: Mapping[str, Pose] = MappingProxyType({}),
        *,
        table: Table | None = None,
        robot: RobotSpec | None = None,
        q: Iterable[float] | None = None,
    ) -> None:
        self._files = tempfile.TemporaryDirectory(prefix="tamp-")
        self._client: int = pybullet.connect(pybullet.DIRECT)
        self._steps = 0
        self._turn: Pose | None = None  # of the hand when its contacts were forgotten the last time
        self.objects: Mapping[str, Object] = MappingProxyType({item.name: item for item in objects})
        self.on_step: Callable[[], None] | None = None
        try:
            self._build(poses, table or Table(), robot, q)
        except BaseException:
            self.close()
            raise

    def _build(
        self,
        poses: Mapping[str, Pose],
        table: Table,
        robot: RobotSpec | None,
        q: Iterable[float] | None,
    ) -> None:
        client, folder = self._client, Path(self._files.name)
        # File names repeat between worlds, their content does not: PyBullet must not remember files by name.
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=STEP,
            numSolverIterations=SOLVER_ITERATIONS,
            deterministicOverlappingPairs=1,
            contactBreakingThreshold=CONTACT_BREAKING,
            enableFileCaching=0,
            physicsClientId=client,
        )
        pybullet.setGravity(0, 0, -GRAVITY, physicsClientId=client)
        solid = Material(mass=0.0, friction=TABLE_FRICTION)
        top = Box((*table.size, table.thickness))
        T_world_table = Pose((*table.center, -table.thickness / 2))
        floor = Box((10.0, 10.0, 0.1))
        slab = create_body(client, folder, top, solid, T_world_table)
        create_body(client, folder, floor, solid, Pose((0, 0, -FLOOR_BELOW - 0.05)))
        loaded: RobotBody | None = None
        if robot is not None:
            loaded = load_robot_body(client, folder, robot, tuple(robot.home if q is None else q))
        self._bodies: dict[str, Body] = {}
        for name, item in self.objects.items():
            body = create_body(client, folder, item.shape, _material(item), poses.get(name, item.pose))
            self._bodies[name] = body
        numbers = {name: body.id for name, body in self._bodies.items()}
        self.robot = None if loaded is None else replace(loaded, bodies=MappingProxyType(numbers))
        self._names = {slab.id: TABLE, **{number: name for name, number in numbers.items()}}
        if loaded is not None:
            self._names[loaded.id] = ROBOT

    def __enter__(self) -> PyBulletSimulator:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Free the world; every later call fails."""
        if self._client >= 0:
            pybullet.disconnect(physicsClientId=self._client)
            self._client = -1
            self._files.cleanup()

    @property
    def time(self) -> float:
        """Simulated time since the start [s]."""
        return self._steps * STEP

    def step(self, count: int = 1) -> None:
        """Let `count` steps pass."""
        for _ in range(count):
            if self.robot is not None:
                self._forget_stale_contacts(self.robot)
                self.robot.follow()
            pybullet.stepSimulation(physicsClientId=self._client)
            self._steps += 1
            if self.on_step is not None:
                self.on_step()

    def _forget_stale_contacts(self, robot: RobotBody) -> None:
        turn = robot.hand_orientation()
        if self._turn is None or angle_between(self._turn, turn) > STALE:
            self._turn = turn
            robot.forget_contacts()

    def poses(self) -> dict[str, Pose]:
        """Object -> where its frame stands now."""
        return {name: body.pose(self._client) for name, body in self._bodies.items()}

    def pose(self, name: str) -> Pose:
        """Where one object's frame stands now."""
        return self._bodies[name].pose(self._client)

    def place(self, name: str, pose: Pose) -> None:
        """Put an object at rest at a pose."""
        self._bodies[name].place(self._client, pose)

    def speeds(self) -> dict[str, tuple[float, float]]:
        """Object -> its linear [m/s] and angular [rad/s] speed."""
        found = {}
        for name, body in self._bodies.items():
            linear, angular = pybullet.getBaseVelocity(body.id, physicsClientId=self._client)
            found[name] = (float(np.linalg.norm(linear)), float(np.linalg.norm(angular)))
        return found

    def limit_speeds(self, linear: float, angular: float) -> None:
        """Slow every object that moves faster than `linear` [m/s] or turns faster than `angular` [rad/s]."""
        for body in self._bodies.values():
            v, w = map(np.array, pybullet.getBaseVelocity(body.id, physicsClientId=self._client))
            fast, spinning = float(np.linalg.norm(v)), float(np.linalg.norm(w))
            if fast > linear or spinning > angular:
                v, w = v * min(1.0, linear / max(fast, 1e-12)), w * min(1.0, angular / max(spinning, 1e-12))
                pybullet.resetBaseVelocity(body.id, v.tolist(), w.tolist(), physicsClientId=self._client)

    def touches(self) -> tuple[Touch, ...]:
        """Contacts of the last step between the table, the objects and the robot."""
        return tuple(
            Touch(self._names[p[1]], self._names[p[2]], p[7], -p[8], p[9], p[5])
            for p in pybullet.getContactPoints(physicsClientId=self._client)
            if p[1] in self._names and p[2] in self._names and p[1] != p[2]
        )


def _material(item: Object) -> Material:
    return Material(item.mass, item.friction, inertia=item.inertia)
