"""URDFs that are none: each mistake is told in a sentence that names where it is, before any library looks at it."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest

from tamp.errors import RobotError
from tamp.task import RobotSpec
from tamp.task.files.robot.robot_file import read_robot
from tests.task.swinging import ARM, ROBOT, write

BASE = '<link name="base">'
TURN = '<joint name="turn" type="continuous"><parent link="base"/>'
BEND = '<joint name="bend" type="revolute"><parent link="column"/>'


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ('size="0.1 0.1 0.02"', 'size="a b c"', "link 'base': <collision>: <box>: size='a b c' are not three numbers"),
        ('size="0.1 0.1 0.02"', "", "<box> has no size"),
        ('size="0.1 0.1 0.02"', 'size="0.1 -0.1 0.02"', "must be greater than 0"),
        ('size="0.1 0.1 0.02"', 'size="nan 0.1 0.02"', "are not three finite numbers"),
        ('size="0.1 0.1 0.02"', 'size="100 100 20"', "is over 10 m: millimetres"),
        ('<sphere radius="0.01"/>', '<sphere radius="inf"/>', "link 'flag': .* radius='inf' is not a finite number"),
        ('<sphere radius="0.01"/>', "", "link 'flag': <collision> has no geometry; valid are mesh, box"),
        ('scale="0.001 0.001 0.001"', 'scale="0.001"', "link 'column': .* scale='0.001' are not three numbers"),
        ('scale="0.001 0.001 0.001"', 'scale="1 1 0"', "makes it flat"),
        ('<origin xyz="0 0 0.02"/>', '<origin xyz="0 inf 0.02"/>', "joint 'turn': <origin>: .* three finite numbers"),
        ('<axis xyz="0 1 0"/>', '<axis xyz="0 0 0"/>', "joint 'bend': <axis> is 0 0 0"),
        (BEND, BEND.replace("revolute", "hinge"), "joint 'bend' has the type 'hinge'; valid are revolute"),
        (BEND, BEND.replace("column", "nothing"), "joint 'bend' has the parent 'nothing', which is no link"),
        (BEND, '<joint name="bend" type="revolute">', "joint 'bend' lacks its parent link"),
        (BEND, BEND.replace('name="bend" ', ""), "a <joint> has no name"),
        (TURN, TURN.replace("base", "boom"), "joints form a loop; only trees are valid"),
        (
            '<parent link="base"/><child link="flag"/>',
            '<parent link="base"/><child link="boom"/>',
            "hangs on two joints",
        ),
        (BASE, f'<link name="lonely"/>{BASE}', "needs exactly one root link, found lonely, base"),
        (BASE, f'<link name="boom"/>{BASE}', "two links are called 'boom'"),
        (BEND, f'{BEND}<mimic joint="nothing"/>', "joint 'bend' mimics 'nothing', which is no joint"),
        (BEND, f'{BEND}<mimic joint="bend"/>', "joint 'bend' mimics itself"),
        (BASE, f'{BASE}<inertial><mass value="-1"/></inertial>', r"<mass> needs a value of 0 or more \[kg\], not -1"),
        (BASE, f'{BASE}<inertial><mass value="1"/><inertia ixx="-1"/></inertial>', "ixx=-1 must be 0 or more"),
        (BASE, f'{BASE}<inertial><mass value="x"/></inertial>', "link 'base': <mass>: value='x' is not a number"),
        ('effort="10"', 'effort="nan"', "joint 'turn': <limit>: effort='nan' is not a finite number"),
        ('name="flag"', 'name="${side}flag"', r"has '\$\{side\}flag'; expand it first, by `xacro arm.urdf"),
        (BASE, f'<xacro:include filename="more.xacro"/>{BASE}', "has <xacro:include>; expand it first"),
    ],
)
def test_what_is_no_urdf_is_refused_in_one_sentence(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], old: str, new: str, complaint: str
) -> None:
    assert old in ARM
    with pytest.raises(RobotError, match=complaint) as error:
        read_robot(write(tmp_path / "swinging", arm=ARM.replace(old, new, 1)))
    assert r"arm.urdf" in str(error.value) and "\n" not in str(error.value)
    assert not capfd.readouterr().err


def read(folder: Path, old: str, new: str, robot: str = ROBOT) -> RobotSpec:
    assert old in ARM
    return read_robot(write(folder / "swinging", robot, ARM.replace(old, new)))


def described(spec: RobotSpec, path: str) -> ElementTree.Element | None:
    return ElementTree.fromstring(spec.description).find(path)


def test_definitions_of_xacro_that_nobody_uses_do_no_harm(tmp_path: Path) -> None:
    assert read(tmp_path, BASE, f'<xacro:property name="x" value="1"/>{BASE}').joints == ("turn", "bend")


@pytest.mark.parametrize("effort", ['effort="0"', ""])
def test_motors_without_strength_are_refused_until_the_robot_s_file_says_it(tmp_path: Path, effort: str) -> None:
    with pytest.raises(RobotError, match=r"joint 'turn' has no effort limit; give arm\.effort in robot\.yaml"):
        read(tmp_path, 'effort="10"', effort)
    given = read(tmp_path, 'effort="10"', effort, ROBOT.replace("acceleration: 8", "acceleration: 8\n  effort: 12.0"))
    limit = described(given, "joint[@name='turn']/limit")
    assert limit is not None and limit.get("effort") == "12.0"


def test_a_joint_without_end_needs_no_limit_where_the_robot_s_file_has_all_of_it(tmp_path: Path) -> None:
    limit = '<limit effort="10" velocity="2" drake:acceleration="3"/>'
    spec = read(tmp_path, limit, "", ROBOT.replace("acceleration: 8", "acceleration: 8\n  effort: 12.0"))
    found = described(spec, "joint[@name='turn']/limit")
    assert found is not None and set(found.keys()) == {"lower", "upper", "effort", "velocity"}


def test_a_body_of_no_mass_has_the_mass_of_its_hulls_and_a_mass_alone_is_kept(tmp_path: Path) -> None:
    spec = read(tmp_path, BASE, f'{BASE}<inertial><mass value="0"/><inertia ixx="0"/></inertial>')
    assert described(spec, "link[@name='base']/inertial") is None
    spec = read(tmp_path, BASE, f'{BASE}<inertial><mass value="3"/></inertial>')
    mass = described(spec, "link[@name='base']/inertial/mass")
    assert mass is not None and mass.get("value") == "3"
    assert described(spec, "link[@name='base']/inertial/inertia") is not None
