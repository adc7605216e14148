"""What a contest's rounding does to a table is settled and said, never refused."""

from __future__ import annotations

import numpy as np
import pytest

import tamp
from tamp.pipeline.prepare import prepare
from tamp.pipeline.solving.solve import carry_out
from tamp.task import At, Box, Object, Pose, Task

LONG = Box((0.2, 0.03, 0.03))
TURNED = Pose.from_rpy((0.0, 0.25, 0.015), (0.0, 0.0, np.pi / 2))


def crossed() -> Task:
    """Two bars through each other away from their middles, and a goal 6 cm in the air."""
    first = Object("first", LONG, Pose((0.06, 0.2, 0.015)), At(Pose((0.0, -0.2, 0.075))))
    return Task("crossed", (first, Object("second", LONG, TURNED)))


def test_what_is_put_through_each_other_is_parted() -> None:
    setup = prepare(crossed())
    poses = {name: pose.matrix for name, pose in setup.start.items()}
    assert not setup.world.overlap("first", poses["first"], "second", poses["second"], tolerance=0.003)
    assert all(np.linalg.norm(T[:2, 3] - (0.03, 0.225)) < 0.1 for T in poses.values())


def test_what_settles_elsewhere_is_said_and_scored_as_given() -> None:
    remarks = prepare(crossed()).remarks
    assert "the goal of first settles 6 cm from its pose, which the score counts from" in remarks
    run = carry_out(crossed(), seed=0, timeout=60.0)
    assert run.result.remarks == remarks
    assert run.result.ede_m == pytest.approx(0.06, abs=0.012)
    assert run.result.plan_checked


def test_the_plan_for_such_a_table_is_accepted_from_the_task_alone() -> None:
    plan = tamp.plan(crossed(), seed=0, timeout=60.0)
    assert tamp.check(crossed(), plan).accepted
