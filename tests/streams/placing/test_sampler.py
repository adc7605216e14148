from __future__ import annotations

import math
from itertools import islice

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.streams.affordances.stable_poses import amid, resting
from tamp.streams.affordances.support import carried_by
from tamp.streams.placing.sampler import (
    RELEASE_HEIGHT,
    facing,
    put_down,
    sample_insertion,
    sample_placement,
    sample_stacking,
)
from tamp.streams.values import Grasp, Placement
from tamp.task import Box, Cylinder, Mesh, Object, Pose, Region, Sphere
from tamp.world.scene import Scene
from tests.streams.tables import BRICK, CRATE, CUBE, CUP, OBJECTS, RED, SLAB, ToldContext, at, corners, workspace_of

BOOK = Object("book", Box((0.04, 0.17, 0.26)), Pose((0.0, 0.2, 0.13)))


@pytest.fixture(scope="module")
def workspace():
    return workspace_of(BOOK)


def test_it_stays_turned_as_it_stands_first(workspace):
    R = facing(workspace, "book", np.random.default_rng(0), 0)
    assert np.allclose(R, np.eye(3))


def test_what_stands_a_little_tilted_now_is_put_down_upright():
    lean = 0.03
    tilted = Pose((0.2, 0.0, 0.052), (math.sin(lean / 2), 0.0, 0.0, math.cos(lean / 2)))
    leaning = workspace_of(Object("box", Box((0.05, 0.05, 0.1)), tilted))
    assert facing(leaning, "box", np.random.default_rng(0), 0)[2, 2] > 1.0 - 1e-9


def test_of_what_will_do_some_is_drawn_and_of_all_where_nothing_does(workspace):
    rng = np.random.default_rng(0)
    lying = [facing(workspace, "book", rng, draw, lambda R: abs(R[2, 0]) > 0.9) for draw in range(8)]
    assert all(abs(R[2, 0]) > 0.9 for R in lying)
    assert np.allclose(facing(workspace, "book", rng, 0, lambda R: False), np.eye(3))


def test_no_hand_puts_it_down_on_its_wide_side_whatever_its_grasp(workspace):
    flat = [R for R in resting(workspace, "book") if abs(R[2, 0]) > 0.9]
    assert flat
    assert not any(put_down(workspace, "book", None, R) for R in flat)
    assert all(put_down(workspace, "book", None, R) for R in resting(workspace, "book") if abs(R[2, 0]) < 0.1)


def test_the_hand_that_holds_it_at_one_end_does_not_set_that_end_down(workspace):
    from_above = Grasp(Pose.from_rpy((0.0, 0.0, 0.12), (np.pi, 0.0, np.pi / 2)), 0.04)
    upside_down = np.diag([1.0, -1.0, -1.0])
    assert put_down(workspace, "book", from_above, np.eye(3))
    assert not put_down(workspace, "book", from_above, upside_down)
    assert amid(workspace, "book", upside_down).on == ("table",)


SHELF = Region("shelf", (0.05, 0.35), (0.3, 0.25))


@pytest.fixture(scope="module")
def shelved():
    return workspace_of(RED, CUBE, SLAB, BRICK, CUP, regions=(SHELF,))


def on_region(workspace, obj, region="shelf", count=9, seed=0, bound=()):
    return list(islice(sample_placement(ToldContext(workspace, seed, bound=bound), obj, region), count))


def assert_inside(workspace, obj, placement, region):
    points = corners(workspace, obj, placement.pose)
    low, high = (np.array(region.center) + side * np.array(region.size) / 2 for side in (-1, 1))
    assert (points[:, :2] >= low - 1e-9).all()
    assert (points[:, :2] <= high + 1e-9).all()
    assert points[:, 2].min() == pytest.approx(RELEASE_HEIGHT, abs=1e-9)
    assert placement.on == ("table",)


@given(
    size=st.tuples(*[st.floats(0.01, 0.11)] * 3),
    yaw=st.floats(-3.1, 3.1),
    seed=st.integers(0, 1000),
)
@settings(max_examples=15, deadline=None)
def test_a_box_put_on_a_region_stands_on_it_whole(size, yaw, seed):
    pose = Pose.from_rpy((0.0, -0.2, size[2] / 2), (0.0, 0.0, yaw))
    workspace = workspace_of(Object("box", Box(size), pose), regions=(SHELF,))
    for placement in on_region(workspace, "box", seed=seed):
        assert_inside(workspace, "box", placement, SHELF)


def test_a_ball_has_no_likely_face_and_is_put_down_all_the_same():
    workspace = workspace_of(Object("ball", Sphere(0.03), Pose((0.0, 0.0, 0.03))))
    for placement in on_region(workspace, "ball", "table"):
        assert_inside(workspace, "ball", placement, workspace.region("table"))


@pytest.mark.parametrize("obj", ["red", "cup", "slab"])
def test_whatever_is_put_on_the_table_stays_on_it(shelved, obj):
    for placement in on_region(shelved, obj, "table", count=20):
        assert_inside(shelved, obj, placement, shelved.region("table"))


@given(seed=st.integers(0, 10_000), x=st.floats(-0.05, 0.15), y=st.floats(0.27, 0.43))
@settings(max_examples=25, deadline=None)
def test_where_there_is_room_a_placement_keeps_clear_of_what_the_plan_has_placed(shelved, seed, x, y):
    standing = Placement(Pose((x, y, 0.041)), ("table",))
    placed = on_region(shelved, "cube", count=6, seed=seed, bound=(at("red", standing),))
    clear = [
        not shelved.world.overlap("cube", p.pose.matrix, "red", standing.pose.matrix, tolerance=0.0) for p in placed
    ]
    assert clear[0]
    assert sum(clear) >= 4  # every third draw is blind


def test_where_the_plan_holds_an_object_the_hand_finds_room_too():
    grasp = Grasp(Pose.from_rpy((0.0, 0.0, 0.01), (np.pi, 0.0, 0.0)), 0.04)
    others = [Object(f"cube_{i}", CUBE.shape, CUBE.pose) for i in range(6)]
    crowded = workspace_of(CUBE, *others, regions=(SHELF,))
    places = [Placement(Pose((x, y, 0.021)), ("table",)) for x in (-0.06, 0.05, 0.16) for y in (0.29, 0.41)]
    bound = tuple(at(other.name, place) for other, place in zip(others, places, strict=True))
    around = Scene({name: place.pose.matrix for _, name, place in bound})

    def blocked(known):
        placed = [on_region(crowded, "cube", count=1, seed=seed, bound=known)[0] for seed in range(10)]
        tools = [p.pose.matrix @ grasp.T_object_tool.matrix for p in placed]
        return sum(crowded.world.hand_contact(tool, 0.056, around, margin=0.0) is not None for tool in tools)

    assert blocked(bound) > 0
    assert blocked((*bound, ("AtGrasp", "cube", grasp))) == 0


def test_the_object_itself_is_not_in_its_own_way(shelved):
    bound = (at("cube", Placement(Pose((0.05, 0.35, 0.021)), ("table",))),)
    assert on_region(shelved, "cube", bound=bound) == on_region(shelved, "cube")


@pytest.mark.parametrize("seed", range(5))
def test_a_buffer_on_the_table_keeps_away_from_every_start_and_goal(shelved, seed):
    (first,) = on_region(shelved, "cube", "table", count=1, seed=seed)
    for name, place in [*shelved.start.items(), *shelved.goals.items()]:
        if name != "cube":
            assert shelved.world.separation("cube", first.pose.matrix, name, place.pose.matrix) > 0.0


def test_on_a_region_the_object_stays_turned_as_it_stands(shelved):
    for placement in on_region(shelved, "cube", count=1):
        assert np.allclose(placement.pose.matrix[:3, :3], CUBE.pose.matrix[:3, :3])


def test_what_is_too_large_for_a_region_stands_there_with_its_middle_and_whole_on_the_table(shelved):
    table = shelved.task.table
    for placement in on_region(shelved, "brick"):
        points = corners(shelved, "brick", placement.pose)[:, :2]
        low, high = points.min(axis=0), points.max(axis=0)
        assert (abs((low + high) / 2 - SHELF.center) <= np.array(SHELF.size) / 2 + 1e-9).all()
        assert (abs(points - table.center) <= np.array(table.size) / 2).all()


def test_what_fits_on_a_region_turned_by_a_quarter_is_turned():
    narrow = Region("narrow", (0.05, 0.35), (0.06, 0.2))
    bar = Object("bar", Box((0.15, 0.04, 0.04)), Pose((0.0, -0.2, 0.02)))
    workspace = workspace_of(bar, regions=(narrow,))
    for placement in on_region(workspace, "bar", "narrow"):
        assert_inside(workspace, "bar", placement, narrow)


def test_what_reaches_beyond_the_table_with_its_middle_on_a_region_is_not_put_there_and_it_says_why():
    rim = Region("rim", (0.29, 0.0), (0.02, 0.1))
    context = ToldContext(workspace_of(CUBE, regions=(rim,)))
    assert list(sample_placement(context, "cube", "rim")) == []
    assert set(context.reasons) == {"cube does not fit on rim in this orientation"}


def test_placements_depend_on_the_generator_alone_and_not_on_earlier_calls(shelved):
    fresh = workspace_of(RED, CUBE, SLAB, BRICK, CUP, regions=(SHELF,))
    on_region(shelved, "slab", "table")
    assert on_region(shelved, "cup", "table", seed=2) == on_region(fresh, "cup", "table", seed=2)
    assert on_region(shelved, "cup", seed=2) != on_region(fresh, "cup", seed=3)


@pytest.mark.parametrize("shape", [Box((0.03, 0.05, 0.08)), Cylinder(0.03, 0.06), Sphere(0.03)])
@pytest.mark.parametrize(("yaw", "seed"), [(0.0, 0), (0.7, 1), (-2.0, 2)])
def test_what_is_stacked_touches_its_support_and_is_not_in_it(shape, yaw, seed):
    workspace = workspace_of(SLAB, Object("thing", shape, Pose((0.0, 0.3, 0.05))))
    below = Placement(Pose.from_rpy((0.1, 0.1, 0.015), (0.0, 0.0, yaw)), ("table",))
    for placement in islice(sample_stacking(ToldContext(workspace, seed), "thing", "slab", below), 5):
        gap = workspace.world.separation("thing", placement.pose.matrix, "slab", below.pose.matrix)
        assert 0.0 < gap < 3 * RELEASE_HEIGHT
        assert placement.on == ("slab",)


def test_the_first_thing_stacked_stands_over_the_middle(table):
    below = table.start["slab"]
    first = next(sample_stacking(ToldContext(table), "red", "slab", below))
    assert first.pose.xyz[:2] == pytest.approx(below.pose.xyz[:2])
    assert first.pose.xyz[2] == pytest.approx(0.03 + 0.04, abs=3 * RELEASE_HEIGHT)


def test_what_is_put_into_a_box_sinks_into_it_without_touching_it_too_deep(kitchen):
    around = kitchen.start["crate"]
    rim = corners(kitchen, "crate", around.pose)[:, 2].max()
    placed = list(islice(filter(None, sample_insertion(ToldContext(kitchen), "cube", "crate", around)), 5))
    assert len(placed) == 5
    for placement in placed:
        assert kitchen.world.separation("cube", placement.pose.matrix, "crate", around.pose.matrix) > 0.0
        assert corners(kitchen, "cube", placement.pose)[:, 2].min() < rim - 0.01
        assert placement.on == ("crate",)


def test_what_is_too_large_for_a_box_does_not_sink_into_it_and_it_says_why():
    workspace = workspace_of(CRATE, BRICK)
    context = ToldContext(workspace)
    assert not any(sample_insertion(context, "brick", "crate", workspace.start["crate"]))
    assert "brick does not sink into crate" in context.reasons


def test_what_is_put_into_a_bowl_stands_on_its_flat_and_what_would_slide_down_its_walls_comes_last():
    sugar = Object("sugar", Box((0.035, 0.035, 0.06)), Pose((0.05, 0.25, 0.03)))
    bowl = Object("bowl", Mesh(OBJECTS / "bowl" / "collision.obj"), Pose((0.08, -0.2, 0.0275)))
    workspace = workspace_of(sugar, bowl)
    start = workspace.start["bowl"]
    placed = list(filter(None, sample_insertion(ToldContext(workspace), "sugar", "bowl", start)))
    carried = [carried_by(workspace, "sugar", place, "bowl", start) for place in placed]
    assert carried == sorted(carried, reverse=True) and any(carried) and not all(carried)
    middle = np.array(start.pose.xyz[:2])
    away = [float(np.linalg.norm(place.pose.xyz[:2] - middle)) for place in placed]
    assert np.mean(away[: sum(carried)]) < np.mean(away[sum(carried) :])


@given(height=st.floats(0.12, 0.3), yaw=st.floats(-3.1, 3.1), seed=st.integers(0, 1000))
@settings(max_examples=15, deadline=None)
def test_what_tips_over_easily_stands_where_it_would_still_lie_on_the_table(height, yaw, seed):
    pose = Pose.from_rpy((0.0, -0.2, height / 2), (0.0, 0.0, yaw))
    workspace = workspace_of(Object("domino", Box((0.03, 0.1, height)), pose))
    table = workspace.region("table")
    standing = [p for p in on_region(workspace, "domino", "table", seed=seed) if p.pose.matrix[2, 2] > 0.9]
    for placement in standing:
        assert_inside(workspace, "domino", placement, Region("middle", table.center, np.array(table.size) - height))
    assert standing
