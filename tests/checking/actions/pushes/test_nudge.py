from __future__ import annotations

from dataclasses import replace

import pytest

from tamp.checking import check
from tamp.checking.tolerances import DEFAULT
from tamp.task import At, Box, Mesh, Move, Object, Plan, Pose, Task
from tests.checking.handmade import Hand
from tests.checking.test_carried_astray import HOME, calm, pushed_on
from tests.task.meshes import parts_obj

SCENARIO = "nudge_in_crate"


def edited(plan, edit):
    """The plan with its nudge changed."""
    *before, nudge = plan.actions
    steps = tuple(edit(s) if isinstance(s, Move) and s.pushed is not None else s for s in nudge.steps)
    return replace(plan, actions=(*before, replace(nudge, steps=steps)))


def moved(plan, x, y):
    """The plan with the slab elsewhere when it is nudged; plan and start agree on that."""
    start = plan.start["slab"]
    there = Pose((x, y, 0.0)) @ start

    def edit(move):
        at = move.pushed.T_tool_object @ start.inverse() @ there
        return replace(move, pushed=replace(move.pushed, T_tool_object=at))

    return replace(edited(plan, edit), start={**plan.start, "slab": there})


def said(task, plan, **known):
    return " ".join(p.sentence for p in check(task, plan, start=dict(plan.start), **known).problems)


def with_peg(task, plan, pose, size=(0.02, 0.02, 0.05)):
    peg = Object("peg", Box(size), pose)
    return replace(task, objects=(*task.objects, peg)), replace(plan, start={**plan.start, "peg": peg.pose})


def test_a_nudge_as_it_is_planned_is_accepted(task, plan):
    assert check(task, plan).accepted


def test_a_nudge_begins_where_the_object_is(task, plan):
    beside = Pose((0.01, 0.0, 0.0))
    found = said(
        task,
        edited(plan, lambda m: replace(m, pushed=replace(m.pushed, T_tool_object=beside @ m.pushed.T_tool_object))),
    )
    assert "from where the plan says" in found


def test_a_finger_that_is_not_at_the_object_does_not_nudge_it(task, plan):
    assert "no finger touches slab" in said(task, moved(plan, 0.02, 0.0))


def test_a_finger_that_presses_past_the_centre_of_mass_turns_the_object(task, plan):
    assert "does not press towards its centre of mass" in said(task, moved(plan, 0.0, 0.04))


def test_a_long_nudge_is_not_believed(task, plan):
    assert "nobody knows where it comes to rest" in said(task, plan, allow=replace(DEFAULT, nudged=0.02))


def test_nudges_that_follow_each_other_add_up(task, plan):
    """Pushed on from where a nudge should have left it, an object is as far off its line as after a long one."""
    nudge = plan.actions[-1]
    again = replace(plan, actions=(*plan.actions, nudge))
    assert "60 mm since it was last gripped" in said(task, again)


def test_what_is_pushed_high_above_what_it_sticks_to_tips_over(task, plan):
    sticky = replace(task, objects=tuple(replace(o, friction=8.0) for o in task.objects))
    assert "slab would tip over" in said(sticky, plan)


def test_nothing_is_nudged_into_a_neighbour_whatever_the_plan_says(task, plan):
    x, y, _ = plan.goals["slab"].xyz
    crowded, pegged = with_peg(task, plan, Pose((x + 0.05, y, 0.031)))
    allowed = edited(pegged, lambda m: replace(m, contacts=m.contacts | {("slab", "peg")}))
    for each in (pegged, allowed):
        assert "slab and peg interpenetrate" in said(crowded, each)


def test_what_stands_on_it_would_fall(task, plan):
    x, y, z = plan.start["slab"].xyz
    loaded, pegged = with_peg(task, plan, Pose((x, y, z + 0.02 + 0.0125)), (0.025, 0.025, 0.025))
    assert "peg stands on slab, which is taken away" in said(loaded, pegged)


def test_a_thing_in_which_objects_slide_worse_than_it_does_itself_would_come_along(task, plan):
    slippery = replace(task, objects=tuple(replace(o, friction=1.5 if o.name == "slab" else 0.5) for o in task.objects))
    assert "crate would come along" in said(slippery, plan)


def test_on_the_table_nothing_is_nudged_off(task, plan):
    x, y, _ = plan.goals["slab"].xyz
    shorter = replace(task, table=replace(task.table, size=(0.05, 0.05), center=(x, y)))
    assert "slab" in said(shorter, moved(plan, 0.3, 0.0))


def over(tmp_path, parts, sunk=0.0):
    """What is said of a nudge by 4.8 cm of a box of 6 cm along y, over a slab 3 cm high of (from y, to y, high)."""
    mesh = tmp_path / "slab.obj"
    mesh.write_text(parts_obj([((-0.05, a, 0.0), (0.05, b, high)) for a, b, high in parts]))
    start = Pose((0.05, -0.032, 0.03 + 0.02 - sunk))
    actions, end = pushed_on(Hand(HOME), ("nudge", "box", "slab"), start, 0.048, 0.04)
    slab = Object("slab", Mesh(mesh), Pose((0.05, 0.0, 0.0)), mass=2.0)
    box = Object("box", Box((0.06, 0.06, 0.04)), start, At(end), mass=0.1)
    starts = {"slab": slab.pose, "box": start}
    plan = Plan("over", "panda", 0, starts, HOME, {"box": end}, calm(actions))
    return " ".join(problem.sentence for problem in check(Task("over", (slab, box)), plan).problems)


@pytest.mark.parametrize(
    ("deep", "wide", "tips"),
    [
        (2.8e-3, 0.036, True),
        (1.2e-3, 0.036, True),
        (2e-4, 0.036, True),
        (0.0, 0.036, False),
        (2.8e-3, 0.01, False),
        (2e-4, 0.01, False),
    ],
)
def test_nothing_is_nudged_over_a_notch_that_it_tips_into(tmp_path, deep, wide, tips):
    """In two simulators it caught there, and took the slab along: the box was 13 to 16 mm off, the slab 7 mm."""
    found = over(tmp_path, [(-0.15, 0.15, 0.03 - deep), (-0.15, -0.01, 0.03), (wide - 0.01, 0.15, 0.03)])
    assert ("box would tip into what is lower" in found) == tips, found
    assert bool(found) == tips, found


@pytest.mark.parametrize(("up", "sunk", "climbs"), [(6e-4, 0.0, True), (6e-4, 5e-4, True), (0.0, 5e-4, False)])
def test_what_is_sunk_within_tolerance_climbs_no_step(tmp_path, up, sunk, climbs):
    """In two simulators the slab came along, by 35 mm in one."""
    found = over(tmp_path, [(-0.15, 0.01, 0.03), (0.01, 0.15, 0.03 + up)], sunk)
    assert ("box presses on slab as it slides over it" in found) == climbs, found
    assert bool(found) == climbs, found


@pytest.mark.parametrize(("friction", "tips"), [(0.53, True), (0.45, False)])
def test_what_is_pushed_where_it_nearly_tips_lags_behind(friction, tips):
    """Pushed 36 mm high, 20 mm behind its edge, it rode on that: 9 and 15 mm behind in two simulators."""
    start = Pose((0.05, -0.1, 0.025))
    size = Box((0.06, 0.04, 0.05))
    actions, end = pushed_on(Hand(HOME), ("nudge", "box", "table"), start, 0.048, 0.02, half=0.02)
    box = Object("box", size, start, At(end), mass=0.2, friction=friction)
    plan = Plan("lags", "panda", 0, {"box": start}, HOME, {"box": end}, calm(actions))
    found = " ".join(problem.sentence for problem in check(Task("lags", (box,)), plan).problems)
    assert ("box would tip over" in found) == tips, found
    assert bool(found) == tips, found
