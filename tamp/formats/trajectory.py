"""A plan's motions for a robot's own controller: set points at a fixed rate, as a table or as ROS 2 messages.

A plan is a sequence of motions of the arm with actions of the gripper between them. What is written is that sequence
on one clock that begins at 0, the gripper given `GRIPPER_S` for each of its actions; a controller that waits for the
gripper itself takes each motion alone. No driver for any hardware is part of this.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np
import yaml

from tamp.errors import TampError
from tamp.task.plan import Fall, Grip, Move, Plan, Release, Trajectory
from tamp.task.robot import RobotSpec
from tamp.versions import how_to_install
from tamp.world.robot.linkage import linkage
from tamp.world.timing.trajectory import positions_at

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

Format = Literal["csv", "ros2", "rosbag2"]
FORMATS: tuple[str, ...] = get_args(Format)

GRIPPER_S = 1.0
"""What an action of the gripper, or the fall of an object, is given [s]."""

STRAY = 0.002
"""How far set points, joined by cubics, may be from the plan's own curve, which was checked for collisions [rad]."""

MOST_RATE = 10_000.0
"""No controller takes more set points a second [1/s]."""

OPENED = 0.0005
"""Fingers that are no farther from an opening than this are there [m]."""

MOST_DRAWN_OUT = 1.05
"""By how much a motion may be slower than planned."""

ARM_TOPIC, GRIPPER_TOPIC = "/arm/joint_trajectory", "/gripper/joint_trajectory"


@dataclass(frozen=True, eq=False)
class Segment:
    """A motion of the arm, or a time in which it stands and the gripper acts.

    Attributes:
        action: what it is part of, such as "pick(mug)".
        phase: of a motion, as `Move` has it; else "open" before a motion, "grip", "release" or "fall".
        start: when it begins [s].
        times: of the set points since then, shape (n,) [s]; the last is its duration.
        positions, velocities: of the arm's joints at those times, shape (n, joints) [rad], [rad/s].
        opening: distance between the finger pads that the gripper goes to, or keeps [m].
    """

    action: str
    phase: str
    start: float
    times: Array
    positions: Array
    velocities: Array
    opening: float


def segments(plan: Plan, robot: RobotSpec, rate: float) -> tuple[Segment, ...]:
    """A plan as set points.

    Args:
        plan: what is to be done.
        robot: whose limits the set points must meet.
        rate: of the set points [1/s]; the last of a motion comes when it ends.

    Raises:
        TampError: where the rate is not positive, or so low that the set points stray from the plan's motions.
    """
    if not (math.isfinite(rate) and rate > 0):
        raise TampError(f"--rate {rate:g}: a positive number of set points a second is needed, such as 100")
    if rate > MOST_RATE:
        raise TampError(f"--rate {rate:g}: at most {MOST_RATE:g} set points a second are valid")
    made: list[Segment] = []
    clock, q, opening = 0.0, np.array(plan.home), robot.gripper.stroke
    for action in plan.actions:
        for step in action.steps:
            if isinstance(step, Move):
                if step.held is None and abs(step.opening - opening) > OPENED:
                    made.append(_standing(str(action), "open", clock, q, step.opening))
                    clock += GRIPPER_S
                points = _set_points(step.trajectory, robot, rate, f"{action}, {step.phase}")
                q, opening = points[1][-1], step.opening
                made.append(Segment(str(action), step.phase, clock, *points, opening))
            else:
                phase, opening = _gripper(step, opening)
                made.append(_standing(str(action), phase, clock, q, opening))
            clock += float(made[-1].times[-1])
    return tuple(made)


def _standing(action: str, phase: str, clock: float, q: Array, opening: float) -> Segment:
    """The time in which the arm stands at `q` [rad] while the gripper goes to an opening [m]."""
    return Segment(action, phase, clock, np.array([0.0, GRIPPER_S]), np.array([q, q]), np.zeros((2, len(q))), opening)


def _gripper(step: Grip | Release | Fall, opening: float) -> tuple[str, float]:
    if isinstance(step, Grip):
        return "grip", step.width
    return ("release", step.opening) if isinstance(step, Release) else ("fall", opening)


def _sampled(trajectory: Trajectory, rate: float) -> tuple[Array, Array, Array]:
    """Times, positions and velocities of a motion at a rate, its end among them and at rest."""
    end = trajectory.duration
    times = np.arange(max(1, math.ceil(end * rate - 1e-6)), dtype=np.float64) / rate
    times = np.append(times, end)
    positions = positions_at(trajectory, times)
    velocities = _velocities_at(trajectory, times)
    return times, positions, velocities


def _velocities_at(trajectory: Trajectory, times: Array) -> Array:
    """Velocities of the cubic Hermite curve at `times` [s], shape (n, joints) [rad/s]."""
    t, q, v = trajectory.times, trajectory.positions, trajectory.velocities
    i = np.clip(np.searchsorted(t, times, side="right") - 1, 0, len(t) - 2)
    h = (t[i + 1] - t[i])[:, None]
    s = (times - t[i])[:, None] / h
    rise = 6 * s * (1 - s) * (q[i + 1] - q[i]) / h
    return np.asarray(rise + (1 - s) * (1 - 3 * s) * v[i] + s * (3 * s - 2) * v[i + 1])


def _set_points(planned: Trajectory, robot: RobotSpec, rate: float, name: str) -> tuple[Array, Array, Array]:
    """Times, positions and velocities from which a controller that joins them by cubics moves as planned.

    Cubics between set points are a little faster here and there than the plan's own curve: a motion that is as fast as
    the joints allow is drawn out until its set points are within their limits.
    """
    slower = 1.0
    while slower < MOST_DRAWN_OUT:
        drawn_out = Trajectory(slower * planned.times, planned.positions.copy(), planned.velocities / slower)
        points = _sampled(drawn_out, rate)
        replayed = Trajectory(*(array.copy() for array in points))
        moments = np.linspace(0.0, drawn_out.duration, max(2, math.ceil(drawn_out.duration / 0.001)))
        stray = float(np.abs(positions_at(replayed, moments) - positions_at(drawn_out, moments)).max())
        if stray > STRAY:
            raise TampError(f"{name}: at {rate:g} Hz set points stray {stray:.4f} rad from the plan; ask for more")
        speed = float((np.abs(_velocities_at(replayed, moments)).max(axis=0) / robot.velocity).max())
        mean = np.diff(replayed.velocities, axis=0) / np.diff(replayed.times)[:, None]
        pull = float((np.abs(mean).max(axis=0) / robot.acceleration).max())
        if max(speed, pull) <= 1.0:
            return points
        slower *= max(speed, math.sqrt(pull)) + 1e-4
    raise TampError(f"{name}: at {rate:g} Hz the set points ask more than the joints can do; ask for more of them")


def export_trajectory(plan: Plan, robot: RobotSpec, path: Path, form: Format = "csv", rate: float = 100.0) -> int:
    """Write a plan's motions.

    Args:
        plan: what is to be done.
        robot: its robot.
        path: a file; for "rosbag2" a folder that does not exist yet.
        form: "csv": a row a set point, times growing: where one segment ends, the next one has the row. "ros2": YAML,
            a document for each segment, whose `message` is a trajectory_msgs/msg/JointTrajectory as `ros2 topic pub`
            takes it. "rosbag2": the same as a bag.
        rate: of the set points [1/s].

    Returns:
        How many set points were written.

    Raises:
        TampError: where the rate will not do, or a library is absent.
    """
    if form not in FORMATS:
        raise TampError(f"unknown format {form!r}; valid are {', '.join(FORMATS)}")
    made = segments(plan, robot, rate)
    if form == "csv":
        return _write_csv(made, robot, path)
    if form == "ros2":
        documents = [_document(segment, robot) for segment in made]
        path.write_text(yaml.safe_dump_all(documents, sort_keys=False, default_flow_style=None), encoding="utf-8")
    else:
        _write_bag(made, robot, path)
    return sum(len(segment.times) for segment in made)


def _write_csv(made: tuple[Segment, ...], robot: RobotSpec, path: Path) -> int:
    """Write the table; how many rows it has below its head."""
    count = 0
    with path.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        columns = [f"{quantity}.{joint}" for quantity in ("q", "v") for joint in robot.joints]
        rows.writerow(["time", "segment", "action", "phase", "opening", *columns])
        for number, segment in enumerate(made):
            # A segment ends where the next one begins: at that time the table has the next one's row alone.
            end = len(segment.times) - (segment is not made[-1])
            count += end
            for time, q, v in zip(segment.times[:end], segment.positions, segment.velocities, strict=False):
                moment = [repr(float(value)) for value in (segment.start + time, segment.opening, *q, *v)]
                rows.writerow([moment[0], number, segment.action, segment.phase, *moment[1:]])
    return count


def _messages(segment: Segment, robot: RobotSpec) -> Iterator[tuple[str, dict[str, Any]]]:
    """Topics and their JointTrajectory messages as plain data: of the arm where it moves, of the fingers where not."""
    if segment.phase in ("open", "grip", "release", "fall"):
        if segment.phase != "fall":
            still = [0.0] * len(robot.gripper.joints)
            width = linkage(robot).joints(segment.opening).tolist()
            point = _point(width, still, float(segment.times[-1]))
            yield GRIPPER_TOPIC, {"joint_names": [*robot.gripper.joints], "points": [point]}
        return
    points = [
        _point(q.tolist(), v.tolist(), float(time))
        for time, q, v in zip(segment.times, segment.positions, segment.velocities, strict=True)
    ]
    yield ARM_TOPIC, {"joint_names": [*robot.joints], "points": points}


def _point(positions: list[float], velocities: list[float], time: float) -> dict[str, Any]:
    nanoseconds = round(time * 1e9)
    since = {"sec": nanoseconds // 10**9, "nanosec": nanoseconds % 10**9}
    return {"positions": positions, "velocities": velocities, "time_from_start": since}


def _document(segment: Segment, robot: RobotSpec) -> dict[str, Any]:
    told: dict[str, Any] = {"action": segment.action, "phase": segment.phase, "start": segment.start}
    for topic, message in _messages(segment, robot):
        told |= {"topic": topic, "type": "trajectory_msgs/msg/JointTrajectory", "message": message}
    return told


def _write_bag(made: tuple[Segment, ...], robot: RobotSpec, path: Path) -> None:
    try:
        from rosbags.rosbag2 import Writer
        from rosbags.typesys import Stores, get_typestore
    except ModuleNotFoundError:
        raise TampError(f"rosbag2 needs an extra: {how_to_install('ros')}; csv and ros2 do not") from None
    if path.exists():
        raise TampError(f"{path}: a bag is a new folder; this is there already")
    types = get_typestore(Stores.ROS2_HUMBLE)
    trajectory = "trajectory_msgs/msg/JointTrajectory"
    with Writer(path, version=8) as bag:
        topics = {t: bag.add_connection(t, trajectory, typestore=types) for t in (ARM_TOPIC, GRIPPER_TOPIC)}
        for segment in made:
            stamp = round(segment.start * 1e9)
            for topic, message in _messages(segment, robot):
                data = types.serialize_cdr(_ros(types.types, message, stamp), trajectory)
                bag.write(topics[topic], stamp, data)


def _ros(types: Any, message: dict[str, Any], stamp: int) -> Any:
    """A JointTrajectory of plain data as rosbags writes it, its header stamped in nanoseconds."""
    time = types["builtin_interfaces/msg/Time"](stamp // 10**9, stamp % 10**9)
    none = np.array([], dtype=np.float64)
    points = [
        types["trajectory_msgs/msg/JointTrajectoryPoint"](
            positions=np.array(point["positions"]),
            velocities=np.array(point["velocities"]),
            accelerations=none,
            effort=none,
            time_from_start=types["builtin_interfaces/msg/Duration"](**point["time_from_start"]),
        )
        for point in message["points"]
    ]
    header = types["std_msgs/msg/Header"](stamp=time, frame_id="")
    return types["trajectory_msgs/msg/JointTrajectory"](
        header=header, joint_names=message["joint_names"], points=points
    )
