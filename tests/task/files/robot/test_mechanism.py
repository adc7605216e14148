"""robot.yaml against its URDF: an arm that is a chain, a hand at its end with two fingers that the gripper moves."""

from __future__ import annotations

from pathlib import Path

import pytest

from tamp.errors import RobotError
from tamp.task.files.robot.robot_file import read_robot
from tests.task.swinging import ARM, ROBOT, write

FIXED = ARM.replace('name="bend" type="revolute"', 'name="bend" type="fixed"')
COUPLED = ARM.replace('<limit lower="0.5"', '<mimic joint="bend"/><limit lower="0.5"')


@pytest.mark.parametrize(
    ("old", "new", "arm", "complaint"),
    [
        ("", "", FIXED, r"arm\.joints\[1\]: bend is fixed in the URDF; only revolute, continuous and prismatic joints"),
        ("[turn, bend]", "[bend, turn]", ARM, r"arm\.joints: the order from the base outwards is turn, bend"),
        ("[turn, bend]", "[turn, turn]", ARM, r"arm\.joints\[1\]: turn is named twice"),
        ("[turn, bend]", "[turn, wave]", ARM, r"wave is not on the way from the base to tool\.parent, boom"),
        ("parent: boom, xyz: [0.0, 0.0, 0.28]", "parent: h_left_tip, xyz: [0.0, 0.0, 0.28]", ARM,
         r"tool\.parent: h_left_tip moves with the gripper's h_left_swing"),
        ("[h_left_tip, h_right_tip]", "[h_left_tip, h_left_tip]", ARM, "h_left_tip is named twice"),
        ("[h_left_tip, h_right_tip]", "[h_left_tip, flag]", ARM, r"flag is not carried by the arm's last joint"),
        ("[h_left_tip, h_right_tip]", "[h_left_tip, h_palm]", ARM, "h_palm is moved by none of the gripper's joints"),
        ("[h_left_swing]", "[h_left_swing, bend]", ARM, r"gripper\.joints: bend is one of arm\.joints"),
        ("[h_left_swing]", "[wave, h_left_level]", ARM, r"h_left_level mimics h_left_swing in the URDF, not wave"),
        ("parent: boom, xyz: [0.0, 0.0, 0.28]", "parent: bom, xyz: [0.0, 0.0, 0.28]", ARM,
         r"robot\.yaml:\d+: tool\.parent: there is no link 'bom'; did you mean 'boom'\? the URDF has base, boom"),
        ("[h_left_tip, h_right_tip]", "[h_left_tip, right_tip]", ARM,
         r"gripper\.fingers\[1\]: there is no link 'right_tip'; did you mean 'h_right_tip'\?"),
        ("[h_left_swing]", "[left_swing]", ARM, r"gripper\.joints\[0\]: there is no joint 'left_swing'; did you mean"),
        ("", "posture: {weave: 0.6}\n", ARM, r"posture\.weave: there is no joint 'weave'; did you mean 'wave'\?"),
        ("", "disable_collisions: [[flag, bum]]\n", ARM, r"disable_collisions\[0\]: there is no link 'bum'"),
        ("[h_left_tip, h_right_tip]", "[h_left_tip, h_right_bar]", ARM,
         r"gripper\.fingers\[1\]: h_right_bar has no <collision> in the URDF; name the links that have the pads"),
        ("", "", COUPLED, "wave mimics bend in the URDF, which is not supported; a posture holds it still"),
        ("", "posture: {wave: 7.0}\n", ARM, r"posture\.wave: 7 is outside the joint's limits of 0\.5 to 1"),
        ("", "posture: {h_attached: 0.0}\n", ARM, r"posture\.h_attached: is fixed in the URDF"),
    ],
)  # fmt: skip
def test_what_is_not_of_one_robot_is_refused_in_one_sentence(
    tmp_path: Path, old: str, new: str, arm: str, complaint: str
) -> None:
    assert old in ROBOT
    robot = ROBOT.replace(old, new, 1) if old else ROBOT + new
    with pytest.raises(RobotError, match=complaint) as error:
        read_robot(write(tmp_path / "swinging", robot, arm))
    assert "robot.yaml" in str(error.value) and "\n" not in str(error.value)


def test_a_joint_that_moves_with_the_arm_may_be_held_still(tmp_path: Path) -> None:
    spec = read_robot(write(tmp_path / "swinging", ROBOT + "posture: {wave: 0.6}\n", COUPLED))
    assert spec.still == (("wave", 0.6),)


def test_joints_that_nothing_drives_are_told(tmp_path: Path) -> None:
    assert read_robot(write(tmp_path / "swinging")).still == (("wave", 0.5),)


@pytest.mark.parametrize("fingers", ["[]", "[h_left_tip]", "[h_left_tip, h_right_tip, h_palm]"])
def test_hands_that_do_not_grip_between_two_fingers_are_refused(tmp_path: Path, fingers: str) -> None:
    robot = ROBOT.replace("[h_left_tip, h_right_tip]", fingers)
    with pytest.raises(RobotError, match=r"gripper: has .* finger.*[Ss]uction cups"):
        read_robot(write(tmp_path / "swinging", robot))


def test_a_suction_cup_is_refused_by_its_name(tmp_path: Path) -> None:
    robot = ROBOT[: ROBOT.index("gripper:")] + "gripper: {suction: true}\n"
    with pytest.raises(RobotError, match=r"has no fingers; .*Suction cups"):
        read_robot(write(tmp_path / "swinging", robot))


def test_who_leaves_out_pads_is_told_how_to_find_them(tmp_path: Path) -> None:
    robot = "".join(line for line in ROBOT.splitlines(keepends=True) if not line.startswith("  pads:"))
    with pytest.raises(RobotError, match=r"needs pads.*With \[\[0, 0, 0\], \[0, 0, 0\]\] there"):
        read_robot(write(tmp_path / "swinging", robot))


def test_links_that_may_touch_are_two_that_there_are(tmp_path: Path) -> None:
    spec = read_robot(write(tmp_path / "swinging", ROBOT + "disable_collisions: [[flag, boom], [boom, flag]]\n"))
    assert spec.disabled_collisions == (("boom", "flag"),) and spec.may_touch("flag", "boom")
    for pair, told in (("[flag, flag]", r"disable_collisions\[0\]: flag is named twice"), ("[flag, f]", "no link 'f'")):
        with pytest.raises(RobotError, match=told):
            read_robot(write(tmp_path / "wrong", ROBOT + f"disable_collisions: [{pair}]\n"))
