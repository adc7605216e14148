"""Adding a robot means adding a folder: a small arm of six joints, of primitive shapes, does what the Panda does."""

from __future__ import annotations

import numpy as np
import pytest

from tamp.errors import RobotError
from tamp.task import Box
from tamp.task.files.robot.robot_file import read_robot
from tamp.world.collision.motion_bound import travel
from tamp.world.geometry.object_geometry import load_geometry
from tamp.world.kinematics.inverse import inverse, straight_line
from tamp.world.motion.planner import plan_motion
from tamp.world.robot.model import robot_model
from tamp.world.scene import Scene
from tamp.world.timing.time_parametrization import time_free_path
from tamp.world.world import World

# Joint axis and length of the link that follows [m].
ARM = (("0 0 1", 0.15), ("0 1 0", 0.3), ("0 1 0", 0.25), ("0 0 1", 0.1), ("0 1 0", 0.1), ("0 0 1", 0.05))

LINK = """<link name="{name}"><collision><origin xyz="0 0 {middle}"/>
  <geometry><{shape}/></geometry></collision></link>"""
JOINT = """<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><origin xyz="{xyz}"/>
  <axis xyz="{axis}"/><limit lower="{lower}" upper="{upper}" effort="10" velocity="2"/></joint>"""

ROBOT = """
urdf: arm.urdf
base: {xyz: [-0.3, 0.0, 0.0], rpy: [0.0, 0.0, 0.0], radius: 0.1}
arm:
  joints: [j0, j1, j2, j3, j4, j5]
  lower: [-3.0, -2.2, -2.6, -3.0, -2.2, -3.0]
  upper: [3.0, 2.2, 2.6, 3.0, 2.2, 3.0]
  velocity: [2, 2, 2, 3, 3, 3]
  acceleration: [8, 8, 8, 10, 10, 10]
  jerk: [4000, 4000, 4000, 5000, 5000, 5000]
  reach: [0.2, 0.5]
  home: [0.0, 0.3, 1.4, 0.0, 1.3, 0.0]
tool: {parent: link5, xyz: [0.0, 0.0, 0.1], rpy: [0.0, 0.0, 0.0]}
gripper: {joints: [left, right], fingers: [finger_left, finger_right], stroke: 0.06, force: 20.0,
  axis: [0.0, 1.0, 0.0], pad: [0.006, 0.015, 0.015]}
"""


def urdf():
    pieces = ['<robot name="small">', LINK.format(name="base", middle=0.0, shape='box size="0.1 0.1 0.02"')]
    parent, height = "base", 0.02
    for i, (axis, length) in enumerate(ARM):
        limits = {"lower": -3.1, "upper": 3.1, "xyz": f"0 0 {height}", "axis": axis}
        pieces.append(JOINT.format(name=f"j{i}", kind="revolute", parent=parent, child=f"link{i}", **limits))
        shape = f'cylinder radius="0.025" length="{length - 0.02}"'
        pieces.append(LINK.format(name=f"link{i}", middle=length / 2, shape=shape))
        parent, height = f"link{i}", length
    for side, sign in (("left", 1), ("right", -1)):
        limits = {"lower": 0, "upper": 0.03, "xyz": f"0 {0.003 * sign} 0.07", "axis": f"0 {sign} 0"}
        pieces.append(JOINT.format(name=side, kind="prismatic", parent="link5", child=f"finger_{side}", **limits))
        pieces.append(LINK.format(name=f"finger_{side}", middle=0.02, shape='box size="0.015 0.006 0.04"'))
    return "\n".join([*pieces, "</robot>"])


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    folder = tmp_path_factory.mktemp("robots") / "small"
    folder.mkdir()
    (folder / "arm.urdf").write_text(urdf())
    (folder / "robot.yaml").write_text(ROBOT)
    return robot_model(read_robot(folder / "robot.yaml"))


def test_its_folder_says_all_there_is_to_know(small):
    assert small.spec.name == "small" and small.dof == 6
    assert len(small.bodies) == 9 and len(small.hand) == 3
    stretched = small.forward(np.zeros(6))[:3, 3]
    np.testing.assert_allclose(stretched, (-0.3, 0.0, 0.02 + 0.9 + 0.1), atol=1e-9)
    assert travel(small, np.array([np.zeros(6), 0.01 * np.eye(6)[1]]), 0.0)[0] == pytest.approx(0.01, abs=0.002)


def test_it_finds_configurations_for_its_own_tool_poses(small):
    rng = np.random.default_rng(0)
    for _ in range(20):
        T = small.forward(rng.uniform(small.lower, small.upper))
        q = next(inverse(small, T, rng))
        np.testing.assert_allclose(small.forward(q), T, atol=1e-4)
        assert small.within_limits(q)


def test_it_plans_and_times_a_motion_round_a_pillar(small):
    T = np.eye(4)
    T[:3, 3] = (0.05, 0.0, 0.4)
    world = World(small, {"pillar": load_geometry(Box((0.08, 0.08, 0.8)))})
    checker = world.checker(Scene({"pillar": T}, opening=0.04), margin=0.003)
    start, goal = small.home, small.home
    start[0], goal[0] = -0.8, 0.8
    assert not checker.edge_free(start, goal)
    result = plan_motion(checker, small.lower, small.upper, start, goal, seed=0, timeout=20.0)
    assert checker.path_free(result.path, 0.01)
    timed = time_free_path(result.path, small.spec, checker).trajectory
    assert (np.abs(timed.velocities) <= np.array(small.spec.velocity) * 1.001).all()


def test_its_tool_follows_a_straight_line(small):
    T = small.forward(small.home)
    T[2, 3] += 0.05
    line = straight_line(small, small.home, T)
    np.testing.assert_allclose(small.forward(line[-1]), T, atol=1e-4)


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("home: [0.0, ", "home: [", "arm: home has 5 values for 6 joints"),
        ("urdf: arm.urdf", "", "urdf: is missing"),
        ("  jerk", "  jolt", "arm.jerk: is missing"),
        (
            "reach: [0.2, 0.5]",
            "reach: [0.5, 0.2]",
            "reach is .0.5, 0.2.; give two distances, the smaller",
        ),
        ("reach: [0.2, 0.5]", "reach: 0.5", "arm.reach: 0.5 is not valid; it must be a list"),
        (", radius: 0.1", "", "base.radius: is missing"),
        ("stroke: 0.06", "stroke: wide", "'wide'"),
        ("arm:", "arm: [", "not YAML"),
    ],
)
def test_a_robot_that_lacks_something_is_refused_in_one_sentence(tmp_path, old, new, complaint):
    path = tmp_path / "robot.yaml"
    path.write_text(ROBOT.replace(old, new, 1))
    with pytest.raises(RobotError, match=complaint) as error:
        read_robot(path)
    assert str(path) in str(error.value) and "\n" not in str(error.value)


def test_a_missing_robot_file_is_named(tmp_path):
    with pytest.raises(RobotError, match=r"robot\.yaml"):
        read_robot(tmp_path / "robot.yaml")
