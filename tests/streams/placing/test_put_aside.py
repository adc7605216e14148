from __future__ import annotations

from dataclasses import replace
from itertools import islice
from math import dist

import numpy as np
import pytest

from tamp.streams.affordances.flat_faces import flat_faces, lies_flat
from tamp.streams.affordances.graspable import graspable
from tamp.streams.affordances.stable_poses import resting, stands
from tamp.streams.cache import SampleCache
from tamp.streams.hand.candidates import hangs_over
from tamp.streams.motion.handling_contacts import handling_hits
from tamp.streams.motion.inverse_kinematics import inverse_kinematics
from tamp.streams.placing import put_aside as laid_aside
from tamp.streams.placing.put_aside import FUTILE, sample_exposed_aside, sample_laid_aside, sample_put_aside
from tamp.streams.pushing.grasp_after_push import grippable
from tamp.streams.releasing.tilted_release import plan_laying
from tamp.streams.values import Placement
from tamp.task import Box, Cylinder, Object, Pose
from tests.streams.tables import CUBE, RED, ToldContext, at, workspace_of

DISC = Object("disc", Cylinder(0.08, 0.02), Pose((0.0, 0.2, 0.131)))
BLOCK = Object("block", Box((0.05, 0.05, 0.12)), Pose((0.0, 0.2, 0.06)))


def can_grip(context, obj, place):
    """Whether `grippable` says so in the end."""
    steps = grippable(context, obj, place)
    try:
        while True:
            next(steps)
    except StopIteration as end:
        return end.value


@pytest.fixture(scope="module")
def workspace():
    return workspace_of(DISC, BLOCK, RED, CUBE, on={"disc": ("block",)})


@pytest.fixture(scope="module")
def samples(workspace):
    context = ToldContext(workspace, bound=tuple(at(*item) for item in workspace.start.items()))
    return list(islice(sample_laid_aside(context, "disc", workspace.start["disc"]), 3))


def test_only_what_no_hand_can_put_down_on_any_face_lies_flat(workspace):
    assert [name for name in workspace.start if lies_flat(workspace, name)] == ["disc"]


def test_the_grasp_takes_it_up_and_lays_it_down_clear_of_what_stands_there(workspace, samples):
    assert len(samples) == 3
    start = workspace.start["disc"]
    others = {name: place for name, place in workspace.start.items() if name != "disc"}
    for grasp, place in samples:
        taken = next(inverse_kinematics(ToldContext(workspace), "disc", start, grasp), None)
        assert taken is not None
        assert not handling_hits(workspace, taken[2], others)
        assert next(plan_laying(ToldContext(workspace), "disc", place, grasp), None) is not None


def test_the_place_is_on_the_table_and_apart_from_all_others(workspace, samples):
    geometry = workspace.world.geometries["disc"]
    for _, place in samples:
        assert place.on == ("table",)
        assert stands(geometry, place.pose.matrix[:3, :3])
        for name in ("block", "red", "cube"):
            other = workspace.start[name].pose.matrix
            assert workspace.world.separation("disc", place.pose.matrix, name, other) > 0.0


def test_it_is_laid_nearer_to_its_goal_than_chance_would_have_it(workspace, samples):
    goal = Placement(Pose((0.15, -0.35, 0.011)), ("table",))
    aiming = replace(workspace, goals={**workspace.goals, "disc": goal})
    context = ToldContext(aiming, bound=tuple(at(*item) for item in aiming.start.items()))
    aimed = list(islice(sample_laid_aside(context, "disc", aiming.start["disc"]), 3))

    def distance(found):
        return np.mean([dist(place.pose.xyz, goal.pose.xyz) for _, place in found])

    assert distance(aimed) < distance(samples)


@pytest.mark.parametrize("free", [True, False])
def test_it_is_laid_at_its_goal_where_nothing_stands_there_by_then(workspace, free):
    goal = Placement(Pose((0.1, 0.0, 0.011)) if free else Pose((0.05, 0.2, 0.011)), ("table",))  # or under the red box
    aiming = replace(workspace, goals={**workspace.goals, "disc": goal})
    context = ToldContext(aiming, bound=tuple(at(*item) for item in aiming.start.items()))
    _, place = next(sample_laid_aside(context, "disc", aiming.start["disc"]))
    assert (place == goal) is free


def test_what_lies_flat_on_two_faces_only_is_put_down_on_another():
    book = Object("book", Box((0.04, 0.17, 0.26)), Pose((0.0, 0.2, 0.131)))
    workspace = workspace_of(book, CUBE)
    assert 0 < len(flat_faces(workspace, "book")) < len(resting(workspace, "book"))
    assert not lies_flat(workspace, "book")
    context = ToldContext(workspace, bound=tuple(at(*item) for item in workspace.start.items()))
    grasp, place = next(sample_put_aside(context, "book", workspace.start["book"]))
    assert abs(place.pose.matrix[2, 0]) < 0.1
    assert stands(workspace.world.geometries["book"], place.pose.matrix[:3, :3])
    assert next(inverse_kinematics(ToldContext(workspace), "book", workspace.start["book"], grasp), None) is not None
    assert next(inverse_kinematics(ToldContext(workspace), "book", place, grasp), None) is not None


def test_what_lies_flat_on_every_face_is_never_put_down_and_it_says_why(workspace):
    context = ToldContext(workspace)
    assert list(sample_put_aside(context, "disc", workspace.start["disc"])) == []
    assert context.reasons == ["disc would lie flat on every face"]


def test_it_is_given_up_once_many_grasps_have_found_no_place(monkeypatch, workspace):
    tried = []

    def nowhere(context, obj, place, grasp):
        tried.append(grasp)
        return False

    monkeypatch.setattr(laid_aside, "lays", nowhere)
    context = ToldContext(replace(workspace, cache=SampleCache()))  # with nobody around, whoever takes it up is free to
    assert list(sample_laid_aside(context, "disc", workspace.start["disc"])) == []
    assert len(set(tried)) == FUTILE
    assert set(context.reasons) == {"no place was found where the arm can lay disc down"}


def test_what_lies_flat_on_every_face_is_laid_where_a_hand_can_take_it_up_again(workspace, samples):
    context = ToldContext(workspace)
    places = [place for _, place in samples]
    assert all(hangs_over(workspace, "disc", place) for place in places)
    assert all(can_grip(context, "disc", place) for place in places)
    assert all(graspable(workspace, "disc", place) for place in places)


def test_what_lies_flat_on_every_face_hangs_over_an_edge_where_the_same_plan_takes_it_up_again(workspace):
    context = ToldContext(workspace, bound=tuple(at(*item) for item in workspace.start.items()))
    for grasp, place in islice(sample_exposed_aside(context, "disc", workspace.start["disc"]), 3):
        assert hangs_over(workspace, "disc", place)
        assert can_grip(ToldContext(workspace), "disc", place)
        assert next(plan_laying(ToldContext(workspace), "disc", place, grasp), None) is not None


def test_what_can_be_taken_up_from_the_table_need_not_hang_over_its_edge(workspace):
    context = ToldContext(workspace)
    assert list(sample_exposed_aside(context, "block", workspace.start["block"])) == []
    assert "need not hang over" in context.reasons[0]
