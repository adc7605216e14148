"""A block that lies otherwise than it stood: taken across one side, put down across another."""

import pytest

from tamp.pipeline.prepare import prepare
from tamp.pipeline.strategies.subproblems.attempt import Attempt
from tamp.planning import solve
from tamp.task import Task, load_robot
from tests.pipeline.samplers import from_above
from tests.streams.placing.test_regrasp import BLOCK


@pytest.fixture(scope="module")
def attempt():
    setup = prepare(Task("turn", (BLOCK,)))
    return Attempt.of(setup, setup.start, load_robot("panda").home, None)


def problem_of(attempt, **options):
    return attempt.problem(attempt.workspace, {}, **options)


@pytest.mark.parametrize("seed", [0, 1])
def test_an_object_that_is_regrasped_is_put_down_in_between_in_the_plan_itself(attempt, seed):
    solution = solve(problem_of(attempt, regrasped={"block"}), seed=seed, timeout=100.0)
    assert solution.plan is not None
    hands = [action for action in solution.plan if not action.name.startswith("move")]
    assert [action.name for action in hands] == ["pick", "lay", "pick", "lay"]
    grasps = [action.args[2] for action in hands]
    assert grasps[0] == grasps[1] != grasps[2] == grasps[3]
    assert hands[1].args[1] == hands[2].args[1] != attempt.workspace.goals["block"]


def test_what_is_regrasped_is_moved_in_no_other_way(attempt):
    facts = {fact[0] for fact in problem_of(attempt, regrasped={"block"}).init}
    assert "RegraspedTo" in facts
    assert not facts & {"Movable", "Placeable", "Layable"}


def test_each_stream_is_served_by_the_function_that_was_given_for_it_and_no_other(attempt):
    theirs = {**attempt.samplers, "sample-grasp": from_above}
    assert attempt.problem(attempt.workspace, {"sample-grasp": from_above}).samplers == theirs
