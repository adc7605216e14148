"""Whole tasks by each metric: who is held against whose goal, what is lost, what the baselines are."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.scoring import METRICS, Metric, evaluate, metric, score
from tamp.task import At, Box, Object, Pose, Symmetry, Task

coordinate = st.floats(-0.4, 0.4)
angle = st.floats(-math.pi, math.pi)
poses = st.builds(Pose.from_rpy, st.tuples(coordinate, coordinate, st.floats(0, 0.4)), st.tuples(angle, angle, angle))
BOX, OTHER = Box((0.06, 0.05, 0.04)), Box((0.06, 0.05, 0.041))
UP, DOWN = Pose((0.1, 0.2, 0.03)), Pose((0.1, -0.2, 0.03))


def _task(*things: tuple[Box, Pose, Pose | None]) -> Task:
    return Task("t", tuple(Object(f"o{i}", s, p, None if g is None else At(g)) for i, (s, p, g) in enumerate(things)))


SWAPPED = _task((BOX, UP, DOWN), (BOX, DOWN, UP))


@pytest.mark.parametrize(
    ("name", "swaps"), [("ede", False), ("ocrtoc2020", False), ("ocrtoc2021", True), ("ocrtoc2024", True)]
)
def test_alike_objects_may_take_each_others_goals_where_the_metric_says_so(name: str, swaps: bool) -> None:
    result = evaluate(SWAPPED, {"o0": UP, "o1": DOWN}, metric(name))
    assert (result.error == 0) is swaps
    assert [o.goal_of for o in result.objects] == (["o1", "o0"] if swaps else ["o0", "o1"])
    assert result.do_nothing == result.error
    assert result.improvement == (None if swaps else 0.0)


def test_objects_of_other_shape_or_symmetry_are_not_alike() -> None:
    unlike = _task((BOX, UP, DOWN), (OTHER, DOWN, UP))
    assert [o.goal_of for o in evaluate(unlike, {"o0": UP, "o1": DOWN}, metric("ocrtoc2021")).objects] == ["o0", "o1"]
    marked = Task("t", (SWAPPED.objects[0], Object("o1", BOX, DOWN, At(UP), symmetry=Symmetry(z=2))))
    assert evaluate(marked, {"o0": UP, "o1": DOWN}, metric("ocrtoc2021")).objects[0].goal_of == "o0"


@settings(max_examples=25)
@given(st.lists(st.tuples(poses, poses), min_size=1, max_size=4), st.sampled_from(METRICS))
def test_an_exchange_can_only_help(ends: list[tuple[Pose, Pose]], m: Metric) -> None:
    """Against the same metric with every object kept to its own goal."""
    task = _task(*((BOX, Pose(), goal) for _, goal in ends))
    final = {f"o{i}": end for i, (end, _) in enumerate(ends)}
    by_name = [min(m.error(o, final[o.name], o.goal.pose), m.bound(o)) for o in task.objects]  # type: ignore[union-attr]
    result = evaluate(task, final, m)
    assert sum(min(o.error, o.bound) for o in result.objects) <= sum(by_name) + 1e-9
    assert sorted(o.goal_of for o in result.objects) == sorted(final)


@pytest.mark.parametrize("m", METRICS, ids=lambda m: m.name)
def test_a_lost_object_counts_for_its_bound_whoevers_goal_it_takes(m: Metric) -> None:
    for where in (None, Pose((0.1, -0.2, -0.7))):
        result = evaluate(SWAPPED, {"o0": where, "o1": UP}, m)
        assert result.lost == ("o0",)
        assert [o.lost for o in result.objects] == [True, False]
        assert result.objects[0].counted == result.objects[0].bound
        assert result.objects[1].counted == 0
        assert result.objects[1].goal_of == "o1"


def test_the_papers_metric_is_the_score() -> None:
    final = {"o0": DOWN, "o1": Pose((0, 0, 0.03))}
    by_name, whole = evaluate(SWAPPED, final, metric("ede")), score(SWAPPED, final)
    assert (by_name.error, by_name.bound, by_name.do_nothing) == (whole.ede_m, whole.mean_ueb_m, whole.do_nothing_ede_m)
    assert (by_name.improvement, by_name.improvement_bound) == (whole.improvement, whole.improvement_ueb)


def test_the_share_in_place_stands_beside_the_measure_of_2024() -> None:
    shift = 0.06 * 0.15 / 1.85  # an overlap of 85 %
    final = {"o0": Pose((0.1 + shift, -0.2, 0.03)), "o1": None}
    said = evaluate(SWAPPED, final, metric("ocrtoc2024")).as_dict()
    assert (said["error"], said["unit"]) == (0.5, "")
    assert said["in_place"] == {"0.5": 0.5, "0.6": 0.5, "0.7": 0.5, "0.8": 0.5, "0.9": 0.0}
    assert "in_place" not in evaluate(SWAPPED, final, metric("ede")).as_dict()


def test_a_task_without_goal_poses_has_no_error() -> None:
    result = evaluate(_task((BOX, UP, None)), {"o0": None}, metric("ocrtoc2024"))
    assert (result.error, result.bound, result.do_nothing, result.improvement) == (None, None, None, None)
    assert result.lost == ("o0",)
    assert result.as_dict()["in_place"] == {}
