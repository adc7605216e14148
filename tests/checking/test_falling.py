from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import tamp
from tamp.checking import check
from tamp.task import Box, Fall, Object, Pose

SCENARIO = Path(__file__).parents[2] / "scenarios" / "lay_book.yaml"


@pytest.fixture(scope="module")
def task():
    return tamp.load_task(SCENARIO)


@pytest.fixture(scope="module")
def plan(task):
    return tamp.plan(task, seed=0, timeout=100.0)


def with_fall(plan, fall):
    """The plan with another step, or none, in place of its fall."""
    actions = tuple(
        replace(a, steps=tuple(new for s in a.steps if (new := fall if isinstance(s, Fall) else s) is not None))
        for a in plan.actions
    )
    return replace(plan, actions=actions)


def fallen(plan):
    return next(s for a in plan.actions for s in a.steps if isinstance(s, Fall))


def said(task, plan):
    return " ".join(p.sentence for p in check(task, plan, start=dict(plan.start)).problems if p.kind != "goal")


def test_a_book_laid_on_its_edge_falls_flat(task, plan):
    assert plan.actions[-1].name == "lay"
    assert check(task, plan).accepted


def test_a_fall_does_not_carry_an_object_elsewhere(task, plan):
    fall = fallen(plan)
    beside = Pose((0.05, 0.0, 0.0)) @ fall.pose
    assert "slide 50 mm" in said(task, with_fall(plan, replace(fall, pose=beside)))


def test_a_fall_does_not_turn_an_object_about_the_vertical(task, plan):
    fall = fallen(plan)
    turned = replace(fall, pose=fall.pose @ Pose.from_rpy((0, 0, 0), (0, 0, 0.5)))
    assert "turn sideways" in said(task, with_fall(plan, turned))


def test_nothing_falls_up(task, plan):
    fall = fallen(plan)
    upright = replace(fall, pose=Pose((*fall.pose.xyz[:2], 0.1), (np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5))))
    assert "would not fall to that side" in said(task, with_fall(plan, upright))


def test_without_a_fall_a_tilted_book_does_not_stay(task, plan):
    problems = said(task, with_fall(plan, None))
    assert "drop nothing" in problems
    assert "tips over" in problems


def test_what_lies_where_an_object_falls_is_hit(task, plan):
    goal = plan.goals["book"]
    brick = Object("brick", Box((0.03, 0.03, 0.03)), Pose((goal.xyz[0], goal.xyz[1], 0.015)))
    crowded = replace(task, objects=(*task.objects, brick))
    known = replace(plan, start={**plan.start, "brick": brick.pose})
    assert "book falls" in said(crowded, known)
    assert "into brick" in said(crowded, known)
