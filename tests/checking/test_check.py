"""Valid plans pass; every kind of corruption is rejected, and for its own reason."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tamp.checking import check
from tamp.checking.check import check_left
from tamp.task import Box, Object, Plan, Pose, Release, Task
from tests.checking.handmade import scales, two_boxes
from tests.checking.mutations import MUTATIONS, STACKS, Mutation
from tests.checking.mutations.handling import lies_tilted_across_two_trays, lies_tilted_in_a_tray, tips_off_a_rim


@pytest.fixture(scope="module")
def valid() -> tuple[Task, Plan]:
    return two_boxes()


def test_a_valid_plan_is_accepted(valid: tuple[Task, Plan]) -> None:
    verdict = check(*valid)
    assert verdict.accepted, str(verdict)
    assert str(verdict) == "accepted"


@pytest.mark.parametrize("mutation", MUTATIONS, ids=lambda mutation: mutation.__name__)
def test_a_corrupted_plan_is_rejected_for_its_own_reason(valid: tuple[Task, Plan], mutation: Mutation) -> None:
    seen = 0
    for seed in range(2):
        mutant = mutation(*valid, np.random.default_rng(seed))
        if mutant is None:
            continue
        verdict = check(*mutant)
        assert not verdict.accepted
        assert {problem.kind for problem in verdict.problems} & set(MUTATIONS[mutation]), str(verdict)
        seen += 1
    assert seen, "the plan gives this mutation nothing to corrupt"


@pytest.mark.parametrize("mutation", STACKS, ids=lambda mutation: mutation.__name__)
def test_a_stack_that_tips_is_rejected_for_that(mutation: Mutation) -> None:
    assert check(*scales()).accepted
    for seed in range(3):
        mutant = mutation(*scales(), np.random.default_rng(seed))
        assert {problem.kind for problem in check(*mutant).problems} & set(STACKS[mutation])


def test_a_problem_names_action_time_bodies_and_depth(valid: tuple[Task, Plan]) -> None:
    task, plan = valid
    task = replace(task, objects=(*task.objects, Object("wall", Box((0.04, 0.3, 0.4)), Pose((0.05, 0.0, 0.2)))))
    verdict = check(task, replace(plan, start={**plan.start, "wall": Pose((0.05, 0.0, 0.2))}))
    hit = next(p for p in verdict.problems if p.kind == "collision")
    assert "wall" in hit.bodies
    assert 0 <= hit.time <= plan.duration
    assert hit.depth > 0.001
    assert str(plan.actions[hit.action]) == hit.name
    assert hit.sentence in str(verdict)


def test_an_action_about_the_table_is_refused(valid: tuple[Task, Plan]) -> None:
    task, plan = valid
    i = next(i for i, action in enumerate(plan.actions) if action.name == "place")
    changed = replace(plan.actions[i], arguments=("table",))
    verdict = check(task, replace(plan, actions=(*plan.actions[:i], changed, *plan.actions[i + 1 :])))
    assert {problem.kind for problem in verdict.problems} >= {"precondition"}


@pytest.mark.parametrize("mutation", [lies_tilted_in_a_tray, lies_tilted_across_two_trays, tips_off_a_rim])
def test_what_does_not_stay_where_it_is_let_go_is_told_without_a_plan(mutation):
    task, plan = mutation(*two_boxes(), np.random.default_rng(2))
    release = next(step for step in plan.steps if isinstance(step, Release))
    told = check_left(task, release.object, {**plan.start, release.object: release.pose})
    assert told
    assert [p.sentence for p in told] == [p.sentence for p in check(task, plan).problems if p.kind == "support"]


def test_what_stays_where_it_is_let_go_is_not_told_of():
    task, plan = two_boxes()
    ends = dict(plan.start)
    for release in (step for step in plan.steps if isinstance(step, Release)):
        ends[release.object] = release.pose
        assert not check_left(task, release.object, ends)
