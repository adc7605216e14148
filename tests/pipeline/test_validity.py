import re

import pytest

from tamp.errors import TaskError
from tamp.formats.obj import box_obj
from tamp.pipeline.setup import prepare
from tamp.task import At, Box, Object, Pose, Task
from tamp.task.load import load_task

RED = "  - {name: red, shape: {box: [0.05, 0.05, 0.08]}, pose: {xyz: [0.05, 0.2, 0.04]}}\n"


def entry(name, xyz, goal=None):
    text = f"  - name: {name}\n    shape: {{box: [0.05, 0.05, 0.08]}}\n    pose: {{xyz: {xyz}}}\n"
    return text if goal is None else f"{text}    goal: {{pose: {{xyz: {goal}}}}}\n"


def refusal(tmp_path, *entries):
    path = tmp_path / "bad.yaml"
    path.write_text("objects:\n" + "".join(entries))
    with pytest.raises(TaskError) as refused:
        prepare(load_task(path))
    message = str(refused.value)
    assert "\n" not in message
    assert message.startswith(str(path))
    place, field, complaint = re.match(r".*bad\.yaml:(\d+): (\S+): (.*)", message).groups()
    return int(place), field, complaint


def test_a_pose_off_the_table(tmp_path):
    line, field, complaint = refusal(tmp_path, RED, entry("blue", [0.6, 0.0, 0.04]))
    assert (line, field) == (5, "objects[1].pose")
    assert complaint == "blue is off the table, which spans x -0.54 to 0.30 and y -0.60 to 0.60"


def test_a_goal_off_the_table(tmp_path):
    line, field, complaint = refusal(tmp_path, RED, entry("blue", [0.0, 0.0, 0.04], [0.0, 0.7, 0.04]))
    assert (line, field) == (6, "objects[1].goal.pose")
    assert complaint.startswith("blue is off the table")


def test_a_pose_under_the_table_top(tmp_path):
    line, field, complaint = refusal(tmp_path, RED, entry("blue", [0.0, 0.0, -0.02]))
    assert (line, field) == (5, "objects[1].pose")
    assert complaint == "blue is under the table top, which is at z = 0"


def test_two_objects_inside_each_other(tmp_path):
    line, field, complaint = refusal(tmp_path, RED, entry("blue", [0.06, 0.2, 0.04]))
    assert (line, field) == (5, "objects[1].pose")
    assert complaint == "blue is inside red; move one of them"


def test_two_goals_inside_each_other(tmp_path):
    there = [0.0, -0.2, 0.04]
    entries = entry("red", [0.05, 0.2, 0.04], there), entry("blue", [0.0, 0.0, 0.04], there)
    line, field, complaint = refusal(tmp_path, *entries)
    assert (line, field) == (9, "objects[1].goal.pose")
    assert complaint == "the goal of blue is inside that of red; move one of them"


def test_what_stands_in_for_a_mesh_may_overlap_and_push_others_off(tmp_path):
    (tmp_path / "bowl.obj").write_text(box_obj("bowl", (-0.1, -0.1, -0.04), (0.1, 0.1, 0.04)))
    bowl = (
        "  - {name: bowl, shape: {mesh: bowl.obj%s}, pose: {xyz: [0, 0.5, 0.04]}, goal: {pose: {xyz: [0, 0, 0.3]}}}\n"
    )
    spoon = entry("spoon", [0.02, 0.55, 0.05])
    assert refusal(tmp_path, bowl % "", spoon)[2] == "spoon is inside bowl; move one of them"
    (tmp_path / "good.yaml").write_text("objects:\n" + bowl % ", stand_in: true" + spoon)
    assert set(prepare(load_task(tmp_path / "good.yaml")).start) == {"bowl", "spoon"}


def test_a_goal_that_nothing_supports(tmp_path):
    line, field, complaint = refusal(tmp_path, RED, entry("blue", [0.0, 0.0, 0.04], [0.0, -0.2, 0.34]))
    assert (line, field) == (6, "objects[1].goal.pose")
    assert complaint.startswith("nothing supports blue there: it would fall 30 cm")


def test_an_object_that_does_not_stay_on_the_table(tmp_path):
    # A tall box stands with its middle just inside the edge, leaning outwards.
    tilted = "  - {name: blue, shape: {box: [0.04, 0.04, 0.3]}, pose: {xyz: [0.0, 0.599, 0.16], rpy: [-0.5, 0, 0]}}\n"
    line, field, complaint = refusal(tmp_path, RED, tilted)
    assert (line, field) == (3, "objects[1].pose")
    assert complaint == "blue does not stay on the table; give it a pose that is supported"


def test_a_task_built_in_code_has_no_file_to_name():
    box = Box((0.05, 0.05, 0.08))
    task = Task("built", (Object("red", box, Pose((0.0, 0.2, 0.04)), At(Pose((0.0, 0.0, 0.5)))),))
    with pytest.raises(TaskError, match=r"^task built: nothing supports red there"):
        prepare(task)


def test_poses_that_overlap_by_a_rounding_are_accepted(tmp_path):
    path = tmp_path / "good.yaml"
    path.write_text("objects:\n" + RED + entry("blue", [0.099, 0.2, 0.0399], [0.0, -0.2, 0.041]))
    setup = prepare(load_task(path))
    assert set(setup.start) == {"red", "blue"}
    assert setup.goals["blue"].on == ("table",)


def test_a_spoon_may_lie_deep_in_what_carries_it(tmp_path):
    path = tmp_path / "good.yaml"
    spoon = "  - {name: spoon, shape: {box: [0.1, 0.02, 0.016]}, pose: {xyz: [0.0, -0.2, 0.012]}}\n"
    plate = "  - {name: plate, shape: {box: [0.12, 0.12, 0.017]}, pose: {xyz: [0.0, -0.2, 0.009]}}\n"
    path.write_text("objects:\n" + plate + spoon)
    assert set(prepare(load_task(path)).start) == {"spoon", "plate"}
