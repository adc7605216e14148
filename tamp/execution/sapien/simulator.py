"""A private SAPIEN world: the table, the objects on it, and, where there is one, the robot."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType, TracebackType

import numpy as np

from tamp.execution.sapien.bodies import add_fixed, add_object, from_sapien, to_sapien
from tamp.execution.sapien.client import physx, sapien
from tamp.execution.sapien.robot import SapienRobot
from tamp.execution.simulator import FLOOR_BELOW, GRAVITY, ROBOT, STEP, TABLE, Touch
from tamp.task import Box, Object, Pose, RobotSpec, Table

SUBSTEPS = 2
"""PhysX's steps in one of the simulator's."""

POSITION_ITERATIONS, VELOCITY_ITERATIONS = 32, 1
"""Of the solver, for each body."""


class SapienSimulator:
    """The simulator's protocol in SAPIEN; see tamp.execution.simulator."""

    def __init__(
        self,
        objects: Iterable[Object],
        poses: Mapping[str, Pose] = MappingProxyType({}),
        *,
        table: Table | None = None,
        robot: RobotSpec | None = None,
        q: Iterable[float] | None = None,
    ) -> None:
        self.objects: Mapping[str, Object] = MappingProxyType({item.name: item for item in objects})
        self.on_step: Callable[[], None] | None = None
        self._steps = 0
        _configure()
        self._system = physx.PhysxCpuSystem()
        self._system.timestep = STEP / SUBSTEPS
        scene = self._scene = sapien.Scene([self._system])
        table = table or Table()
        top = Box((*table.size, table.thickness))
        slab = add_fixed(scene, top, Pose((*table.center, -table.thickness / 2)))
        add_fixed(scene, Box((10.0, 10.0, 0.1)), Pose((0.0, 0.0, -FLOOR_BELOW - 0.05)))
        self.robot: SapienRobot | None = None
        if robot is not None:
            self.robot = SapienRobot(scene, self._system, robot, tuple(robot.home if q is None else q))
        self._bodies = {n: add_object(scene, item, poses.get(n, item.pose)) for n, item in self.objects.items()}
        self._names = {slab: TABLE, **{body: name for name, body in self._bodies.items()}}
        if self.robot is not None:
            self.robot.objects = MappingProxyType(self._bodies)
            self._names |= dict.fromkeys(self.robot.links.values(), ROBOT)

    def __enter__(self) -> SapienSimulator:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._scene = self._system = None

    @property
    def time(self) -> float:
        """Simulated time since the start [s]."""
        return self._steps * STEP

    def step(self, count: int = 1) -> None:
        """Let `count` steps pass."""
        part = STEP / SUBSTEPS
        for _ in range(count):
            for number in range(SUBSTEPS):
                if self.robot is not None:
                    self.robot.drive(number * part, part)
                self._system.step()
            self._steps += 1
            if self.on_step is not None:
                self.on_step()

    def pose(self, name: str) -> Pose:
        """Where one object's frame stands now."""
        return from_sapien(self._bodies[name].entity_pose)

    def poses(self) -> dict[str, Pose]:
        """Object -> where its frame stands now."""
        return {name: self.pose(name) for name in self.objects}

    def place(self, name: str, pose: Pose) -> None:
        """Put an object at rest at a pose."""
        body = self._bodies[name]
        body.entity.pose = to_sapien(pose)
        body.linear_velocity = body.angular_velocity = [0.0, 0.0, 0.0]

    def speeds(self) -> dict[str, tuple[float, float]]:
        """Object -> its linear [m/s] and angular [rad/s] speed."""
        return {
            name: (float(np.linalg.norm(body.linear_velocity)), float(np.linalg.norm(body.angular_velocity)))
            for name, body in self._bodies.items()
        }

    def limit_speeds(self, linear: float, angular: float) -> None:
        """Slow every object that moves faster than `linear` [m/s] or turns faster than `angular` [rad/s]."""
        for name, (fast, spinning) in self.speeds().items():
            body = self._bodies[name]
            if fast > linear or spinning > angular:
                body.linear_velocity = body.linear_velocity * min(1.0, linear / max(fast, 1e-12))
                body.angular_velocity = body.angular_velocity * min(1.0, angular / max(spinning, 1e-12))

    def touches(self) -> tuple[Touch, ...]:
        """Contacts of the last step between the table, the objects and the robot."""
        found = []
        for contact in self._system.get_contacts():
            a, b = (self._names.get(body) for body in contact.bodies)
            if a is None or b is None or a == b:
                continue
            for point in contact.points:
                x, y, z = point.normal.tolist()
                px, py, pz = point.position.tolist()
                force = abs(float(np.dot(point.impulse, point.normal))) * SUBSTEPS / STEP
                found.append(Touch(a, b, (x, y, z), -float(point.separation), force, (px, py, pz)))
        return tuple(found)


def _configure() -> None:
    """PhysX takes these for the world that is made next."""
    physx.set_scene_config(
        gravity=np.array([0.0, 0.0, -GRAVITY]),
        bounce_threshold=2.0,
        enable_pcm=True,
        enable_tgs=True,
        enable_ccd=False,
        enable_enhanced_determinism=True,
        enable_friction_every_iteration=True,
    )
    physx.set_body_config(
        solver_position_iterations=POSITION_ITERATIONS,
        solver_velocity_iterations=VELOCITY_ITERATIONS,
        sleep_threshold=0.0,
    )
