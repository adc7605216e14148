"""The robot cell behind the Standard API: a simulator, its robot and cameras, a clock, and a tally of grasps."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tamp.execution.controller import ARRIVED, set_points
from tamp.execution.log import Frame
from tamp.execution.simulator import STEP, Simulator, wait
from tamp.perception.cameras.camera import WORLD, Camera
from tamp.perception.cameras.capture import Shot, View, calibrated_pose, shoot
from tamp.perception.rendering.robot import camera_pose, link_pose
from tamp.perception.rendering.surface import Surface
from tamp.task import Pose, Task, Trajectory
from tamp.world.kinematics.inverse import inverse, straight_line
from tamp.world.robot.model import robot_model
from tamp.world.timing.time_parametrization import time_path

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

SETTLE_S = 1.0
"""How long the scene comes to rest before the clock starts, and before it is scored [s]."""

PICTURE_S = 1 / 30
"""Simulated time that a picture takes [s]."""

START_TOLERANCE = 0.05
"""How far from where the arm stands a trajectory may begin [rad]."""

OVERSPEED = 1.05
"""So many times its speed limit a joint may be asked to move at: splines overshoot a little."""

LIFTED = 0.02
"""A grasp has succeeded when its object is so much higher than where the fingers closed on it [m]."""

SHUT = 0.002
"""Fingers that end nearer than this have closed on nothing [m]."""

TOOL = "tool"


class Refusal(Exception):  # noqa: N818  an answer
    """What was asked cannot be done; nothing has moved."""


class TimeOver(Exception):  # noqa: N818  an outcome
    """The simulated time of the task is used up."""


@dataclass
class Grasps:
    """Grasps so far; a grasp is a closing of the fingers on something, or all the way.

    Attributes:
        attempted, succeeded: so many.
        holding: what the fingers closed on last and how high its origin was then, until it is lifted or let go.
    """

    attempted: int = 0
    succeeded: int = 0
    holding: tuple[str, float] | None = None


class Workcell:
    """A task's scene with its robot.

    Args:
        task: objects, table and robot.
        simulator: the world, at its start.
        cameras: what there is to see with.
        looks: object -> what it looks like.
        seed: of the sensors' noise and of inverse kinematics.
        limit_s: simulated time there is [s].
        renderer: "raycast" or "software".
        film_s: simulated time between recorded frames [s]; None records none.
    """

    def __init__(
        self,
        task: Task,
        simulator: Simulator,
        cameras: Sequence[Camera],
        looks: dict[str, Surface],
        *,
        seed: int,
        limit_s: float,
        renderer: str = "raycast",
        film_s: float | None = None,
    ) -> None:
        assert simulator.robot is not None
        self.task, self.robot, self.grasps = task, simulator.robot, Grasps()
        self.cameras = {camera.name: camera for camera in cameras}
        self.frames: list[Frame] = []
        self._simulator, self._looks, self._seed, self._renderer = simulator, looks, seed, renderer
        self._model, self._spec = robot_model(self.robot.spec), self.robot.spec
        self._rng, self._pictures = np.random.default_rng(seed), itertools.count()
        simulator.step(round(SETTLE_S / STEP))
        self._target = self.robot.configuration()
        self._began, self._limit = simulator.time, limit_s
        self._steps, self._film = itertools.count(), None if film_s is None else max(1, round(film_s / STEP))
        simulator.on_step = self._after_step
        self._record()

    @property
    def time(self) -> float:
        """Simulated time that is used [s]."""
        return min(self._simulator.time - self._began, self._limit)

    @property
    def time_left(self) -> float:
        """Simulated time that is left [s]."""
        return self._limit - self.time

    def final_poses(self) -> dict[str, Pose]:
        """Object -> pose (world frame), after a moment to come to rest; the clock stands still."""
        self._simulator.on_step = None
        self._simulator.step(round(SETTLE_S / STEP))
        self._record()
        return self._simulator.poses()

    def state(self) -> tuple[Array, Array, float]:
        """Joint positions (joints,) [rad], `T_world_tool` (4, 4), distance between the finger pads [m]."""
        return self.robot.configuration(), self.robot.tool().matrix, self.robot.opening()

    def picture(self, name: str) -> Shot:
        """What a camera sees now."""
        camera = self._camera(name)
        self._simulator.step(round(PICTURE_S / STEP))
        view = View(camera, tuple(float(q) for q in self.robot.configuration()))
        return next(
            shoot(
                self._looks,
                self._simulator.poses(),
                [view],
                self._spec,
                table=self.task.table,
                seed=self._seed,
                renderer=self._renderer,
                first=next(self._pictures),
            )
        )

    def frame_pose(self, name: str) -> Array:
        """`T_world_frame`, (4, 4), by encoders and calibration, of the world, the tool, a camera or a link."""
        q = [float(value) for value in self.robot.configuration()]
        if name == WORLD:
            return np.eye(4)
        if name == TOOL:
            return np.asarray(self._model.forward(np.array(q)))
        if name in self.cameras:
            camera = self.cameras[name]
            return calibrated_pose(camera, camera_pose(camera, self._spec, q), self._seed)
        if not self._model.model.existBodyName(name):
            raise Refusal(f"there is no frame {name!r}; valid are world, tool, {', '.join(self.cameras)}, and links")
        return link_pose(self._model, name, q, self.robot.opening())

    def move_joints(self, q: Array, speed: float) -> None:
        """Move on a straight line in joint space."""
        self._refuse_joints(q)
        self._follow(time_path(np.array([self._within(self._target), self._within(q)]), self._spec, speed=speed))

    def move_pose(self, T_world_tool: Array, speed: float, straight: bool) -> None:
        """Move the tool to a pose, on a line of its own or of the joints."""
        try:
            T = Pose.from_matrix(T_world_tool).matrix
        except ValueError as error:
            raise Refusal(f"T_world_tool is no pose: {error}") from None
        if np.abs(T - T_world_tool).max() > 1e-3:
            raise Refusal("T_world_tool is no pose: its rotation is not orthonormal")
        here = self._within(self._target)
        if straight:
            path = straight_line(self._model, here, T)
        else:
            found = next(inverse(self._model, T, self._rng, near=here, count=1), None)
            path = None if found is None else np.array([here, found])
        if path is None:
            way = "on a straight line from here" if straight else "at all"
            raise Refusal(f"the tool cannot reach that pose {way}")
        self._follow(time_path(path, self._spec, speed=speed))

    def follow(self, times: Array, positions: Array, velocities: Array | None) -> None:
        """Follow a trajectory."""
        if not len(times):
            raise Refusal("the trajectory has no points")
        if positions.shape != (len(times), len(self._spec.joints)):
            raise Refusal(f"positions have shape {positions.shape}, not ({len(times)}, {len(self._spec.joints)})")
        if velocities is not None and velocities.shape != positions.shape:
            raise Refusal(f"velocities have shape {velocities.shape}, not that of positions, {positions.shape}")
        if (np.diff(times) <= 1e-6).any():
            raise Refusal("times do not increase strictly")
        if times[-1] - times[0] > self.time_left:
            raise Refusal(f"the trajectory takes {times[-1] - times[0]:.1f} s; {self.time_left:.1f} s are left")
        self._refuse_joints(positions)
        off = float(np.abs(positions[0] - self.robot.configuration()).max())
        if off > START_TOLERANCE:
            raise Refusal(f"the trajectory begins {off:.3f} rad from where the arm is; {START_TOLERANCE} is tolerated")
        if velocities is None:
            velocities = np.zeros_like(positions)
            if len(times) > 2:
                velocities[1:-1] = np.gradient(positions, times, axis=0)[1:-1]
        trajectory = Trajectory(times - times[0], positions.copy(), velocities.copy())
        between, speeds = set_points(trajectory, STEP)
        self._refuse_joints(between)  # a spline may leave what its points keep to
        excess = float((np.abs(speeds) / self._spec.velocity).max())
        if excess > OVERSPEED:
            raise Refusal(f"a joint would move at {excess:.2f} times its largest speed")
        self._follow(trajectory)

    def go_to(self, width: float, effort: float) -> None:
        """Open, or close until `width` or something is between the fingers."""
        width = min(width, self._spec.gripper.stroke)
        if width >= self.robot.opening() - 1e-3:
            self.grasps.holding = None
            self.robot.open_to(width)
            self._arrive(width)
            return
        held = self._held()  # is no new grasp where the fingers only press otherwise
        self.robot.squeeze(max(1.0, min(effort, self._spec.gripper.force)))
        self._close(width)
        touched = [name for name in self._simulator.objects if any(self.robot.touching(name))]
        if not touched and self.robot.opening() <= width + SHUT:
            self.robot.open_to(width)
            self._arrive(width)
        if held is None and (touched or self.robot.opening() < SHUT):
            self.grasps.attempted += 1
            held = self._held()
            self.grasps.holding = None if held is None else (held, self._simulator.pose(held).xyz[2])

    def _arrive(self, width: float) -> None:
        """Wait until the fingers are at rest at a width to which they were sent."""
        self._wait(1.5, lambda: abs(self.robot.opening() - width) < 5e-4, 3)

    def _close(self, width: float) -> None:
        """Wait until fingers that squeeze are at a width, or have stood still for a tenth of a second."""
        still = 0
        for _ in range(round(2.0 / STEP)):
            self._simulator.step()
            still = still + 1 if self.robot.finger_speed() < 1e-3 else 0
            if self.robot.opening() <= width or still >= 24:
                return

    def _held(self) -> str | None:
        """What touches both pads."""
        return next((name for name in self._simulator.objects if all(self.robot.touching(name))), None)

    def wait(self, seconds: float) -> None:
        """Let simulated time pass."""
        for _ in range(round(seconds / STEP)):
            self._simulator.step()

    def _wait(self, limit_s: float, until: Callable[[], bool], patience: int) -> bool:
        return wait(self._simulator, limit_s, until, patience)

    def _follow(self, trajectory: Trajectory) -> None:
        for q, v in zip(*set_points(trajectory, STEP), strict=True):
            self._target = q
            self.robot.command(q, v)
            self._simulator.step()
        self._target = end = trajectory.positions[-1]
        self.robot.command(end)
        self._wait(0.5, lambda: float(np.abs(self.robot.configuration() - end).max()) < ARRIVED, 6)

    def _refuse_joints(self, q: Array) -> None:
        if q.shape[-1] != len(self._spec.joints):
            raise Refusal(f"{q.shape[-1]} joint positions; the arm has {len(self._spec.joints)} joints")
        outside = np.abs(q - self._within(q)).reshape(-1, q.shape[-1]).max(axis=0)
        if outside.max() > 1e-6:
            joint = int(outside.argmax())
            low, high = self._spec.lower[joint], self._spec.upper[joint]
            raise Refusal(f"joint {joint} would leave its range, {low:.4f} to {high:.4f} rad")

    def _within(self, q: Array) -> Array:
        return np.clip(q, self._spec.lower, self._spec.upper)

    def _camera(self, name: str) -> Camera:
        if name not in self.cameras:
            raise Refusal(f"there is no camera {name!r}; valid are {', '.join(self.cameras)}")
        return self.cameras[name]

    def _after_step(self) -> None:
        count = next(self._steps)
        if self.grasps.holding is not None and count % 24 == 0:
            name, height = self.grasps.holding
            if self._simulator.pose(name).xyz[2] - height > LIFTED and all(self.robot.touching(name)):
                self.grasps.succeeded += 1
                self.grasps.holding = None
        if self._film is not None and count % self._film == 0:
            self._record()
        if self._simulator.time - self._began >= self._limit:
            raise TimeOver

    def _record(self) -> None:
        if self._film is not None:
            q = tuple(float(value) for value in self.robot.configuration())
            self.frames.append(Frame(self.time, self._simulator.poses(), q, self.robot.opening()))
