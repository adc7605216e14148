"""A private MuJoCo world: the table, the objects on it, and, where there is one, the robot."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType, TracebackType
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from tamp.execution.mujoco.bodies import SOLID, add_geoms, add_object
from tamp.execution.mujoco.friction import Coulomb
from tamp.execution.mujoco.robot import MuJoCoRobot, add_robot
from tamp.execution.simulator import FLOOR_BELOW, GRAVITY, ROBOT, STEP, TABLE, Touch
from tamp.task import Box, Object, Pose, RobotSpec, Table

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

SUBSTEPS = 2
"""MuJoCo's steps in one of the simulator's."""

IMPRATIO = 400.0
"""How many times stiffer friction is than the normal force, as MuJoCo counts it: a held block creeps by micrometres."""

log = logging.getLogger("tamp")

# Left alone, MuJoCo writes its warnings to a file in the folder where the user stands.
mujoco.set_mju_user_warning(lambda text: log.warning("MuJoCo: %s", text))


class MuJoCoSimulator:
    """The simulator's protocol in MuJoCo; see tamp.execution.simulator."""

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
        self._model: Any = _model(self.objects, poses, table or Table(), robot)
        self._data: Any = mujoco.MjData(self._model)
        bodies = {name: self._model.body(_body_name(i)) for i, name in enumerate(self.objects)}
        self._q = {name: int(self._model.jnt_qposadr[body.jntadr[0]]) for name, body in bodies.items()}
        self._v = {name: int(self._model.jnt_dofadr[body.jntadr[0]]) for name, body in bodies.items()}
        self._centers = {name: np.array(body.ipos) for name, body in bodies.items()}
        self._owner = _owners(self._model, {body.id: name for name, body in bodies.items()}, robot)
        links = np.zeros(self._model.nbody, dtype=bool)
        for geom, owner in self._owner.items():
            links[self._model.geom_bodyid[geom]] |= owner == ROBOT
        self._coulomb = Coulomb(self._model, links)
        self.robot: MuJoCoRobot | None = None
        if robot is not None:
            geoms = {name: frozenset(g for g, owner in self._owner.items() if owner == name) for name in bodies}
            start = tuple(robot.home if q is None else q)
            self.robot = MuJoCoRobot(robot, self._model, self._data, geoms, start)
        mujoco.mj_forward(self._model, self._data)

    def __enter__(self) -> MuJoCoSimulator:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._model = self._data = None

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
                mujoco.mj_step1(self._model, self._data)
                self._coulomb.mend(self._data)
                mujoco.mj_step2(self._model, self._data)
            self._steps += 1
            if self.on_step is not None:
                self.on_step()

    def pose(self, name: str) -> Pose:
        """Where one object's frame stands now."""
        x, y, z, qw, qx, qy, qz = self._data.qpos[self._q[name] : self._q[name] + 7].tolist()
        return Pose((x, y, z), (qx, qy, qz, qw))

    def poses(self) -> dict[str, Pose]:
        """Object -> where its frame stands now."""
        return {name: self.pose(name) for name in self.objects}

    def place(self, name: str, pose: Pose) -> None:
        """Put an object at rest at a pose."""
        x, y, z, w = pose.quat
        self._data.qpos[self._q[name] : self._q[name] + 7] = (*pose.xyz, w, x, y, z)
        self._data.qvel[self._v[name] : self._v[name] + 6] = 0.0

    def speeds(self) -> dict[str, tuple[float, float]]:
        """Object -> its linear [m/s] and angular [rad/s] speed."""
        found = {}
        for name in self.objects:
            linear, angular, _ = self._velocity(name)
            found[name] = (float(np.linalg.norm(linear)), float(np.linalg.norm(angular)))
        return found

    def limit_speeds(self, linear: float, angular: float) -> None:
        """Slow every object that moves faster than `linear` [m/s] or turns faster than `angular` [rad/s]."""
        for name, (fast, spinning) in self.speeds().items():
            if fast > linear or spinning > angular:
                v, w, arm = self._velocity(name)
                v, w = v * min(1.0, linear / max(fast, 1e-12)), w * min(1.0, angular / max(spinning, 1e-12))
                at = self._v[name]
                self._data.qvel[at : at + 3] = v - np.cross(w, arm)
                self._data.qvel[at + 3 : at + 6] = self._rotation(name).T @ w

    def _rotation(self, name: str) -> Array:
        """An object's orientation, shape (3, 3)."""
        return self.pose(name).matrix[:3, :3]

    def _velocity(self, name: str) -> tuple[Array, Array, Array]:
        """Velocity of an object's centre of mass, its angular velocity, and the way from its origin to that centre.

        Each of shape (3,), in the world frame. MuJoCo has the velocity of the origin, and the angular one in the
        object's frame.
        """
        at, R = self._v[name], self._rotation(name)
        w, arm = R @ self._data.qvel[at + 3 : at + 6], R @ self._centers[name]
        return self._data.qvel[at : at + 3] + np.cross(w, arm), w, arm

    def touches(self) -> tuple[Touch, ...]:
        """Contacts of the last step between the table, the objects and the robot."""
        found = []
        wrench = np.zeros(6)
        for number in range(self._data.ncon):
            contact = self._data.contact[number]
            a, b = (self._owner.get(int(geom)) for geom in contact.geom)
            if a is None or b is None or a == b:
                continue
            mujoco.mj_contactForce(self._model, self._data, number, wrench)
            x, y, z = (-contact.frame[:3]).tolist()  # MuJoCo's points from the first geom to the second
            where = tuple(contact.pos.tolist())
            found.append(Touch(a, b, (x, y, z), -float(contact.dist), float(wrench[0]), where))
        return tuple(found)


def _body_name(number: int) -> str:
    """What an object's body is called in the model: names of objects may be anything."""
    return f"object_{number}"


def _model(objects: Mapping[str, Object], poses: Mapping[str, Pose], table: Table, robot: RobotSpec | None) -> Any:
    spec = mujoco.MjSpec()
    spec.option.timestep = STEP / SUBSTEPS
    spec.option.gravity = [0.0, 0.0, -GRAVITY]
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = IMPRATIO
    # Else constraints are as stiff as the fingers are light: with a kilogram between them, contacts come and go.
    spec.option.enableflags |= mujoco.mjtEnableBit.mjENBL_DIAGEXACT
    spec.compiler.balanceinertia = True
    spec.compiler.degree = False
    spec.compiler.autolimits = False
    top = spec.worldbody.add_body(name=TABLE, pos=(*table.center, -table.thickness / 2))
    add_geoms(spec, top, Box((*table.size, table.thickness)), SOLID)
    floor = spec.worldbody.add_body(name="floor", pos=(0.0, 0.0, -FLOOR_BELOW - 0.05))
    add_geoms(spec, floor, Box((10.0, 10.0, 0.1)), SOLID)
    if robot is not None:
        add_robot(spec, robot)
    for number, (name, item) in enumerate(objects.items()):
        add_object(spec, item, _body_name(number), poses.get(name, item.pose))
    return spec.compile()


def _owners(model: Any, names: Mapping[int, str], robot: RobotSpec | None) -> dict[int, str]:
    """Geom -> what it belongs to; those of the floor are absent."""
    still = {model.body(TABLE).id: TABLE}
    floor = model.body("floor").id
    found = {}
    for geom, body in enumerate(model.geom_bodyid.tolist()):
        if body != floor:
            found[geom] = names.get(body) or still.get(body) or ROBOT
    return found
