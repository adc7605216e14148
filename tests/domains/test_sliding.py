"""From a task file to the simulator: what no hand can grasp is slid over the table's edge and gripped there."""

from pathlib import Path

import tamp

SCENARIOS = Path(__file__).parents[2] / "scenarios"


def test_a_flat_box_wider_than_the_hand_is_slid_over_the_edge_and_stood_up():
    task = tamp.load_task(SCENARIOS / "slide_box.yaml")
    plan = tamp.plan(task, seed=0, timeout=100.0)
    assert [action.name for action in plan.actions] == ["move", "slide", "move", "pick", "move", "place"]
    run = tamp.execute(task, plan)
    assert run.status == "done"
    assert tamp.score(task, run.final_poses).ede_m < 0.01
