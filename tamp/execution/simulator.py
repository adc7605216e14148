"""A private PyBullet world: the table, the objects on it, and, where there is one, the robot."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType, TracebackType

import numpy as np

from tamp.execution.bodies import Body, Material, create_body
from tamp.execution.bullet import pybullet
from tamp.execution.robot_body import RobotBody
from tamp.execution.robot_loading import load_robot_body
from tamp.task import Box, Object, Pose, RobotSpec, Table
from tamp.task.model import TABLE_FRICTION

STEP = 1.0 / 240.0
"""Length of one simulation step [s]."""

CONTACT_BREAKING = 0.001
"""How far a remembered contact point may drift before it is dropped [m].

Bullet's own 2 cm keeps the points of a held object for as long as it is held, with normals that do not turn with the
arm: after half a turn they lock the fingers.
"""

SOLVER_ITERATIONS = 100
"""Of the contact solver. PyBullet's 50 let a squeezed object creep: placing errors of 1 mm instead of 0.1 mm."""

GRAVITY = 9.81
"""[m/s^2]."""

TABLE = "table"
FLOOR_BELOW = 0.75
"""Height of the table top over the floor that catches what falls off it [m]."""


@dataclass(frozen=True)
class Touch:
    """Two bodies touch.

    Attributes:
        a, b: their names; "table" and "robot" are the names of those.
        normal: unit vector from `b` to `a` in the world frame.
        depth: how deep they are in each other [m]; negative for a gap that is about to close.
        force: normal force in the last step [N].
        point: where (world frame) [m].
    """

    a: str
    b: str
    normal: tuple[float, float, float]
    depth: float
    force: float
    point: tuple[float, float, float] = (0.0, 0.0, 0.0)


class Simulator:
    """A world of rigid bodies at 240 steps a second; a context manager, since it holds PyBullet's memory.

    The same construction and the same commands give the same poses to the last bit, on one machine: build a new world
    rather than restoring an old one, which PyBullet does not do exactly.

    Args:
        objects: what lies on the table.
        poses: object -> pose (world frame); an object that is absent here starts at its own pose.
        table: the table top; the usual one where it is None.
        robot: the robot, or None for a world without one.
        q: arm configuration to start from [rad]; the robot's home where it is None.

    Attributes:
        table, bodies, robot: what was built; `bodies` by object name, `robot` None where there is none.
        on_step: called after every step, for an onlooker.

    Raises:
        TaskError: where an object's mesh cannot be used.
        RobotError: where the robot's URDF cannot be used.
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
        self.on_step: Callable[[], None] | None = None
        try:
            self._build(tuple(objects), poses, table or Table(), robot, q)
        except BaseException:
            self.close()
            raise

    def _build(
        self,
        objects: tuple[Object, ...],
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
        self.table = create_body(client, folder, top, solid, T_world_table)
        create_body(client, folder, floor, solid, Pose((0, 0, -FLOOR_BELOW - 0.05)))
        self.robot: RobotBody | None = None
        if robot is not None:
            self.robot = load_robot_body(client, folder, robot, tuple(robot.home if q is None else q))
        self.bodies: Mapping[str, Body] = MappingProxyType(
            {
                item.name: create_body(client, folder, item.shape, _material(item), poses.get(item.name, item.pose))
                for item in objects
            }
        )
        self._names = {self.table.id: TABLE, **{body.id: name for name, body in self.bodies.items()}}
        if self.robot is not None:
            self._names[self.robot.id] = "robot"

    def __enter__(self) -> Simulator:
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
            pybullet.stepSimulation(physicsClientId=self._client)
            self._steps += 1
            if self.on_step is not None:
                self.on_step()

    def wait(self, limit_s: float, until: Callable[[], bool], patience: int = 12) -> bool:
        """Step until a condition has held for `patience` steps on end; False where `limit_s` [s] ran out first."""
        held = 0
        for _ in range(round(limit_s / STEP)):
            self.step()
            held = held + 1 if until() else 0
            if held >= patience:
                return True
        return False

    def poses(self) -> dict[str, Pose]:
        """Object -> where its frame stands now."""
        return {name: body.pose(self._client) for name, body in self.bodies.items()}

    def pose(self, name: str) -> Pose:
        """Where one object's frame stands now."""
        return self.bodies[name].pose(self._client)

    def speeds(self) -> dict[str, tuple[float, float]]:
        """Object -> its linear [m/s] and angular [rad/s] speed."""
        found = {}
        for name, body in self.bodies.items():
            linear, angular = pybullet.getBaseVelocity(body.id, physicsClientId=self._client)
            found[name] = (float(np.linalg.norm(linear)), float(np.linalg.norm(angular)))
        return found

    def limit_speeds(self, linear: float, angular: float) -> None:
        """Slow every object that moves faster than `linear` [m/s] or turns faster than `angular` [rad/s]."""
        for body in self.bodies.values():
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
