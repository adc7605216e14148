"""What takes much apart for little is not done when no time is left to mend it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import tamp
from tamp.pipeline.solving.risk import stages, worth_its_risk
from tamp.task import Action, At, Attachment, Box, Grip, Object, Plan, Pose, Release, Task, load_robot, task_robot
from tamp.world.robot.model import robot_model

SCENARIOS = Path(__file__).parents[3] / "scenarios"
CHANCES = st.floats(0.0, 1.0)


@pytest.fixture(scope="module")
def tower():
    """A task of a tower to be reversed, a plan for it, and the robot."""
    task = tamp.load_task(SCENARIOS / "reverse_tower.yaml")
    return task, tamp.plan(task, seed=0, timeout=100.0), robot_model(task_robot(task))


@given(chance=CHANCES)
def test_a_plan_that_reaches_far_goals_is_worth_its_risk(tower, chance):
    task, plan, robot = tower
    missing = [*stages(task, robot, plan)]
    assert missing[-1] < 0.02 < missing[0]
    assert len(missing) == len(plan.actions) + 1
    assert worth_its_risk(task, robot, plan, 0.1, chance)


def handled(name, xyz):
    """An action that takes an object and leaves it elsewhere."""
    return Action(
        "place", (name, "table"), (Grip(Attachment(name, Pose((0, 0, 0))), 0.05), Release(name, Pose(xyz), 0.08))
    )


@pytest.mark.parametrize(("off", "chance", "worth"), [(0.02, 0.9, True), (0.02, 0.0, False), (0.3, 0.0, True)])
def test_what_stands_well_is_taken_away_for_a_little_only_while_that_can_be_mended(off, chance, worth):
    there, here = (0.0, 0.0, 0.025), (0.0, 0.0, 0.075)
    low = Object("low", Box((0.05, 0.05, 0.05)), Pose((off, 0.0, 0.025)), At(Pose(there)))
    top = Object("top", Box((0.05, 0.05, 0.05)), Pose(here), At(Pose(here)))
    task = Task("tower", (low, top))
    actions = handled("top", (0.0, 0.4, 0.025)), handled("low", there), handled("top", here)
    start = {"low": low.pose, "top": top.pose}
    plan = Plan("tower", "panda", 0, start, load_robot("panda").home, dict(start), actions, {})
    assert worth_its_risk(task, robot_model(task_robot(task)), plan, 0.1, chance) == worth


def test_it_counts_how_much_is_taken_apart_when_it_goes_wrong(tower):
    """Four blocks are put aside and back for one of them; most may go wrong while little is off its goal yet."""
    names = ("one", "two", "three", "four")
    at = {name: Pose((0.1 * number, 0.0, 0.025)) for number, name in enumerate(names)}
    objects = [Object(name, Box((0.05, 0.05, 0.05)), pose, At(pose)) for name, pose in at.items()]
    objects[0] = replace(objects[0], pose=Pose((0.0, 0.12, 0.025)))
    start = {thing.name: thing.pose for thing in objects}
    aside = [handled(name, (0.1, -0.1, 0.025)) for name in names[1:]]
    back = [handled(name, at[name].xyz) for name in names]
    actions = (*aside, *back)
    plan = Plan("row", "panda", 0, start, load_robot("panda").home, dict(at), actions, {})
    task, robot = Task("row", tuple(objects)), tower[2]
    assert not worth_its_risk(task, robot, plan, 0.1, 0.0)
    assert worth_its_risk(task, robot, plan, 0.1, 0.5)
    assert worth_its_risk(task, robot, plan, 0.02, 0.0)


@given(chance=CHANCES)
def test_a_plan_that_does_nothing_risks_nothing(tower, chance):
    task, plan, robot = tower
    assert worth_its_risk(task, robot, replace(plan, actions=()), 0.1, chance)
