"""A simulated workcell: a physics engine for arm and gripper, a renderer with sensor noise for the cameras."""

from __future__ import annotations

from collections.abc import Mapping

from tamp.errors import TampError
from tamp.execution.controller import Operator
from tamp.execution.simulator import STEP, Simulator, wait
from tamp.perception.cameras.camera import Camera, Frame
from tamp.perception.cameras.capture import View, shoot
from tamp.perception.rendering.surface import Surface
from tamp.task import RobotSpec, Table, Trajectory

STILL = 0.001
"""Fingers slower than this stand [m/s]."""


class SimulatedWorkcell:
    """The workcell's protocol in a simulator; see `Workcell`.

    Args:
        simulator: the true world; nobody reaches it through the workcell.
        looks: object -> what it looks like.
        cameras: the cameras.
        table: the table top.
        seed: decides every error of sensors and calibration.
        renderer: "raycast" or "software".
    """

    def __init__(
        self,
        simulator: Simulator,
        looks: Mapping[str, Surface],
        cameras: tuple[Camera, ...],
        table: Table,
        *,
        seed: int = 0,
        renderer: str = "raycast",
    ) -> None:
        self.__simulator = simulator
        self.__operator = Operator(simulator)
        self._looks, self._table, self._seed, self._renderer = looks, table, seed, renderer
        self._cameras = {camera.name: camera for camera in cameras}
        self._pictures = 0

    @property
    def robot(self) -> RobotSpec:
        """The robot as data."""
        return self.__operator.robot.spec

    @property
    def cameras(self) -> tuple[Camera, ...]:
        """The cameras."""
        return tuple(self._cameras.values())

    @property
    def time(self) -> float:
        """Simulated time since the world was built [s]."""
        return self.__simulator.time

    def frame(self, camera: str) -> Frame:
        """A picture from where the camera is now; each has noise of its own.

        Raises:
            TampError: where there is no such camera.
        """
        if camera not in self._cameras:
            raise TampError(f"there is no camera {camera!r}; valid are {', '.join(self._cameras)}")
        view = View(self._cameras[camera], self.configuration(), self.opening())
        poses = self.__simulator.poses()
        shots = shoot(
            self._looks,
            poses,
            (view,),
            self.robot,
            table=self._table,
            seed=self._seed,
            first=self._pictures,
            renderer=self._renderer,
        )
        self._pictures += 1
        return next(shots).frame

    def configuration(self) -> tuple[float, ...]:
        """Where the arm's joints are now [rad]."""
        return tuple(float(q) for q in self.__operator.robot.configuration())

    def opening(self) -> float:
        """Distance between the finger pads now [m]."""
        return float(max(0.0, self.__operator.robot.opening()))

    def follow(self, trajectory: Trajectory) -> None:
        """Follow a trajectory set point by set point."""
        self.__operator.follow(trajectory)

    def open_to(self, opening: float) -> None:
        """Open or close the empty fingers to an opening [m]."""
        self.__operator.open(opening)

    def squeeze(self, force: float) -> None:
        """Close the fingers until they stand, and keep pressing with a force [N]."""
        robot = self.__operator.robot
        robot.squeeze(force)
        wait(self.__simulator, 2.0, lambda: robot.finger_speed() < STILL, patience=24)

    def wait(self, seconds: float) -> None:
        """Let time pass [s]."""
        self.__simulator.step(round(seconds / STEP))
