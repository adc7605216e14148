"""What a solution works with: `goal` and `robot`.

    class Solution:
        def run(self, goal, robot):
            frame = robot.camera.frame("kinect")
            robot.arm.move_joints(robot.arm.home)
            robot.gripper.go_to(0.08, effort=20)

Time is simulated: it passes while the robot moves or waits, not while the solution thinks. Metres, radians, newtons;
poses are homogeneous transforms, shape (4, 4); `T_a_b` is the pose of b in a. World frame: origin on the table, z up.
"""

from __future__ import annotations

import os
import reprlib
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from tamp.contest.api.schema import ANSWERS, CALLS, VERSION, check
from tamp.contest.api.wire import Channel, Message, ProtocolError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Matrix = NDArray[np.float64]


class Refused(Exception):  # noqa: N818  the robot's answer, which a solution may expect
    """The robot cannot do what was asked; nothing has moved. Says why."""


class TimeUp(Exception):  # noqa: N818
    """The time of the task is over; the robot takes no more calls."""


@dataclass(frozen=True, eq=False)
class GoalObject:
    """An object of the task, and where it shall be.

    Attributes:
        name: unique in the task.
        mesh: an OBJ file at true size, a group each convex part [m].
        visual: the coloured mesh, where there is one.
        mass: [kg].
        friction: coefficient of lateral friction.
        pose: `T_world_object` that it shall have, (4, 4), or None where it need not be moved.
        on, inside: the region or object that it shall stand on or lie in, where the goal is no pose; else None.
    """

    name: str
    mesh: Path
    visual: Path | None
    mass: float
    friction: float
    pose: Matrix | None
    on: str | None
    inside: str | None


@dataclass(frozen=True, eq=False)
class Goal:
    """What is asked.

    Attributes:
        task: the task's name.
        objects: name -> object.
        table: centre x, y, size x, y and thickness of the table top, whose face is at z = 0 [m].
    """

    task: str
    objects: Mapping[str, GoalObject]
    table: tuple[float, ...]

    def __reduce__(self) -> tuple[Any, ...]:  # a solution may send it to processes of its own
        return _goal, (self.task, dict(self.objects), self.table)


def _goal(task: str, objects: dict[str, GoalObject], table: tuple[float, ...]) -> Goal:
    return Goal(task, MappingProxyType(objects), table)


@dataclass(frozen=True, eq=False)
class Frame:
    """What a camera sees now; colour and depth are registered.

    Attributes:
        color: (height, width, 3), uint8.
        depth: (height, width), float32, along the optical axis [m]; 0 is no measurement.
        robot: where the robot is in the picture, by its encoders; (height, width), bool.
        K: intrinsics, (3, 3); the centre of pixel (u, v) is at (u + 0.5, v + 0.5).
        T_world_camera: pose of the optical frame (z forward, x right, y down) as calibration has it, (4, 4).
    """

    color: NDArray[np.uint8]
    depth: NDArray[np.float32]
    robot: NDArray[np.bool_]
    K: Matrix
    T_world_camera: Matrix


@dataclass(frozen=True, eq=False)
class ArmState:
    """Where the arm is.

    Attributes:
        q: joint positions, (joints,) [rad].
        T_world_tool: pose of the tool frame, whose z axis is the approach, (4, 4).
        width: distance between the finger pads [m].
    """

    q: Matrix
    T_world_tool: Matrix
    width: float


_Queue = SimpleQueue[Any]
"""Of all queues, this one loses and blocks nothing where an exception of a signal's handler comes in between."""

ONE_PROCESS = "the robot answers to the process that run() is called in: ask there, and send what was seen to others"


class Connection:
    """Asks the server, one call at a time, in a thread of its own: whoever asks, and whatever interrupts who waits.

    Attributes:
        time_left: simulated seconds that were left after the last call.
    """

    def __init__(self, channel: Channel) -> None:
        self._channel, self._number = channel, 0
        # A signal that the solution handles, such as an alarm, interrupts no thread but its own first one.
        self._waiting, self._process = _Queue(), os.getpid()
        threading.Thread(target=self._work, daemon=True).start()
        self.time_left = 0.0

    def __reduce__(self) -> NoReturn:
        raise TypeError(ONE_PROCESS)

    def ask(
        self, kind: str, fields: Mapping[str, Any] = MappingProxyType({}), arrays: Mapping[str, Any] | None = None
    ) -> Message:
        """Say something and wait for the answer.

        Raises:
            Refused: where it cannot be done.
            TimeUp: where the time of the task is over.
            ValueError: where an argument is none that the API takes.
            RuntimeError: in another process.
        """
        self._require_own_process()
        try:
            check(Message(kind, 0, fields, arrays or {}), CALLS)
        except ProtocolError as error:
            raise ValueError(str(error)) from None
        answer: Message = self._done(lambda: self._exchange(kind, fields, arrays or {}))
        if answer.kind == "over":
            self.time_left = 0.0
            raise TimeUp(answer.fields["reason"])
        if answer.kind == "refused":
            raise Refused(answer.fields["reason"])
        return answer

    def _require_own_process(self) -> None:
        if os.getpid() != self._process:
            raise RuntimeError(ONE_PROCESS)

    def _exchange(self, kind: str, fields: Mapping[str, Any], arrays: Mapping[str, Any]) -> Message:
        self._number += 1
        self._channel.send(Message(kind, self._number, fields, arrays))
        answer = check(self._channel.receive(), ANSWERS)
        if answer.number != self._number:
            raise ProtocolError(f"the answer is to call {answer.number}, not {self._number}")
        self.time_left = float(answer.fields.get("time_left", self.time_left))
        return answer

    def tell(self, kind: str, **fields: Any) -> None:
        """Say what has no answer, once the last call has its own."""
        self._require_own_process()  # a copy of it may have come to the end of run(), too
        message = check(Message(kind, self._number + 1, fields), CALLS)
        self._done(lambda: self._channel.send(message))

    def _done(self, action: Callable[[], Any]) -> Any:
        """What comes of an action that the thread does; whatever interrupts who waits for it, it is done whole."""
        came = _Queue()
        self._waiting.put((action, came))
        value, error = came.get()
        if error is not None:
            raise error
        return value

    def _work(self) -> None:
        while True:
            action, came = self._waiting.get()
            try:
                came.put((action(), None))
            except BaseException as error:
                came.put((None, error))


def _vector(name: str, values: ArrayLike, dimensions: int) -> Matrix:
    try:
        array = np.array(values, dtype="<f8")
    except (TypeError, ValueError):
        raise ValueError(f"{name} is {reprlib.repr(values)}, expected an array of numbers") from None
    if array.ndim != dimensions:
        raise ValueError(f"{name} has shape {array.shape}, expected {dimensions} dimensions")
    return array


def _number(name: str, value: Any) -> float:
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"{name} is {reprlib.repr(value)}, expected a number") from None


class Cameras:
    """The cameras.

    Attributes:
        names: of all cameras.
    """

    def __init__(self, connection: Connection, names: Sequence[str]) -> None:
        self._connection, self.names = connection, tuple(names)

    def frame(self, name: str) -> Frame:
        """What a camera sees from where it is now; one on the wrist moves with the arm."""
        arrays = self._connection.ask("frame", {"camera": name}).arrays
        robot = arrays["robot"].astype(bool)
        return Frame(arrays["color"], arrays["depth"], robot, arrays["K"], arrays["T_world_camera"])


class Arm:
    """The arm. A call returns when the motion is over.

    Attributes:
        joints: their names.
        home, lower, upper: rest configuration and limits, (joints,) [rad].
        velocity: largest joint speeds, (joints,) [rad/s].
    """

    def __init__(self, connection: Connection, welcome: Message) -> None:
        self._connection = connection
        self.joints = tuple(joint["name"] for joint in welcome.fields["joints"])
        self.home, self.lower, self.upper, self.velocity = (
            welcome.arrays[name] for name in ("home", "lower", "upper", "velocity")
        )

    def state(self) -> ArmState:
        """Where the arm is."""
        answer = self._connection.ask("state")
        return ArmState(answer.arrays["q"], answer.arrays["T_world_tool"], float(answer.fields["width"]))

    def move_joints(self, q: ArrayLike, speed: float = 1.0) -> None:
        """Move on a straight line in joint space to `q` [rad], at a share of the arm's speed."""
        self._connection.ask("move_joints", {"speed": _number("speed", speed)}, {"q": _vector("q", q, 1)})

    def move_pose(self, T_world_tool: ArrayLike, speed: float = 1.0, straight: bool = True) -> None:
        """Move the tool to a pose (4, 4), on a straight line or, where not `straight`, however the joints go."""
        fields = {"speed": _number("speed", speed), "straight": bool(straight)}
        self._connection.ask("move_pose", fields, {"T_world_tool": _vector("T_world_tool", T_world_tool, 2)})

    def follow(self, times: ArrayLike, positions: ArrayLike, velocities: ArrayLike | None = None) -> None:
        """Follow a trajectory that begins where the arm is.

        Args:
            times: (n,), strictly increasing [s].
            positions: (n, joints) [rad].
            velocities: (n, joints) [rad/s]; without them they follow from the positions, at rest at both ends.
        """
        arrays = {"times": _vector("times", times, 1), "positions": _vector("positions", positions, 2)}
        if velocities is not None:
            arrays["velocities"] = _vector("velocities", velocities, 2)
        self._connection.ask("follow", {}, arrays)


class Gripper:
    """The gripper.

    Attributes:
        stroke: largest distance between the pads [m].
    """

    def __init__(self, connection: Connection, stroke: float) -> None:
        self._connection, self.stroke = connection, stroke

    def go_to(self, width: float, effort: float = 20.0) -> None:
        """Open or close to `width` [m]; closing on something, keep pressing with `effort` [N] a finger."""
        self._connection.ask("go_to", {"width": _number("width", width), "effort": _number("effort", effort)})


class Robot:
    """The robot cell: cameras, arm, gripper, calibration, and the clock.

    Attributes:
        name: of the robot.
    """

    def __init__(self, connection: Connection, welcome: Message) -> None:
        self._connection = connection
        self.name = str(welcome.fields["robot"])
        self.camera = Cameras(connection, [camera["name"] for camera in welcome.fields["cameras"]])
        self.arm = Arm(connection, welcome)
        self.gripper = Gripper(connection, float(welcome.fields["stroke"]))

    @property
    def time_left(self) -> float:
        """Simulated time that is left [s]."""
        return self._connection.time_left

    def tf(self, parent: str, child: str) -> Matrix:
        """`T_parent_child`, (4, 4), of "world", "tool", a camera, or a link of the robot."""
        return self._connection.ask("tf", {"parent": parent, "child": child}).arrays["T_parent_child"]

    def wait(self, seconds: float) -> None:
        """Let simulated time pass [s]."""
        self._connection.ask("wait", {"seconds": _number("seconds", seconds)})


def connect(connection: Connection, models: Path) -> tuple[Goal, Robot]:
    """Begin: what is asked, and the robot.

    Args:
        connection: to the server.
        models: the folder that holds the objects' meshes.
    """
    welcome = connection.ask("hello", {"version": VERSION})
    objects = {item["name"]: _object(item, models) for item in welcome.fields["objects"]}
    goal = Goal(str(welcome.fields["task"]), MappingProxyType(objects), tuple(welcome.fields["table"]))
    return goal, Robot(connection, welcome)


def _object(item: Mapping[str, Any], models: Path) -> GoalObject:
    return GoalObject(
        name=item["name"],
        mesh=models / item["mesh"],
        visual=None if item["visual"] is None else models / item["visual"],
        mass=item["mass"],
        friction=item["friction"],
        pose=None if item["pose"] is None else np.array(item["pose"]).reshape(4, 4),
        on=item["on"],
        inside=item["inside"],
    )
