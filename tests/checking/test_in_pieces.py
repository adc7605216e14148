"""A plan that is checked in pieces, one after the other, gets the verdict that it gets as a whole."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tamp.checking import check
from tamp.checking.check import begin
from tamp.checking.verdict import Problem
from tamp.errors import TaskError
from tamp.task import Action, Box, Move, Object, Plan, Pose, Task
from tests.checking.handmade import DOWN, OPEN, Hand, above, carry, scales, two_boxes
from tests.checking.mutations import MUTATIONS

HOME = two_boxes()[1].home
PLANS = {"two boxes": two_boxes(), "scales": scales()}


def pieces(plan: Plan, cuts: list[int]) -> list[tuple[Action, ...]]:
    """The plan's actions, cut before some of them."""
    ends = [0, *sorted({min(cut, len(plan.actions)) for cut in cuts}), len(plan.actions)]
    return [plan.actions[a:b] for a, b in pairwise(ends)]


def in_pieces(task: Task, plan: Plan, parts: list[tuple[Action, ...]], **known) -> list[tuple[str, str, float]]:
    """What the checker says of the parts one after the other; of goals, after the last."""
    found, state = list[Problem](), known.pop("after", None)
    for index, actions in enumerate(parts):
        part = replace(plan, actions=actions)
        if state is not None:
            start = {name: Pose.from_matrix(T) for name, T in state.poses.items()}
            part = replace(part, start=start, home=tuple(float(q) for q in state.q))
        verdict = check(task, part, after=state, **known)
        state = verdict.state
        found += [each for each in verdict.problems if each.kind != "goal" or index == len(parts) - 1]
    return said(found)


def said(problems) -> list[tuple[str, str, float]]:
    return sorted((each.kind, each.sentence, round(each.time, 6)) for each in problems)


@pytest.mark.parametrize("title", PLANS)
@given(
    kind=st.sampled_from([None, *MUTATIONS]),
    cuts=st.lists(st.integers(0, 4), max_size=3),
    seed=st.integers(0, 99),
)
@settings(max_examples=6, deadline=None)
def test_pieces_one_after_the_other_are_judged_as_the_whole(title, kind, cuts, seed):
    task, plan = PLANS[title]
    if kind is not None:
        changed = kind(task, plan, np.random.default_rng(seed))
        assume(changed is not None)
        task, plan = changed
    with suppress(TaskError):  # of what the mutation makes of a plan without what it corrupts nothing can be judged
        assert in_pieces(task, plan, pieces(plan, cuts)) == said(check(task, plan).problems)


def led(aside: float) -> tuple[Task, Plan]:
    """A hand passes by a box that is said to start aside of where the task has it, where it stays."""
    box = Object("box", Box((0.06, 0.06, 0.06)), Pose((0.15, 0.045, 0.03)))
    end, hand = 0.15 + aside - 0.03 - 0.0105 - 0.0015, Hand(HOME)
    tops = [Pose((end - by, 0.0, 0.03), DOWN) for by in (0.06, 0.0, 0.06)]
    ways = [hand.free(above(tops[0])), *(hand.line(to) for to in (*tops, above(tops[-1])))]
    actions = tuple(Action("move", (), (Move("transit", way, OPEN),)) for way in ways)
    return Task("led", (box,)), Plan("led", "panda", 0, {"box": Pose((0.15 + aside, 0.045, 0.03))}, HOME, {}, actions)


@pytest.mark.parametrize("aside", [0.0055, 0.0])
def test_what_stays_elsewhere_is_met_by_a_piece_that_continues_the_task_s_own_scene(aside):
    """A plan accepted piece by piece, from where settling has put things, was refused as a whole."""
    task, plan = led(aside)
    state = begin(task, plan.start, ())
    found = in_pieces(task, plan, [(action,) for action in plan.actions], after=state)
    assert found == said(check(task, plan).problems) and bool(found) == bool(aside)


def test_shifts_add_up_from_piece_to_piece():
    """Each release creeps by 1.8 mm, within tolerance; the third is refused, whether they are one plan or three."""
    at, box, hand, actions = Pose((0.05, -0.2, 0.03)), Box((0.05, 0.05, 0.06)), Hand(HOME), list[tuple[Action, ...]]()
    for index in range(3):
        x = 0.05 + 0.0018 * index
        here, there = Pose((x, -0.2 + 0.1 * index, 0.03)), Pose((x, -0.1 + 0.1 * index, 0.03))
        steps = carry(hand, "red", here, there, 0.05, ("table", "table"))
        actions.append(tuple(_crept(action, 0.0018) for action in steps))
    task = Task("creeps", (Object("red", box, at),))
    plan = Plan("creeps", "panda", 0, {"red": at}, HOME, {}, tuple(action for part in actions for action in part))
    whole = said(check(task, plan).problems)
    assert [kind for kind, sentence, _ in whole if "add up" in sentence] == ["release"]
    assert in_pieces(task, plan, actions) == whole


def _crept(action: Action, by: float) -> Action:
    """Where the action lets go of something, that is said to stand a little aside."""
    steps = [
        replace(step, pose=Pose((step.pose.xyz[0] + by, *step.pose.xyz[1:]), step.pose.quat))
        if hasattr(step, "pose")
        else step
        for step in action.steps
    ]
    return replace(action, steps=tuple(steps))


def test_a_continuation_that_begins_elsewhere_is_refused():
    task, plan = PLANS["two boxes"]
    half = replace(plan, actions=plan.actions[:2])
    state = check(task, half).state
    rest = replace(plan, actions=plan.actions[2:])
    kinds = {problem.kind for problem in check(task, rest, after=state).problems}
    assert "start" in kinds
