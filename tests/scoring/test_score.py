"""The paper's error: its laws, its bounds, and what counts."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.errors import TaskError
from tamp.scoring import ede, score, upper_error_bound
from tamp.task import At, Box, Object, On, Pose, Region, Task

coordinate = st.floats(-2, 2)
angle = st.floats(-math.pi, math.pi)
poses = st.builds(Pose.from_rpy, st.tuples(coordinate, coordinate, coordinate), st.tuples(angle, angle, angle))
edges = st.floats(0.01, 0.5)


@given(edges, poses)
def test_ede_of_equal_poses_is_zero(edge: float, pose: Pose) -> None:
    assert ede(edge, pose, pose) == 0.0


@given(edges, poses, poses)
def test_ede_is_symmetric(edge: float, a: Pose, b: Pose) -> None:
    assert ede(edge, a, b) == pytest.approx(ede(edge, b, a), abs=1e-12)


@given(edges, poses, poses, poses)
def test_ede_does_not_see_a_common_motion(edge: float, a: Pose, b: Pose, motion: Pose) -> None:
    assert ede(edge, motion @ a, motion @ b) == pytest.approx(ede(edge, a, b), abs=1e-9)


@given(edges, poses, st.floats(0, 1), st.floats(0, 1))
def test_ede_of_a_shift_is_its_length_and_grows_with_it(edge: float, pose: Pose, short: float, more: float) -> None:
    x, y, z = pose.xyz
    near, far = (ede(edge, Pose((x + d, y, z), pose.quat), pose) for d in (short, short + more))
    assert near == pytest.approx(short, abs=1e-9)
    assert near <= far + 1e-12


@given(edges, poses, poses, poses)
def test_ede_obeys_the_triangle_inequality(edge: float, a: Pose, b: Pose, c: Pose) -> None:
    assert ede(edge, a, c) <= ede(edge, a, b) + ede(edge, b, c) + 1e-9


def test_a_half_turn_moves_each_vertex_by_the_diagonal_of_a_face() -> None:
    turned = Pose.from_rpy((0, 0, 0), (0, 0, math.pi))
    assert ede(0.1, turned, Pose()) == pytest.approx(0.1 * math.sqrt(2))


def _task(**goals: object) -> Task:
    box = Box((0.06, 0.06, 0.06))
    names = ("a", "b", "c")
    return Task(
        "t",
        tuple(Object(n, box, Pose((0, 0.2 * i, 0.03)), goals.get(n)) for i, n in enumerate(names)),  # type: ignore[arg-type]
        regions=(Region("r", (0.1, 0.1), (0.1, 0.1)),),
    )


def _start(task: Task) -> dict[str, Pose | None]:
    return {o.name: o.pose for o in task.objects}


@settings(max_examples=50)
@given(poses)
def test_no_object_counts_for_more_than_its_bound(pose: Pose) -> None:
    task = _task(a=At(Pose((0.1, 0, 0.03))))
    result = score(task, {**_start(task), "a": pose})
    assert result.ede_m is not None
    assert result.ede_m <= upper_error_bound(Box((0.06, 0.06, 0.06))) == pytest.approx(0.3)
    assert result.objects[0].error_m == result.ede_m


def test_doing_nothing_improves_nothing_and_doing_all_improves_all() -> None:
    task = _task(a=At(Pose((0.1, 0, 0.03))), b=At(Pose((0.1, 0.2, 0.03))))
    idle = score(task, _start(task))
    assert (idle.improvement, idle.ede_m, idle.mean_ueb_m) == (0.0, pytest.approx(0.1), pytest.approx(0.3))
    assert not idle.solved
    done = score(task, {**_start(task), **{o.name: o.goal.pose for o in task.objects if isinstance(o.goal, At)}})
    assert (done.ede_m, done.improvement, done.improvement_ueb, done.solved) == (0.0, 1.0, 1.0, True)
    assert [o.name for o in done.objects] == ["a", "b"]


def test_three_centimetres_decide() -> None:
    task = _task(a=At(Pose((0.1, 0, 0.03))))
    for shift, solved in ((0.029, True), (0.031, False)):
        assert score(task, {**_start(task), "a": Pose((0.1 + shift, 0, 0.03))}).solved is solved


def test_a_lost_object_counts_for_its_bound() -> None:
    task = _task(a=At(Pose((0, 0, 0.03))))
    for where in (None, Pose((0, 0, -0.7)), Pose((0, 0, -0.05))):
        result = score(task, {**_start(task), "a": where})
        assert result.lost == ("a",)
        assert result.objects[0].lost
        assert result.ede_m == pytest.approx(0.3)
        assert not result.solved


def test_a_goal_on_a_region_asks_for_the_centre_inside() -> None:
    task = _task(a=On("r"))
    for x, met in ((0.1, True), (0.149, True), (0.151, False)):
        result = score(task, {**_start(task), "a": Pose((x, 0.1, 0.03))})
        assert result.goals_met == {"a": met}
        assert result.solved is met
        assert result.ede_m is result.improvement is None


def test_a_goal_on_an_object_asks_for_its_height_too() -> None:
    task = _task(a=On("b"))
    for z, met in ((0.09, True), (0.03, True), (0.2, False), (-0.02, False)):
        assert score(task, {**_start(task), "a": Pose((0, 0.2, z))}).goals_met["a"] is met


def test_every_object_needs_a_pose() -> None:
    with pytest.raises(TaskError, match="lack b, c"):
        score(_task(), {"a": Pose()})


@pytest.mark.parametrize("wrong", [np.eye(4), {"xyz": [0, 0, 0]}, (0, 0, 0)])
def test_what_is_no_pose_is_named(wrong: Any) -> None:
    with pytest.raises(TaskError, match=f"pose of a is a {type(wrong).__name__}; expected .* tamp.Pose"):
        score(_task(), {**_start(_task()), "a": wrong})
    with pytest.raises(TaskError, match="the final poses are a list; expected a mapping"):
        score(_task(), [wrong])  # type: ignore[arg-type]


def test_a_score_without_goals_is_solved_and_says_so_in_json() -> None:
    task = _task()
    assert score(task, _start(task)).as_dict()["solved"] is True
