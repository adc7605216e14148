"""Arms that cannot move and turn their tool every way."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tamp.task import Pose
from tamp.task.files.robot.robot_file import read_robot
from tamp.world.kinematics.freedom import confined
from tamp.world.kinematics.inverse import inverse, straight_line
from tamp.world.robot.model import RobotModel, robot_model
from tests.streams.tables import panda
from tests.task.scara import ARM, JOINT, ROBOT, write


@pytest.fixture(scope="module")
def scara(tmp_path_factory: pytest.TempPathFactory) -> RobotModel:
    return robot_model(read_robot(write(tmp_path_factory.mktemp("scara"))))


def found(robot: RobotModel, T: np.ndarray) -> np.ndarray | None:
    return next(iter(inverse(robot, T, np.random.default_rng(0), count=1)), None)


def down(tilt: float) -> np.ndarray:
    """A tool above the table, so far off straight down [rad]; shape (4, 4)."""
    return Pose.from_rpy((0.1, 0.15, 0.05), (np.pi - tilt, 0.0, 0.4)).matrix


def test_seven_joints_leave_the_tool_free_and_four_do_not(scara: RobotModel) -> None:
    assert not confined(panda())
    assert confined(scara)


def test_joints_are_not_counted_for_what_they_cannot_do(tmp_path: Path) -> None:
    """With three joints in line at the wrist there are six, and the hand hangs straight down as before."""
    spare = "".join(
        f'<link name="{link}"/>' + JOINT.format(name, "revolute", link, child, "0 0 0", 0, "0 0 1", -2.9, 2.9, "")
        for name, link, child in (("again", "first", "second"), ("once_more", "second", "palm"))
    )
    arm = ARM.replace('<parent link="quill"/><child link="palm"/>', '<parent link="quill"/><child link="first"/>')
    robot = ROBOT.replace("wrist]", "wrist, again, once_more]").replace("0.8, 0.0, 0.0]", "0.8, 0.0, 0.0, 0.0, 0.0]")
    spec = read_robot(write(tmp_path, robot, arm.replace("</robot>", f"{spare}</robot>")))
    assert len(spec.joints) == 6 and confined(robot_model(spec))


@pytest.mark.parametrize("tilt", [0.0, 2e-4, 1e-3])
def test_a_confined_arm_gets_as_near_as_it_can_to_what_stands_a_hair_off_upright(
    scara: RobotModel, tilt: float
) -> None:
    q = found(scara, down(tilt))
    assert q is not None
    T = scara.forward(q)
    assert np.linalg.norm(T[:3, 3] - down(tilt)[:3, 3]) < 2e-4
    assert np.arccos(-T[2, 2]) < 1e-6
    assert straight_line(scara, q, Pose((0.0, 0.0, 0.1)).matrix @ T) is not None


def test_but_not_to_a_pose_that_leans(scara: RobotModel) -> None:
    assert found(scara, down(0.01)) is None


def test_an_arm_that_is_free_follows_exactly() -> None:
    q = found(panda(), down(1e-3))
    assert q is not None and np.abs(panda().forward(q) - down(1e-3)).max() < 2e-5
