"""Fingers that swing: planner, hand and checker have the pads where a reckoning by hand has them."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tamp.checking.robot.kinematics import read_kinematics
from tamp.errors import RobotError
from tamp.execution.robot.gripper_drive import gripper_drive
from tamp.streams.hand.hand_boxes import hand_boxes
from tamp.task import RobotSpec, load_robot
from tamp.task.files.robot.robot_file import read_robot
from tamp.world.collision.motion_bound import travel
from tamp.world.robot.hand import _way, hand_points, hand_poses
from tamp.world.robot.linkage import linkage, pad_rates
from tamp.world.robot.model import RobotModel, robot_model
from tests.task.swinging import LEAN, RADIUS, ROBOT, depth, opening, write

ANGLES = st.floats(0.1, 0.49)  # within the stroke


@pytest.fixture(scope="module")
def spec(tmp_path_factory: pytest.TempPathFactory) -> RobotSpec:
    return read_robot(write(tmp_path_factory.mktemp("robots") / "swinging"))


@pytest.fixture(scope="module")
def swinging(spec: RobotSpec) -> RobotModel:
    return robot_model(spec)


@given(ANGLES)
def test_driver_depth_and_opening_belong_together(spec: RobotSpec, angle: float) -> None:
    link = linkage(spec)
    assert link.driver(opening(angle)) == pytest.approx(angle, abs=1e-5)
    assert link.opening(angle) == pytest.approx(opening(angle), abs=1e-6)
    assert float(link.depth(opening(angle))) == pytest.approx(depth(angle), abs=1e-6)
    assert link.joints(opening(angle)) == pytest.approx([angle, -angle, angle, -angle], abs=1e-5)


@given(ANGLES)
def test_the_checker_has_the_pads_in_the_same_place_by_its_own_means(spec: RobotSpec, angle: float) -> None:
    tree, wide = read_kinematics(spec), opening(angle)
    assert tree.pad_depth(wide) == pytest.approx(depth(angle), abs=1e-6)
    placed = tree.forward(np.array([spec.home]), wide)
    tips = [placed[name][0, :3, 3] for name in spec.gripper.fingers]
    assert np.linalg.norm(tips[1] - tips[0]) == pytest.approx(wide, abs=1e-6)


@given(ANGLES)
def test_bodies_of_the_hand_are_where_kinematics_have_them(swinging: RobotModel, angle: float) -> None:
    way, wide = _way(swinging), opening(angle)
    for k, T in enumerate(reversed(hand_poses(swinging, wide))):
        at_once, alone = way.all_at(wide), way.at(np.array([wide]), k)
        for R, p in ((at_once[0][k], at_once[1][k]), (alone[0][0], alone[1][0])):
            assert np.allclose(R, T[:3, :3], atol=1e-5)
            assert np.allclose(p, T[:3, 3], atol=1e-6)


@given(ANGLES)
def test_boxes_of_the_hand_hold_its_points(swinging: RobotModel, angle: float) -> None:
    lower, upper = hand_boxes(swinging).opened(np.array([opening(angle)]))
    points = np.concatenate(hand_points(swinging, opening(angle)))
    within = ((points[:, None] > lower - 2e-4) & (points[:, None] < upper + 2e-4)).all(axis=2)
    assert within.any(axis=1).all()


def test_the_whole_hand_is_known_by_what_carries_it(swinging: RobotModel) -> None:
    assert [swinging.bodies[i].name for i in swinging.hand] == ["boom", "h_palm", "h_left_tip", "h_right_tip"]


def test_no_point_of_the_hand_moves_farther_than_is_said(swinging: RobotModel) -> None:
    q = np.array([[0.0, 0.3], [0.02, 0.31]])
    farthest = 0.0
    for wide in np.linspace(0.0, swinging.spec.gripper.stroke, 5):
        poses = swinging.joint_poses(q, float(wide))
        for body in swinging.bodies:
            ends = [body.hull.vertices @ T[body.joint, :3, :3].T + T[body.joint, :3, 3] for T in poses]
            farthest = max(farthest, float(np.linalg.norm(ends[1] - ends[0], axis=1).max()))
    assert farthest <= travel(swinging, q, 0.0)[0]


@given(ANGLES, st.floats(1.0, 50.0))
def test_motors_do_the_work_of_the_fingers(spec: RobotSpec, angle: float, force: float) -> None:
    drive = gripper_drive(spec)
    torques, wide = drive.forces(force, opening(angle)), opening(angle)
    rates = drive.velocities(0.01, wide)
    assert float(torques @ rates) == pytest.approx(2 * force * 0.01, rel=1e-6)
    assert drive.speed(drive.joints(wide), rates) == pytest.approx(0.01, rel=1e-6)
    assert drive.opening(drive.joints(wide)) == pytest.approx(wide, abs=1e-6)


@given(ANGLES)
def test_what_is_held_is_borne_by_each_joint_as_the_pads_part_with_it_alone(spec: RobotSpec, angle: float) -> None:
    drive, wide, parting = gripper_drive(spec), opening(angle), -RADIUS * math.cos(LEAN - angle)
    assert float(drive.balance(7.0, wide) @ drive.velocities(0.01, wide)) == pytest.approx(2 * 7.0 * 0.01, rel=1e-3)
    assert pad_rates(spec, np.array([angle]))[0] == pytest.approx([parting, 0.0, parting, 0.0], abs=1e-6)


def test_fingers_that_slide_move_by_half_of_the_opening() -> None:
    spec = load_robot("panda")
    link, drive = linkage(spec), gripper_drive(spec)
    assert link.joints(0.05).tolist() == [0.025, 0.025] and link.opening(0.025) == 0.05
    assert float(link.depth(0.05)) == 0.0 and len(link.grid) == 2
    assert drive.scale == pytest.approx(1.0) and drive.forces(20.0, 0.04) == pytest.approx([20.0, 20.0])
    assert drive.balance(20.0, 0.04) == pytest.approx([20.0, 20.0])


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("stroke: 0.04", "stroke: 0.08", "the pads part by 0.04.* m at most, less than the stroke of 0.08 m"),
        ("limits: [0.0, 0.5]", "limits: [0.0, 0.2]", "the pads come no nearer than 0.0.* m to each other"),
        ("limits: [0.0, 0.5]", "limits: [-2.0, 0.5]", "the pads turn back between the gripper's limits"),
    ],
)
def test_pads_that_do_not_do_what_is_said_are_refused(tmp_path, old: str, new: str, complaint: str) -> None:
    spec = read_robot(write(tmp_path / "swinging", ROBOT.replace(old, new, 1)))
    with pytest.raises(RobotError, match=complaint):
        linkage(spec)


def test_a_stroke_beyond_the_joints_is_refused() -> None:
    spec = load_robot("panda")
    wide = dataclasses.replace(spec, gripper=dataclasses.replace(spec.gripper, stroke=0.1))
    with pytest.raises(RobotError, match=r"a stroke of 0.1 m needs joints that slide from 0 to half of it"):
        linkage(wide)


def test_fingers_that_turn_as_in_pliers_are_refused(tmp_path) -> None:
    path = write(tmp_path / "pliers")
    hand = tmp_path / "pliers" / "urdf" / "hand.urdf"
    hand.write_text(hand.read_text().replace('multiplier="-1"', 'multiplier="-0.5"'))
    with pytest.raises(RobotError, match=r"the fingers turn by .* rad on the way from closed to open"):
        linkage(read_robot(path))


def test_pads_that_stop_just_short_of_closing_have_a_rate_there_too(tmp_path) -> None:
    spec = read_robot(write(tmp_path / "short", ROBOT.replace("limits: [0.0, 0.5]", "limits: [0.0, 0.49]", 1)))
    link = linkage(spec)
    assert 0.0004 < link.openings[0] < 0.002
    assert link.per_driver(0.0) == pytest.approx(link.per_driver(float(link.openings[0])))
    assert gripper_drive(spec).velocities(0.1, 0.0).shape == (4,)


def sliding(folder: Path, right: str) -> Path:
    """The robot with fingers that slide along one axis and mimic nothing, the right one in a range of its own."""
    robot = ROBOT.replace("[h_left_swing]", "[h_left, h_right]").replace("limits: [0.0, 0.5]", "limits: [0.0, 0.03]")
    path = write(folder, robot.replace("[[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]", "[[0.0, -0.002, 0.0], [0.0, 0.002, 0.0]]"))
    palm, box = '<link name="palm"/>', '<collision><geometry><box size="0.01 0.004 0.02"/></geometry></collision>'
    for side, y, ends in (("left", 0.002, 'lower="0" upper="0.03"'), ("right", -0.002, right)):
        palm += f"""<link name="{side}_tip">{box}</link><joint name="{side}" type="prismatic"><parent link="palm"/>
            <child link="{side}_tip"/><axis xyz="0 1 0"/><origin xyz="0 {y} 0.08"/>
            <limit {ends} effort="9" velocity="1"/></joint>"""
    (folder / "urdf" / "hand.urdf").write_text(f'<robot name="hand">{palm}</robot>')
    return path


def test_a_finger_whose_range_is_the_other_s_the_other_way_round_goes_the_other_way(tmp_path) -> None:
    spec = read_robot(sliding(tmp_path / "mirrored", 'lower="-0.03" upper="0"'))
    assert spec.gripper.multipliers == (1.0, -1.0)
    assert linkage(spec).opening(0.01) == pytest.approx(0.02)
    assert gripper_drive(spec).sliding


def test_fingers_that_move_the_same_way_are_refused(tmp_path) -> None:
    spec = read_robot(sliding(tmp_path / "same", 'lower="0" upper="0.03"'))
    with pytest.raises(RobotError, match="the pads do not part as h_left moves; fingers that move the same way"):
        linkage(spec)
