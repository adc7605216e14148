"""OCRTOC's Python interfaces of 2020 and 2021 over this contest's robot: solutions change their import lines.

    from tamp.contest.adapters.ocrtoc2021 import CameraInterface, GripperInterface, TransformInterface, ...

    class SolutionServer:
        def __init__(self, name): ...
        def execute_callback(self, goal): ...  # goal.object_list, goal.pose_list

    Solution = Solution2021.of(SolutionServer)

What is bridged, and what is not, stands in docs/guides/ocrtoc_solutions.md.
"""

from __future__ import annotations

from collections.abc import Callable
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any

import numpy as np

from tamp.contest.adapters.messages import (
    CameraInfo,
    GoalResponse,
    Image,
    JointSpaceGoalRequest,
    ManipulatorInfoRequest,
    ManipulatorInfoResponse,
    ManipulatorStateRequest,
    ManipulatorStateResponse,
    OrganizationGoal,
    PointCloud2,
    Pose,
    PoseArray,
    PoseGoalRequest,
    PoseStamped,
    matrix_of,
    pose_of,
)
from tamp.contest.api.client import Refused

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.contest.api.client import Frame, Goal, Robot

    Matrix = NDArray[np.float64]

__all__ = [
    "CameraInfo",
    "CameraInterface",
    "GripperInterface",
    "Image",
    "JointSpaceGoalRequest",
    "ManipulatorInfoRequest",
    "ManipulatorInterface",
    "ManipulatorStateRequest",
    "OrganizationGoal",
    "PointCloud2",
    "Pose",
    "PoseArray",
    "PoseGoalRequest",
    "PoseStamped",
    "ServiceProxy",
    "Solution2021",
    "TransformInterface",
    "sleep",
]

ROBOT: ContextVar[Robot] = ContextVar("robot")
"""The robot of the run. ROS's interfaces are made without being given one: they find their nodes by name."""

END_EFFECTOR = "panda_link8"
"""The link whose pose goals and states are of, as MoveIt's group `panda_arm` has it."""

FRAMES = {"rgb_camera_link": "kinect", "realsense_color_optical_frame": "realsense"}
"""Optical frames of 2021 -> cameras here."""

CLOUD, INFO, COLOR, DEPTH = "points", "camera_info", "color", "depth"
TOPICS = {
    "color/image_raw": COLOR,
    "color/image_rect_color": COLOR,
    "depth_to_color/image_raw": DEPTH,
    "aligned_depth_to_color/image_raw": DEPTH,
    "color/camera_info": INFO,
    "depth/points": CLOUD,
}
"""What follows a camera's name in a topic -> what is there."""

TYPES = {COLOR: Image, DEPTH: Image, INFO: CameraInfo, CLOUD: PointCloud2}
SPEED = 0.5
WIDEST = 0.078
LONGEST_WAIT_S = 60.0


def sleep(seconds: float) -> None:
    """rospy.sleep: let simulated time pass [s]."""
    left = float(seconds)
    while left > 0:
        ROBOT.get().wait(min(left, LONGEST_WAIT_S))
        left -= LONGEST_WAIT_S


class CameraInterface:
    """Pictures by topic: `/kinect/color/image_raw` and so on; each call takes a new one."""

    def __init__(self) -> None:
        self.subscribe_topic_dict: dict[str, type] = {}

    def subscribe_topic(self, topic_name: str, topic_type: type) -> bool:
        """Whether there is such a topic of this type, and it is subscribed now."""
        try:
            _, what = _parsed(topic_name)
        except ValueError as error:
            print(error)
            return False
        if topic_name in self.subscribe_topic_dict or topic_type is not TYPES[what]:
            print(f"{topic_name}: is subscribed already, or is of type {TYPES[what].__name__}")
            return False
        self.subscribe_topic_dict[topic_name] = topic_type
        return True

    def get_numpy_image_with_encoding(self, topic_name: str) -> tuple[NDArray[Any], str]:
        """Colour (h, w, 3) and "rgb8", or depth (h, w) [m] and "32FC1"."""
        camera, what = self._subscribed(topic_name, Image)
        frame = ROBOT.get().camera.frame(camera)
        return (frame.color, "rgb8") if what == COLOR else (frame.depth, "32FC1")

    def get_dict_camera_info(self, topic_name: str) -> dict[str, Any]:
        """frame_id, image_height, image_width, D (none), K (9 numbers, row by row)."""
        camera, _ = self._subscribed(topic_name, CameraInfo)
        frame = ROBOT.get().camera.frame(camera)
        names = {ours: theirs for theirs, ours in FRAMES.items()}
        height, width = frame.depth.shape
        return {
            "frame_id": names.get(camera, camera),
            "image_height": height,
            "image_width": width,
            "D": [0.0] * 5,
            "K": [float(value) for value in frame.K.ravel()],
        }

    def get_numpy_points(self, topic_name: str) -> Matrix:
        """What was measured in the camera's optical frame: x, y, z [m], r, g, b of each pixel with a depth, (n, 6)."""
        camera, _ = self._subscribed(topic_name, PointCloud2)
        return _cloud(ROBOT.get().camera.frame(camera))

    def _subscribed(self, topic_name: str, topic_type: type) -> tuple[str, str]:
        if self.subscribe_topic_dict.get(topic_name) is not topic_type:
            raise ValueError(f"{topic_name}: is not subscribed as {topic_type.__name__}")
        return _parsed(topic_name)


def _parsed(topic: str) -> tuple[str, str]:
    """The camera of a topic, and what of it is there."""
    camera, _, rest = topic.strip("/").partition("/")
    names = ROBOT.get().camera.names
    if camera not in names or rest not in TOPICS:
        raise ValueError(f"{topic}: no such topic; there are /{'|'.join(names)}/ with {', '.join(TOPICS)}")
    return camera, TOPICS[rest]


def _cloud(frame: Frame) -> Matrix:
    v, u = np.nonzero(frame.depth > 0)
    rays = np.linalg.solve(frame.K, np.array([u + 0.5, v + 0.5, np.ones(len(u))]))
    return np.hstack([(rays * frame.depth[v, u]).T, frame.color[v, u].astype(np.float64)])


class TransformInterface:
    """Transforms between `world`, links of the robot, and the cameras' optical frames."""

    def lookup_numpy_transform(self, parent_frame: str, child_frame: str, timeout: float = 1.0) -> Matrix | None:
        """`T_parent_child`, (4, 4); None where there is no such frame."""
        try:
            return ROBOT.get().tf(FRAMES.get(parent_frame, parent_frame), FRAMES.get(child_frame, child_frame))
        except Refused as refused:
            print(refused)
            return None

    def ros_pose_to_matrix4x4(self, pose: Pose) -> Matrix:
        """The matrix of a pose."""
        return matrix_of(pose)

    def matrix4x4_to_ros_pose(self, matrix: Matrix) -> Pose:
        """The pose of a matrix."""
        return pose_of(matrix)


class ManipulatorInterface:
    """The arm, as the services of 2021's node answer; no motion is checked for collisions."""

    def __init__(self, group_name: str = "panda_arm") -> None:
        self.group_names, self.end_effector_link, self.planning_frame = [group_name], END_EFFECTOR, "world"

    def get_manipulator_info_handler(self, request: ManipulatorInfoRequest) -> ManipulatorInfoResponse:
        """Names of the group, the end effector's link and the frame of poses."""
        return ManipulatorInfoResponse(self.group_names, self.end_effector_link, self.planning_frame)

    def get_manipulator_state_handler(self, request: ManipulatorStateRequest) -> ManipulatorStateResponse:
        """Where the arm is."""
        robot = ROBOT.get()
        pose = PoseStamped(pose_of(robot.tf(self.planning_frame, self.end_effector_link)))
        return ManipulatorStateResponse(pose, [float(value) for value in robot.arm.state().q])

    def send_joint_space_goal_handler(self, request: JointSpaceGoalRequest) -> GoalResponse:
        """Move to joint positions."""
        return self._done(lambda robot: robot.arm.move_joints(request.joint_goal, speed=SPEED))

    def send_pose_goal_handler(self, request: PoseGoalRequest) -> GoalResponse:
        """Move the end effector's link to a pose, however the joints go."""

        def move(robot: Robot) -> None:
            T_world_tool = matrix_of(request.goal) @ robot.tf(self.end_effector_link, "tool")
            robot.arm.move_pose(T_world_tool, speed=SPEED, straight=False)

        return self._done(move)

    def _done(self, move: Callable[[Robot], None]) -> GoalResponse:
        try:
            move(ROBOT.get())
        except Refused as refused:
            return GoalResponse(False, str(refused))
        return GoalResponse(True, "Done.")


class ServiceProxy:
    """rospy.ServiceProxy for the manipulator's four services; its type need not be given."""

    def __init__(self, name: str, service_type: object = None) -> None:
        manipulator = ManipulatorInterface()
        services: dict[str, Callable[[Any], Any]] = {
            "get_manipulator_info": manipulator.get_manipulator_info_handler,
            "get_manipulator_state": manipulator.get_manipulator_state_handler,
            "send_joint_space_goal": manipulator.send_joint_space_goal_handler,
            "send_pose_goal": manipulator.send_pose_goal_handler,
        }
        if name.strip("/") not in services:
            raise ValueError(f"there is no service {name!r}; valid are {', '.join(services)}")
        self._serve = services[name.strip("/")]

    def __call__(self, request: Any = None) -> Any:
        """Ask."""
        return self._serve(request)


class GripperInterface:
    """The gripper; a command takes its waiting time, or longer where the fingers need it."""

    def __init__(self, topic_name: str = "/franka_gripper/gripper_action") -> None:
        self.topic_name = topic_name

    def go_to_position(self, position: float, max_effort: float = 30, wait_time: float = 2.0) -> None:
        """Bring the fingers to a distance from each other [m], with a force [N]."""
        robot = ROBOT.get()
        before = robot.time_left
        robot.gripper.go_to(min(max(float(position), 0.0), robot.gripper.stroke), effort=float(max_effort))
        sleep(wait_time - (before - robot.time_left))

    def close(self) -> None:
        """Close."""
        self.go_to_position(0.0)

    def open(self) -> None:
        """Open."""
        self.go_to_position(WIDEST)


class Solution2021:
    """Runs a solution server; `Solution2021.of(SolutionServer)` is the class of such a solution."""

    server: Callable[[str], Any]

    @classmethod
    def of(cls, server: Callable[[str], Any]) -> type[Solution2021]:
        """A solution.

        Args:
            server: a class that is made with a name and has `execute_callback(goal)`.
        """
        return type("Solution", (cls,), {"server": staticmethod(server)})

    def run(self, goal: Goal, robot: Robot) -> None:
        """Give the server the task as the solution action does: what has a goal pose, by name, and its pose."""
        poses = {name: thing.pose for name, thing in goal.objects.items() if thing.pose is not None}
        asked = OrganizationGoal(
            scene_id=goal.task,
            object_list=list(poses),
            pose_list=[PoseArray([pose_of(pose)]) for pose in poses.values()],
        )
        before = ROBOT.set(robot)
        try:
            self.server("solution_server").execute_callback(asked)
        finally:
            ROBOT.reset(before)
