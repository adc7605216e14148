from __future__ import annotations

import math

import numpy as np
import pytest

from tamp.execution.action_execution import PUT_BACK
from tamp.execution.controller import Operator, backwards, positions_at
from tamp.execution.executor import execute, open_execution
from tamp.execution.log import Deviation
from tamp.execution.monitor import Monitor
from tamp.execution.recovery import CLEAR, can_carry, opening_out, undone, way_out
from tamp.execution.settling.settle import settle
from tamp.task import Attachment, Box, Grip, Move, Object, Pose, Release, Task, load_robot
from tamp.world.geometry.object_geometry import load_geometry
from tamp.world.robot.model import robot_model
from tamp.world.scene import Scene
from tamp.world.world import World
from tests.execution.planning_by_hand import DOWN, HandPlanner

BOARD = Object("board", Box((0.03, 0.12, 0.03)), Pose((0.1, 0.2, 0.015)))
POST = Object("post", Box((0.02, 0.02, 0.1)), Pose((0.1, -0.11, 0.05)))
GOAL = Pose((0.1, -0.2, 0.015))
TASK = Task("board and post", (BOARD, POST))


AS_PLANNED = Pose()


def carried(turn=AS_PLANNED, post=POST.pose):
    """Whether the board, which `turn` took from where it should lie in the hand, can be carried past the post."""
    poses = dict(settle(TASK).poses)
    hand = HandPlanner(TASK, poses)
    hand.pick("board", DOWN, 0.03)
    hand.place(GOAL)
    steps = [step for action in hand.plan().actions for step in action.steps]
    grip = next(i for i, step in enumerate(steps) if isinstance(step, Grip))
    held = Attachment("board", turn @ steps[grip].attachment.T_tool_object)
    world = World(robot_model(load_robot("panda")), {o.name: load_geometry(o.shape) for o in TASK.objects}, TASK.table)
    return can_carry(world, {**poses, "post": post}, held, steps[grip + 1 :])


def test_what_lies_in_the_hand_as_planned_can_be_carried():
    assert carried()


def test_what_would_be_put_into_something_cannot():
    assert not carried(post=Pose((0.1, -0.2, 0.05)))


@pytest.mark.parametrize(("angle", "free"), [(0.0, True), (np.pi / 2, False)])
def test_the_object_counts_as_it_lies_in_the_hand_now(angle, free):
    assert carried(Pose.from_rpy((0, 0, 0), (0, 0, angle)), post=Pose((0.145, -0.2, 0.05))) == free


def test_the_table_does_not_count():
    assert carried(Pose((0.0, 0.0, 0.02)))


BLOCK = Object("block", Box((0.05, 0.05, 0.08)), Pose((0.1, 0.2, 0.04)))
GRASP = Pose((0, 0, 0.02)) @ DOWN
RECOVERY_GOAL = Pose((0.1, -0.2, 0.04))


def planned(task, name, grasp, width, goal):
    hand = HandPlanner(task, settle(task).poses)
    hand.pick(name, grasp, width)
    hand.place(goal)
    return hand.plan()


def test_a_motion_backwards_passes_the_same_places():
    plan = planned(Task("one", (BLOCK,)), "block", GRASP, 0.05, RECOVERY_GOAL)
    there = plan.actions[0].steps[1].trajectory
    back = backwards(there)
    times = np.linspace(0.0, there.duration, 50)
    assert back.times[0] == 0.0
    assert positions_at(back, times) == pytest.approx(positions_at(there, there.duration - times))


def test_a_pick_is_taken_back_step_by_step():
    approach, grip, lift = planned(Task("one", (BLOCK,)), "block", GRASP, 0.05, RECOVERY_GOAL).actions[0].steps[1:]
    lower, release, retreat = undone((approach, grip, lift), BLOCK.pose)
    assert isinstance(lower, Move) and (lower.phase, lower.held) == ("lower", lift.held)
    assert isinstance(release, Release) and (release.object, release.pose) == ("block", BLOCK.pose)
    assert isinstance(retreat, Move) and (retreat.phase, retreat.opening) == ("retreat", approach.opening)
    assert (lower.trajectory.positions[-1] == lift.trajectory.positions[0]).all()
    assert (retreat.trajectory.positions[-1] == approach.trajectory.positions[0]).all()
    assert isinstance(grip, Grip) and release.opening == approach.opening


def test_what_turns_in_the_fingers_and_is_in_the_way_is_put_back_and_only_so_often(simulator, monkeypatch):
    """A monitor for whom whatever is held has slipped."""
    task = Task("one", (BLOCK,))
    monkeypatch.setattr("tamp.execution.executor.can_carry", lambda *_: False)
    with open_execution(task, settle(task).poses, monitor=Monitor(slip=-1.0), simulator=simulator) as execution:
        for attempt in range(PUT_BACK + 1):
            hand = HandPlanner(task, execution.poses(), q=execution.configuration())
            hand.pick("block", GRASP, 0.05)
            hand.place(RECOVERY_GOAL)
            run = execution.carry_out(hand.plan())
            if attempt < PUT_BACK:
                assert run.status == "deviated"
                assert run.deviation is not None and (run.deviation.object, run.deviation.kind) == ("block", "slipped")
                assert [entry.name for entry in run.log] == ["pick(block)"]
                assert math.dist(run.final_poses["block"].xyz, BLOCK.pose.xyz) < 0.003
    assert run.status == "done"
    assert math.dist(run.final_poses["block"].xyz, RECOVERY_GOAL.xyz) < 0.003


@pytest.mark.parametrize(("angle", "asked"), [(0.04, False), (0.1, True)])
def test_what_turned_a_little_is_put_back_where_it_would_meet_something_on_its_way(monkeypatch, angle, asked):
    """Where it is put down it may: it gives way there."""
    in_tool, phases = Operator.in_tool, list[str]()

    def meets(world, poses, held, steps):
        phases.extend(step.phase for step in steps)
        return False

    turned = Pose.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, angle))
    monkeypatch.setattr("tamp.execution.executor.can_carry", meets)
    monkeypatch.setattr(Operator, "in_tool", lambda self, name: turned @ in_tool(self, name))
    task = Task("one", (BLOCK,))
    run = execute(task, planned(task, "block", GRASP, 0.05, RECOVERY_GOAL))
    assert set(phases) == ({"transfer"} if asked else set())
    assert (run.deviation is not None and run.deviation.kind == "slipped") == asked


def test_what_turns_in_the_fingers_but_meets_nothing_is_carried_on(simulator):
    task = Task("one", (BLOCK,))
    run = execute(
        task, planned(task, "block", GRASP, 0.05, RECOVERY_GOAL), monitor=Monitor(slip=-1.0), simulator=simulator
    )
    assert run.status == "done"
    assert run.log[0].deviations[0].kind == "slipped"
    assert math.dist(run.final_poses["block"].xyz, RECOVERY_GOAL.xyz) < 0.003


def test_a_hand_that_lost_its_object_on_the_way_down_draws_back(simulator, monkeypatch):
    task = Task("one", (BLOCK,))
    plan = planned(task, "block", GRASP, 0.05, RECOVERY_GOAL)
    lost, move, phases = Operator.lost, Operator.move, []

    def noted(self, step):
        phases.append(step.phase)
        move(self, step)

    def dropped(self, kind="dropped"):
        if phases[-1] != "lower" or self.held is None:
            return lost(self, kind)
        self.held = None
        return Deviation("block", kind, 0.03, 0.0)

    monkeypatch.setattr(Operator, "move", noted)
    monkeypatch.setattr(Operator, "lost", dropped)
    run = execute(task, plan, simulator=simulator)
    assert run.status == "deviated"
    assert run.deviation is not None and run.deviation.kind == "dropped"
    end = plan.actions[1].steps[-1].trajectory.positions[-1]
    assert np.abs(np.array(run.configuration) - end).max() < 0.01


def test_an_arm_that_touches_something_leaves_it_by_the_shortest_way():
    world = World(robot_model(load_robot("panda")), {"block": load_geometry(BLOCK.shape)})
    hand = HandPlanner(Task("one", (BLOCK,)), {"block": BLOCK.pose})
    hand.pick("block", GRASP, 0.05)
    inside = hand.actions[0].steps[1].trajectory.positions[-1]
    beside = {"block": Pose((0.1, 0.23, 0.04))}  # a finger is in it by now
    path = way_out(world, beside, inside)
    assert path is not None
    assert path[0] == pytest.approx(inside)
    checker = world.checker(Scene({"block": beside["block"].matrix}, opening=0.08), margin=CLEAR)
    assert checker.free(path[-1]) and not checker.free(path[-2])
    assert way_out(world, beside, path[-1]) is None


def test_open_fingers_leave_what_is_between_them_since_they_may_close():
    world = World(robot_model(load_robot("panda")), {"block": load_geometry(BLOCK.shape)})
    hand = HandPlanner(Task("one", (BLOCK,)), {"block": BLOCK.pose})
    hand.pick("block", GRASP, 0.05)
    around = hand.actions[0].steps[1].trajectory.positions[-1]
    path = way_out(world, {"block": BLOCK.pose}, around)
    assert path is not None
    for opening in (0.0, 0.03, 0.08):
        checker = world.checker(Scene({"block": BLOCK.pose.matrix}, opening=opening), margin=CLEAR)
        assert checker.free(path[-1])


def test_fingers_leave_what_they_would_only_pass_as_they_close():
    pole = Object("pole", Box((0.005, 0.005, 0.08)), BLOCK.pose)
    world = World(robot_model(load_robot("panda")), {"pole": load_geometry(pole.shape)})
    hand = HandPlanner(Task("one", (BLOCK,)), {"block": BLOCK.pose})
    hand.pick("block", GRASP, 0.05)
    around = hand.actions[0].steps[1].trajectory.positions[-1]
    T = world.robot.forward(around)
    aside = {"pole": Pose(tuple(T[:3, 3] + 0.031 * T[:3, 1] - [0.0, 0.0, 0.02]))}
    scenes = {opening: Scene({"pole": aside["pole"].matrix}, opening=opening) for opening in (0.0, 0.03, 0.08)}
    assert [world.checker(scene, margin=CLEAR).free(around) for scene in scenes.values()] == [True, False, True]
    assert way_out(world, aside, around) is not None


def test_an_arm_that_something_came_after_leaves_it_another_way():
    world = World(robot_model(load_robot("panda")), {"block": load_geometry(BLOCK.shape)})
    hand = HandPlanner(Task("one", (BLOCK,)), {"block": BLOCK.pose})
    hand.pick("block", GRASP, 0.05)
    around = hand.actions[0].steps[1].trajectory.positions[-1]
    poses = {"block": BLOCK.pose}
    ends = [tuple(way_out(world, poses, around, tried)[-1]) for tried in range(3)]
    assert len(set(ends)) == 3
    checker = world.checker(Scene({"block": BLOCK.pose.matrix}, opening=0.08), margin=CLEAR)
    assert all(checker.free(np.array(q)) for q in ends)


@pytest.mark.parametrize(("beside", "opens"), [(0.056, False), (0.075, True)])
def test_a_hand_opens_wide_as_it_leaves_what_it_touches_unless_it_meets_another_so(beside, opens):
    pole = Object("pole", Box((0.005, 0.005, 0.03)), BLOCK.pose)
    world = World(
        robot_model(load_robot("panda")), {"block": load_geometry(BLOCK.shape), "pole": load_geometry(pole.shape)}
    )
    hand = HandPlanner(Task("one", (BLOCK,)), {"block": BLOCK.pose})
    hand.pick("block", GRASP, 0.05)
    around = hand.actions[0].steps[1].trajectory.positions[-1]
    T = world.robot.forward(around)
    poses = {"block": BLOCK.pose, "pole": Pose(tuple(T[:3, 3] + beside * T[:3, 1] - [0.0, 0.0, 0.005]))}
    assert opening_out(world, poses, around, 0.041) == (0.08 if opens else 0.041)


def test_an_arm_that_is_free_stays():
    world = World(robot_model(load_robot("panda")), {"block": load_geometry(BLOCK.shape)})
    assert way_out(world, {"block": BLOCK.pose}, np.array(world.robot.home)) is None


@pytest.mark.parametrize("share", [0.5, None])
def test_the_empty_hand_does_not_set_out_towards_what_stands_in_its_way_by_now(share):
    """A post that the plan has far away stands where the hand comes by, or nowhere near."""
    task = Task("one in the way", (BLOCK, POST))
    hand = HandPlanner(task, {"block": BLOCK.pose, "post": POST.pose})
    hand.pick("block", GRASP, 0.05)
    hand.place(RECOVERY_GOAL)
    plan = hand.plan()
    way, stands = plan.actions[0].steps[0].trajectory.positions, Pose((0.1, -0.4, 0.05))
    if share is not None:
        x, y, z = robot_model(load_robot("panda")).forward(way[int(share * len(way))])[:3, 3]
        post = Object("post", Box((0.02, 0.02, 2 * z)), POST.pose)
        task, stands = Task("one in the way", (BLOCK, post)), Pose((x, y, z))
    with open_execution(task, {"block": BLOCK.pose, "post": stands}) as execution:
        run = execution.carry_out(plan)
    assert run.status == "deviated" and run.deviation is not None
    assert (run.deviation.object, run.deviation.kind) == ("post", "misplaced" if share is not None else "disturbed")
    assert len(run.log) == (0 if share is not None else len(plan.actions))
    assert math.dist(run.final_poses["post"].xyz, stands.xyz) < 0.002
