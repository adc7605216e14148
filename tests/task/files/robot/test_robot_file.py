"""robot.yaml and the URDFs that it names: what is taken as it comes, and what is refused in which sentence."""

from __future__ import annotations

import math
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from tamp.checking.robot.links import read_links
from tamp.errors import RobotError
from tamp.task import RobotSpec
from tamp.task.files.robot.robot_file import read_robot
from tamp.world.robot.urdf import link_shapes
from tests.task.mesh.test_collada import write as write_dae
from tests.task.swinging import ARM, ROBOT, write


@pytest.fixture
def spec(tmp_path: Path) -> RobotSpec:
    return read_robot(write(tmp_path / "swinging"))


def test_joints_that_mimic_are_found_through_others(spec: RobotSpec) -> None:
    grip = spec.gripper
    assert dict(zip(grip.joints, grip.multipliers, strict=True)) == {
        "h_left_swing": 1.0, "h_left_level": -1.0, "h_right_swing": 1.0, "h_right_level": -1.0,
    }  # fmt: skip
    assert grip.offsets == (0.0,) * 4 and grip.limits == (0.0, 0.5)
    assert grip.depths == pytest.approx((0.018, 0.012, 0.006, 0.003)) and grip.fingertip == 0.01


def test_a_joint_without_end_gets_a_turn_to_each_side_of_home(spec: RobotSpec) -> None:
    assert spec.lower == pytest.approx((-2 * math.pi, -2.0)) and spec.upper == pytest.approx((2 * math.pi, 2.0))
    assert spec.velocity == (1.5, 1.5) and spec.acceleration == (8.0, 8.0) and spec.jerk == (4000.0, 4000.0)


def test_only_driven_joints_move_in_the_description(spec: RobotSpec) -> None:
    joints = ElementTree.fromstring(spec.description).findall("joint")
    moving = {joint.get("name") for joint in joints if joint.get("type") != "fixed"}
    assert moving == {*spec.joints, *spec.gripper.joints}
    assert not [joint for joint in joints if joint.find("mimic") is not None]


def test_other_joints_stand_at_their_posture_or_at_the_limit_next_to_zero(tmp_path: Path) -> None:
    for text, angle in ((ROBOT, 0.5), (ROBOT + "posture: {wave: 0.7}\n", 0.7)):
        spec = read_robot(write(tmp_path / "swinging", text))
        wave = ElementTree.fromstring(spec.description).find("joint[@name='wave']")
        assert wave is not None and wave.get("type") == "fixed"
        origin = wave.find("origin")
        assert origin is not None
        assert [float(v) for v in origin.get("rpy", "").split()] == pytest.approx([0.0, 0.0, angle])
        assert [float(v) for v in origin.get("xyz", "").split()] == pytest.approx([0.04, 0.0, 0.0])


def test_meshes_in_millimetres_are_found_in_the_folders_that_are_named(spec: RobotSpec) -> None:
    column = next(shape for shape in link_shapes(spec) if shape.link == "column")
    assert np.ptp(column.hull.vertices, axis=0) == pytest.approx([0.03, 0.03, 0.18])


def test_capsules_and_collada_are_shapes_of_links(tmp_path: Path) -> None:
    arm = ARM.replace('<sphere radius="0.01"/>', '<capsule radius="0.01" length="0.05"/>').replace("bar.obj", "bar.dae")
    path = write(tmp_path / "swinging", arm=arm)
    dae = write_dae(tmp_path / "swinging" / "theirs_elsewhere" / "meshes", unit="1000")
    dae.rename(dae.with_name("bar.dae"))
    spec = read_robot(path)
    sizes = {shape.link: np.ptp(shape.hull.vertices, axis=0) for shape in link_shapes(spec)}
    assert sizes["flag"] == pytest.approx([0.02, 0.02, 0.07], abs=1e-3)
    assert sizes["column"] == pytest.approx([0.1, 0.2, 0.3])
    for solid in read_links(spec).solids:  # the checker reads them by its own means
        if solid.name in sizes and len(solid.pieces) == 1:
            assert np.ptp(solid.pieces[0].part.vertices, axis=0) == pytest.approx(sizes[solid.name])


@pytest.mark.parametrize("kept", ["a bar.obj", "a%20bar.obj"])
def test_what_a_url_writes_in_percent_is_found(tmp_path: Path, kept: str) -> None:
    path = write(tmp_path / "swinging", arm=ARM.replace("meshes/bar.obj", "meshes/a%20bar.obj"))
    meshes = path.parent / "theirs_elsewhere" / "meshes"
    (meshes / "bar.obj").rename(meshes / kept)
    assert any(shape.link == "column" for shape in link_shapes(read_robot(path)))


def test_a_joint_whose_axis_is_left_out_turns_about_x(tmp_path: Path) -> None:
    joint = '<child link="boom"/><axis xyz="0 1 0"/>'
    assert joint in ARM
    spec = read_robot(write(tmp_path / "swinging", arm=ARM.replace(joint, '<child link="boom"/>')))
    root = ElementTree.fromstring(spec.description)
    axes = {joint.get("name"): joint.find("axis") for joint in root.iter("joint") if joint.get("type") != "fixed"}
    assert all(axis is not None for axis in axes.values())
    assert axes["bend"].get("xyz") == "1 0 0"


def test_a_picture_s_mesh_that_is_missing_is_left_out(spec: RobotSpec) -> None:
    assert ElementTree.fromstring(spec.description).find("link[@name='column']/visual") is None


def test_a_package_is_found_in_the_folders_above_the_urdf(tmp_path: Path) -> None:
    folder = tmp_path / "theirs" / "robots"
    path = write(folder, ROBOT.replace("meshes: [theirs_elsewhere]\n", ""))
    (folder.parent / "meshes").mkdir()
    (folder / "theirs_elsewhere" / "meshes" / "bar.obj").rename(folder.parent / "meshes" / "bar.obj")
    assert any(shape.link == "column" for shape in link_shapes(read_robot(path)))


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("urdf/arm.urdf", "urdf/absent.urdf", r"absent\.urdf: no such URDF"),
        ("urdf/arm.urdf", "python://no_such_package_here/arm.urdf", r"robot\.yaml:1: urdf: the Python package"),
        (
            "urdf/arm.urdf",
            "dist://no-such-distribution/arm.urdf",
            "'no-such-distribution' is not installed",
        ),
        ("urdf/arm.urdf", "ftp://x/arm.urdf", r"no path; it may begin with python://PACKAGE/"),
        ("[theirs_elsewhere]", "[nowhere]", r"meshes\[0\]: there is no folder"),
        ("meshes: [theirs_elsewhere]", "", r"there is no mesh 'package://theirs/meshes/bar.obj'; looked for"),
        (
            "parent: boom, xyz: [0.0, 0.0, 0.2]",
            "parent: bom",
            r"gripper\.attach\.parent: there is no link 'bom'; did you mean 'boom'\? the URDF has base, boom",
        ),
        (
            "[turn, bend]",
            "[turn, bent]",
            r"arm\.joints\[1\]: there is no joint 'bent'; did you mean 'bend'\? the URDF has bend",
        ),
        (
            "[turn, bend]",
            "[turn, bend]\n  lower: [1, 1]\n  upper: [0, 0]",
            "has limits of 1 to 0; the lower comes first",
        ),
        ("[h_left_swing]", "[h_right_swing]", "h_right_swing mimics h_left_swing; name the joint that is driven first"),
        ("  pads: [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]\n", "", "gripper: needs pads"),
        ("home: [0.0, 0.3]", "home: [0.0, 2.3]", r"arm.home\[1\]: 2.3 is outside the joint's limits of -2 to 2"),
        ("axis: [0.0, 1.0, 0.0]", "axis: [0.0, 0.0, 1.0]", "gripper.axis: must be a direction across the tool's z"),
        ("  velocity: 1.5", "  velocity: [1, 2, 3]", "arm: velocity has 3 values for 2 joints"),
        ("stroke:", "strike:", r"gripper.str[io]ke"),
        ("urdf: urdf/arm.urdf", "- urdf", "not YAML|no mapping"),
        ("urdf/arm.urdf", "python://../arm.urdf", r"urdf: the Python package '\.\.' is not installed"),
        ("urdf/arm.urdf", "dist:///arm.urdf", "urdf: the distribution '' is not installed"),
        ("urdf/arm.urdf", "~no_such_user_here/arm.urdf", "urdf: there is no folder ~no_such_user_here"),
        ("radius: 0.1}", "radius: 0.6}", r"base\.radius is 0\.6: nothing would be left of arm\.reach"),
        ("stroke: 0.04", "stroke: 0.0004", r"gripper: stroke is 0\.0004; pads that part by less than 0\.002 m"),
        ("limits: [0.0, 0.5]", "limits: [0.5, 0.0]", r"gripper\.limits: the lower one comes first"),
    ],
)
def test_what_cannot_be_used_is_refused_in_one_sentence(tmp_path: Path, old: str, new: str, complaint: str) -> None:
    assert old in ROBOT
    with pytest.raises(RobotError, match=complaint) as error:
        read_robot(write(tmp_path / "swinging", ROBOT.replace(old, new, 1)))
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ('lower="-2" upper="2"', "", "joint 'bend' has no limits"),
        (
            'lower="-2" upper="2"',
            'lower="2" upper="-2"',
            "bend has limits of 2 to -2; the lower comes first",
        ),
        ('xyz="0.04 0 0"', 'xyz="0.04 0"', "xyz='0.04 0' are not three numbers"),
        ('lower="-2"', 'lower="low"', "lower='low' is not a number"),
        ("</robot>", "", "not a URDF"),
        ('<robot name="arm"', '<sdf><robot name="arm"', "not a URDF"),
    ],
)
def test_a_broken_urdf_is_refused_in_one_sentence(tmp_path: Path, old: str, new: str, complaint: str) -> None:
    assert old in ARM
    with pytest.raises(RobotError, match=complaint) as error:
        read_robot(write(tmp_path / "swinging", arm=ARM.replace(old, new, 1)))
    assert r"arm.urdf" in str(error.value) and "\n" not in str(error.value)


def test_names_of_arm_and_gripper_that_clash_need_a_prefix(tmp_path: Path) -> None:
    arm = ARM.replace('name="flag"', 'name="palm"').replace('link="flag"', 'link="palm"')
    with pytest.raises(RobotError, match=r"both arm and gripper have a link 'palm'; give gripper\.attach a prefix"):
        read_robot(write(tmp_path / "swinging", ROBOT.replace(", prefix: h_", "").replace("h_", ""), arm))
