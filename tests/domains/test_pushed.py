"""From a task file to the simulator: what no hand can grasp as it stands is pushed to where one can, and gripped."""

import pytest

import tamp
from tests.planned import planned


@pytest.mark.parametrize(("scenario", "push"), [("slide_box", "slide"), ("topple_pail", "topple")])
def test_a_flat_box_is_slid_over_the_edge_and_a_pail_pushed_over_and_both_are_stood_up(scenario, push):
    task, plan = planned(scenario, 0)
    assert [action.name for action in plan.actions] == ["move", push, "move", "pick", "move", "place"]
    run = tamp.execute(task, plan)
    assert run.status == "done"
    assert tamp.score(task, run.final_poses).ede_m < 0.01
