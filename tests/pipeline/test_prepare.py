from __future__ import annotations

import math
import re
from dataclasses import replace

import pytest

from tamp.errors import TaskError
from tamp.execution.settling.settle import Settled, settle
from tamp.formats.obj import box_obj
from tamp.pipeline.prepare import RESTLESS, prepare, settled_goals
from tamp.streams.affordances.stable_poses import stands
from tamp.streams.placing.sampler import RELEASE_HEIGHT
from tamp.task import At, Box, Mesh, Object, Pose, Sphere, Task
from tamp.task.files.load import load_task


def cube(name, x, y, z, goal=None):
    return Object(name, Box((0.05, 0.05, 0.05)), Pose((x, y, z)), None if goal is None else At(Pose(goal)))


def test_the_start_is_seen_as_it_came_to_rest():
    setup = prepare(Task("tower", (cube("low", 0.0, 0.0, 0.025), cube("top", 0.0, 0.0, 0.075))))
    assert setup.supports is not None
    assert setup.observe(setup.start).start == replace(setup, supports=None).observe(setup.start).start
    apart = {**setup.start, "top": Pose((0.2, 0.2, 0.025))}
    assert setup.observe(apart).start["top"].on == ("table",)


def test_a_start_that_never_comes_to_rest_is_said_to_be_so(monkeypatch):
    """Where objects are jammed in each other, a simulator may drive them across the table for ever."""
    task = Task("tower", (cube("low", 0.0, 0.0, 0.025), cube("top", 0.0, 0.0, 0.075)))
    assert not prepare(task).remarks
    still = settle(task)
    monkeypatch.setattr("tamp.pipeline.prepare.settle_once", lambda *_, **__: replace(still, resting=False))
    setup = prepare(task)
    assert setup.supports is None
    assert setup.remarks == (RESTLESS,)


def test_goals_mean_where_things_come_to_rest_let_go_a_little_above():
    task = Task(
        "stack", (cube("low", 0.0, 0.2, 0.025, (0.1, 0.0, 0.03)), cube("top", 0.0, -0.2, 0.025, (0.1, 0.0, 0.085)))
    )
    setup = prepare(task)
    goals = settled_goals(task, setup.world, setup.start)
    assert goals["low"].on == ("table",)
    assert goals["top"].on == ("low",)
    for name, height in (("low", 0.025), ("top", 0.075)):
        resting = (0.1, 0.0, height + RELEASE_HEIGHT)
        assert math.dist(goals[name].pose.xyz, resting) < 0.002


def test_a_goal_may_rest_on_something_that_has_no_goal():
    task = Task("shelf", (cube("shelf", 0.1, 0.0, 0.025), cube("top", 0.0, 0.2, 0.025, (0.1, 0.0, 0.075))))
    setup = prepare(task)
    assert setup.goals["top"].on == ("shelf",)
    assert set(setup.goals) == {"top"}


def test_what_has_no_goal_and_stands_where_a_goal_will_be_does_not_disturb_it():
    task = Task("occupied", (cube("idle", 0.1, 0.0, 0.025), cube("red", 0.0, 0.2, 0.025, (0.11, 0.0, 0.025))))
    goal = prepare(task).goals["red"]
    assert goal.on == ("table",)
    assert goal.pose.xyz == pytest.approx((0.11, 0.0, 0.025 + RELEASE_HEIGHT), abs=0.001)


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


def test_a_goal_that_falls_off_what_it_rests_on_is_no_reason_to_refuse_a_task(tmp_path):
    # A tall tower's uppermost block is 8 mm over the edge: no rounding, and still not in the air.
    tower = "  - {name: base, shape: {box: [0.04, 0.04, 0.3]}, pose: {xyz: [0, 0.3, 0.15]}, "
    tower += "goal: {pose: {xyz: [0, 0, 0.15]}}}\n"
    (tmp_path / "good.yaml").write_text("objects:\n" + tower + entry("blue", [0.0, -0.2, 0.04], [0.028, 0.0, 0.34]))
    setup = prepare(load_task(tmp_path / "good.yaml"))
    assert setup.goals["blue"].pose.xyz[2] < 0.1
    assert any(remark.startswith("the goal of blue settles") for remark in setup.remarks)


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


@pytest.mark.parametrize(("goal", "told"), [(("on", "red", "shelf"), "on"), (("handempty",), "handempty")])
def test_a_goal_that_no_skill_says_to_hold_is_refused_with_what_to_write_instead(goal, told):
    task = Task("facts", (cube("red", 0.0, 0.2, 0.025), cube("shelf", 0.1, 0.0, 0.025)), goal=(goal,))
    with pytest.raises(TaskError, match=rf"no skill of domain tabletop says when {told} holds; .*goal: {{on: shelf}}"):
        prepare(task)


def test_a_goal_of_a_domain_that_says_when_it_holds_is_none_of_those():
    task = Task("facts", (cube("red", 0.0, 0.2, 0.025),), domain="kitchen", goal=(("cleaned", "red"),))
    assert prepare(task).domain.followed == {"cleaned", "cooked"}


def test_a_mesh_far_from_its_origin_is_on_the_table_all_the_same(tmp_path):
    path = tmp_path / "far.obj"
    path.write_text(box_obj("far", (1.0, -0.5, 3.0), (1.05, -0.45, 3.08)))
    there = Object("far", Mesh(path), Pose((-1.0, 0.6, -3.0)), At(Pose((-1.0, 0.3, -3.0))))
    setup = prepare(Task("far", (there,)))
    assert setup.start["far"].xyz == pytest.approx((-1.0, 0.6, -3.0), abs=0.002)


@pytest.mark.parametrize("rpy", [(math.pi / 4, 0.0, 0.3), (math.pi, 0.0, 0.0)])
def test_what_only_balances_on_an_edge_or_a_tip_falls(rpy, tmp_path):
    tip = tmp_path / "pyramid.obj"
    corners = "v -0.03 -0.03 0\nv 0.03 -0.03 0\nv 0.03 0.03 0\nv -0.03 0.03 0\nv 0 0 0.09\n"
    tip.write_text(corners + "f 4 3 2 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n")
    shape, height = (Box((0.06, 0.06, 0.06)), 0.06 / math.sqrt(2)) if rpy[2] else (Mesh(tip), 0.09)
    balanced = Pose.from_rpy((0.05, -0.2, height), rpy)
    start = Object("red", shape, Pose((0.0, 0.2, 0.03 if rpy[2] else 0.0)), At(balanced))
    setup = prepare(Task("balanced", (start, Object("alike", shape, replace(balanced, xyz=(0.1, 0.3, height))))))
    for pose in (setup.goals["red"].pose, setup.start["alike"]):
        assert stands(setup.world.geometries["red"], pose.matrix[:3, :3])


@pytest.mark.parametrize(("supports", "falls"), [((), True), ((("lid", "red"),), False)])
def test_what_others_hold_in_balance_is_left_so(supports, falls, monkeypatch):
    """A screwdriver that a clamp lay on was turned under it, and both were shifted."""
    edge = Pose.from_rpy((0.0, 0.2, 0.06 / math.sqrt(2)), (math.pi / 4, 0.0, 0.0))
    lid = Object("lid", Box((0.1, 0.1, 0.01)), Pose((0.1, -0.2, 0.005)))
    things = (Object("red", Box((0.06, 0.06, 0.06)), edge), lid)
    asked = []

    def settle_once(task, poses, **_):
        asked.append(poses)
        return Settled({o.name: o.pose for o in things}, (("red", "table"), *supports), {}, True)

    monkeypatch.setattr("tamp.pipeline.prepare.settle_once", settle_once)
    prepare(Task("held", things))
    assert any(poses and poses["red"] != edge for poses in asked) == falls


def test_what_is_round_stays_as_it_is_turned():
    ball = Object("ball", Sphere(0.03), Pose.from_rpy((0.0, 0.2, 0.03), (1.0, 2.0, 3.0)))
    assert prepare(Task("round", (ball,))).start["ball"].matrix == pytest.approx(ball.pose.matrix, abs=0.002)
