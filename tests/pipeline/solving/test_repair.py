from __future__ import annotations

import math
import time
from dataclasses import replace

import pytest

import tamp
from tamp import clock
from tamp.checking import check
from tamp.execution.action_execution import Performer
from tamp.execution.log import Deviation
from tamp.pipeline.options.settings import Settings
from tamp.pipeline.plan import Planning, plan
from tamp.pipeline.prepare import prepare
from tamp.pipeline.solving.repair import Resuming, errands, remainder, still_good, worth_doing
from tamp.pipeline.solving.solve import carry_out
from tamp.task import At, Attachment, Box, Object, Pose, Task

SIDE = Box((0.05, 0.05, 0.05))
LOWER = Object("lower", SIDE, Pose((0.05, 0.2, 0.025)), At(Pose((0.05, -0.1, 0.025))))
UPPER = Object("upper", SIDE, Pose((-0.1, 0.2, 0.025)), At(Pose((0.05, -0.1, 0.075))))
TASK = Task("tower", (LOWER, UPPER))


@pytest.fixture(scope="module")
def setup():
    return prepare(TASK)


@pytest.fixture(scope="module")
def made():
    return plan(TASK, seed=0, timeout=300.0)


@pytest.fixture(scope="module")
def whole(made):
    return tamp.execute(TASK, made)


def stopped(made, whole, beside):
    """The execution up to where the lower block is put down, so far beside its goal [m]."""
    done = next(i for i, action in enumerate(made.actions) if action.name == "place") + 1
    x, y, z = made.goals["lower"].xyz
    here = {**made.start, "lower": Pose((x + beside, y, z - 0.001))}
    end = made.actions[done - 1].steps[-1].trajectory.positions[-1]
    off = Deviation("lower", "misplaced", beside, 0.0)
    log = (*whole.log[: done - 1], replace(whole.log[done - 1], deviations=(off,)))
    q = tuple(float(angle) for angle in end)
    return replace(whole, status="deviated", log=log, deviation=off, final_poses=here, configuration=q)


def resumed(setup, made, execution, spared=()):
    rest, amended = Resuming(setup, Settings(), 1, time.monotonic() + 300.0).resume(made, execution, spared)
    placed = [] if rest is None else [a.arguments[0] for a in rest.actions if a.name in ("place", "stack")]
    return rest, amended, placed


def test_what_later_errands_count_on_is_put_right_before_them(setup, made, whole):
    execution = stopped(made, whole, 0.03)
    rest, amended, placed = resumed(setup, made, execution)
    assert (amended, placed) == ({"lower"}, ["lower", "upper"])
    assert dict(rest.start) == dict(execution.final_poses)
    assert check(TASK, rest, start=rest.start, goals=made.goals).accepted
    assert rest.actions[-1] == made.actions[-1]


def test_what_does_not_matter_to_the_rest_stays(setup, made, whole):
    _, amended, placed = resumed(setup, made, stopped(made, whole, 0.011))
    assert (amended, placed) == (set(), ["upper"])


def test_what_shall_not_be_put_right_again_stays(setup, made, whole):
    rest, amended, _ = resumed(setup, made, stopped(made, whole, 0.03), {"lower"})
    assert (rest, amended) == (None, set())


def test_what_cannot_be_put_right_stays(setup, made, whole):
    """The lower block stands where no arm reaches it."""
    execution = stopped(made, whole, 0.03)
    far = {**execution.final_poses, "lower": Pose((0.55, -0.55, 0.025))}
    rest, amended, _ = resumed(setup, made, replace(execution, final_poses=far))
    assert (rest, amended) == (None, set())


FIRST = Object("first", SIDE, Pose((0.05, 0.2, 0.025)), At(Pose((0.05, -0.1, 0.025))))
SECOND = Object("second", SIDE, Pose((-0.1, 0.2, 0.025)), At(Pose((-0.1, -0.2, 0.025))))
REMAINDER_TASK = Task("pair", (FIRST, SECOND))


@pytest.fixture(scope="module")
def pair_setup():
    return prepare(REMAINDER_TASK)


def shifted(pose, x):
    return Pose((pose.xyz[0] + x, *pose.xyz[1:]), pose.quat)


@pytest.fixture(scope="module")
def pair():
    """A plan for two blocks, and its execution until the first of them is put down."""
    made = plan(REMAINDER_TASK, seed=0, timeout=300.0)
    whole = tamp.execute(REMAINDER_TASK, made)
    stop = next(i for i, entry in enumerate(whole.log) if entry.name.startswith("place")) + 1
    return made, replace(whole, status="deviated", log=whole.log[:stop])


def stopped_remainder(pair, name, x):
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


def kept(pair_setup, case):
    rest = still_good(pair_setup, *case, math.inf)
    return None if rest is None else [str(action) for action in rest.actions]


def test_what_is_left_starts_from_the_state_as_it_is(pair_setup, pair):
    made, run = stopped_remainder(pair, names(pair)[0], 0.015)
    rest = remainder(pair_setup, made, run)
    assert rest.actions == made.actions[len(run.log) :]
    assert rest.start[names(pair)[0]] == run.final_poses[names(pair)[0]]
    assert rest.start[names(pair)[1]] == made.start[names(pair)[1]]
    assert rest.goals == made.goals


def test_what_is_off_is_taken_as_it_is_whether_or_not_that_was_noted(pair_setup, pair):
    made, run = stopped_remainder(pair, names(pair)[0], 0.015)
    there = {**run.final_poses, names(pair)[1]: shifted(made.start[names(pair)[1]], 0.2)}
    rest = remainder(pair_setup, made, replace(run, final_poses=there))
    assert rest.start == there


def test_what_was_pushed_stands_where_the_hand_has_pushed_it_to(pair_setup, pair):
    made, run = stopped_remainder(pair, names(pair)[0], 0.015)
    (move, *others), pushed = made.actions[0].steps, Attachment(names(pair)[1], Pose((0.0, 0.0, 0.1)))
    slid = replace(made.actions[0], steps=(replace(move, pushed=pushed), *others))
    T = pair_setup.world.robot.forward(move.trajectory.positions[-1])
    there = {**run.final_poses, pushed.object: Pose.from_matrix(T) @ pushed.T_tool_object}
    rest = remainder(pair_setup, replace(made, actions=(slid, *made.actions[1:])), replace(run, final_poses=there))
    assert rest.start[pushed.object] == there[pushed.object]


def test_errands_end_where_the_hand_is_empty(pair):
    made, _ = pair
    cut = list(errands(made.actions))
    assert [action for errand in cut for action in errand] == list(made.actions)
    assert [errand[-1].name for errand in cut] == ["place", "place"]


def test_the_rest_is_good_where_what_is_off_is_not_needed_any_more(pair_setup, pair):
    made, run = stopped_remainder(pair, names(pair)[0], 0.015)
    assert still_good(pair_setup, made, run, math.inf).actions == made.actions[len(run.log) :]


def test_the_rest_is_of_no_use_where_its_object_has_moved(pair_setup, pair):
    assert kept(pair_setup, stopped_remainder(pair, names(pair)[1], 0.03)) is None


def test_an_errand_that_has_become_wrong_is_left_out_and_the_arm_goes_on_to_the_next(pair_setup, pair):
    """The object of the first errand has moved before anything was done."""
    made, run = pair
    first, _ = names(pair)
    there = {**made.start, first: shifted(made.start[first], 0.03)}
    off = Deviation(first, "disturbed", 0.03, 0.0)
    begun = replace(run, log=(), deviation=off, final_poses=there, configuration=made.home)
    rest = still_good(pair_setup, made, begun, math.inf)
    assert [str(action) for action in rest.actions] == [str(action) for action in made.actions[len(run.log) :]]
    assert rest.actions[1:] == made.actions[len(run.log) + 1 :]
    assert rest.start == there
    assert check(REMAINDER_TASK, rest, start=there, goals=rest.goals).executable


def test_a_new_way_is_found_to_what_is_left_where_the_arm_is_elsewhere(pair_setup, pair):
    made, run = stopped_remainder(pair, names(pair)[0], 0.015)
    elsewhere = replace(run, configuration=(run.configuration[0] + 0.1, *run.configuration[1:]))
    rest = still_good(pair_setup, made, elsewhere, math.inf)
    assert rest.home == elsewhere.configuration
    assert rest.actions[1:] == made.actions[len(run.log) + 1 :]


def test_no_new_way_is_sought_once_time_is_up(pair_setup, pair):
    made, run = stopped_remainder(pair, names(pair)[0], 0.015)
    elsewhere = replace(run, configuration=(run.configuration[0] + 0.1, *run.configuration[1:]))
    assert still_good(pair_setup, made, elsewhere, -math.inf) is None


def test_what_the_hand_should_hold_and_has_lost_is_left_out(pair_setup, pair):
    made, run = pair
    first, second = names(pair)
    stop = next(i for i, action in enumerate(made.actions) if action.name == "pick") + 1
    configuration = tuple(float(q) for q in made.actions[stop - 1].steps[-1].trajectory.positions[-1])
    there = {**made.start, first: shifted(made.start[first], 0.03)}
    off = Deviation(first, "missed", 0.03, 0.0)
    missed = replace(run, log=run.log[:stop], deviation=off, final_poses=there, configuration=configuration)
    rest = still_good(pair_setup, made, missed, math.inf)
    assert {action.arguments[0] for action in rest.actions if action.arguments} == {second}


def test_what_slipped_and_was_put_back_is_taken_up_anew(pair_setup, pair):
    """The errand in which it was lost is done again, from where it stands, and then all the others."""
    made, run = pair
    first, second = names(pair)
    stop = next(i for i, action in enumerate(made.actions) if action.name == "pick") + 1
    configuration = tuple(float(q) for q in made.actions[stop - 1].steps[0].trajectory.positions[0])
    there = {**made.start, first: shifted(made.start[first], 0.004)}
    off = Deviation(first, "slipped", 0.03, 0.3)
    slipped = replace(run, log=run.log[:stop], deviation=off, final_poses=there, configuration=configuration)
    rest, amended, placed = resumed(pair_setup, made, slipped)
    assert (amended, placed) == ({first}, [first, second])
    assert check(REMAINDER_TASK, rest, start=rest.start, goals=made.goals).accepted
    assert resumed(pair_setup, made, slipped, {first})[1:] == (set(), [second])


def test_a_run_goes_on_with_the_rest_and_corrects_in_the_end(monkeypatch):
    """The first object is made to end 15 mm beside its goal, as if somebody had nudged it."""
    true, nudged, searches, search = Performer.perform, [], [], Planning.run

    def perform(self, action, expected, after):
        if action.name == "move" and not action.arguments and len(expected) == 2 and searches and not nudged:
            placed = [name for name, pose in expected.items() if pose.xyz[1] < 0]
            if placed:
                nudged.append(placed[0])
                aside = Pose((-0.015, 0.0, 0.0)) @ self._simulator.pose(placed[0])
                self._simulator.place(placed[0], aside)
        return true(self, action, expected, after)

    def counted(self, **options):
        searches.append(self)
        return search(self, **options)

    monkeypatch.setattr(Performer, "perform", perform)
    monkeypatch.setattr(Planning, "run", counted)
    run = carry_out(REMAINDER_TASK, seed=0, timeout=300.0)
    assert nudged
    assert run.result.status == "solved"
    assert run.result.ede_m < 0.005
    assert [execution.status for execution in run.executions] == ["deviated", "done", "done"]
    assert len(searches) == 2  # one for the plan, one for the correction
    assert len(run.plans) == 3


def test_what_was_put_aside_in_vain_is_not_put_aside_unless_what_it_serves_may_be_planned_anew():
    here = {obj.name: obj.pose for obj in REMAINDER_TASK.objects}
    goals = {obj.name: obj.goal.pose for obj in REMAINDER_TASK.objects}
    done = {**here, "first": goals["first"]}  # 30 cm nearer
    aside = {**done, "first": shifted(goals["first"], 0.2)}  # and 20 cm farther again
    stages = [(0, here), (4, done), (8, aside)]
    second = {"second": goals["second"]}  # which would gain 25 cm: farther than that does not count
    assert [worth_doing(REMAINDER_TASK, stages, second, chance) for chance in (1.0, 0.9, 0.7, 0.0)] == [8, 8, 4, 4]
    assert worth_doing(REMAINDER_TASK, stages, {}, 1.0) == 4
    assert worth_doing(REMAINDER_TASK, stages[:2], {}, 0.0) == 4
    assert worth_doing(REMAINDER_TASK, [stages[1], stages[2]], {}, 1.0) == 4
    assert worth_doing(REMAINDER_TASK, stages[:1], {}, 0.0) == 0


def test_an_arm_that_came_to_rest_a_hair_beyond_a_limit_is_planned_with(setup):
    robot = setup.world.robot
    q = (float(robot.upper[0]) + 1e-4, *robot.home[1:].tolist())
    found = Planning(setup, setup.start, q, seed=0, deadline=clock.now() + 60.0, settings=Settings()).run()
    assert found is not None and found.actions
