from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tamp.checking import check
from tamp.task import Box, Fall, Move, Object, Pose
from tests.checking.handmade import tree
from tests.checking.judging import assert_wrong_and_rejected
from tests.checking.mutations import FALLS, TOPPLES
from tests.checking.mutations.topples import topple_halfway, topple_on_ice
from tests.planned import planned

SCENARIO = "topple_pail"
CORRUPTIONS = {**TOPPLES, **FALLS}


def edited(plan, edit, kind=Move):
    """The plan with the push of its topple changed, or its fall."""
    actions = list(plan.actions)
    k = next(k for k, action in enumerate(actions) if action.name == "topple")
    chosen = (s for s in actions[k].steps if isinstance(s, kind) and (kind is Fall or s.pushed is not None))
    old = next(chosen)
    actions[k] = replace(actions[k], steps=tuple(edit(s) if s is old else s for s in actions[k].steps))
    return replace(plan, actions=tuple(actions))


def moved(plan, by):
    """The plan with the pail elsewhere, moved by a pose in its own frame; plan and start agree on that."""
    start = {**plan.start, "pail": plan.start["pail"] @ by}

    def edit(move):
        return replace(move, pushed=replace(move.pushed, T_tool_object=move.pushed.T_tool_object @ by))

    return replace(edited(plan, edit), start=start)


def said(task, plan):
    return " ".join(p.sentence for p in check(task, plan, start=dict(plan.start)).problems)


def test_a_topple_as_it_is_planned_is_accepted(task, plan):
    assert check(task, plan).accepted


def test_the_arm_does_not_tip_over_what_weighs_too_much(task, plan):
    heavy = replace(task, objects=tuple(replace(o, mass=300.0) if o.name == "pail" else o for o in task.objects))
    assert "to push pail asks" in said(heavy, plan)


def test_the_finger_has_to_be_at_the_object(task, plan):
    assert "no finger touches pail" in said(task, moved(plan, Pose((0.02, 0.2, 0.0))))


def test_what_is_left_before_its_balance_falls_back(task, plan):
    short = topple_halfway(task, plan, np.random.default_rng(0))
    assert "beyond the edge that it shall fall over" in said(*short)


def test_it_does_not_fall_through_what_stands_there(task, plan):
    x, y, _ = next(s for a in plan.actions for s in a.steps if isinstance(s, Fall)).pose.xyz
    peg = Object("peg", Box((0.02, 0.02, 0.05)), Pose((x, y, 0.025)))
    crowded = replace(task, objects=(*task.objects, peg))
    found = said(crowded, replace(plan, start={**plan.start, "peg": peg.pose}))
    assert "mm into peg" in found


def test_what_stands_on_ice_slides_before_it_tips(task, plan):
    assert "would slide before it tips" in said(*topple_on_ice(task, plan, np.random.default_rng(0)))


def test_a_hand_that_lifts_or_drags_it_does_not_turn_it_over_its_edge(task, plan):
    def off_the_table(move):
        higher = Pose((0.0, 0.0, -0.02)) @ move.pushed.T_tool_object
        return replace(move, pushed=replace(move.pushed, T_tool_object=higher))

    found = said(task, edited(plan, off_the_table))
    assert "above or below the table" in found or "slides by" in found


def test_a_push_that_only_shifts_it_is_no_topple(task, plan):
    _, slide = planned("slide_box", 0)
    push = next(s for a in slide.actions for s in a.steps if isinstance(s, Move) and s.pushed)
    assert "does not turn" in said(task, edited(plan, lambda m: replace(m, trajectory=push.trajectory)))


@pytest.mark.parametrize(("ends", "tips"), [(-0.138, True), (-0.15, True), (-0.165, True), (-0.195, False)])
def test_what_comes_down_too_near_the_edge_of_the_table_tips_on_over_it(task, plan, ends, tips):
    """In PyBullet and MuJoCo it falls off where the table ends at -0.165 m, and stays where it does at -0.17."""
    high = task.table.center[0] + task.table.size[0] / 2
    short = replace(task.table, center=((ends + high) / 2, 0.0), size=(high - ends, task.table.size[1]))
    assert ("pail tips on over the edge of table" in said(replace(task, table=short), plan)) == tips


def test_it_falls_no_farther_than_onto_the_next_face(task, plan):
    def over(fall):
        half = Pose.from_rpy((0.0, 0.0, 0.0), (np.pi / 2, 0.0, 0.0))
        return replace(fall, pose=Pose(fall.pose.xyz, (fall.pose @ half @ half).quat))

    assert "cannot fall flat by a turn" in said(task, edited(plan, over, Fall))


@pytest.mark.parametrize("mutation", CORRUPTIONS, ids=lambda mutation: mutation.__name__)
def test_a_corrupted_topple_is_wrong_and_rejected_for_its_own_reason(task, plan, mutation):
    assert_wrong_and_rejected(mutation(task, plan, np.random.default_rng(0)), CORRUPTIONS[mutation])


def test_the_oracle_finds_nothing_wrong_with_a_valid_one(task, plan):
    pytest.importorskip("pinocchio")
    from tests.checking.oracle import wrong

    assert wrong(task, plan) is None


def test_what_is_toppled_beside_where_it_is_said_to_be_lies_as_far_aside(task, plan):
    """It was forgotten that it is aside, and it was met, and taken up, where it does not lie."""
    k = next(k for k, action in enumerate(plan.actions) if action.name == "topple")
    short, by = replace(plan, actions=plan.actions[: k + 1]), Pose((0.0, 0.0019, 0.0))

    def said_aside(move):
        tool = Pose.from_matrix(tree().tool(move.trajectory.positions[:1])[0])
        return replace(move, pushed=replace(move.pushed, T_tool_object=tool.inverse() @ by @ plan.start["pail"]))

    assert "pail" not in check(task, short).state.stayed
    aside = edited(edited(short, said_aside), lambda fall: replace(fall, pose=by @ fall.pose), Fall)
    state = check(task, aside).state
    off = (state.stayed["pail"] - state.poses["pail"])[:3, 3]
    assert np.abs(off - (0.0, -0.0019, 0.0)).max() < 1e-4
