from __future__ import annotations

import csv
import itertools
from dataclasses import replace

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicHermiteSpline

from tamp.errors import TampError
from tamp.formats.trajectory import ARM_TOPIC, GRIPPER_S, GRIPPER_TOPIC, STRAY, export_trajectory, segments
from tamp.task import Action, Attachment, Fall, Grip, Move, Plan, Pose, Release, load_robot
from tamp.world.robot.model import robot_model
from tamp.world.timing.time_parametrization import time_path

ROBOT = load_robot("panda")
HOME = np.array(ROBOT.home)
HELD = Attachment("cup", Pose())


def moved(start, end):
    """A motion as fast as the limits allow."""
    return time_path(np.linspace(start, end, 20), robot_model(ROBOT).spec)


def plan_of(offset):
    there = HOME + offset
    out, back = moved(HOME, there), moved(there, HOME)
    pick = Action("pick", ("cup",), (Move("transit", out, 0.08), Grip(HELD, 0.03), Move("lift", back, 0.03, HELD)))
    place = Action(
        "lay", ("cup",), (Move("transfer", out, 0.03, HELD), Release("cup", Pose(), 0.08), Fall("cup", Pose()))
    )
    return Plan("task", "panda", 0, {"cup": Pose()}, tuple(HOME), {}, (pick, place))


PLAN = plan_of(np.array([0.8, 0.2, -0.3, 0.4, 0.2, -0.5, 0.9]))


@settings(max_examples=15, deadline=None)
@given(offset=st.lists(st.floats(-0.5, 0.5), min_size=7, max_size=7), rate=st.sampled_from([20.0, 60.0, 125.0, 1000.0]))
def test_a_controller_that_joins_the_set_points_by_cubics_keeps_the_limits_and_the_path(offset, rate):
    offset = np.array(offset)
    if np.abs(offset).max() < 0.05:
        offset[0] = 0.3
    made = segments(plan_of(offset), ROBOT, rate)
    planned = plan_of(offset).actions[0].steps[0].trajectory
    transit = made[0]
    replay = CubicHermiteSpline(transit.times, transit.positions, transit.velocities)
    times = np.linspace(0.0, transit.times[-1], 2000)
    assert (np.abs(replay(times, 1)).max(axis=0) <= np.array(ROBOT.velocity) * (1 + 1e-9)).all()
    pull = np.abs(np.diff(transit.velocities, axis=0)) / np.diff(transit.times)[:, None]
    assert (pull.max(axis=0) <= np.array(ROBOT.acceleration) * (1 + 1e-9)).all()
    true = CubicHermiteSpline(planned.times, planned.positions, planned.velocities)
    assert np.abs(replay(times) - true(times * planned.duration / transit.times[-1])).max() < 2 * STRAY
    assert transit.positions[-1] == pytest.approx(planned.positions[-1], abs=1e-9)
    assert np.abs(transit.velocities[[0, -1]]).max() < 1e-6


def test_motions_and_the_gripper_follow_each_other_on_one_clock():
    made = segments(PLAN, ROBOT, 100.0)
    assert [segment.phase for segment in made] == ["transit", "grip", "lift", "transfer", "release", "fall"]
    assert [segment.opening for segment in made] == [0.08, 0.03, 0.03, 0.03, 0.08, 0.08]
    ends = [segment.start + segment.times[-1] for segment in made]
    assert [segment.start for segment in made[1:]] == pytest.approx(ends[:-1])
    assert made[1].times[-1] == GRIPPER_S
    for before, after in itertools.pairwise(made):
        assert before.positions[-1] == pytest.approx(after.positions[0], abs=1e-6)
    assert np.diff(made[0].times)[:-1] == pytest.approx(0.01)


def test_fingers_go_to_a_motion_s_opening_before_it_begins():
    transit, *rest = PLAN.actions[0].steps
    plan = replace(PLAN, actions=(Action("pick", ("cup",), (replace(transit, opening=0.05), *rest)),))
    made = segments(plan, ROBOT, 100.0)
    assert [(s.phase, s.opening) for s in made[:2]] == [("open", 0.05), ("transit", 0.05)]
    assert made[1].start == GRIPPER_S


def test_a_table_has_a_row_a_set_point(tmp_path):
    path = tmp_path / "plan.csv"
    count = export_trajectory(PLAN, ROBOT, path, "csv", 50.0)
    with path.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == count
    times = [float(row["time"]) for row in rows]
    assert times[0] == 0.0 and min(np.diff(times)) > 0.0
    assert [float(rows[0][f"q.{joint}"]) for joint in ROBOT.joints] == pytest.approx(ROBOT.home)
    assert rows[-1]["phase"] == "fall" and rows[0]["action"] == "pick(cup)"


def test_ros_messages_say_the_same(tmp_path):
    path = tmp_path / "plan.yaml"
    export_trajectory(PLAN, ROBOT, path, "ros2", 50.0)
    documents = list(yaml.safe_load_all(path.read_text(encoding="utf-8")))
    made = segments(PLAN, ROBOT, 50.0)
    assert [d.get("topic") for d in documents] == [ARM_TOPIC, GRIPPER_TOPIC, ARM_TOPIC, ARM_TOPIC, GRIPPER_TOPIC, None]
    message = documents[0]["message"]
    assert message["joint_names"] == list(ROBOT.joints)
    assert np.array([point["positions"] for point in message["points"]]) == pytest.approx(made[0].positions)
    since = [p["time_from_start"]["sec"] + 1e-9 * p["time_from_start"]["nanosec"] for p in message["points"]]
    assert since == pytest.approx(made[0].times, abs=1e-9)
    assert documents[1]["message"]["points"][0]["positions"] == [0.015, 0.015]


def test_a_bag_is_read_back_without_ros(tmp_path):
    pytest.importorskip("rosbags")
    from rosbags.rosbag2 import Reader
    from rosbags.typesys import Stores, get_typestore

    path = tmp_path / "bag"
    export_trajectory(PLAN, ROBOT, path, "rosbag2", 50.0)
    types, made = get_typestore(Stores.ROS2_HUMBLE), segments(PLAN, ROBOT, 50.0)
    with Reader(path) as reader:
        read = [(c.topic, stamp, types.deserialize_cdr(raw, c.msgtype)) for c, stamp, raw in reader.messages()]
    assert [stamp for _, stamp, _ in read] == pytest.approx([round(1e9 * s.start) for s in made[:-1]])
    topic, _, message = read[0]
    assert (topic, message.joint_names) == (ARM_TOPIC, list(ROBOT.joints))
    assert np.array([point.positions for point in message.points]) == pytest.approx(made[0].positions)
    with pytest.raises(TampError, match="a bag is a new folder"):
        export_trajectory(PLAN, ROBOT, path, "rosbag2", 50.0)


@pytest.mark.parametrize(
    ("rate", "complaint"), [(0.0, "--rate 0: a positive number"), (0.5, "at 0.5 Hz set points"), (1e9, "at most 10000")]
)
def test_a_rate_that_will_not_do_is_refused(tmp_path, rate, complaint):
    with pytest.raises(TampError, match=complaint):
        export_trajectory(PLAN, ROBOT, tmp_path / "plan.csv", "csv", rate)


def test_a_plan_beyond_the_limits_is_refused():
    fast = PLAN.actions[0].steps[0]
    hurried = replace(fast.trajectory, times=fast.trajectory.times / 2, velocities=2 * fast.trajectory.velocities)
    plan = replace(PLAN, actions=(Action("move", (), (replace(fast, trajectory=hurried),)),))
    with pytest.raises(TampError, match=r"move\(\), transit: at 100 Hz the set points ask more than the joints can do"):
        segments(plan, ROBOT, 100.0)
