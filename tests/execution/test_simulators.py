from __future__ import annotations

import math
import re
import subprocess
import sys
import types
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tamp.errors import TampError, TaskError
from tamp.execution.controller import Operator
from tamp.execution.executor import execute
from tamp.execution.pybullet.simulator import PyBulletSimulator
from tamp.execution.settling.settle import settle
from tamp.execution.simulator import GRAVITY, STEP, TABLE, wait
from tamp.execution.simulators import DEFAULT, SIMULATORS, Entry, make_simulator, require
from tamp.task import Attachment, Box, Inertia, Mesh, Object, Pose, Task, load_robot
from tamp.task.files.robot.robot_file import read_robot
from tamp.world.robot.linkage import linkage
from tests.checking.handmade import alone, timed
from tests.task.swinging import ARM, ROBOT, write

SINGLE = 1e-6  # engines may count in single precision
BOX = Object("box", Box((0.05, 0.05, 0.08)), Pose((0.1, 0.2, 0.04)), mass=0.3)
OTHER = Object("other", Box((0.04, 0.04, 0.04)), Pose((0.1, -0.2, 0.02)))


class Heavier(PyBulletSimulator):
    """A third party's simulator, in a module of its own."""

    made = 0

    def __init__(self, *args, **options):
        type(self).made += 1
        super().__init__(*args, **options)


class Strange(Heavier):
    def __init__(self, scene):
        """Takes what nobody gives."""


def test_a_simulator_from_outside_is_given_by_its_address():
    address = f"{__name__}:Heavier"
    require(address)
    before = Heavier.made
    settled = settle(Task("one", (BOX,)), simulator=address)
    assert Heavier.made == before + 1
    assert settled.resting


@pytest.mark.parametrize(
    ("name", "complaint"),
    [
        ("gazebo", r"unknown simulator 'gazebo'; valid are pybullet.*\"package.module:Class\""),
        ("nowhere.at_all:Physics", r"simulator 'nowhere.at_all:Physics': there is no module 'nowhere'"),
        ("tamp.execution.simulator:Nothing", r"the module 'tamp.execution.simulator' has no 'Nothing'"),
        (f"{__name__}:Strange", r"Strange' must take \(objects, poses, \*, table, robot, q\): "),
        (":Physics", r"simulator ':Physics' is not of the form package.module:Class"),
        ("tests.execution.broken:Physics", r"'tests.execution.broken' cannot be imported: NameError: .*broken.py:1$"),
        ("tamp.execution.simulator:STEP", r"is no class"),
        ("json:JSONDecoder", r"simulator 'json:JSONDecoder' lacks __enter__, __exit__, step, pose"),
    ],
)
def test_a_simulator_that_is_not_there_is_refused(name, complaint):
    with pytest.raises(TampError, match=complaint):
        require(name)


def test_what_has_its_mass_all_in_its_middle_is_refused_before_a_touch_throws_it_about():
    moments = (5e-7, 5e-7, 5e-7)
    speck = replace(BOX, inertia=Inertia(Pose(), moments))
    with pytest.raises(TaskError, match=r"box: its least moment of inertia is 5.0e-07 kg m\^2, .* valid is 3.8e-05"):
        settle(Task("one", (speck,)))
    settle(Task("one", (replace(BOX, inertia=Inertia(Pose(), (4e-5, 4e-5, 4e-5))),)))


def test_what_stands_in_for_a_slenderer_shape_is_not_refused(tmp_path):
    """A hammer of OCRTOC 2020, of which no more than the size is known, had its task refused."""
    path = tmp_path / "stand_in.obj"
    trimesh.creation.box(BOX.shape.size).export(path)
    slender = replace(BOX, inertia=Inertia(Pose(), (5e-7, 1e-4, 1e-4)))
    settle(Task("one", (replace(slender, shape=Mesh(path, stand_in=True)),)))
    with pytest.raises(TaskError, match="no simulator bears"):
        settle(Task("one", (replace(slender, shape=Mesh(path)),)))


@pytest.mark.parametrize("mass", [1e-5, 1e-3, 3e-3])
@pytest.mark.parametrize("simulator", ["pybullet", "mujoco"])
def test_what_weighs_next_to_nothing_is_pressed_gently_and_stays_in_the_fingers(simulator, mass):
    """By the force that holds a cup it shot out of them in PyBullet."""
    pytest.importorskip(simulator)
    start, end = Pose((0.05, -0.2, 0.03)), Pose((0.05, 0.2, 0.03))
    task, plan = alone(Box((0.04, 0.04, 0.06)), start, end, 0.04, 0.005, mass=mass)
    done = execute(task, plan, monitor=None, simulator=simulator)
    assert math.dist(done.final_poses["red"].xyz, end.xyz) < 0.008


def test_one_whose_library_is_absent_says_what_to_install(monkeypatch):
    absent = {**SIMULATORS, "absent": Entry("nowhere:Class", "no_such_library", "mujoco")}
    monkeypatch.setattr("tamp.execution.simulators.SIMULATORS", absent)
    with pytest.raises(TampError, match=r"pip install 'mujoco>="):
        require("absent")


def test_naming_simulators_loads_none():
    code = "import sys, tamp.execution.simulators as s; [s.require(n) for n in s.installed()]; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert DEFAULT in SIMULATORS
    assert not {entry.library for entry in SIMULATORS.values()} & set(loaded)


def test_time_passes_in_steps(simulator):
    seen = []
    with make_simulator(simulator, (BOX,)) as world:
        world.on_step = lambda: seen.append(world.time)
        world.step(3)
        assert world.time == pytest.approx(3 * STEP)
    assert seen == pytest.approx([STEP, 2 * STEP, 3 * STEP])


def test_what_falls_obeys_gravity(simulator):
    with make_simulator(simulator, (BOX,), {"box": Pose((0.1, 0.2, 1.0))}) as world:
        world.step(60)
        fallen, (speed, turn) = 1.0 - world.pose("box").xyz[2], world.speeds()["box"]
    assert fallen == pytest.approx(GRAVITY * 0.25**2 / 2, rel=0.03)
    assert speed == pytest.approx(GRAVITY * 0.25, rel=0.02)
    assert turn == pytest.approx(0.0, abs=1e-6)


def test_speeds_can_be_limited(simulator):
    with make_simulator(simulator, (BOX,), {"box": Pose((0.1, 0.2, 1.0))}) as world:
        world.step(60)
        world.limit_speeds(0.1, 0.1)
        assert world.speeds()["box"][0] == pytest.approx(0.1)


def test_what_is_put_somewhere_stands_there_at_rest(simulator):
    there = Pose.from_rpy((0.0, 0.1, 0.5), (0.4, 0.5, 0.6))
    with make_simulator(simulator, (BOX, OTHER)) as world:
        world.step(10)
        other = world.pose("other")
        world.place("box", there)
        assert world.pose("box").matrix == pytest.approx(
            there.matrix, abs=1e-6
        )  # engines may count in single precision
        assert world.speeds()["box"] == pytest.approx((0.0, 0.0))
        assert world.poses() == {"box": world.pose("box"), "other": other}


@given(st.tuples(*[st.floats(-0.07, 0.07)] * 2, st.floats(-3.0, 3.0)), st.sampled_from(["box", "can"]))
@settings(max_examples=6, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_mesh_that_comes_down_askew_lies_flat_and_still(simulator, tmp_path, turn, kind):
    """What an engine forgets of its contacts may leave it rattling from corner to corner, deep in the table."""
    height = 0.036
    shape = trimesh.creation.box((0.11, 0.07, height)) if kind == "box" else trimesh.creation.cylinder(0.03, height)
    shape.export(tmp_path / "shape.obj")
    thing = Object("thing", Mesh(tmp_path / "shape.obj"), Pose.from_rpy((0.1, 0.2, height / 2 + 0.008), turn))
    with make_simulator(simulator, (thing,)) as world:
        world.step(480)
        assert world.pose("thing").xyz[2] == pytest.approx(height / 2, abs=0.001)
        assert max(world.speeds()["thing"]) < 0.02


def test_a_touch_carries_the_weight_of_what_rests(simulator):
    with make_simulator(simulator, (BOX, OTHER)) as world:
        world.step(240)
        touches = [touch for touch in world.touches() if "box" in (touch.a, touch.b)]
    assert {frozenset((touch.a, touch.b)) for touch in touches} == {frozenset(("box", "table"))}
    upward = [touch.force * touch.normal[2] * (1 if touch.a == "box" else -1) for touch in touches]
    assert sum(upward) == pytest.approx(BOX.mass * GRAVITY, rel=0.05)
    for touch in touches:
        assert abs(touch.normal[2]) == pytest.approx(1.0, abs=1e-3)
        assert abs(touch.depth) < 0.002
        assert math.dist(touch.point[:2], BOX.pose.xyz[:2]) < 0.04 and abs(touch.point[2]) < 0.002


def test_the_arm_follows_and_the_fingers_open_and_close(simulator):
    spec = load_robot("panda")
    with make_simulator(simulator, (BOX,), robot=spec) as world:
        robot = world.robot
        assert robot.spec is spec
        assert robot.configuration() == pytest.approx(spec.home, abs=SINGLE)
        assert robot.opening() == pytest.approx(spec.gripper.stroke)
        there = (0.02, *spec.home[1:])
        robot.command(there)
        world.step(120)
        assert robot.configuration() == pytest.approx(there, abs=1e-3)
        robot.open_to(0.03)
        assert wait(world, 2.0, lambda: abs(robot.opening() - 0.03) < 5e-4)
        robot.squeeze(20.0)
        world.step(240)
        assert robot.opening() < 0.002
        assert robot.finger_speed() < 0.005
        assert robot.touching("box") == (False, False)


def test_what_moves_needs_no_hull(simulator, tmp_path):
    """An arm of two bare links, and fingers on bare bars."""
    arm = re.sub(r'(<link name="column">)<collision>.*?</collision>', r"\1", ARM, flags=re.DOTALL)
    arm = re.sub(r'(<link name="boom">)<collision>.*?</collision>', r"\1", arm, flags=re.DOTALL)
    assert arm.count("<collision>") == ARM.count("<collision>") - 2
    spec = read_robot(write(tmp_path / "bare", arm=arm))
    with make_simulator(simulator, (), robot=spec) as world:
        world.step(120)
        assert world.robot.configuration() == pytest.approx(spec.home, abs=1e-3)
        world.robot.open_to(0.02)
        assert wait(world, 2.0, lambda: abs(world.robot.opening() - 0.02) < 1e-3)


def test_links_may_be_called_as_other_bodies_of_the_world_are(simulator, tmp_path):
    names = {"column": "table", "base": "floor", "flag": "object_0"}
    arm = ARM
    for old, new in names.items():
        assert f'"{old}"' in arm
        arm = arm.replace(f'"{old}"', f'"{new}"')
    spec = read_robot(write(tmp_path / "named", arm=arm))
    with make_simulator(simulator, (BOX,), robot=spec) as world:
        world.step(24)
        assert world.robot.configuration() == pytest.approx(spec.home, abs=1e-3)
        assert any({touch.a, touch.b} == {"box", TABLE} for touch in world.touches())


def test_a_world_without_a_robot_has_none(simulator):
    with make_simulator(simulator, (BOX,)) as world:
        assert world.robot is None
        assert dict(world.objects) == {"box": BOX}


def test_mujoco_warns_through_the_log_and_writes_nothing_where_the_user_stands(tmp_path, monkeypatch, caplog):
    pytest.importorskip("mujoco")
    monkeypatch.chdir(tmp_path)
    with make_simulator("mujoco", [BOX], {"box": Pose((1e12, 0.0, 0.1))}) as simulator:
        simulator.step()
    assert "MuJoCo: " in caplog.text
    assert not list(tmp_path.iterdir())


def idle_driver(folder):
    """The swinging robot with a hand whose driver is a knob beside the fingers, which both mimic."""
    path = write(folder, ROBOT.replace("joints: [h_left_swing]", "joints: [h_crank]"))
    hand = folder / "urdf" / "hand.urdf"
    text = hand.read_text().replace('<mimic joint="left_swing"/>', '<mimic joint="crank"/>')
    text = re.sub(r'(name="left_swing" .*?<limit[^>]*/>)', r'\1<mimic joint="crank"/>', text, count=1, flags=re.DOTALL)
    knob = """<link name="knob"/><joint name="crank" type="revolute"><parent link="palm"/><child link="knob"/>
      <axis xyz="1 0 0"/><limit lower="0" upper="0.8" effort="9" velocity="2"/></joint></robot>"""
    hand.write_text(text.replace("</robot>", knob))
    return read_robot(path)


def test_fingers_that_mimic_an_idle_link_press_no_harder_than_told(simulator, tmp_path):
    spec = idle_driver(tmp_path / "idle")
    assert spec.gripper.joints[0] == "h_crank" and len(spec.gripper.joints) == 5
    with make_simulator(simulator, (), robot=spec) as world:
        tool = world.robot.tool()
    block = Object("block", Box((0.03, 0.036, 0.03)), tool, mass=0.05)
    with make_simulator(simulator, (block,), robot=spec) as world:
        world.robot.squeeze(10.0)
        world.step(48)
        assert all(world.robot.touching("block"))
        world.step(48)
        assert world.robot.opening() == pytest.approx(0.036, abs=0.0015)


def test_links_that_swing_hold_a_block_between_pads_that_stay_where_the_linkage_has_them(simulator, tmp_path):
    robot = read_robot(write(tmp_path / "swinging"))
    depth = float(linkage(robot).depth(0.02))
    block = Object("block", Box((0.02, 0.02, 0.02)), Pose(), mass=0.1)
    with make_simulator(simulator, (block,), robot=robot) as world:
        world.robot.squeeze(robot.gripper.force)
        for _ in range(round(1.0 / STEP)):
            world.place("block", world.robot.tool() @ Pose((0.0, 0.0, depth)))
            world.step()
        world.step(round(1.0 / STEP))
        assert all(world.robot.touching("block"))
        assert world.robot.opening() == pytest.approx(0.02, abs=1e-3)
        x, y, z = (world.robot.tool().inverse() @ world.pose("block")).xyz
        assert math.hypot(x, y, z - depth) < 1e-3


@pytest.mark.parametrize("mass", [0.03, 0.1, 0.3])
def test_what_is_light_gives_way_no_more_in_mujoco_where_fingers_squeeze_it_with_all_their_force(mass):
    pytest.importorskip("mujoco")
    spec = load_robot("panda")
    with make_simulator("mujoco", (), robot=spec) as world:
        tool = world.robot.tool()
    block = Object("block", Box((0.03, 0.04, 0.03)), tool, mass=mass)
    with make_simulator("mujoco", (block,), robot=spec) as world:
        world.robot.squeeze(spec.gripper.force)
        for _ in range(240):
            world.place("block", tool)
            world.step()
        world.step(240)
        assert world.robot.opening() == pytest.approx(0.04, abs=5e-4)


def test_what_slides_in_mujoco_stays_on_the_table_and_stops_as_friction_has_it():
    pytest.importorskip("mujoco")
    flat = Object("flat", Box((0.17, 0.11, 0.045)), Pose((-0.2, 0.0, 0.0225)))
    with make_simulator("mujoco", (flat,)) as world:
        world.step(60)
        start, speed = world.pose("flat"), 0.17
        world._data.qvel[world._v["flat"]] = speed
        while max(world.speeds()["flat"]) > 0.01:
            world.step()
            assert world.pose("flat").xyz[2] < 0.0225
            assert any({touch.a, touch.b} == {"flat", TABLE} for touch in world.touches())
        world.step(60)
        way = world.pose("flat").xyz[0] - start.xyz[0]
        assert way == pytest.approx(speed**2 / (2 * flat.friction * GRAVITY), rel=0.1)


@pytest.mark.parametrize(("mass", "friction", "aside"), [(1.2, 0.31, 0.017), (1.4, 0.3, -0.005)])
def test_fingers_hold_in_mujoco_what_is_ten_times_as_heavy_as_they_are(mass, friction, aside):
    pytest.importorskip("mujoco")
    start, end = Pose((0.05, -0.2, 0.03)), Pose((0.05, 0.2, 0.03))
    task, plan = alone(Box((0.05, 0.05, 0.06)), start, end, 0.05, 0.005, aside, mass=mass, friction=friction)
    done = execute(task, plan, monitor=None, simulator="mujoco")
    assert math.dist(done.final_poses["red"].xyz, end.xyz) < 0.0025


def test_what_sticks_as_nothing_real_does_stays_in_the_hand_in_mujoco():
    """It was thrown 63 m away, by the cone of a friction that tasks may have."""
    pytest.importorskip("mujoco")
    start, end = Pose((0.05, -0.1, 0.04)), Pose((0.05, 0.1, 0.04))
    task, plan = alone(Box((0.05, 0.05, 0.08)), start, end, 0.05, 0.01, mass=0.3, friction=1e6)
    done = execute(task, plan, monitor=None, simulator="mujoco")
    assert math.dist(done.final_poses["red"].xyz, end.xyz) < 0.0025


def test_what_slides_down_a_ramp_in_mujoco_stays_on_it_and_gets_as_fast_as_friction_lets_it(tmp_path):
    """The friction of two objects is the product of their coefficients."""
    pytest.importorskip("mujoco")
    angle, high = 0.6, 0.6 * math.tan(0.6)
    corners = [(x, y, z) for y in (-0.1, 0.1) for x, z in ((0.0, 0.0), (0.6, 0.0), (0.0, high))]
    trimesh.convex.convex_hull(corners).export(tmp_path / "ramp.obj")
    ramp = Object("ramp", Mesh(tmp_path / "ramp.obj"), Pose((-0.2, 0.0, 0.0)), mass=1000.0, friction=0.6)
    start = ramp.pose @ Pose.from_rpy((0.0, 0.0, high), (0.0, angle, 0.0)) @ Pose((0.1, 0.0, 0.02))
    flat = Object("flat", Box((0.08, 0.08, 0.04)), start, mass=0.2, friction=0.5)
    with make_simulator("mujoco", (ramp, flat)) as world:
        for _ in range(96):
            world.step()
            assert sum(touch.force for touch in world.touches() if {touch.a, touch.b} == {"flat", "ramp"}) > 0.0
        pull = GRAVITY * (math.sin(angle) - 0.6 * 0.5 * math.cos(angle))
        assert world.speeds()["flat"][0] == pytest.approx(0.4 * pull, rel=0.02)
        assert math.dist(world.pose("flat").xyz, start.xyz) == pytest.approx(pull * 0.4**2 / 2, rel=0.02)


@pytest.mark.parametrize("pads", [None, ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))])
def test_what_is_held_stays_where_it_is_in_a_hand_that_swings_round(simulator, pads):
    """Also where the file of a gripper whose fingers slide says where their pads are."""
    spec = load_robot("panda")
    spec = replace(spec, gripper=replace(spec.gripper, pads=pads))
    with make_simulator(simulator, (), robot=spec) as world:
        tool = world.robot.tool()
    block = Object("block", Box((0.03, 0.04, 0.03)), tool, mass=0.1)
    with make_simulator(simulator, (block,), robot=spec) as world:
        operator = Operator(world)
        world.robot.squeeze(20.0)
        for _ in range(120):
            world.place("block", tool)
            world.step()
        world.step(60)
        operator.held, held = Attachment("block", Pose()), operator.in_tool("block")
        aside = (0.8, *spec.home[1:])
        for there, back in ((spec.home, aside), (aside, spec.home)):
            operator.follow(timed(np.array([there, back]), spec, share=0.5))
            assert math.dist(operator.in_tool("block").xyz, held.xyz) < 2e-4


def test_a_library_that_another_thread_is_importing_is_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two pictures that a server drew at once were none."""
    monkeypatch.setitem(sys.modules, "half_imported", types.ModuleType("half_imported"))
    assert Entry("half_imported:Simulator", "half_imported").installed
    assert not Entry("nowhere:Simulator", "nowhere").installed


def test_a_library_that_must_not_be_imported_is_not_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    class Refuses:
        def find_spec(self, name: str, *about: object) -> None:
            raise ImportError(f"{name} must not be imported")

    monkeypatch.setattr(sys, "meta_path", [Refuses(), *sys.meta_path])
    assert not Entry("refused:Simulator", "refused").installed
