"""OCRTOC's Python interfaces of 2021: what they answer, and a whole run of a solution server."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from tamp.contest.adapters.messages import Point, Quaternion
from tamp.contest.adapters.ocrtoc2021 import (
    ROBOT,
    CameraInfo,
    CameraInterface,
    GripperInterface,
    Image,
    JointSpaceGoalRequest,
    PointCloud2,
    Pose,
    PoseGoalRequest,
    ServiceProxy,
    Solution2021,
    TransformInterface,
    sleep,
)
from tamp.contest.api.client import Refused
from tests.contest.adapters.robots import FakeRobot, goal_of, run_tiny

SERVER = '''
import numpy as np
from tamp.contest.adapters.ocrtoc2021 import *


class SolutionServer:
    """Looks where the box is by the points of the fixed camera, and carries it to its goal from above."""

    def __init__(self, name):
        self.camera, self.tf, self.gripper = CameraInterface(), TransformInterface(), GripperInterface()
        self.camera.subscribe_topic("/kinect/depth/points", PointCloud2)

    def execute_callback(self, goal):
        print(goal.scene_id, goal.frame_id, goal.object_list)
        points = self.camera.get_numpy_points("/kinect/depth/points")[:, :3]
        T = self.tf.lookup_numpy_transform("world", "rgb_camera_link")
        points = points @ T[:3, :3].T + T[:3, 3]
        box = points[(np.abs(points[:, :2]) < 0.3).all(axis=1) & (points[:, 2] > 0.02) & (points[:, 2] < 0.1)]
        low, high = np.percentile(box, [2, 98], axis=0)
        start, end = (low + high) / 2, goal.pose_list[0].poses[0].position
        self.gripper.open()
        self.go(start[0], start[1], 0.2), self.go(start[0], start[1], 0.03)
        self.gripper.close()
        self.go(start[0], start[1], 0.2), self.go(end.x, end.y, 0.2), self.go(end.x, end.y, 0.032)
        self.gripper.open()
        self.go(end.x, end.y, 0.2)

    def go(self, x, y, z):
        tool = np.diag([1.0, -1.0, -1.0, 1.0])
        tool[:3, 3] = x, y, z
        link8 = tool @ self.tf.lookup_numpy_transform("tool", "panda_link8")
        request = PoseGoalRequest(self.tf.matrix4x4_to_ros_pose(link8))
        response = ServiceProxy("/send_pose_goal")(request)
        assert response.successed, response.text


Solution = Solution2021.of(SolutionServer)
'''


def test_a_solution_server_sees_a_box_and_carries_it_to_its_goal(tmp_path: Path) -> None:
    run, log = run_tiny(tmp_path, "server.py", SERVER)
    assert run["ede_m"] < 0.03 and run["grasps_succeeded"] == 1, (run, log)
    assert "tiny world ['red']" in log


@pytest.fixture
def robot() -> Iterator[FakeRobot]:
    made = FakeRobot()
    before = ROBOT.set(made.typed)
    yield made
    ROBOT.reset(before)


def test_cameras_answer_by_topic(robot: FakeRobot) -> None:
    camera = CameraInterface()
    assert camera.subscribe_topic("/kinect/color/image_raw", Image)
    assert camera.subscribe_topic("/realsense/aligned_depth_to_color/image_raw", Image)
    assert camera.subscribe_topic("/kinect/color/camera_info", CameraInfo)
    assert camera.subscribe_topic("/kinect/depth/points", PointCloud2)
    for topic, kind in (("/kinect/color/image_raw", Image), ("/kinect/sound", Image), ("/eye/depth/points", Image)):
        assert not camera.subscribe_topic(topic, kind)
    assert not camera.subscribe_topic("/kinect/color/image_rect_color", CameraInfo)
    color, encoding = camera.get_numpy_image_with_encoding("/kinect/color/image_raw")
    assert (color.shape, encoding) == ((4, 6, 3), "rgb8")
    depth, encoding = camera.get_numpy_image_with_encoding("/realsense/aligned_depth_to_color/image_raw")
    assert (depth.shape, encoding, depth[1, 2]) == ((4, 6), "32FC1", 2.0)
    info = camera.get_dict_camera_info("/kinect/color/camera_info")
    assert (info["frame_id"], info["image_width"], info["K"][2]) == ("rgb_camera_link", 6, 3.0)
    points = camera.get_numpy_points("/kinect/depth/points")
    assert points.tolist() == [pytest.approx([-0.1, -0.1, 2.0, 7, 7, 7])]
    with pytest.raises(ValueError, match="is not subscribed as PointCloud2"):
        camera.get_numpy_points("/realsense/depth/points")


def test_the_manipulator_answers_as_services(robot: FakeRobot, monkeypatch: pytest.MonkeyPatch) -> None:
    goal = Pose(Point(0.1, 0.2, 0.3), Quaternion(1.0, 0.0, 0.0, 0.0))
    assert ServiceProxy("/send_pose_goal")(PoseGoalRequest(goal)).successed
    assert robot.told[-1][0] == "pose" and np.allclose(robot.told[-1][1][:3, 3], (0.1, 0.2, 0.2))
    assert ServiceProxy("send_joint_space_goal")(JointSpaceGoalRequest([0.5] * 7)).successed
    assert robot.told[-1] == ("joints", [0.5] * 7)
    state = ServiceProxy("/get_manipulator_state")()
    assert state.joint_position_list == [0.0] * 7 and state.current_pose.pose.orientation.w == 1.0
    assert ServiceProxy("/get_manipulator_info")().end_effector_link == "panda_link8"
    with pytest.raises(ValueError, match="there is no service"):
        ServiceProxy("/move_group")

    def refuse(*_: object, **__: object) -> None:
        raise Refused("out of reach")

    monkeypatch.setattr(robot.arm, "move_joints", refuse)
    answer = ServiceProxy("/send_joint_space_goal")(JointSpaceGoalRequest([9.0] * 7))
    assert (answer.successed, answer.text) == (False, "out of reach")


def test_the_gripper_takes_its_time_and_frames_that_are_not_there_are_none(robot: FakeRobot) -> None:
    GripperInterface().open()
    assert robot.told == [("gripper", 0.078, 30.0), ("wait", 1.5)]
    GripperInterface().go_to_position(9.0, max_effort=5, wait_time=0.1)
    assert robot.told[2:] == [("gripper", 0.08, 5.0)]
    sleep(130)
    assert [told[1] for told in robot.told[3:]] == [60, 60, 10]
    transforms = TransformInterface()
    assert transforms.lookup_numpy_transform("world", "panda_ee_link") is None
    assert transforms.lookup_numpy_transform("world", "rgb_camera_link") is not None


def test_the_server_is_given_what_has_a_pose(tmp_path: Path) -> None:
    seen = []

    class Server:
        def __init__(self, name: str) -> None:
            self.name = name

        def execute_callback(self, goal: object) -> None:
            seen.append((self.name, goal, ROBOT.get()))

    robot = FakeRobot()
    pose = np.eye(4)
    pose[0, 3] = 0.25
    for wanted in (pose, None):
        Solution2021.of(Server)().run(goal_of(wanted, tmp_path), robot.typed)
    (name, goal, given), (_, empty, _) = seen
    assert name == "solution_server" and given is robot and goal.object_list == ["a b"]
    assert goal.pose_list[0].poses[0].position.x == 0.25 and empty.object_list == empty.pose_list == []
    with pytest.raises(LookupError):
        ROBOT.get()
