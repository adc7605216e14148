import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tamp.errors import PlanError
from tamp.execution.controller import Operator
from tamp.execution.executor import WATCHFUL, execute, open_execution
from tamp.execution.monitor import angle_between
from tamp.execution.settling.settle import settle
from tamp.execution.simulators import make_simulator
from tamp.task import (
    Action,
    Box,
    Cylinder,
    Grip,
    Limits,
    Mesh,
    Move,
    Object,
    Pose,
    Release,
    Task,
    Trajectory,
    load_robot,
)
from tamp.task.mesh.parts import bounds, parts
from tests.execution.planning_by_hand import DOWN, HandPlanner

OBJECTS = Path(__file__).parents[2] / "scenarios" / "objects"
GOAL = Pose.from_rpy((0.12, -0.22, 0.04), (0, 0, -0.4))


def box_task(*more):
    box = Object("box", Box((0.05, 0.05, 0.08)), Pose.from_rpy((0.1, 0.2, 0.04), (0, 0, 0.3)))
    return Task("box", (box, *more))


def grip_above(depth):
    """A grasp from above, the tool `depth` [m] over the object's origin."""
    return Pose((0, 0, depth)) @ DOWN


def move_one(task, name, grasp, width, goal, **planned):
    hand = HandPlanner(task, settle(task).poses)
    hand.pick(name, grasp, width, **planned)
    hand.place(goal)
    return hand.plan()


def test_a_box_is_placed_to_a_millimetre(simulator):
    task = box_task()
    plan = move_one(task, "box", grip_above(0.02), 0.05, GOAL)
    run = execute(task, plan, simulator=simulator)
    assert run.status == "done"
    assert (run.grasps_attempted, run.grasps_succeeded) == (1, 1)
    assert math.dist(run.final_poses["box"].xyz, GOAL.xyz) < 0.001
    assert angle_between(run.final_poses["box"], GOAL) < 0.02
    assert [entry.name for entry in run.log] == ["pick(box)", "place(box)"]
    assert max(entry.tracking_error for entry in run.log) < 0.005
    assert run.sim_s > plan.duration


@pytest.mark.parametrize("yaw", [-2.0, -0.7, 0.7, 2.0])
@pytest.mark.parametrize("shape", [Box((0.05, 0.05, 0.08)), Cylinder(0.03, 0.1)], ids=["box", "cylinder"])
def test_what_is_held_does_not_tip_over_while_the_hand_turns(simulator, shape, yaw):
    """Contact points whose normals do not turn with the hand tip it over by two degrees and more."""
    z = -float(bounds(shape)[0][2])
    task = Task("one", (Object("thing", shape, Pose((0.1, 0.2, z))),))
    plan = move_one(task, "thing", grip_above(0.02), 0.06, Pose.from_rpy((0.12, -0.22, z), (0, 0, yaw)))
    with make_simulator(simulator, task.objects, plan.start, robot=load_robot("panda"), q=plan.home) as world:
        operator = Operator(world)
        for step in plan.steps:
            if isinstance(step, Grip):
                assert operator.grip(step) is None
            elif isinstance(step, Release):
                break
            else:
                operator.move(step)
        assert operator.held is not None
        upright = operator.in_tool("thing").matrix[2, 2]
    assert math.acos(min(1.0, -upright)) < 0.015


def test_fingers_close_gently_and_hold_as_firmly_as_the_plan_says(simulator, monkeypatch):
    task = box_task()
    plan = move_one(task, "box", grip_above(0.02), 0.05, GOAL)
    with make_simulator(simulator, task.objects, plan.start, robot=load_robot("panda"), q=plan.home) as world:
        operator, forces = Operator(world), []
        squeeze = operator.robot.squeeze
        monkeypatch.setattr(type(operator.robot), "squeeze", lambda _, force: (forces.append(force), squeeze(force))[1])
        for step in plan.steps:
            if isinstance(step, Grip):
                assert operator.grip(replace(step, force=45.0)) is None
                assert forces == [20.0, 45.0]
            elif isinstance(step, Release):
                operator.release(step)
            else:
                operator.move(step)
        assert forces == [20.0, 45.0, 20.0]
        assert math.dist(world.pose("box").xyz, GOAL.xyz) < 0.003


def test_the_same_plan_ends_the_same_to_the_last_bit(simulator):
    task = box_task()
    plan = move_one(task, "box", grip_above(0.02), 0.05, GOAL)
    first, second = execute(task, plan, simulator=simulator), execute(task, plan, simulator=simulator)
    assert first.final_poses == second.final_poses
    assert first.configuration == second.configuration


@pytest.mark.parametrize(
    ("shape", "grasp", "width"),
    [
        (Cylinder(0.033, 0.1), grip_above(0.02), 0.066),
        (Box((0.12, 0.03, 0.03)), grip_above(0.0), 0.03),
        (Mesh(OBJECTS / "can" / "collision.obj"), grip_above(0.025), 0.066),
    ],
    ids=["cylinder", "bar", "can"],
)
def test_other_shapes_arrive_too(simulator, shape, grasp, width):
    z = -float(bounds(shape)[0][2])
    task = Task("one", (Object("thing", shape, Pose((0.1, 0.2, z))),))
    goal = Pose.from_rpy((0.1, -0.2, z), (0, 0, 0.5))
    run = execute(task, move_one(task, "thing", grasp, width, goal), simulator=simulator)
    assert run.status == "done"
    assert math.dist(run.final_poses["thing"].xyz, goal.xyz) < 0.003


def test_a_cup_is_carried_by_its_rim(simulator):
    cup = Mesh(OBJECTS / "cup" / "collision.obj")
    lower, upper = bounds(cup)
    points = np.concatenate([part.vertices for part in parts(cup)])
    rim = points[points[:, 2] > upper[2] - 0.002]
    radius = float(np.linalg.norm(rim[:, :2], axis=1).mean())
    task = Task("cup", (Object("cup", cup, Pose((0.1, 0.2, -float(lower[2])))),))
    goal = Pose((0.1, -0.2, -float(lower[2])))
    grasp = Pose((0.0, radius, float(upper[2]) - 0.008)) @ DOWN
    # In SAPIEN the cup hangs more askew from its rim when it is let go, and leans on the finger that opens.
    leans = simulator == "sapien"
    plan = move_one(task, "cup", grasp, 0.005, goal, opening=0.04)
    run = execute(task, plan, simulator=simulator, monitor=None if leans else WATCHFUL)
    assert run.status == "done"
    assert math.dist(run.final_poses["cup"].xyz, goal.xyz) < (0.01 if leans else 0.006)
    assert run.final_poses["cup"].matrix[2, 2] > math.cos(0.02)
    assert abs(run.final_poses["cup"].matrix[1, 0]) < 0.05  # nothing kicks it as the fingers part


def test_a_tower_is_built(simulator):
    boxes = [Object(f"b{i}", Box((0.05, 0.05, 0.05)), Pose((0.0 + 0.12 * i, 0.2, 0.025))) for i in range(3)]
    task = Task("tower", tuple(boxes))
    hand = HandPlanner(task, settle(task).poses)
    for level, name in enumerate(("b1", "b2")):
        hand.pick(name, grip_above(0.01), 0.05)
        hand.place(Pose((0.0, 0.2, 0.075 + 0.05 * level)))
    run = execute(task, hand.plan(), simulator=simulator)
    assert run.status == "done"
    assert run.grasps_succeeded == 2
    assert run.final_poses["b2"].xyz == pytest.approx((0.0, 0.2, 0.125), abs=0.002)


def test_a_missed_grasp_stops_the_plan_with_the_hand_drawn_back(simulator):
    task = box_task()
    start = dict(settle(task).poses)
    elsewhere = {"box": Pose((0.1, 0.3, 0.04))}
    hand = HandPlanner(task, start)
    hand.pick("box", grip_above(0.02), 0.05)
    hand.place(GOAL)
    plan = hand.plan()
    with open_execution(task, elsewhere, simulator=simulator) as session:
        run = session.carry_out(plan)
        assert run.status == "deviated"
        assert run.deviation is not None and run.deviation.kind == "missed"
        assert (run.grasps_attempted, run.grasps_succeeded) == (1, 0)
        assert len(run.log) == 1
        lift = plan.actions[0].steps[-1]
        assert np.abs(np.array(session.configuration()) - lift.trajectory.positions[-1]).max() < 0.01


def test_what_hangs_in_a_hand_that_lost_it_falls_out_before_anything_is_planned_anew(simulator, monkeypatch):
    answers = iter([True, True])
    task = box_task()
    plan = move_one(task, "box", grip_above(0.02), 0.05, GOAL)
    pick, place = plan.actions
    carried = tuple(step for step in place.steps if isinstance(step, Move) and step.phase == "transfer")
    plan = replace(plan, actions=(pick, Action("move", ("box",), carried)))
    with open_execution(task, plan.start, plan.home, simulator=simulator) as session:
        body = type(session._operator.robot)
        touching = body.touching

        def one_finger_only_later_on(self, name):
            return touching(self, name) if next(answers, False) else (True, False)

        monkeypatch.setattr(body, "touching", one_finger_only_later_on)
        run = session.carry_out(plan)
    assert (run.status, run.deviation.kind) == ("deviated", "dropped")
    assert run.final_poses["box"].xyz[2] < 0.05


def test_a_plan_goes_on_from_where_the_last_one_stopped(simulator):
    task = box_task()
    believed = dict(settle(task).poses)
    with open_execution(task, {"box": Pose((0.1, 0.3, 0.04))}, simulator=simulator) as session:
        first = HandPlanner(task, believed)
        first.pick("box", grip_above(0.02), 0.05)
        assert session.carry_out(first.plan()).status == "deviated"
        second = HandPlanner(task, session.poses(), q=session.configuration())
        second.pick("box", grip_above(0.02), 0.05)
        second.place(GOAL)
        run = session.carry_out(second.plan())
    assert run.status == "done"
    assert math.dist(run.final_poses["box"].xyz, GOAL.xyz) < 0.001


def test_a_neighbour_pushed_aside_stops_the_plan_once_the_hand_is_empty(simulator):
    neighbour = Object("neighbour", Box((0.03, 0.03, 0.12)), Pose((0.12, -0.15, 0.06)))
    task = box_task(neighbour)
    hand = HandPlanner(task, settle(task).poses)
    hand.pick("box", grip_above(0.02), 0.05)
    hand.place(Pose((0.12, -0.15, 0.04)))
    hand.pick("box", grip_above(0.02), 0.05, pose=GOAL)
    run = execute(task, hand.plan(), simulator=simulator)
    assert run.status == "deviated"
    assert [entry.name for entry in run.log] == ["pick(box)", "place(box)"]
    assert "neighbour" in {d.object for d in run.log[-1].deviations}


def test_without_a_monitor_a_plan_runs_to_its_end(simulator):
    task = box_task()
    plan = move_one(task, "box", grip_above(0.02), 0.05, GOAL)
    wrong = replace(plan, start={"box": Pose((0.3, 0.3, 0.04))})
    assert execute(task, plan, monitor=None, simulator=simulator).status == "done"
    with open_execution(task, plan.start, monitor=None, simulator=simulator) as session:
        assert session.carry_out(wrong).status == "done"


def test_the_time_limit_holds(simulator):
    task = replace(box_task(), limits=Limits(execution_sim_s=0.5))
    run = execute(task, move_one(task, "box", grip_above(0.02), 0.05, GOAL), simulator=simulator)
    assert run.status == "timeout"
    assert len(run.log) == 1


def test_a_plan_that_starts_elsewhere_is_refused(simulator):
    task = box_task()
    plan = move_one(task, "box", grip_above(0.02), 0.05, GOAL)
    with open_execution(task, plan.start, simulator=simulator) as session:
        with pytest.raises(PlanError, match=r"the plan starts 0\.500 rad from where the arm stands"):
            session.carry_out(replace(plan, home=(0.5, *plan.home[1:])))
        with pytest.raises(PlanError, match="the plan is about 'cup'; the scene has box"):
            session.carry_out(replace(plan, start={"cup": Pose()}))


def test_a_plan_for_another_arm_or_of_no_motions_is_refused_in_a_sentence(simulator):
    """As `tamp execute --unchecked` meets it, and code that does not ask the checker."""
    task = box_task()
    plan = move_one(task, "box", grip_above(0.02), 0.05, GOAL)

    def edited(change):
        return replace(plan, actions=tuple(replace(a, steps=tuple(map(change, a.steps))) for a in plan.actions))

    def six_joints(step):
        t = step.trajectory if isinstance(step, Move) else None
        return (
            step
            if t is None
            else replace(step, trajectory=Trajectory(t.times, t.positions[:, :6], t.velocities[:, :6]))
        )

    def at_once(step):
        t = step.trajectory if isinstance(step, Move) else None
        return step if t is None else replace(step, trajectory=Trajectory(0.0 * t.times, t.positions, t.velocities))

    def another(step):
        return replace(step, attachment=replace(step.attachment, object="cup")) if isinstance(step, Grip) else step

    with pytest.raises(PlanError, match="the arm is to start from 6 joint positions; robot 'panda' has 7"):
        execute(task, replace(plan, home=plan.home[:6]), simulator=simulator)
    for change, message in (
        (six_joints, "a transit motion is none of 7 joints"),
        (at_once, "at times that increase"),
        (another, "the plan is about 'cup'; the scene has box"),
    ):
        with pytest.raises(PlanError, match=message):
            execute(task, edited(change), simulator=simulator)


def test_jitter_follows_the_seed(simulator):
    task = box_task()
    start = settle(task).poses

    def begin(seed, jitter):
        with open_execution(task, start, seed=seed, jitter=jitter, simulator=simulator) as session:
            return session.poses()["box"].xyz

    assert begin(1, 0.01) == begin(1, 0.01) != begin(2, 0.01)
    assert begin(1, 0.0) == pytest.approx(start["box"].xyz)


def test_frames_are_recorded_at_equal_times(simulator):
    task = box_task()
    plan = move_one(task, "box", grip_above(0.02), 0.05, GOAL)
    run = execute(task, plan, frame_s=0.5, simulator=simulator)
    gaps = np.diff([frame.time for frame in run.frames])
    assert gaps == pytest.approx(0.5)
    assert len(run.frames) == pytest.approx(run.sim_s / 0.5, abs=2)
    assert min(frame.opening for frame in run.frames) < 0.052
