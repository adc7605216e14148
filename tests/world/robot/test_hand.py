"""The hand alone: the same answers as the arena gives, for any opening, among hulls and hollows."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tamp.task import Box, Object, Pose
from tamp.world.scene import Scene
from tests.streams.tables import workspace_of

MARGIN = 0.002
TRAY = Object("tray", Box((0.2, 0.2, 0.02)), Pose((0.1, 0.1, 0.01)))
POST = Object("post", Box((0.04, 0.04, 0.2)), Pose((0.0, -0.1, 0.1)))


@pytest.fixture(scope="module")
def workspace():
    return workspace_of(TRAY, POST)


def scene_of(workspace):
    return Scene({name: place.pose.matrix for name, place in workspace.start.items()})


@given(seed=st.integers(0, 10_000), ignored=st.sampled_from([(), ("tray",), ("table",), ("table", "post")]))
@settings(max_examples=15, deadline=None)
def test_it_agrees_with_the_arena(workspace, seed, ignored):
    rng, count = np.random.default_rng(seed), 40
    T = np.tile(np.eye(4), (count, 1, 1))
    T[:, :3, :3] = Rotation.random(count, random_state=seed).as_matrix()
    T[:, :3, 3] = rng.uniform((-0.2, -0.3, 0.0), (0.3, 0.3, 0.4), (count, 3))
    openings, scene = rng.uniform(0.0, 0.08, count), scene_of(workspace)
    hits = workspace.world.free_hand(scene, MARGIN, ignore=ignored).hits(T, openings)
    contacts = [workspace.world.hand_contact(T[i], openings[i], scene, MARGIN, ignore=ignored) for i in range(count)]
    assert hits.tolist() == [contact is not None for contact in contacts]


def test_one_and_many_are_answered_alike(workspace):
    hand = workspace.world.free_hand(scene_of(workspace), MARGIN)
    T = np.tile(np.diag([1.0, -1.0, -1.0, 1.0]), (20, 1, 1))
    T[:, :3, 3] = np.linspace((0.1, 0.1, 0.0), (0.1, 0.1, 0.3), 20)
    hits = hand.hits(T, np.full(20, 0.04))
    assert 0 < hits.sum() < 20
    assert [hand.hit(pose, 0.04) for pose in T] == hits.tolist()


def test_nothing_is_asked_of_no_hands(workspace):
    assert workspace.world.free_hand(Scene(), MARGIN).hits(np.empty((0, 4, 4)), np.empty(0)).shape == (0,)
