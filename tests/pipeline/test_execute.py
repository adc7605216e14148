"""What the checker rejects is not carried out, unless somebody says so aloud."""

from __future__ import annotations

from dataclasses import replace

import pytest

import tamp
from tests.checking.handmade import two_boxes


def test_a_plan_for_the_goals_as_start_moves_nothing():
    task, plan = two_boxes()
    cheat = replace(plan, start={**plan.start, **plan.goals}, actions=())
    with pytest.raises(tamp.PlanRefusedError, match=r"red starts .* from where it settles"):
        tamp.execute(task, cheat)


def test_an_experiment_says_that_it_is_one():
    task, plan = two_boxes()
    with pytest.warns(UserWarning, match="not checked"):
        run = tamp.execute(task, replace(plan, actions=()), unchecked=True)
    assert run.status == "done"
