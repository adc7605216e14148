"""Where no one grasp serves both start and goal, an object is put down and grasped anew, without being asked for."""

from __future__ import annotations

import time

from tamp.pipeline.options.settings import Settings
from tamp.pipeline.plan import Planning
from tamp.pipeline.prepare import prepare
from tamp.task import Task, load_robot
from tests.streams.placing.test_regrasp import BLOCK


def no_laying(context, obj, placement, grasp):
    """Yield no way to lay anything down: what cannot be put down by the grasp that took it must be regrasped."""
    context.fail("nothing is laid down")
    yield from ()


def test_what_no_one_grasp_brings_to_its_goal_is_grasped_anew_on_its_way():
    setup, deadline = prepare(Task("turn", (BLOCK,))), time.monotonic() + 3000.0
    search = Planning(
        setup,
        setup.start,
        load_robot("panda").home,
        seed=0,
        deadline=deadline,
        settings=Settings(samplers={"plan-laying": no_laying}),
    )
    plan = search.run()
    assert plan is not None
    assert not search.left
    hands = [action.name for action in plan.actions if action.name != "move"]
    assert hands == ["pick", "place", "pick", "place"]
