import tamp
from tamp.checking import check
from tests.planned import planned


def test_what_no_hand_can_take_out_of_a_crate_is_nudged_to_its_place_in_there():
    task, plan = planned("nudge_in_crate", 0)
    assert [action.name for action in plan.actions] == ["move", "nudge"]
    assert plan.actions[-1].arguments == ("slab", "crate")
    assert check(task, plan).accepted
    run = tamp.execute(task, plan, seed=0)
    assert tamp.score(task, run.final_poses).ede_m < 0.01
