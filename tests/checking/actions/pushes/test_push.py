from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

import tamp
from tamp.checking import check
from tamp.checking.robot.links import read_links
from tamp.checking.tolerances import DEFAULT
from tamp.streams.pushing.slide import plan_sliding
from tamp.task import Box, Inertia, Move, Object, Pose, Trajectory, load_robot
from tamp.world.robot.model import robot_model
from tests.checking.judging import assert_wrong_and_rejected
from tests.checking.mutations import PUSHES, push_tips_aslant, push_what_slips

SCENARIO = "slide_box"


def pushing(plan):
    return next(s for a in plan.actions for s in a.steps if isinstance(s, Move) and s.pushed)


def with_push(plan, push):
    """The plan with another motion in place of its push."""
    old = pushing(plan)
    actions = tuple(replace(a, steps=tuple(push if s is old else s for s in a.steps)) for a in plan.actions)
    return replace(plan, actions=actions)


def said(task, plan, **known):
    return " ".join(p.sentence for p in check(task, plan, start=dict(plan.start), **known).problems)


def test_a_flat_box_is_slid_over_the_edge_and_gripped_there(task, plan):
    assert [a.name for a in plan.actions] == ["move", "slide", "move", "pick", "move", "place"]
    assert check(task, plan).accepted


def test_a_push_begins_where_the_object_is(task, plan):
    push = pushing(plan)
    beside = replace(push.pushed, T_tool_object=Pose((0.01, 0.0, 0.0)) @ push.pushed.T_tool_object)
    assert "from where the plan says" in said(task, with_push(plan, replace(push, pushed=beside)))


def test_an_object_that_no_finger_touches_is_not_pushed(task, plan):
    start = {**plan.start, "box": Pose((0.02, 0.2, 0.0)) @ plan.start["box"]}
    push = pushing(plan)
    away = replace(push.pushed, T_tool_object=push.pushed.T_tool_object @ Pose((0.02, 0.2, 0.0)))
    moved = replace(with_push(plan, replace(push, pushed=away)), start=start)
    assert "no finger touches box" in said(task, moved)


def test_what_a_hand_does_not_quite_touch_lags_behind_and_that_adds_up(task, plan):
    """Ten pushes from 2.5 mm away leave it that much farther behind each time."""
    push = pushing(plan)
    robot, held = robot_model(load_robot("panda")), push.pushed.T_tool_object.matrix
    tool, end = (robot.forward(push.trajectory.positions[k]) @ held for k in (0, -1))
    ahead = tool[:3, :3].T @ (end - tool)[:3, 3]
    by = Pose(tuple(0.002 * ahead / np.linalg.norm(ahead)))
    away = replace(push.pushed, T_tool_object=push.pushed.T_tool_object @ by)
    moved = replace(with_push(plan, replace(push, pushed=away)), start={**plan.start, "box": plan.start["box"] @ by})
    strict = replace(DEFAULT, strayed=0.002)
    assert re.search(r"shifts of box that nothing explains add up to 2\.\d mm", said(task, moved, allow=strict))
    assert "shifts of box" not in said(task, plan, allow=strict)


def test_a_motion_that_pushes_nothing_slides_nothing(task, plan):
    found = said(task, with_push(plan, replace(pushing(plan), pushed=None)))
    assert "push nothing" in found and "a push motion that pushes nothing" in found


def test_a_hand_that_slows_down_fast_loses_what_it_pushes(task, plan):
    push = pushing(plan)
    old = push.trajectory
    hasty = Trajectory(old.times / 6, old.positions, old.velocities * 6)
    assert "slides on when the hand slows down" in said(task, with_push(plan, replace(push, trajectory=hasty)))


def test_an_object_is_not_pushed_so_far_that_it_may_tip_over_the_edge(task, plan):
    length, width = task.table.size
    smaller = replace(task, table=replace(task.table, size=(length - 0.03, width - 0.03)))
    assert "may tip over" in said(smaller, plan)


def test_what_is_tall_tips_backwards_where_it_is_pushed_hastily_near_its_foot(task, plan):
    high = Inertia(Pose((0.0, 0.0, 1.0)), (1e-3, 1e-3, 1e-3))
    tall = replace(task, objects=tuple(replace(o, inertia=high) for o in task.objects))
    push = pushing(plan)
    old = push.trajectory
    for factor, tips in ((0.5, True), (10.0, False)):
        timed = Trajectory(old.times * factor, old.positions, old.velocities / factor)
        found = said(tall, with_push(plan, replace(push, trajectory=timed)))
        assert ("box would tip backwards: it is sped up by" in found) == tips


def test_what_sticks_to_the_table_tips_over_before_it_slides(task, plan):
    sticky = replace(task, objects=tuple(replace(o, friction=30.0) for o in task.objects))
    assert "box would tip over" in said(sticky, plan)


def test_the_hand_that_pushes_grazes_nothing_whatever_the_plan_says(task, plan):
    push = pushing(plan)
    tree = read_links(load_robot(task.robot)).tree
    middle = push.trajectory.positions[len(push.trajectory.times) // 2 :][:1]
    hand = next(solid for solid in read_links(load_robot(task.robot)).solids if solid.name == "panda_hand")
    T = tree.forward(middle, push.opening)["panda_hand"][0]
    corners = hand.hull.part.vertices @ T[:3, :3].T + T[:3, 3]
    side = corners[corners[:, 1].argmax()]  # 3 mm of it are beyond the peg's face
    peg = Object("peg", Box((0.02, 0.02, side[2] + 0.02)), Pose((side[0], side[1] + 0.007, side[2] / 2 + 0.01)))
    crowded, started = replace(task, objects=(*task.objects, peg)), {**plan.start, "peg": peg.pose}
    claimed = replace(push, contacts=push.contacts | {("robot", "peg")})
    found = check(crowded, replace(with_push(plan, claimed), start=started), start=started).problems
    assert any({"panda_hand", "peg"} == {*p.bodies} and p.action == 1 for p in found), found


def left_at(task, plan):
    """Where the push leaves the box, shape (3,), by another robot model than the checker's."""
    push = pushing(plan)
    T = robot_model(load_robot(task.robot)).forward(push.trajectory.positions[-1])
    return (T @ push.pushed.T_tool_object.matrix)[:3, 3]


def test_what_stands_in_its_way_is_not_pushed_along(task, plan):
    x, y, _ = (left_at(task, plan) + plan.start["box"].xyz) / 2
    peg = Object("peg", Box((0.02, 0.02, 0.04)), Pose((float(x), float(y), 0.02)))
    crowded = replace(task, objects=(*task.objects, peg))
    found = said(crowded, replace(plan, start={**plan.start, "peg": peg.pose}))
    assert "box and peg interpenetrate" in found


def test_what_stands_on_it_is_not_slid_along(task, plan):
    x, y, _ = plan.start["box"].xyz
    rider = Object("rider", Box((0.03, 0.03, 0.03)), Pose((x, y, 0.06)))
    loaded = replace(task, objects=(*task.objects, rider))
    found = said(loaded, replace(plan, start={**plan.start, "rider": rider.pose}))
    assert "rider stands on box, which is taken away" in found


@pytest.fixture(scope="module")
def aslant(task):
    """A plan that pushes as far off the flank's normal as friction allows."""

    def last_of_all(context, obj, placement):
        yield from reversed(list(plan_sliding(context, obj, placement)))

    return tamp.plan(task, seed=0, timeout=100.0, samplers={"plan-sliding": last_of_all})


ASLANT = (push_what_slips, push_tips_aslant)


@pytest.mark.parametrize("mutation", ASLANT, ids=lambda mutation: mutation.__name__)
def test_fingers_that_push_a_flank_aslant_neither_slip_along_it_nor_tip_what_it_is_of(task, aslant, mutation):
    assert_wrong_and_rejected(mutation(task, aslant, np.random.default_rng(0)), PUSHES[mutation])


@pytest.mark.parametrize("mutation", [m for m in PUSHES if m not in ASLANT], ids=lambda mutation: mutation.__name__)
def test_a_corrupted_push_is_wrong_and_rejected_for_its_own_reason(task, plan, mutation):
    assert_wrong_and_rejected(mutation(task, plan, np.random.default_rng(0)), PUSHES[mutation])


def test_the_oracle_finds_nothing_wrong_with_a_valid_one(task, plan):
    pytest.importorskip("pinocchio")
    from tests.checking.oracle import wrong

    assert wrong(task, plan) is None
