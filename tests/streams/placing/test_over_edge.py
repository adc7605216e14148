from __future__ import annotations

from dataclasses import replace
from itertools import islice, product

import numpy as np
import pytest

from tamp.execution.monitor import angle_between
from tamp.execution.settling.settle import let_fall
from tamp.streams.affordances.slide_path import LEAST_OVERHANG, STEADY
from tamp.streams.affordances.stable_poses import resting
from tamp.streams.collisions import overlap
from tamp.streams.grasping.sampler import grasps
from tamp.streams.motion.inverse_kinematics import inverse_kinematics
from tamp.streams.placing import over_edge
from tamp.streams.placing.over_edge import regrasps_over_edges
from tamp.streams.placing.regrasp import sample_regrasp
from tamp.streams.releasing.tilted_release import plan_bringing
from tamp.task import At, Box, Object, Pose
from tamp.task.mesh.parts import convex_hull
from tests.checking.mutations.solids import hulls
from tests.streams.tables import ToldContext, at, corners, workspace_of

LENGTH, HEIGHT = 0.2, 0.006
OVER = Pose.from_rpy((0.1, 0.0, HEIGHT / 2), (np.pi, 0.0, 1.5))
BAR = Object("bar", Box((LENGTH, 0.03, HEIGHT)), Pose.from_rpy((0.1, 0.2, HEIGHT / 2), (0.0, 0.0, 0.4)), At(OVER))
WALL = Object("wall", Box((0.06, 0.5, 0.1)), Pose((-0.51, 0.3, 0.05)))


def regrasps(workspace, bound=(), count=3, many=False):
    context = ToldContext(workspace, bound=bound)
    ends = (workspace.start["bar"], workspace.goals["bar"])
    found = regrasps_over_edges(context, "bar", *ends, lambda context, obj, *at: grasps(context, obj, at), many=many)
    return list(islice(found, count))


@pytest.fixture(scope="module")
def workspace():
    return workspace_of(BAR)


@pytest.fixture(scope="module")
def regrasp(workspace):
    """The first that there is of something flat which has to be turned over."""
    return regrasps(workspace, count=1)[0]


def test_what_is_flat_is_turned_over_where_it_hangs_over_an_edge(workspace, regrasp):
    _, place, _ = regrasp
    middle, half = np.array(workspace.task.table.center), np.array(workspace.task.table.size) / 2
    beyond = np.abs(corners(workspace, "bar", place.pose)[:, :2] - middle) - half
    assert beyond.max() > LEAST_OVERHANG
    assert (np.abs(np.array(place.pose.xyz[:2]) - middle) - half).max() < 1e-6 - STEADY


def test_each_hand_brings_it_to_where_the_next_one_takes_it(workspace, regrasp):
    first, place, second = regrasp
    context = ToldContext(workspace)
    for start, end, grasp in ((workspace.start["bar"], place, first), (place, workspace.goals["bar"], second)):
        assert next(inverse_kinematics(context, "bar", start, grasp), None)
        assert next(plan_bringing(context, "bar", end, grasp), None)


def test_no_place_is_where_something_stands():
    among = workspace_of(BAR, WALL)
    places = [place for _, place, _ in regrasps(among, bound=(at("wall", among.start["wall"]),))]
    assert places and not any(overlap(among, "bar", place, "wall", among.start["wall"]) for place in places)


def test_grasps_that_reach_one_end_only_are_told_of(workspace):
    context = ToldContext(workspace)
    ends = (workspace.start["bar"], workspace.goals["bar"])
    for many in (True, False):
        assert not list(regrasps_over_edges(context, "bar", *ends, lambda *_: iter(()), many=many))
    assert context.reasons == ["no place for bar over an edge of the table that two grasps reach"]


def test_same_seed_same_regrasps(regrasp):
    assert regrasps(workspace_of(BAR), count=1) == [regrasp]  # drawn anew: a workspace keeps what it was asked


@pytest.mark.parametrize("many", [True, False])
def test_places_are_those_that_many_hands_serve_or_the_others(monkeypatch, many):
    monkeypatch.setattr("tamp.streams.placing.over_edge.MANY", 1 if many else 1000)
    alone = workspace_of(BAR)  # one of its own: what is kept of places does not know of another MANY
    assert regrasps(alone, count=1, many=many)
    assert not regrasps(alone, many=not many)


def test_a_rod_is_turned_half_about_itself_by_hands_from_beside_too():
    """No hand from beside has room amid the table, where it would put down or take up a rod that has a quarter turn."""
    half = At(Pose.from_rpy((0.1, 0.0, 0.015), (np.pi, 0.0, 1.5)))
    rod = replace(BAR, shape=Box((LENGTH, 0.03, 0.03)), pose=Pose((0.1, 0.2, 0.015)), goal=half)
    among = workspace_of(rod)
    looked_at = over_edge._looked_at(ToldContext(among), "bar", among.start["bar"], among.goals["bar"])
    assert any(hands and abs(place.pose.matrix[2, 2]) < 0.1 for hands, place in looked_at)


def test_what_does_not_roll_for_its_head_is_not_put_with_its_head_over_an_edge():
    """Let go in a simulator it stays wherever it may be put: the handle alone would roll."""
    around = np.linspace(0.0, 2 * np.pi, 24, endpoint=False)
    ring = 0.015 * np.stack([np.zeros(24), np.cos(around), np.sin(around)], axis=1)
    handle = convex_hull(np.concatenate([ring + np.array((end, 0.0, 0.0)) for end in (-0.2, 0.1)]))
    head = convex_hull(np.array([*product((0.1, 0.12), (-0.03, 0.07), (-0.015, 0.015))]))
    hammer = replace(
        BAR, shape=hulls("hammer", [handle, head]), pose=Pose((0.1, 0.2, 0.015)), goal=At(Pose((0.1, -0.2, 0.015)))
    )
    among = workspace_of(hammer)
    context = ToldContext(among)
    drawn = [over_edge._over_edge(context, "bar", R) for R in resting(among, "bar") for _ in range(12)]
    places = [place.pose for place in drawn if place is not None]
    assert places
    for pose in places:
        rests = let_fall([hammer], {"bar": pose}, table=among.task.table)
        assert rests is not None and angle_between(rests["bar"], pose) < 0.1


def test_they_come_after_those_amid_the_table():
    """Where the object has a side to stand on in between, no edge is needed."""
    block = replace(
        BAR,
        shape=Box((0.1, 0.04, 0.04)),
        pose=Pose((0.1, 0.2, 0.02)),
        goal=At(Pose.from_rpy((0.1, 0.0, 0.02), (np.pi, 0.0, 0.0))),
    )
    among = workspace_of(block)
    _, place, _ = next(sample_regrasp(ToldContext(among), "bar", among.start["bar"], among.goals["bar"]))
    half = np.array(among.task.table.size) / 2
    assert (np.abs(corners(among, "bar", place.pose)[:, :2] - among.task.table.center) < half).all()
