"""The few ROS messages that OCRTOC's Python interfaces take and give, field by field, without ROS."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Matrix = NDArray[np.float64]


@dataclass
class Point:
    """geometry_msgs/Point [m]."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0


@dataclass
class Quaternion:
    """geometry_msgs/Quaternion."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    w: float = 1.0


@dataclass
class Pose:
    """geometry_msgs/Pose."""

    position: Point = field(default_factory=Point)
    orientation: Quaternion = field(default_factory=Quaternion)


@dataclass
class PoseStamped:
    """geometry_msgs/PoseStamped, without its header: the frame is `world`."""

    pose: Pose = field(default_factory=Pose)


@dataclass
class PoseArray:
    """geometry_msgs/PoseArray: the target poses of one object."""

    poses: list[Pose] = field(default_factory=list)


@dataclass
class OrganizationGoal:
    """The goal of the solution action.

    Attributes:
        scene_id: the task's name.
        frame_id: of the poses; always "world".
        object_list: names of objects.
        pose_list: the target poses of each, one an object.
    """

    scene_id: str = ""
    frame_id: str = "world"
    object_list: list[str] = field(default_factory=list)
    pose_list: list[PoseArray] = field(default_factory=list)


@dataclass
class ManipulatorInfoRequest:
    """ocrtoc_common/ManipulatorInfo asks for nothing."""


@dataclass
class ManipulatorInfoResponse:
    """Its answer."""

    group_names: list[str]
    end_effector_link: str
    planning_frame: str


@dataclass
class ManipulatorStateRequest:
    """ocrtoc_common/ManipulatorState asks for nothing."""


@dataclass
class ManipulatorStateResponse:
    """Its answer: pose of the end effector's link in the world, joint positions [rad]."""

    current_pose: PoseStamped
    joint_position_list: list[float]


@dataclass
class JointSpaceGoalRequest:
    """ocrtoc_common/JointSpaceGoal: joint positions [rad]."""

    joint_goal: list[float] = field(default_factory=list)


@dataclass
class PoseGoalRequest:
    """ocrtoc_common/PoseGoal: pose of the end effector's link in the world."""

    goal: Pose = field(default_factory=Pose)


@dataclass
class GoalResponse:
    """The answer to both; `successed` is OCRTOC's spelling."""

    successed: bool
    text: str = ""


class Image:
    """sensor_msgs/Image, as the type of a topic."""


class CameraInfo:
    """sensor_msgs/CameraInfo, as the type of a topic."""


class PointCloud2:
    """sensor_msgs/PointCloud2, as the type of a topic."""


def matrix_of(pose: Any) -> Matrix:
    """The homogeneous transform (4, 4) of a pose message; a quaternion need not have unit length."""
    at, turn = pose.position, pose.orientation
    x, y, z, w = np.array([turn.x, turn.y, turn.z, turn.w]) / np.linalg.norm([turn.x, turn.y, turn.z, turn.w])
    T = np.eye(4)
    T[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    T[:3, 3] = at.x, at.y, at.z
    return T


def pose_of(matrix: Matrix) -> Pose:
    """The pose message of a homogeneous transform (4, 4).

    The quaternion is the eigenvector of the largest eigenvalue of a symmetric matrix (Bar-Itzhack, Journal of Guidance,
    Control, and Dynamics 23, 2000), which has no special cases.
    """
    r = matrix[:3, :3]
    k = np.array(
        [
            [r[0, 0] - r[1, 1] - r[2, 2], r[0, 1] + r[1, 0], r[0, 2] + r[2, 0], r[2, 1] - r[1, 2]],
            [r[0, 1] + r[1, 0], r[1, 1] - r[0, 0] - r[2, 2], r[1, 2] + r[2, 1], r[0, 2] - r[2, 0]],
            [r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], r[2, 2] - r[0, 0] - r[1, 1], r[1, 0] - r[0, 1]],
            [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], r[0, 0] + r[1, 1] + r[2, 2]],
        ]
    )
    quaternion = np.linalg.eigh(k)[1][:, -1]
    if quaternion[3] < 0:
        quaternion = -quaternion
    return Pose(Point(*(float(v) for v in matrix[:3, 3])), Quaternion(*(float(v) for v in quaternion)))
