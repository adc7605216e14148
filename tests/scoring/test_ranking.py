"""Rankings: what is counted, who comes first, and how sure one may be."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tamp.errors import TampError
from tamp.results import Result
from tamp.scoring.ranking import Yardstick, measure, rank, recall
from tamp.task import At, Box, Object, On, Pose, Region, Task

TASKS = (Yardstick("a", 0.4, 0.8, 1), Yardstick("b", 0.2, 0.6, 1), Yardstick("c", 0.3, 0.7, 2))


def _run(task: str, ede_m: float | None, seconds: float = 10.0, seed: int = 0, **fields: object) -> Result:
    status = "failed" if ede_m is None or ede_m > 0.03 else "solved"
    return Result(task, seed, status, execution_sim_s=seconds, ede_m=ede_m, **fields)  # type: ignore[arg-type]


def _all(error: float, seconds: float = 10.0) -> list[Result]:
    return [_run(task.task, error, seconds) for task in TASKS]


def test_the_smaller_mean_error_comes_first_and_time_decides_between_equals() -> None:
    ranked = rank({"slow": _all(0.1, 20), "worse": _all(0.2, 1), "quick": _all(0.1, 10), "twin": _all(0.1, 10)}, TASKS)
    assert [(s.rank, s.solution) for s in ranked] == [(1, "quick"), (1, "twin"), (3, "slow"), (4, "worse")]
    assert ranked[0].mean.error_m == pytest.approx(0.1)
    assert ranked[0].mean.improvement == pytest.approx(1 - 0.1 / 0.3)
    assert ranked[0].mean.improvement_ueb == pytest.approx(1 - 0.1 / 0.7)


def test_what_was_not_attempted_or_left_no_score_counts_as_doing_nothing() -> None:
    (some,) = rank({"some": [_run("a", 0.1), _run("b", None)]}, TASKS)
    assert some.mean.error_m == pytest.approx((0.1 + 0.2 + 0.3) / 3)
    assert (some.attempted, some.solved, some.execution_s) == (1, 0, 10.0)
    (none,) = rank({"none": []}, TASKS)
    assert (none.mean.improvement, none.attempted, none.execution_s, none.grasp_success) == (0.0, 0, None, None)


def test_levels_have_means_of_their_own() -> None:
    (s,) = rank({"s": [_run("a", 0.2), _run("b", 0.0), _run("c", 0.15)]}, TASKS)
    assert {level: (m.tasks, m.error_m, m.improvement) for level, m in s.levels.items()} == {
        1: (2, pytest.approx(0.1), pytest.approx(1 - 0.1 / 0.3)),
        2: (1, pytest.approx(0.15), pytest.approx(0.5)),
    }
    assert s.as_dict()["levels"][2]["error_m"] == pytest.approx(0.15)


def test_runs_count_by_their_mean_or_the_best_of_the_first_k() -> None:
    runs = [_run("a", error, seed=seed) for seed, error in enumerate((0.3, 0.1, 0.0))]
    runs.append(_run("a", None, seed=3))
    errors = {k: rank({"s": runs}, TASKS[:1], best_of=k)[0].mean.error_m for k in (None, 1, 2, 3)}
    assert errors == {None: pytest.approx((0.3 + 0.1 + 0.0 + 0.4) / 4), 1: 0.3, 2: 0.1, 3: 0.0}
    assert rank({"s": list(reversed(runs))}, TASKS[:1], best_of=2)[0].mean.error_m == 0.1


def test_with_the_best_of_runs_the_better_simulator_over_all_tasks_counts() -> None:
    errors = {"x": (0.1, 0.2, 0.3), "y": (0.3, 0.1, 0.1)}
    runs = [
        _run(task.task, error, simulator=simulator)
        for simulator, each in errors.items()
        for task, error in zip(TASKS, each, strict=True)
    ]
    means = {k: rank({"s": runs}, TASKS, best_of=k)[0].mean.error_m for k in (None, 1)}
    assert means == {None: pytest.approx(1.1 / 6), 1: pytest.approx(0.5 / 3)}
    assert rank({"none": []}, TASKS, best_of=1)[0].attempted == 0


def test_the_best_of_equal_runs_is_the_quickest() -> None:
    runs = [_run("a", 0.1, seconds=30, seed=0), _run("a", 0.1, seconds=20, seed=1)]
    assert rank({"s": runs}, TASKS[:1], best_of=2)[0].execution_s == 20


def test_grasps_are_counted_over_the_runs_that_count() -> None:
    runs = [_run("a", 0.1, grasps_attempted=4, grasps_succeeded=3), _run("x", 0.1, grasps_attempted=9)]
    assert rank({"s": runs}, TASKS)[0].grasp_success == 0.75


@given(st.lists(st.floats(0, 1), min_size=1, max_size=8), st.integers(0, 5))
def test_the_interval_holds_the_mean_lies_within_the_errors_and_repeats(errors: list[float], seed: int) -> None:
    tasks = tuple(Yardstick(f"t{i}", 1.0, 2.0) for i in range(len(errors)))
    runs = [_run(task.task, error) for task, error in zip(tasks, errors, strict=True)]
    (s,) = rank({"s": runs}, tasks, seed=seed)
    low, high = s.interval_m
    assert min(errors) - 1e-9 <= low <= high <= max(errors) + 1e-9
    assert low - 1e-9 <= s.mean.error_m <= high + 1e-9 or len(set(errors)) > 1
    assert rank({"s": runs}, tasks, seed=seed)[0] == s


def test_the_interval_is_as_wide_as_theory_says() -> None:
    """Half of many tasks fail: the standard error of the mean is 0.5 / sqrt(n)."""
    tasks = tuple(Yardstick(f"t{i}", 1.0, 2.0) for i in range(400))
    (s,) = rank({"s": [_run(task.task, float(i % 2)) for i, task in enumerate(tasks)]}, tasks)
    assert s.interval_m == (pytest.approx(0.5 - 1.96 * 0.025, abs=0.005), pytest.approx(0.5 + 1.96 * 0.025, abs=0.005))


def test_yardsticks_come_from_tasks_or_from_results() -> None:
    box = Box((0.06, 0.06, 0.06))
    posed = Task("p", (Object("o", box, Pose((0, 0, 0.03)), At(Pose((0.1, 0, 0.03)))),), level=3)
    symbolic = Task("s", (Object("o", box, Pose(), On("r")),), regions=(Region("r", (0, 0), (0.1, 0.1)),))
    assert measure([posed, symbolic]) == (Yardstick("p", pytest.approx(0.1), pytest.approx(0.3), 3),)
    told = replace(_run("p", 0.0), do_nothing_ede_m=0.1, mean_ueb_m=0.3, level=3)
    assert recall([_run("s", None), told, _run("p", None)]) == (Yardstick("p", 0.1, 0.3, 3),)


def test_an_empty_set_ranks_nobody() -> None:
    with pytest.raises(TampError, match="no task with a goal pose"):
        rank({"s": []}, ())
