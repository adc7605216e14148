"""The kit for robots: what fits is said to fit, and each mistake is told by the check that is for it."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tamp.checking.robot.links import read_links
from tamp.cli import main
from tamp.conformance.findings import Finding
from tamp.conformance.robot.kit import _Trial, check_robot
from tamp.errors import RobotError
from tamp.task import Pose, RobotSpec, load_robot
from tamp.task.files.robot.robot_file import read_robot
from tamp.world.robot.model import robot_model
from tests.task.scara import ROBOT as SCARA
from tests.task.scara import write as write_scara
from tests.task.swinging import ARM, ROBOT, write


def trial(spec: RobotSpec) -> _Trial:
    return _Trial(spec, robot_model(spec), read_links(spec), np.random.default_rng(0))


def wrong(findings: list[Finding]) -> list[str]:
    return [finding.text for finding in findings if finding.outcome == "wrong"]


def test_a_robot_that_fits_is_said_to_fit(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["robots", "check", "panda", "--json", str(tmp_path / "found.json")]) == 0
    assert capsys.readouterr().out.endswith("it fits\n")
    found = json.loads((tmp_path / "found.json").read_text())
    assert found["fits"] and found["numbers"]["kinematics_m"] < 1e-9 and found["numbers"]["ik_hits"] > 0.99


def test_what_cannot_be_read_is_all_that_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["robots", "check", str(tmp_path)]) != 0
    assert "robot.yaml" in capsys.readouterr().err


def test_swinging_fingers_fit_and_their_way_along_the_approach_is_told(tmp_path: Path) -> None:
    found = list(trial(read_robot(write(tmp_path / "swinging"))).gripper())
    assert not wrong(found) and "1.0 mm of way along the approach" in found[-1].text


def test_fingers_whose_zero_is_not_closed_are_told() -> None:
    spec = load_robot("panda")
    description = spec.description.replace('xyz="0 0 0.0584"', 'xyz="0 0.005 0.0584"', 1)
    assert description != spec.description
    (text, *_) = wrong(list(trial(replace(spec, description=description)).gripper()))
    assert "the fingers' hulls are" in text and "give gripper.pads" in text


def test_a_tool_beside_the_pads_is_told() -> None:
    spec = load_robot("panda")
    aside = replace(spec, T_parent_tool=Pose((0.0, 0.004, 0.1034)))
    assert any("4.0 mm beside the tool's z axis" in text for text in wrong(list(trial(aside).gripper())))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("axis: [0.0, 1", "axis: [1.0, 0", r"along gripper.axis, \[1, 0, 0\] in the tool frame, but along \[0, 1, 0\]"),
        ("0.1034]", "0.1034]\n  rpy: [0, 0, 1.5708]", r"along gripper.axis, .* but along \[1, 0, 0\]; .* the tool"),
    ],
)
def test_fingers_that_close_across_the_axis_are_told_wherever_the_robot_is_loaded(
    old: str, new: str, said: str, tmp_path: Path
) -> None:
    spec = read_robot(written(tmp_path, old, new))
    assert re.search(said, wrong([*check_robot(spec).findings])[0])
    with pytest.raises(RobotError, match=said):
        robot_model(spec)


def test_fingers_that_are_in_each_other_are_told_by_the_hand() -> None:
    spec = load_robot("panda")
    description = spec.description.replace('xyz="0 0 0.0584"', 'xyz="0 -0.01 0.0584"', 1)
    description = description.replace('xyz="0 0 0.0584"', 'xyz="0 0.01 0.0584"', 1)
    assert (
        "closed fingers reach over the middle" in wrong(list(trial(replace(spec, description=description)).hand()))[0]
    )


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("radius: 0.16", "radus: 0.16", r"base.radus: unknown field; did you mean radius\?"),
        ("velocity: [", "velocity: [-", r"arm.velocity\[0\]: -2.175 is not valid; it must be greater than 0"),
        ("acceleration: ", "acceleration: fast #", r"arm.acceleration: 'fast' is not valid; it must be a number"),
    ],
)
def test_a_field_that_is_wrong_is_named_as_it_is_in_the_file(old: str, new: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(RobotError, match=said):
        read_robot(written(tmp_path, old, new))


def written(folder: Path, old: str, new: str) -> Path:
    """The Panda's file with something said otherwise."""
    text = (Path(__file__).parents[2] / "robots" / "panda" / "robot.yaml").read_text()
    assert text.count(old) == 1
    (folder / "robot.yaml").write_text(text.replace(old, new))
    return folder / "robot.yaml"


def test_pads_that_reach_beyond_the_fingers_are_told() -> None:
    spec = load_robot("panda")
    aside = replace(spec, T_parent_tool=Pose((0.01, 0.0, 0.1034)))
    assert any("8.5 mm beyond the fingers" in text for text in wrong(list(trial(aside).gripper())))
    assert not wrong(list(trial(spec).gripper()))


@pytest.mark.parametrize(
    ("z", "end"), [(0.1134, "10.2 mm beyond the fingertips"), (0.0534, "4.1 mm beyond the fingers' other ends")]
)
def test_pads_that_reach_beyond_the_fingers_along_the_approach_are_told(z: float, end: str) -> None:
    spec = load_robot("panda")
    off = replace(spec, T_parent_tool=Pose((0.0, 0.0, z)))
    assert any(end in text and "move the tool" in text for text in wrong(list(trial(off).gripper())))


def test_guessed_pads_at_the_fingers_roots_are_told(tmp_path: Path) -> None:
    robot = ROBOT.replace("pads: [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]", "pads: [[0.0, 0.0, -0.01], [0.0, 0.0, -0.01]]")
    (text,) = wrong(list(trial(read_robot(write(tmp_path / "swinging", robot))).gripper()))
    assert "9.0 mm beyond the fingers' other ends" in text and "move gripper.pads" in text


@pytest.mark.parametrize("rpy", [(np.pi, 0.0, 0.0), (0.0, np.pi / 2, 0.0)])
def test_a_tool_whose_z_does_not_point_out_of_the_hand_is_told(rpy: tuple[float, float, float]) -> None:
    spec = load_robot("panda")
    (text,) = wrong(list(trial(replace(spec, T_parent_tool=Pose.from_rpy((0.0, 0.0, 0.1034), rpy))).hand()))
    assert "beyond the fingertips along the tool's z; turn the tool" in text


def test_an_arm_that_cannot_turn_its_tool_every_way_is_noted(tmp_path: Path) -> None:
    found = list(trial(read_robot(write_scara(tmp_path / "scara"))).inverse())
    assert [f.outcome for f in found] == ["ok", "note"] and "straight above only" in found[1].text
    assert len(list(trial(load_robot("panda")).inverse())) == 1


def test_a_tool_at_the_flange_is_told() -> None:
    spec = load_robot("panda")
    assert "the tool belongs between the pads" in wrong(list(trial(replace(spec, T_parent_tool=Pose())).hand()))[0]


def test_a_home_in_the_table_is_told() -> None:
    spec = load_robot("panda")
    low = replace(spec, home=(0.0, 1.2, 0.0, -1.2, 0.0, 2.4, 0.785))
    assert any(text.startswith("at home:") for text in wrong(list(trial(low).collisions())))


def test_pads_that_never_meet_end_the_kit_with_what_the_fingers_are() -> None:
    spec = load_robot("panda")
    pads = ((0.0, 0.0, 0.04), (0.0, 0.0, 0.04))
    judgement = check_robot(replace(spec, gripper=replace(spec.gripper, pads=pads, stroke=0.1)))
    assert not judgement.fits and "the pads part by 0.08" in judgement.findings[-1].text
    assert [f.text.split()[0] for f in judgement.findings if f.check == "fingers"] == [*spec.gripper.fingers]


def test_a_home_in_which_the_arm_is_in_itself_is_told() -> None:
    spec = load_robot("panda")
    folded = replace(spec, home=(0.0, 0.0, 0.0, -3.07, 0.0, 0.0, 0.785), T_world_base=Pose((-0.42, 0.0, 0.3)))
    assert any(text.startswith("at home: panda_") for text in wrong(list(trial(folded).collisions())))


def test_limits_in_degrees_are_told() -> None:
    spec = load_robot("panda")
    (text,) = wrong(list(trial(replace(spec, upper=(166.0, *spec.upper[1:]))).limits()))
    assert text == "panda_joint1 has a range of 26.88 turns; limits are in radians, and 10 turns the most"


def test_what_slides_is_told_in_metres(tmp_path: Path) -> None:
    spec = read_robot(write_scara(tmp_path / "scara", SCARA.replace("  acceleration", "  velocity: 3\n  acceleration")))
    *notes, ranges = [finding.text for finding in trial(spec).limits()]
    assert ranges.endswith("the joints' ranges are 0.92 turns, 0.92 turns, 0.28 m, 0.92 turns")
    assert "lift may slide at 3 m/s, the URDF says 2" in notes and "wrist may turn at 3 rad/s, the URDF says 2" in notes
    (text,) = wrong(list(trial(replace(spec, upper=(*spec.upper[:2], 280.0, spec.upper[3]))).limits()))
    assert text == "lift has a range of 280.00 m; limits are in metres, and 20 m the most"


@pytest.mark.parametrize("x", [-420.0, -1.5])
def test_a_base_from_which_nothing_on_the_table_is_in_reach_is_told(x: float) -> None:
    (text,) = wrong(list(trial(replace(load_robot("panda"), T_world_base=Pose((x, 0.0, 0.0)))).reach()))
    assert text.startswith("arm.reach says 0.32 to 0.68 m, but from the base the table is ") and "in metres" in text


def test_a_reach_where_the_hand_never_gets_is_told() -> None:
    (text,) = wrong(list(trial(replace(load_robot("panda"), reach=(3.0, 5.0))).reach()))
    assert text.startswith("arm.reach says 3 to 5 m")


def test_motors_that_cannot_carry_the_arm_are_told_by_the_simulators(tmp_path: Path) -> None:
    spec = read_robot(written(tmp_path, "  acceleration:", "  effort: 1.0\n  acceleration:"))
    found = wrong(list(trial(spec).simulation()))
    assert any(re.match(r"\w+: panda_joint\d is .* off home after 1 s: are masses and effort limits", t) for t in found)


def test_where_the_fingers_faces_are_is_told_whatever_pads_say(tmp_path: Path) -> None:
    pads = "pads: [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]"
    robot = ROBOT.replace(pads, "pads: [[0.0, 0.02, 0.0], [0.0, -0.02, 0.0]]")
    assert robot != ROBOT
    judgement = check_robot(read_robot(write(tmp_path / "swinging", robot)))
    told = [f.text for f in judgement.findings if f.check == "faces"]
    assert not judgement.fits and told[-1].endswith("[[0.0000, 0.0000, 0.0000], [0.0000, 0.0000, 0.0000]]")


def test_round_fingertips_are_noted(tmp_path: Path) -> None:
    path = write(tmp_path / "swinging")
    hand = tmp_path / "swinging" / "urdf" / "hand.urdf"
    hand.write_text(hand.read_text().replace('box size="0.01 0.004 0.02"', 'cylinder radius="0.002" length="0.02"'))
    (note,) = [f.text for f in check_robot(read_robot(path)).findings if (f.check, f.outcome) == ("faces", "note")]
    assert re.search(r"flat over [\d.]+ by 20.0 mm, gripper.pad says 10 by 18", note)


def test_a_free_home_is_proposed_where_the_one_given_is_not() -> None:
    spec = load_robot("panda")
    low = replace(spec, home=(0.0, 1.2, 0.0, -1.2, 0.0, 2.4, 0.785))
    (text,) = wrong(list(trial(low).collisions()))
    found = re.search(r"free is \[(.*)\]$", text)
    assert found is not None
    assert not wrong(list(trial(replace(spec, home=tuple(map(float, found[1].split(", "))))).collisions()))


def test_links_whose_hulls_are_often_in_each_other_are_noted_and_may_be_left_out(tmp_path: Path) -> None:
    folder, fat = tmp_path / "swinging", ARM.replace('sphere radius="0.01"', 'sphere radius="0.26"')
    spec = read_robot(write(folder, arm=fat))
    noted = [f.text for f in trial(spec).collisions() if f.outcome == "note"]
    assert any("boom and flag at" in text and "disable_collisions" in text for text in noted)
    left = replace(spec, disabled_collisions=(("boom", "flag"),))
    assert not any("boom and flag" in f.text for f in trial(left).collisions())
    assert {"boom", "flag"} not in [{a.name, b.name} for a, b in trial(left).links.pairs]
