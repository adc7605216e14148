"""Whether where something ends is chance, found without the robot."""

from __future__ import annotations

from benchmarks.ends import BOUND_M
from benchmarks.parts.steadiness import spread
from tamp.task import Box, Pose
from tests.checking.handmade import alone


def put_down(thickness: float, height: float) -> list[float]:
    """How far from where it is put a board comes to rest that stands on its edge, let go from near there."""
    start, end = Pose((0.05, -0.2, height / 2)), Pose((0.05, 0.2, height / 2))
    task, plan = alone(Box((0.04, thickness, height)), start, end, thickness, height / 2 - 0.03)
    return spread(task, plan, len(plan.actions) - 1)


def test_what_stands_broad_ends_where_it_is_put_and_what_stands_narrow_may_not() -> None:
    assert max(put_down(0.04, 0.06)) < 0.003
    narrow = put_down(0.002, 0.2)
    assert min(narrow) < BOUND_M < max(narrow)


def test_what_lets_nothing_go_ends_nowhere() -> None:
    task, plan = alone(Box((0.04, 0.04, 0.06)), Pose((0.05, -0.2, 0.03)), Pose((0.05, 0.2, 0.03)), 0.04)
    assert [spread(task, plan, index) for index in range(3)] == [[], [], []]
