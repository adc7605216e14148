from __future__ import annotations

from dataclasses import replace
from itertools import combinations, islice

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.pipeline.strategies.subproblems.goal_graph import asking_for
from tamp.streams.placing.packing import crowded, packed, rows
from tamp.streams.placing.sampler import sample_placement
from tamp.streams.values import Grasp
from tamp.task import Box, Cylinder, Object, On, Pose, Region
from tamp.world.scene import Scene
from tests.streams.tables import ToldContext, at, corners, workspace_of

BOX, THERE = Box((0.04, 0.04, 0.08)), On("narrow")
NARROW = Region("narrow", (0.05, -0.2), (0.12, 0.14))
"""Two rows of three boxes, with 4 cm for the fingers between them, nearly fill it."""
FROM_ABOVE = Grasp(Pose.from_rpy((0.0, 0.0, 0.02), (np.pi, 0.0, 0.0)), 0.04)


def boxes(count, goal=THERE):
    return [
        Object(f"box_{k}", BOX, Pose.from_rpy((-0.2 + 0.06 * k, 0.3, 0.04), (0, 0, 0.1 * k)), goal)
        for k in range(count)
    ]


def footprint(workspace, name, T):
    points = corners(workspace, name, Pose.from_matrix(T))[:, :2]
    return np.concatenate([points.min(axis=0), points.max(axis=0)])


def gaps(a, b):
    """Room between two footprints along x and y."""
    return np.maximum(a[:2] - b[2:], b[:2] - a[2:])


def filled(workspace, region, names):
    """Footprints of objects put one after the other to the first place that is left."""
    taken = []
    for name in names:
        poses = packed(workspace, name, region, workspace.start[name].pose.matrix[:3, :3], None, taken)
        if not len(poses):
            return taken
        taken.append(footprint(workspace, name, poses[0]))
    return taken


def test_forty_boxes_fit_where_random_places_would_jam():
    region = Region("narrow", (0.0, -0.31), (0.3, 0.5))
    workspace = workspace_of(*boxes(40), regions=(region,))
    assert crowded(workspace, region)
    way, taken = rows(workspace, region), filled(workspace, region, workspace.start)
    assert len(taken) == 40
    for a, b in combinations(taken, 2):
        assert (gaps(a, b) > np.array(way.gaps) - 1e-4).any()
    low, high = np.min(taken, axis=0)[:2], np.max(taken, axis=0)[2:]
    assert (low > np.array([-0.15, -0.56]) - 1e-4).all()
    assert (high < np.array([0.15, -0.06]) + 1e-4).all()


def test_where_there_is_room_for_all_no_rows_are_wanted():
    region = Region("narrow", (0.0, -0.31), (0.3, 0.5))
    assert not crowded(workspace_of(*boxes(8), regions=(region,)), region)
    assert not crowded(workspace_of(*boxes(6, goal=None), regions=(NARROW,)), NARROW)


def test_what_stands_in_a_region_and_has_no_goal_takes_its_room():
    post = Object("post", Cylinder(0.02, 0.1), Pose((0.05, -0.2, 0.05)))
    few = boxes(2)
    assert not crowded(workspace_of(*few, regions=(NARROW,)), NARROW)
    assert crowded(workspace_of(*few, post, regions=(NARROW,)), NARROW)


def test_a_question_about_one_object_knows_that_the_others_will_come():
    workspace = workspace_of(*boxes(6), regions=(NARROW,))
    assert crowded(asking_for(workspace, {"box_0"}), NARROW)


@given(sizes=st.lists(st.tuples(*[st.floats(0.02, 0.09)] * 2), min_size=2, max_size=8), yaw=st.floats(-3.1, 3.1))
@settings(max_examples=15, deadline=None)
def test_objects_of_all_sizes_stay_apart_and_within_the_region(sizes, yaw):
    region = Region("narrow", (0.0, -0.3), (0.3, 0.3))
    mixed = [
        Object(f"box_{k}", Box((*size, 0.05)), Pose.from_rpy((0.0, 0.3, 0.025), (0, 0, yaw)), On("narrow"))
        for k, size in enumerate(sizes)
    ]
    workspace = workspace_of(*mixed, regions=(region,))
    way, taken = rows(workspace, region), filled(workspace, region, workspace.start)
    assert taken
    for a, b in combinations(taken, 2):
        assert (gaps(a, b) > np.array(way.gaps) - 1e-4).any()
    assert (np.min(taken, axis=0)[:2] > np.array([-0.15, -0.45]) - 1e-4).all()
    assert (np.max(taken, axis=0)[2:] < np.array([0.15, -0.15]) + 1e-4).all()


def test_fingers_close_where_the_rows_leave_them_room():
    workspace = workspace_of(*boxes(6), regions=(NARROW,))
    way = rows(workspace, NARROW)
    quarter = replace(FROM_ABOVE, T_object_tool=FROM_ABOVE.T_object_tool @ Pose.from_rpy((0, 0, 0), (0, 0, np.pi / 2)))
    for grasp in (FROM_ABOVE, quarter):
        poses = packed(workspace, "box_2", NARROW, workspace.start["box_2"].pose.matrix[:3, :3], grasp, [])
        closing = (poses @ grasp.T_object_tool.matrix)[:, :3, 1]
        assert np.abs(closing[:, way.axis]) == pytest.approx(np.ones(len(poses)), abs=1e-5)


def test_one_after_the_other_they_fill_the_region_and_the_hand_has_room_each_time():
    workspace = workspace_of(*boxes(6), regions=(NARROW,))
    bound = ()
    for name in workspace.start:
        around = Scene({known[1]: known[2].pose.matrix for known in bound})
        held = ("AtGrasp", name, FROM_ABOVE)
        place = next(sample_placement(ToldContext(workspace, bound=(held, *bound)), name, "narrow"))
        tool = place.pose.matrix @ FROM_ABOVE.T_object_tool.matrix
        assert workspace.world.hand_contact(tool, 0.056, around, margin=0.001) is None
        others = (
            workspace.world.overlap(name, place.pose.matrix, o, T, tolerance=0.0) for o, T in around.poses.items()
        )
        assert not any(others)
        bound = (*bound, at(name, place))


def test_no_place_in_the_rows_comes_twice():
    workspace = workspace_of(*boxes(6), regions=(NARROW,))
    context = ToldContext(workspace, bound=(at("box_1", workspace.start["box_1"]),))
    places = list(islice(sample_placement(context, "box_0", "narrow"), 12))
    assert len(set(places)) == len(places)
