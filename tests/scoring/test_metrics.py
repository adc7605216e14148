"""The laws that every metric obeys, and what each of OCRTOC's own adds to the paper's."""

from __future__ import annotations

import csv
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.errors import TampError
from tamp.scoring.ede import mean_edge
from tamp.scoring.metrics import EDE, METRICS, OCRTOC_2020, OCRTOC_2021, OCRTOC_2024, Metric, metric
from tamp.scoring.ocrtoc2020 import symmetric_error
from tamp.scoring.ocrtoc2021 import BOUND_M, POINTS, add, add_s, surface_points
from tamp.scoring.ocrtoc2024 import intersection_over_union
from tamp.task import Box, Cylinder, Object, Pose, Sphere, Symmetry
from tamp.task.model import ANY_TURN

OBJECTS_2020 = Path(__file__).parents[3] / "shared" / "ocrtoc" / "2020" / "models_2020_sim" / "objects.csv"

coordinate = st.floats(-1, 1)
angle = st.floats(-math.pi, math.pi)
poses = st.builds(Pose.from_rpy, st.tuples(coordinate, coordinate, coordinate), st.tuples(angle, angle, angle))
sides = st.floats(0.02, 0.3)
folds = st.sampled_from([1, 2, 3, 4, 6])
boxes = st.builds(Box, st.tuples(sides, sides, sides))
shapes = boxes | st.builds(Cylinder, sides, sides) | st.builds(Sphere, sides)
symmetries = st.builds(Symmetry, folds, folds, folds)
objects = st.builds(
    lambda shape, symmetry: Object("o", shape, Pose(), symmetry=symmetry), shapes, symmetries | st.just(Symmetry())
)
few = settings(max_examples=30)


@pytest.mark.parametrize("m", METRICS, ids=lambda m: m.name)
class TestLaws:
    @few
    @given(thing=objects, pose=poses)
    def test_equal_poses_have_no_error(self, m: Metric, thing: Object, pose: Pose) -> None:
        assert m.error(thing, pose, pose) == pytest.approx(0, abs=1e-6)
        assert m.counted(m.error(thing, pose, pose), m.bound(thing)) == pytest.approx(0, abs=1e-6)

    @few
    @given(thing=objects, a=poses, b=poses, motion=poses)
    def test_a_common_motion_is_not_seen(self, m: Metric, thing: Object, a: Pose, b: Pose, motion: Pose) -> None:
        assert m.error(thing, motion @ a, motion @ b) == pytest.approx(m.error(thing, a, b), abs=1e-6)

    @few
    @given(thing=objects, a=poses, b=poses)
    def test_what_counts_is_capped(self, m: Metric, thing: Object, a: Pose, b: Pose) -> None:
        error, bound = m.error(thing, a, b), m.bound(thing)
        assert 0 <= m.counted(error, bound) <= bound
        assert m.counted(10 * bound, bound) == bound

    @few
    @given(thing=objects, pose=poses, near=st.floats(0, 0.5), more=st.floats(0, 0.5))
    def test_a_longer_way_is_no_smaller_error(
        self, m: Metric, thing: Object, pose: Pose, near: float, more: float
    ) -> None:
        x, y, z = pose.xyz
        short, long = (m.error(thing, Pose((x + d, y, z), pose.quat), pose) for d in (near, near + more))
        assert short <= long + 1e-6


marks = st.builds(lambda axis, fold: Symmetry(**{axis: fold}), st.sampled_from("xyz"), st.sampled_from([1, 2, 4, 360]))


@given(shapes, marks, poses, poses)
def test_most_metrics_see_no_direction(shape: Box, mark: Symmetry, a: Pose, b: Pose) -> None:
    """With the marks of OCRTOC. ADD-S does see one: the nearest point of the goal is not that of the solution."""
    thing = Object("o", shape, Pose(), symmetry=mark)
    for m in (EDE, OCRTOC_2020, OCRTOC_2024):
        assert m.error(thing, a, b) == pytest.approx(m.error(thing, b, a), abs=1e-6)


@given(objects, poses, poses)
def test_a_symmetric_object_is_never_worse_off(thing: Object, a: Pose, b: Pose) -> None:
    plain = replace(thing, symmetry=Symmetry())
    for m in (OCRTOC_2020, OCRTOC_2021):
        assert m.error(thing, a, b) <= m.error(plain, a, b) + 1e-9


@given(boxes, st.sampled_from("xyz"), poses, poses)
def test_an_axis_within_the_cube_is_never_worse_than_the_cube(box: Box, axis: str, a: Pose, b: Pose) -> None:
    """By convexity; a rod that sticks out of the cube can be worse, which the next test shows."""
    plain = Object("o", box, Pose())
    turning = replace(plain, symmetry=replace(Symmetry(), **{axis: ANY_TURN}))
    if box.size["xyz".index(axis)] <= 2 * mean_edge(box):
        assert symmetric_error(turning, a, b) <= symmetric_error(plain, a, b) + 1e-9


def test_the_axis_of_a_long_rod_errs_more_than_its_cube_as_ocrtoc_defines_it() -> None:
    rod = Object("rod", Cylinder(0.001, 0.3), Pose())
    upside_down = Pose.from_rpy((0, 0, 0), (math.pi, 0, 0))
    plain = symmetric_error(rod, upside_down, Pose())
    assert symmetric_error(replace(rod, symmetry=Symmetry(z=ANY_TURN)), upside_down, Pose()) > plain


@pytest.mark.skipif(not OBJECTS_2020.is_file(), reason="OCRTOC's data is not at ../shared/ocrtoc")
@settings(max_examples=5)
@given(poses, poses)
def test_no_object_of_2020_is_worse_off_by_its_symmetry(a: Pose, b: Pose) -> None:
    with OBJECTS_2020.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            _, _, mark = row["metric"].partition("symmetric_")
            fold = 360 // int(mark[1:]) if mark[1:] else ANY_TURN
            plain = Object(row["object"], Box(tuple(float(row[n]) for n in ("width", "length", "height"))), Pose())
            marked = replace(plain, symmetry=Symmetry(**{mark[0]: fold})) if mark else plain
            assert symmetric_error(marked, a, b) <= symmetric_error(plain, a, b) + 1e-9


def test_the_cube_of_2020_is_twice_the_papers() -> None:
    turned = Pose.from_rpy((0, 0, 0), (0, 0, math.pi))
    cube = Object("o", Box((0.1, 0.1, 0.1)), Pose())
    assert EDE.error(cube, turned, Pose()) == pytest.approx(0.1 * math.sqrt(2))
    assert OCRTOC_2020.error(cube, turned, Pose()) == pytest.approx(0.2 * math.sqrt(2))
    assert OCRTOC_2020.bound(cube) == EDE.bound(cube) == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("symmetry", "rpy", "forgiven"),
    [
        (Symmetry(z=2), (0, 0, math.pi), True),
        (Symmetry(z=2), (0, 0, math.pi / 2), False),
        (Symmetry(z=4), (0, 0, -math.pi / 2), True),
        (Symmetry(x=2), (math.pi, 0, 0), True),
        (Symmetry(x=2), (0, math.pi, 0), False),
        (Symmetry(x=2, z=2), (0, math.pi, 0), True),
        (Symmetry(z=ANY_TURN), (0, 0, 1.234), True),
        (Symmetry(z=ANY_TURN), (math.pi, 0, 0), False),
        (Symmetry(x=2, z=ANY_TURN), (math.pi, 0, 0), True),
        (Symmetry(x=ANY_TURN, y=ANY_TURN), (1, 2, 3), True),
    ],
)
def test_2020_forgives_the_turns_of_the_symmetry_and_no_others(
    symmetry: Symmetry, rpy: tuple[float, float, float], forgiven: bool
) -> None:
    thing = Object("o", Cylinder(0.05, 0.08), Pose(), symmetry=symmetry)
    turned = Pose((0.1, 0.2, 0.3), Pose.from_rpy((0, 0, 0), rpy).quat)
    assert (symmetric_error(thing, turned, Pose((0.1, 0.2, 0.3))) < 1e-9) is forgiven


@given(shapes, poses, poses)
def test_add_s_is_never_above_add(shape: Box, a: Pose, b: Pose) -> None:
    points = surface_points(shape)
    assert add_s(points, a, b) <= add(points, a, b) + 1e-12


def test_points_lie_on_the_surface_well_apart_and_are_always_the_same() -> None:
    box = Box((0.1, 0.2, 0.3))
    points = surface_points(box)
    assert points.shape == (POINTS, 3)
    assert np.abs(np.abs(points) / (0.05, 0.1, 0.15)).max(axis=1) == pytest.approx(np.ones(POINTS))
    apart = np.linalg.norm(points[:, None] - points[None], axis=2) + np.eye(POINTS)
    area_each = 2 * (0.02 + 0.03 + 0.06) / POINTS
    assert apart.min() > 0.5 * math.sqrt(area_each)
    surface_points.__globals__["_surface_points"].cache_clear()
    assert (surface_points(box) == points).all()


def test_2021_counts_a_shift_as_its_length_up_to_its_bound() -> None:
    thing = Object("o", Box((0.1, 0.1, 0.1)), Pose())
    assert OCRTOC_2021.error(thing, Pose((0.3, 0, 0)), Pose()) == pytest.approx(0.3)
    assert OCRTOC_2021.bound(thing) == BOUND_M == pytest.approx(0.6708, abs=1e-4)


@pytest.mark.parametrize(
    ("pose", "share"),
    [
        (Pose((0.05, 0, 0)), 1 / 3),
        (Pose((0.1, 0, 0)), 0),
        (Pose((0, 0, 1)), 0),
        (Pose.from_rpy((0, 0, 0), (0, 0, math.pi / 2)), 1),
        (Pose.from_rpy((0, 0, 0), (0, 0, math.pi / 4)), (2 * math.sqrt(2) - 2) / (4 - 2 * math.sqrt(2))),
    ],
)
def test_the_overlap_of_cubes_is_what_geometry_says(pose: Pose, share: float) -> None:
    assert intersection_over_union(Box((0.1, 0.1, 0.1)), pose, Pose()) == pytest.approx(share, abs=1e-9)


def test_in_place_since_2024_means_an_overlap_over_four_fifths() -> None:
    thing = Object("o", Box((0.1, 0.1, 0.1)), Pose())
    for overlap, counted in ((0.82, 0.0), (0.78, 1.0)):
        shift = 0.1 * (1 - overlap) / (1 + overlap)
        error = OCRTOC_2024.error(thing, Pose((shift, 0, 0)), Pose())
        assert error == pytest.approx(1 - overlap)
        assert OCRTOC_2024.counted(error, 1.0) == counted


def test_a_metric_of_another_name_is_refused() -> None:
    with pytest.raises(TampError, match=r"'ade'; did you mean 'ede'\? valid are ede, ocrtoc2020, ocrtoc2021, "):
        metric("ade")
