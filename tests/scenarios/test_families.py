from __future__ import annotations

import math
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.scenarios.families import BASE, FAMILIES, RIGHT, clutter, dense, permutation, sort, stack, towers
from tamp.task import At, On, Task
from tamp.task.validate import validate

from .solids import bottom, overlap, placed

SPREAD = [("sort", 40), ("stack", 40), ("clutter", 9), ("permutation", 20)]
CASES = [*SPREAD, ("dense", 40), ("towers", 40)]


@pytest.mark.parametrize(("family", "most"), SPREAD)
@settings(max_examples=12, deadline=None)
@given(data=st.data())
def test_starts_are_apart_supported_reachable_and_off_the_region(family, most, data):
    n, seed = data.draw(st.integers(1, most)), data.draw(st.integers(0, 1000))
    task = FAMILIES[family](n, seed)
    validate(task)
    assert len(task.objects) == n
    bodies = [placed(o.shape, o.pose) for o in task.objects]
    assert all(overlap(a, b) < 1e-6 for a, b in combinations(bodies, 2))
    for o, body in zip(task.objects, bodies, strict=True):
        storey = int(o.name.removeprefix("box_")) % 2 if family == "stack" else 0
        assert bottom(body) == pytest.approx(storey * o.shape.size[2], abs=1e-9)
        assert 0.3 < math.dist(o.pose.xyz[:2], BASE) < 0.75
        if family != "permutation":
            assert body[0][:, 1].min() > RIGHT.center[1] + RIGHT.size[1] / 2


@pytest.mark.parametrize(("family", "most"), CASES)
def test_same_seed_same_task_and_another_seed_another(family, most):
    build = FAMILIES[family]
    assert build(most, 3) == build(most, 3)
    assert build(most, 3).objects != build(most, 4).objects


@pytest.mark.parametrize(("family", "most"), CASES)
@pytest.mark.parametrize("beyond", [0, 1])
def test_numbers_without_a_task_are_refused(family, most, beyond):
    with pytest.raises(ValueError, match=f"{family} has tasks for n = 1 to {most}"):
        FAMILIES[family](beyond and most + 1, 0)


def sizes(task: Task) -> set[tuple[float, float, float]]:
    return {o.shape.size for o in task.objects}


def test_boxes_are_of_the_size_compared_with():
    assert sizes(sort(10, 0)) == sizes(stack(10, 0)) == sizes(permutation(8, 0)) == {(0.05, 0.05, 0.08)}
    assert sizes(clutter(9, 0)) == {(0.05, 0.05, 0.08), (0.05, 0.05, 0.14)}


def test_region_has_room_for_all():
    for n in (10, 20, 40):
        edge = sort(n, 0).objects[0].shape.size[0]
        assert n * (edge + 0.025) ** 2 < RIGHT.size[0] * RIGHT.size[1]


def test_a_finger_fits_between_any_two_boxes_of_sort():
    for n in (10, 20, 40):
        for a, b in combinations(sort(n, 1).objects, 2):
            diagonal = math.sqrt(2) * a.shape.size[0]
            assert math.dist(a.pose.xyz, b.pose.xyz) > diagonal + 0.022 - 1e-9


def test_stack_is_towers_of_two_that_all_go_to_the_region():
    task = stack(7, 5)
    assert all(o.goal == On("right") for o in task.objects)
    for lower, upper in zip(task.objects[0:6:2], task.objects[1:6:2], strict=True):
        assert upper.pose.xyz == pytest.approx((*lower.pose.xyz[:2], 0.12))
    assert task.objects[6].pose.xyz[2] == 0.04


def test_clutter_rings_the_short_box_at_the_pitch():
    task = clutter(9, 2)
    assert [o.name for o in task.objects if o.goal is not None] == ["short"]
    middle = np.array(task.object("short").pose.xyz[:2])
    away = sorted(float(np.linalg.norm(np.array(o.pose.xyz[:2]) - middle)) for o in task.objects[1:])
    assert away == pytest.approx([0.08] * 4 + [0.08 * math.sqrt(2)] * 4)


def test_dense_boxes_stand_apart_on_a_grid_and_towers_are_two_high():
    for task in (dense(40, 3), towers(40, 3)):
        validate(task)
        assert len(task.objects) == 40
        assert sizes(task) == {(0.04, 0.04, 0.08)}
        assert all(o.goal == On("right") for o in task.objects)
        bodies = [placed(o.shape, o.pose) for o in task.objects]
        assert all(overlap(a, b) < 1e-6 for a, b in combinations(bodies, 2))
        assert all(body[0][:, 1].min() > RIGHT.center[1] + RIGHT.size[1] / 2 for body in bodies)
    assert {round(o.pose.xyz[2], 9) for o in towers(40, 3).objects} == {0.04, 0.12}


def test_permutation_permutes():
    task = permutation(12, 1)
    ends = [o.goal.pose for o in task.objects if isinstance(o.goal, At)]
    assert sorted(p.xyz for p in ends) == sorted(o.pose.xyz for o in task.objects)
