import math
from dataclasses import replace

import pybullet
import pytest

import tamp
from tamp.checking import check
from tamp.execution.performer import Performer
from tamp.execution.record import Deviation
from tamp.pipeline.planning import Planning, plan
from tamp.pipeline.remainder import errands, remainder, still_good, worth_doing
from tamp.pipeline.setup import prepare
from tamp.pipeline.solving import carry_out
from tamp.task import At, Attachment, Box, Object, Pose, Task

SIDE = Box((0.05, 0.05, 0.05))
FIRST = Object("first", SIDE, Pose((0.05, 0.2, 0.025)), At(Pose((0.05, -0.1, 0.025))))
SECOND = Object("second", SIDE, Pose((-0.1, 0.2, 0.025)), At(Pose((-0.1, -0.2, 0.025))))
TASK = Task("pair", (FIRST, SECOND))


def shifted(pose, x):
    return Pose((pose.xyz[0] + x, *pose.xyz[1:]), pose.quat)


@pytest.fixture(scope="module")
def pair():
    """A plan for two blocks, and its execution until the first of them is put down."""
    made = plan(TASK, seed=0, timeout=300.0)
    whole = tamp.execute(TASK, made)
    stop = next(i for i, entry in enumerate(whole.log) if entry.name.startswith("place")) + 1
    return made, replace(whole, status="deviated", log=whole.log[:stop])


@pytest.fixture(scope="module")
def setup():
    return prepare(TASK)


def stopped(pair, name, x):
    """The plan and its execution, with an object beside where it should be by then."""
    made, run = pair
    put_down = next(step for action in made.actions[: len(run.log)] for step in action.steps if hasattr(step, "pose"))
    here = dict(made.start) | {put_down.object: put_down.pose}
    here[name] = shifted(here[name], x)
    off = Deviation(name, "disturbed", abs(x), 0.0)
    log = (*run.log[:-1], replace(run.log[-1], deviations=(off,)))
    end = made.actions[len(run.log) - 1].steps[-1].trajectory.positions[-1]
    configuration = tuple(float(q) for q in end)
    return made, replace(run, log=log, deviation=off, final_poses=here, configuration=configuration)


def names(pair):
    """The object that is put down first, and the other one."""
    done = pair[0].actions[len(pair[1].log) - 1].arguments[0]
    return done, ({"first", "second"} - {done}).pop()


def kept(setup, case):
    rest = still_good(setup, *case, math.inf)
    return None if rest is None else [str(action) for action in rest.actions]


def test_what_is_left_starts_from_the_state_as_it_is(setup, pair):
    made, run = stopped(pair, names(pair)[0], 0.015)
    rest = remainder(setup, made, run)
    assert rest.actions == made.actions[len(run.log) :]
    assert rest.start[names(pair)[0]] == run.final_poses[names(pair)[0]]
    assert rest.start[names(pair)[1]] == made.start[names(pair)[1]]
    assert rest.goals == made.goals


def test_what_is_off_is_taken_as_it_is_whether_or_not_that_was_noted(setup, pair):
    made, run = stopped(pair, names(pair)[0], 0.015)
    there = {**run.final_poses, names(pair)[1]: shifted(made.start[names(pair)[1]], 0.2)}
    rest = remainder(setup, made, replace(run, final_poses=there))
    assert rest.start == there


def test_what_was_pushed_stands_where_the_hand_has_pushed_it_to(setup, pair):
    made, run = stopped(pair, names(pair)[0], 0.015)
    (move, *others), pushed = made.actions[0].steps, Attachment(names(pair)[1], Pose((0.0, 0.0, 0.1)))
    slid = replace(made.actions[0], steps=(replace(move, pushed=pushed), *others))
    T = setup.world.robot.forward(move.trajectory.positions[-1])
    there = {**run.final_poses, pushed.object: Pose.from_matrix(T) @ pushed.T_tool_object}
    rest = remainder(setup, replace(made, actions=(slid, *made.actions[1:])), replace(run, final_poses=there))
    assert rest.start[pushed.object] == there[pushed.object]


def test_errands_end_where_the_hand_is_empty(pair):
    made, _ = pair
    cut = list(errands(made.actions))
    assert [action for errand in cut for action in errand] == list(made.actions)
    assert [errand[-1].name for errand in cut] == ["place", "place"]


def test_the_rest_is_good_where_what_is_off_is_not_needed_any_more(setup, pair):
    made, run = stopped(pair, names(pair)[0], 0.015)
    assert still_good(setup, made, run, math.inf).actions == made.actions[len(run.log) :]


def test_the_rest_is_of_no_use_where_its_object_has_moved(setup, pair):
    assert kept(setup, stopped(pair, names(pair)[1], 0.03)) is None


def test_an_errand_that_has_become_wrong_is_left_out_and_the_arm_goes_on_to_the_next(setup, pair):
    """The object of the first errand has moved before anything was done."""
    made, run = pair
    first, _ = names(pair)
    there = {**made.start, first: shifted(made.start[first], 0.03)}
    off = Deviation(first, "disturbed", 0.03, 0.0)
    begun = replace(run, log=(), deviation=off, final_poses=there, configuration=made.home)
    rest = still_good(setup, made, begun, math.inf)
    assert [str(action) for action in rest.actions] == [str(action) for action in made.actions[len(run.log) :]]
    assert rest.actions[1:] == made.actions[len(run.log) + 1 :]
    assert rest.start == there
    assert check(TASK, rest, start=there, goals=rest.goals).executable


def test_a_new_way_is_found_to_what_is_left_where_the_arm_is_elsewhere(setup, pair):
    made, run = stopped(pair, names(pair)[0], 0.015)
    elsewhere = replace(run, configuration=(run.configuration[0] + 0.1, *run.configuration[1:]))
    rest = still_good(setup, made, elsewhere, math.inf)
    assert rest.home == elsewhere.configuration
    assert rest.actions[1:] == made.actions[len(run.log) + 1 :]


def test_no_new_way_is_sought_once_time_is_up(setup, pair):
    made, run = stopped(pair, names(pair)[0], 0.015)
    elsewhere = replace(run, configuration=(run.configuration[0] + 0.1, *run.configuration[1:]))
    assert still_good(setup, made, elsewhere, -math.inf) is None


def test_what_the_hand_should_hold_and_has_lost_is_left_out(setup, pair):
    made, run = pair
    first, second = names(pair)
    stop = next(i for i, action in enumerate(made.actions) if action.name == "pick") + 1
    configuration = tuple(float(q) for q in made.actions[stop - 1].steps[-1].trajectory.positions[-1])
    there = {**made.start, first: shifted(made.start[first], 0.03)}
    off = Deviation(first, "missed", 0.03, 0.0)
    missed = replace(run, log=run.log[:stop], deviation=off, final_poses=there, configuration=configuration)
    rest = still_good(setup, made, missed, math.inf)
    assert {action.arguments[0] for action in rest.actions if action.arguments} == {second}


def test_a_run_goes_on_with_the_rest_and_corrects_in_the_end(monkeypatch):
    """The first object is made to end 15 mm beside its goal, as if somebody had nudged it."""
    true, nudged, searches, search = Performer.perform, [], [], Planning.run

    def perform(self, action, expected, after):
        if action.name == "move" and not action.arguments and len(expected) == 2 and searches and not nudged:
            placed = [name for name, pose in expected.items() if pose.xyz[1] < 0]
            if placed:
                nudged.append(placed[0])
                body, client = self._simulator.bodies[placed[0]], self._simulator._client
                position, turn = pybullet.getBasePositionAndOrientation(body.id, physicsClientId=client)
                aside = (position[0] - 0.015, *position[1:])
                pybullet.resetBasePositionAndOrientation(body.id, aside, turn, physicsClientId=client)
        return true(self, action, expected, after)

    def counted(self, **options):
        searches.append(self)
        return search(self, **options)

    monkeypatch.setattr(Performer, "perform", perform)
    monkeypatch.setattr(Planning, "run", counted)
    run = carry_out(TASK, seed=0, timeout=300.0)
    assert nudged
    assert run.result.status == "solved"
    assert run.result.ede_m < 0.005
    assert [execution.status for execution in run.executions] == ["deviated", "done", "done"]
    assert len(searches) == 2  # one for the plan, one for the correction
    assert len(run.plans) == 3


def test_what_was_put_aside_in_vain_is_not_put_aside_unless_what_it_serves_may_be_planned_anew():
    here, goals = {obj.name: obj.pose for obj in TASK.objects}, {obj.name: obj.goal.pose for obj in TASK.objects}
    done = {**here, "first": goals["first"]}  # 30 cm nearer
    aside = {**done, "first": shifted(goals["first"], 0.2)}  # and 20 cm farther again
    stages = [(0, here), (4, done), (8, aside)]
    second = {"second": goals["second"]}  # which would gain 25 cm: farther than that does not count
    assert [worth_doing(TASK, stages, second, chance) for chance in (1.0, 0.9, 0.7, 0.0)] == [8, 8, 4, 4]
    assert worth_doing(TASK, stages, {}, 1.0) == 4
    assert worth_doing(TASK, stages[:2], {}, 0.0) == 4
    assert worth_doing(TASK, [stages[1], stages[2]], {}, 1.0) == 4
    assert worth_doing(TASK, stages[:1], {}, 0.0) == 0
