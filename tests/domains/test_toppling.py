"""From a task file to the simulator: what no hand can grasp as it stands is pushed over and gripped as it lies."""

from pathlib import Path

import tamp

SCENARIOS = Path(__file__).parents[2] / "scenarios"


def test_a_pail_on_its_head_is_pushed_over_gripped_by_its_rim_and_stood_up():
    task = tamp.load_task(SCENARIOS / "topple_pail.yaml")
    plan = tamp.plan(task, seed=0, timeout=100.0)
    assert [action.name for action in plan.actions] == ["move", "topple", "move", "pick", "move", "place"]
    run = tamp.execute(task, plan)
    assert run.status == "done"
    assert tamp.score(task, run.final_poses).ede_m < 0.01
