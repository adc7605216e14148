"""Tasks in code: what can be no pose or object is refused where it is made, a task in one sentence before planning."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import tamp
from tamp.errors import ModelError, PlanError
from tamp.task import At, Box, Inertia, Mesh, Object, On, Pose, Task
from tamp.task.files.plan_file import save_plan
from tamp.task.plan import Plan, Trajectory
from tamp.task.validate import validate

BOX, POSE = Box((0.05, 0.05, 0.05)), Pose((0.0, 0.0, 0.025))


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Pose((0, 0)), "a pose needs three finite coordinates"),  # type: ignore[arg-type]
        (lambda: Pose((0, 0, math.nan)), "a pose needs three finite coordinates"),
        (lambda: Pose("abc"), "a pose needs three finite coordinates"),  # type: ignore[arg-type]
        (lambda: Pose(quat=(0, 0, 0, 0)), "no orientation"),
        (lambda: Pose(quat=(1e-320, 0, 0, 0)), "no orientation"),
        (lambda: Pose(quat=(1e200, 0, 0, 0)), "finite"),
        (lambda: Box((0.1, 0.1)), "a box needs a size along x, y and z"),  # type: ignore[arg-type]
        (lambda: At((0, 0, 0)), "a goal needs a tamp.Pose"),  # type: ignore[arg-type]
        (lambda: Object("a", BOX, POSE, POSE), "a goal pose is tamp.At"),  # type: ignore[arg-type]
        (lambda: Object("a", BOX, (0, 0, 0)), "is no pose; valid are tamp.Pose"),  # type: ignore[arg-type]
        (lambda: Object("a", BOX, POSE, mass=-1), "object a: mass is -1; valid are positive numbers"),
        (lambda: Object("a", BOX, POSE, mass=1e160), r"valid are positive numbers up to 1e\+06"),
        (lambda: Object("a", BOX, POSE, mass=1e-6), "object a: mass is 1e-06; valid are .* and 1e-05 at least"),
        (lambda: Inertia(POSE, (1.0, 0.3, 0.3)), r"no body has the moments of inertia \(1.0, 0.3, 0.3\)"),
        (lambda: Inertia(POSE, (0.0, 1.0, 1.0)), "each is positive"),
        (lambda: Object("a", BOX, POSE, friction=1e300), r"object a: friction is 1e\+300"),
        (lambda: Object("a", BOX, POSE, mass="1"), "object a: mass is '1'"),  # type: ignore[arg-type]
        (lambda: Object("a", BOX, POSE, friction=math.nan), "object a: friction is nan"),
        (lambda: Task("t", (), goal=("Wiped", "x")), "goal: 'Wiped' is no fact; valid is a predicate"),  # type: ignore[arg-type]
        (
            lambda: Task("t", (), init=(("not", ("Wet", "x")),)),
            r"init: .* is no fact; .* as in init=\(\('Cleaned', 'mug'\),\)",
        ),  # type: ignore[arg-type, list-item]
        (lambda: Task("t", (), goal=((),)), r"goal: \(\) is no fact"),
    ],
)
def test_what_cannot_be_is_refused_where_it_is_made(make: Callable[[], object], said: str) -> None:
    with pytest.raises(ModelError, match=said) as refused:
        make()
    assert isinstance(refused.value, tamp.TaskError)
    assert isinstance(refused.value, ValueError)


@pytest.mark.parametrize(
    ("item", "said"),
    [
        (Object("a", "cup.obj", POSE), "'cup.obj' is no shape; valid are tamp.Box"),  # type: ignore[arg-type]
        (Object("a", BOX, POSE, On("shelv")), "'shelv' is no possible target; the task has nothing to be on"),
        (Object("a", BOX, Pose((2, 0, 0.1))), r"objects\[0\].pose: a is off the table, which spans x -0.54 to 0.30"),
        (Object("a", BOX, POSE, At(Pose((0, 2, 0.1)))), r"objects\[0\].goal.pose: a is off the table"),
        (Object("a", BOX, Pose((0, 0, -0.1))), "a is under the table top"),
    ],
)
def test_what_a_task_cannot_have_is_refused_without_its_geometry(item: Object, said: str) -> None:
    with pytest.raises(tamp.TaskError, match=said):
        validate(Task("t", (item,)))


@pytest.mark.parametrize("limit", [0.0, -1.0, math.nan])
def test_a_limit_is_positive(limit: float) -> None:
    with pytest.raises(tamp.TaskError, match=r"limits\.planning_s: is .*; valid are positive numbers of seconds"):
        validate(Task("t", (Object("a", BOX, POSE),), limits=tamp.Limits(planning_s=limit)))


@pytest.mark.parametrize(
    ("matrix", "said"),
    [
        (np.diag([1.0, 1.0, -1.0, 1.0]), "mirrors"),
        (np.diag([1000.0, 1000.0, 1000.0, 1.0]), "scales"),
        (np.full((4, 4), np.nan), "is no rotation"),
        (np.eye(3), r"of shape \(4, 4\), not \(3, 3\)"),
        ([[1.0]], r"of shape \(4, 4\), not list"),
    ],
)
def test_a_matrix_that_is_no_rigid_motion_makes_no_pose(matrix: Any, said: str) -> None:
    with pytest.raises(ModelError, match=said):
        Pose.from_matrix(matrix)


def test_a_matrix_in_single_precision_makes_the_pose_that_it_was_made_of() -> None:
    pose = Pose.from_rpy((0.1, -0.2, 0.3), (0.4, -1.2, 2.5))
    assert Pose.from_matrix(pose.matrix.astype(np.float32)).quat == pytest.approx(pose.quat, abs=1e-6)


def test_a_box_is_made_of_any_three_numbers() -> None:
    assert hash(Box([0.05, 0.05, 0.05])) == hash(BOX)  # type: ignore[arg-type]


def test_a_mesh_is_named_by_a_path_of_either_kind() -> None:
    assert Mesh("cup.obj") == Mesh(Path("cup.obj"))  # type: ignore[arg-type]


def test_a_plan_is_saved_with_its_folders_and_what_bars_it_is_named(tmp_path: Path) -> None:
    plan = Plan("t", "panda", 0, {}, (), {}, ())
    save_plan(plan, tmp_path / "new" / "plan.json")
    assert tamp.load_plan(tmp_path / "new" / "plan.json").task == "t"
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(OSError, match=r"file/plan\.json'$"):
        save_plan(plan, tmp_path / "file" / "plan.json")


@pytest.mark.parametrize("odd", [[0.0, 1.0], np.array(["0", "1"]), np.array([0.0, 1.0j]), np.array([0.0, None])])
def test_a_trajectory_is_made_of_arrays_of_real_numbers(odd: object) -> None:
    rows = np.zeros((2, 7))
    with pytest.raises(PlanError, match="the times of a trajectory are an array of real numbers, not"):
        Trajectory(odd, rows, rows)  # type: ignore[arg-type]


@pytest.mark.parametrize("kind", [np.int64, np.float32, ">f8", np.longdouble])
def test_numbers_of_any_kind_are_those_that_a_checker_computes_with(kind: str) -> None:
    rows = np.asfortranarray(np.arange(14.0).reshape(2, 7))
    made = Trajectory(np.array([0, 1], kind), rows.astype(kind), rows)
    assert made == Trajectory(np.array([0.0, 1.0]), np.ascontiguousarray(rows), np.ascontiguousarray(rows))
    assert made.positions.dtype == np.float64 and made.positions.flags.c_contiguous


def test_a_plan_stands_where_poses_say() -> None:
    with pytest.raises(PlanError, match=r"a plan needs a tamp\.Pose for cup, not a ndarray"):
        Plan("t", "panda", 0, {"cup": np.eye(4)}, (), {}, ())  # type: ignore[dict-item]
