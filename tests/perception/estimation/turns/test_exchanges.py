"""Plates that differ by tenths of a millimetre, each of which may be in any one's place, are told by whole pictures."""

from __future__ import annotations

import math
import random
from collections.abc import Mapping

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tamp.perception.cameras.capture import shoot, views
from tamp.perception.estimation.estimator import estimate_poses
from tamp.perception.estimation.fusion import LevelFrame, level
from tamp.perception.estimation.turns import exchanges
from tamp.perception.estimation.turns.exchanges import told_apart
from tamp.perception.estimation.turns.rendered import Shown
from tamp.perception.rendering.surface import Surface
from tamp.task import Pose, Table
from tests.perception.estimation.turns.test_rendered import CAMERAS, PANDA, TURNS, _plate

pytest.importorskip("embreex", reason="the extra perception is not installed")

FLAT, BUMPED = _plate(0.0), _plate(0.0008)
HERE, THERE, ASIDE = (
    Pose.from_rpy((x, y, 0.0), (0.0, 0.0, 0.4)) for x, y in ((-0.1, 0.15), (-0.05, -0.15), (0.2, 0.0))
)


def _frames(looks: Mapping[str, Surface], poses: Mapping[str, Pose], seed: int) -> list[LevelFrame]:
    return [level(shot.frame, Table()) for shot in shoot(looks, poses, views(CAMERAS, PANDA), PANDA, seed=seed)]


def _turned(pose: Pose) -> np.ndarray:
    return np.stack([pose.matrix @ turn for turn in TURNS])


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("exchanged", [False, True])
def test_plates_are_given_the_places_where_pictures_show_them(seed: int, exchanged: bool) -> None:
    frames = _frames({"flat": FLAT, "bumped": BUMPED}, {"flat": HERE, "bumped": THERE}, seed)
    at = [HERE, THERE]
    poses = {(i, place): _turned(at[place]) for i in (0, 1) for place in (0, 1)}
    told = told_apart(frames, {0: FLAT, 1: BUMPED}, {0: int(exchanged), 1: int(not exchanged)}, poses)
    assert told.places == {0: 0, 1: 1}
    assert np.allclose(told.poses[1], THERE.matrix), "its turn is told, too"
    assert all(0.01 < lead < math.inf for lead in told.leads.values())


def test_of_three_places_two_are_of_one_mesh() -> None:
    looks, at = {"one": FLAT, "bumped": BUMPED, "other": FLAT}, [HERE, THERE, ASIDE]
    frames = _frames(looks, dict(zip(looks, at, strict=True)), 0)
    meshes = {0: FLAT, 1: FLAT, 2: BUMPED}
    # As the perceiver has it, one of a mesh has no poses where another of that mesh was found.
    poses = {
        (i, place): _turned(at[place]) for i in (0, 1, 2) for place in (0, 1, 2) if (i, place) not in ((0, 1), (1, 0))
    }
    told = told_apart(frames, meshes, {0: 0, 1: 1, 2: 2}, poses)
    assert told.places == {0: 0, 1: 2, 2: 1}
    assert told.leads.keys() == {0, 1, 2}


def test_where_nothing_is_shown_nothing_is_told() -> None:
    poses = {(i, place): _turned(Pose((5.0, float(place), 0.0))) for i in (0, 1) for place in (0, 1)}
    frames = _frames({"flat": FLAT}, {"flat": HERE}, 0)
    for some in (frames, []):
        told = told_apart(some, {0: FLAT, 1: BUMPED}, {0: 0, 1: 1}, poses)
        assert not told.places
        assert not told.poses


@pytest.mark.parametrize("seed", range(3))
def test_the_perceiver_says_who_is_where(seed: int) -> None:
    looks, poses = {"flat": FLAT, "bumped": BUMPED}, {"flat": HERE, "bumped": THERE}
    shots = shoot(looks, poses, views(CAMERAS, PANDA), PANDA, seed=seed)
    found = estimate_poses([shot.frame for shot in shots], looks, seed=seed)
    for name, true in poses.items():
        pose = found[name].pose
        assert pose is not None
        assert math.dist(pose.xyz, true.xyz) < 0.01
        assert found[name].confidence > 0.5


@pytest.mark.parametrize(("by", "kept"), [(20.0, True), (300.0, False)])
def test_pictures_overrule_points_only_where_they_tell_clearly(
    by: float, kept: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of what little shows of two books in their holders either way is as likely."""
    said = iter([[Shown(0, 1000.0 + by), Shown(0, 1000.0)], [Shown(0, 1000.0), Shown(0, 1000.0)]])
    monkeypatch.setattr(exchanges, "all_shown", lambda *_: next(said))
    poses = {(i, place): HERE.matrix[None] for i in (0, 1) for place in (0, 1)}
    told = told_apart([], {0: FLAT, 1: BUMPED}, {0: 0, 1: 1}, poses)
    assert told.places == ({0: 0, 1: 1} if kept else {0: 1, 1: 0})
    assert bool(told.leads) != kept


def test_three_change_places_where_one_of_a_mesh_was_found_in_each(monkeypatch: pytest.MonkeyPatch) -> None:
    """Flat ones were found at 0 and 1, bumped ones at 2 and 3; they are at 0 and 2, and 1 and 3."""
    costs = {0: (1000.0, 2000.0), 1: (2000.0, 1000.0), 2: (1000.0, 2000.0), 3: (2000.0, 1000.0)}
    said = iter([[Shown(0, cost) for cost in costs[place]] for place in range(4)])
    monkeypatch.setattr(exchanges, "all_shown", lambda *_: next(said))
    meshes = {0: FLAT, 1: FLAT, 2: BUMPED, 3: BUMPED}
    of_one = {(0, 1), (1, 0), (2, 3), (3, 2)}
    pairs = sorted(((i, place) for i in range(4) for place in range(4)), key=lambda at: meshes[at[0]] is BUMPED)
    poses = {at: HERE.matrix[None] for at in pairs if at not in of_one}
    told = told_apart([], meshes, {i: i for i in range(4)}, poses)
    assert {told.places[0], told.places[1]} == {0, 2}
    assert all((i, place) not in of_one for i, place in told.places.items())


def test_what_was_not_found_where_a_mesh_is_shown_is_not_put_there(monkeypatch: pytest.MonkeyPatch) -> None:
    """The flat one at 1 was never found at 2, where one is shown; the other has no place but its own."""
    costs = {0: (1000.0, 5000.0), 1: (2000.0, 1000.0), 2: (1000.0, 2000.0)}
    said = iter([[Shown(0, cost) for cost in costs[place]] for place in range(3)])
    monkeypatch.setattr(exchanges, "all_shown", lambda *_: next(said))
    meshes = {0: FLAT, 1: FLAT, 2: BUMPED}
    found = [(0, 0), (0, 2), (1, 1), (2, 0), (2, 1), (2, 2)]
    poses = dict.fromkeys(found, HERE.matrix[None])
    told = told_apart([], meshes, {i: i for i in range(3)}, poses)
    assert told.places == {0: 0, 1: 1, 2: 2}
    assert not told.leads.keys() & {1, 2}, "what pictures speak against is not said to be sure"


@given(st.randoms(use_true_random=False), st.integers(1, 6))
def test_objects_are_only_put_where_they_may_be(rng: random.Random, count: int) -> None:
    meshes = {i: rng.choice([FLAT, BUMPED]) for i in range(count)}
    pairs = [(i, place) for i in range(count) for place in range(count)]
    poses = {at: HERE.matrix[None] for at in pairs if at[0] == at[1] or rng.random() < 0.5}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(exchanges, "all_shown", lambda _, some: [Shown(0, 1000 * rng.random()) for _ in some])
        told = told_apart([], meshes, {i: i for i in range(count)}, poses)
    assert set(told.places.items()) <= poses.keys()
    assert set(told.places) == set(told.places.values()) == set(range(count))
