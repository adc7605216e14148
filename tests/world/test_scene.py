import numpy as np
import pytest

from tamp.world.scene import Scene


def at(x):
    T = np.eye(4)
    T[0, 3] = x
    return T


def test_copies_change_one_thing_and_share_the_rest():
    scene = Scene({"a": at(1), "b": at(2)}, opening=0.08)
    moved = scene.moved("a", at(3))
    assert moved.poses["a"][0, 3] == 3
    assert scene.poses["a"][0, 3] == 1
    assert moved.poses["b"] is scene.poses["b"]
    assert set(scene.without("a").poses) == {"b"}


def test_attach_and_detach():
    scene = Scene({"a": at(1), "b": at(2)}, opening=0.08)
    holding = scene.attached("a", at(0.1), opening=0.05)
    assert holding.held[0] == "a"
    assert set(holding.poses) == {"b"}
    assert holding.opening == 0.05
    assert holding.without("a").held is None
    placed = holding.detached("a", at(5), opening=0.08)
    assert placed.held is None
    assert placed.poses["a"][0, 3] == 5
    assert placed.opening == 0.08


def test_poses_are_read_only_and_safe_from_their_sources():
    T = at(1)
    scene = Scene({"a": T})
    T[0, 3] = 7
    assert scene.poses["a"][0, 3] == 1
    with pytest.raises(ValueError, match="read-only"):
        scene.poses["a"][0, 3] = 2
    with pytest.raises(TypeError):
        scene.poses["b"] = T
