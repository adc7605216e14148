"""From a task file to the simulator: what no hand can grasp as it stands is pushed to where one can, and gripped."""

from pathlib import Path

import pytest

import tamp

SCENARIOS = Path(__file__).parents[2] / "scenarios"


@pytest.mark.parametrize(("scenario", "push"), [("slide_box", "slide"), ("topple_pail", "topple")])
def test_a_flat_box_is_slid_over_the_edge_and_a_pail_pushed_over_and_both_are_stood_up(scenario, push):
    task = tamp.load_task(SCENARIOS / f"{scenario}.yaml")
    plan = tamp.plan(task, seed=0, timeout=100.0)
    assert [action.name for action in plan.actions] == ["move", push, "move", "pick", "move", "place"]
    run = tamp.execute(task, plan)
    assert run.status == "done"
    assert tamp.score(task, run.final_poses).ede_m < 0.01
