"""What is no seed and no limit is refused at once, by whatever takes them."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import tamp
from tamp.pipeline.plan import refuse_arguments
from tamp.pipeline.solving.solve import carry_out

ONE = Path(__file__).parents[2] / "scenarios" / "one_object.yaml"


@pytest.mark.parametrize("call", [tamp.plan, tamp.solve, carry_out])
@pytest.mark.parametrize(
    ("given", "said"),
    [
        *(({"timeout": value}, f"timeout is {value}; valid are positive") for value in (math.nan, 0, -1.0)),
        *(({"seed": value}, rf"seed is {value!r}; valid are 0, 1, 2") for value in ("a", -1, 0.5)),
    ],
)
def test_what_is_no_seed_or_limit_is_refused(call: Any, given: dict[str, Any], said: str) -> None:
    with pytest.raises(tamp.TampError, match=said):
        call(tamp.load_task(ONE), **given)


def test_what_is_no_task_or_plan_is_refused_and_so_are_both_in_the_wrong_order() -> None:
    task = tamp.load_task(ONE)
    plan = tamp.Plan(task.name, task.robot, 0, {}, (), {}, ())
    for call in (tamp.check, tamp.execute):
        with pytest.raises(tamp.TaskError, match="task and plan are swapped: the task comes first"):
            call(plan, task)
        with pytest.raises(tamp.PlanError, match=r"expected a Plan, .* found 'plan.json'"):
            call(task, "plan.json")
    for call in (tamp.plan, tamp.solve, tamp.prepare, lambda given: tamp.score(given, {})):
        with pytest.raises(tamp.TaskError, match=r"expected a Task, .* found a Plan"):
            call(plan)


def test_every_number_that_is_one_will_do() -> None:
    for seed, timeout in ((np.int64(3), np.float64(1.5)), (0, None), (1, math.inf), (2, 1)):
        refuse_arguments(seed, timeout)
