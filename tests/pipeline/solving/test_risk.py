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


@given(chance=CHANCES)
def test_a_plan_that_does_nothing_risks_nothing(tower, chance):
    task, plan, robot = tower
    assert worth_its_risk(task, robot, replace(plan, actions=()), 0.1, chance)
