"""A third party's simulator as runs see it: what it raises, or answers wrongly, is a sentence that names it.

The protocol's methods are passed on. An answer that later steps would compute on with, such as a pose that is none or
a joint position that is no number, is refused where it comes in.
"""

from __future__ import annotations

import math
import reprlib
from collections.abc import Callable, Mapping, Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Any, TypeVar

from tamp.errors import ModelError, PartError, TampError, told
from tamp.execution.simulator import Robot, Simulator, Touch
from tamp.task import Object, Pose, RobotSpec

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Vector = NDArray[np.float64]

Answer = TypeVar("Answer")


class _Asked:
    """Asks something of a simulator's."""

    def __init__(self, name: str) -> None:
        self._name = name

    def _ask(self, method: str, ask: Callable[[], Answer]) -> Answer:
        """An answer; what is raised instead, as a PartError that says by what."""
        try:
            return ask()
        except ModelError as error:
            raise self._fault(method, f"raised {told(error)}") from error
        except TampError:
            raise
        except (Exception, SystemExit) as error:
            raise self._fault(method, f"raised {told(error)}") from error

    def _fault(self, method: str, complaint: str) -> PartError:
        return PartError(f"simulator {self._name!r}: {method} {complaint}")

    def _expect(self, fits: bool, method: str, valid: str, found: object) -> None:
        if not fits:
            raise self._fault(method, f"gave {reprlib.repr(found)}; valid is {valid}")

    def _number(self, method: str, ask: Callable[[], Any]) -> float:
        found = self._ask(method, ask)
        self._expect(_finite([found]), method, "a finite number", found)
        return float(found)


def _finite(values: Any) -> bool:
    """Whether these are finite numbers, one after the other."""
    try:
        return all(math.isfinite(float(value)) for value in values)
    except (TypeError, ValueError):
        return False


class GuardedRobot(_Asked):
    """The robot of such a simulator; see `tamp.execution.simulator.Robot`."""

    def __init__(self, name: str, robot: Robot) -> None:
        super().__init__(name)
        self._robot = robot
        self.spec: RobotSpec = self._ask("robot.spec", lambda: robot.spec)

    def configuration(self) -> Vector:
        """Arm joint positions, shape (joints,) [rad]."""
        import numpy as np

        found = self._ask("robot.configuration", self._robot.configuration)
        fits = _finite(found) and len(found) == len(self.spec.joints)
        self._expect(fits, "robot.configuration", f"{len(self.spec.joints)} finite joint positions [rad]", found)
        return np.asarray(found, dtype=np.float64)

    def opening(self) -> float:
        """Distance between the finger pads [m]."""
        return self._number("robot.opening", self._robot.opening)

    def finger_speed(self) -> float:
        """Speed of the fastest finger [m/s]."""
        return self._number("robot.finger_speed", self._robot.finger_speed)

    def tool(self) -> Pose:
        """`T_world_tool` as it is now."""
        found = self._ask("robot.tool", self._robot.tool)
        self._expect(isinstance(found, Pose), "robot.tool", "a tamp.Pose", found)
        return found

    def command(self, q: Sequence[float] | Vector, velocity: Sequence[float] | Vector | None = None) -> None:
        """Send the arm to `q` [rad]."""
        self._ask("robot.command", lambda: self._robot.command(q, velocity))

    def open_to(self, opening: float) -> None:
        """Send the fingers to `opening` [m]."""
        self._ask("robot.open_to", lambda: self._robot.open_to(opening))

    def squeeze(self, force: float) -> None:
        """Close the fingers, each with `force` [N]."""
        self._ask("robot.squeeze", lambda: self._robot.squeeze(force))

    def touching(self, name: str) -> tuple[bool, ...]:
        """For each finger, whether it touches an object."""
        return self._ask("robot.touching", lambda: tuple(map(bool, self._robot.touching(name))))


class GuardedSimulator(_Asked):
    """Such a simulator; see `tamp.execution.simulator.Simulator`.

    Args:
        name: as the user gave it.
        make: makes the world.
        with_robot: whether one was asked for.

    Raises:
        PartError: where it cannot be made, or has no robot though one was asked for.
    """

    def __init__(self, name: str, make: Callable[[], Simulator], with_robot: bool) -> None:
        super().__init__(name)
        self._world = self._ask("its construction", make)
        robot = self._ask("robot", lambda: self._world.robot)
        self._expect((robot is not None) == with_robot, "robot", "one exactly where the world is made with one", robot)
        self.robot: Robot | None = None if robot is None else GuardedRobot(name, robot)

    def __enter__(self) -> GuardedSimulator:
        self._ask("__enter__", self._world.__enter__)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._ask("__exit__", lambda: self._world.__exit__(kind, error, trace))

    @property
    def on_step(self) -> Callable[[], None] | None:
        """Called after every step."""
        return self._world.on_step

    @on_step.setter
    def on_step(self, onlooker: Callable[[], None] | None) -> None:
        self._world.on_step = onlooker

    @property
    def objects(self) -> Mapping[str, Object]:
        """The objects in the world, by name."""
        return self._ask("objects", lambda: self._world.objects)

    @property
    def time(self) -> float:
        """Simulated time since the start [s]."""
        return self._number("time", lambda: self._world.time)

    def step(self, count: int = 1) -> None:
        """Let `count` steps pass."""
        self._ask("step", lambda: self._world.step(count))

    def pose(self, name: str) -> Pose:
        """Where one object's frame stands now (world frame)."""
        found = self._ask("pose", lambda: self._world.pose(name))
        self._expect(isinstance(found, Pose), "pose", "a tamp.Pose", found)
        return found

    def poses(self) -> dict[str, Pose]:
        """Object -> where its frame stands now (world frame)."""
        found = self._ask("poses", self._world.poses)
        names = sorted(self.objects)
        fits = (
            isinstance(found, Mapping) and sorted(found) == names and all(isinstance(p, Pose) for p in found.values())
        )
        self._expect(fits, "poses", f"a tamp.Pose of each of {', '.join(names) or 'no object'}", found)
        return dict(found)

    def place(self, name: str, pose: Pose) -> None:
        """Put an object at rest at a pose (world frame)."""
        self._ask("place", lambda: self._world.place(name, pose))

    def speeds(self) -> dict[str, tuple[float, float]]:
        """Object -> its linear [m/s] and angular [rad/s] speed."""
        found = self._ask("speeds", self._world.speeds)
        fits = isinstance(found, Mapping) and all(_finite(pair) and len(pair) == 2 for pair in found.values())
        self._expect(fits, "speeds", "two finite numbers for each object", found)
        return dict(found)

    def limit_speeds(self, linear: float, angular: float) -> None:
        """Slow every object that moves faster than `linear` [m/s] or turns faster than `angular` [rad/s]."""
        self._ask("limit_speeds", lambda: self._world.limit_speeds(linear, angular))

    def touches(self) -> tuple[Touch, ...]:
        """Contacts of the last step between the table, the objects and the robot."""
        found = self._ask("touches", lambda: tuple(self._world.touches()))
        odd = next((touch for touch in found if not isinstance(touch, Touch)), None)
        self._expect(odd is None, "touches", "a Touch of tamp.execution.simulator for each contact", odd)
        return found
