from __future__ import annotations

import pytest

from tamp.scoring.ede import upper_error_bound
from tamp.scoring.total_error import shortfall
from tamp.task import At, Box, Object, On, Pose, Task

RED = Object("red", Box((0.05, 0.05, 0.08)), Pose((0.05, 0.2, 0.04)), At(Pose((0.05, -0.2, 0.04))))
TOP = Object("top", Box((0.04, 0.04, 0.04)), Pose((0.15, 0.05, 0.02)), On("red"))
TASK = Task("tower", (RED, TOP))


def test_poses_count_by_distance_and_relations_in_full_until_they_hold():
    away = upper_error_bound(TOP.shape)
    assert shortfall(TASK, {"red": RED.pose, "top": TOP.pose}) == pytest.approx(
        min(0.4, upper_error_bound(RED.shape)) + away
    )
    there = Pose((0.05, -0.2, 0.04))
    assert shortfall(TASK, {"red": there, "top": TOP.pose}) == pytest.approx(away)
    assert shortfall(TASK, {"red": there, "top": Pose((0.05, -0.2, 0.1))}) == pytest.approx(0.0, abs=1e-9)


def test_what_is_far_away_counts_no_more_than_its_bound():
    task = Task("one", (RED,))
    assert shortfall(task, {"red": Pose((9.0, 0.0, 0.0))}) == pytest.approx(upper_error_bound(RED.shape))
