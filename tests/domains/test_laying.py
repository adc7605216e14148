"""From a task file to the simulator: what is laid down or dropped lands where it shall lie."""

import numpy as np
import pytest

import tamp
from tamp.task import Grip, Release
from tests.planned import planned


@pytest.mark.parametrize("seed", [0, 1])
def test_a_book_that_is_wider_than_the_hand_is_laid_down_to_a_centimetre(seed):
    task, plan = planned("lay_book", seed)
    assert [action.name for action in plan.actions] == ["move", "pick", "move", "lay"]
    run = tamp.execute(task, plan)
    assert run.status == "done"
    assert tamp.score(task, run.final_poses).ede_m < 0.01


@pytest.mark.parametrize("seed", [0, 1])
def test_a_block_for_the_corner_of_a_deep_box_is_dropped_into_it(seed):
    task, plan = planned("drop_into_corner", seed)
    assert [action.name for action in plan.actions] == ["move", "pick", "move", "lay-on"]
    run = tamp.execute(task, plan, monitor=None)
    assert tamp.score(task, run.final_poses).ede_m < 0.03


@pytest.mark.parametrize("seed", [0, 1])
def test_a_disc_that_hangs_over_the_edge_meanwhile_trades_places_with_what_it_lies_on(seed):
    task, plan = planned("lay_over_edge", seed)
    grips = [step.attachment.object for step in plan.steps if isinstance(step, Grip)]
    assert grips == ["disc", "block", "disc", "block"]
    run = tamp.execute(task, plan)
    assert run.status == "done"
    assert tamp.score(task, run.final_poses).ede_m < 0.01


def test_a_disc_that_no_hand_can_put_down_flat_amid_the_table_is_laid_aside_or_put_over_its_edge():
    task, plan = planned("lay_aside", 0)
    names = [action.name for action in plan.actions if action.name != "move"]
    assert names in [["unstack", aside, "pick", "place"] for aside in ("lay", "place")]
    if names[1] == "place":
        table, disc = task.table, next(step.pose for step in plan.steps if isinstance(step, Release))
        room = np.array(table.size) / 2 - np.abs(np.array(disc.xyz[:2]) - table.center)
        assert room.min() < 0.08
    run = tamp.execute(task, plan)
    assert run.status == "done"
    assert tamp.score(task, run.final_poses).ede_m < 0.01
