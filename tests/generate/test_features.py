from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tamp.generate.features import _cycles, measure
from tamp.generate.graph import Node, SceneGraph
from tamp.generate.levels import level
from tamp.generate.placement.contact import on_table
from tamp.generate.placement.object_model import thing, yawed
from tamp.generate.scene import Scene
from tamp.scenarios.library.model import read_library
from tamp.task import Pose

CAN = thing(next(model for model in read_library() if model.name == "can_1"))


def scene(*places: tuple[float, float]) -> Scene:
    names = [f"can_{i}" for i in range(len(places))]
    poses = {name: Pose.from_matrix(on_table(CAN, CAN.resting[0], xy)) for name, xy in zip(names, places, strict=True)}
    return Scene(SceneGraph(tuple(map(Node, names))), poses, (), dict.fromkeys(names, 0.0))


def test_a_swap_is_two_occupied_goals_in_one_cycle():
    here, there = (0.0, 0.2), (0.0, -0.2)
    things = {"can_0": CAN, "can_1": CAN}
    features = measure(things, scene(here, there), scene(there, here))
    assert (features.occupied, features.cycles, features.moving, features.reoriented) == (2, 1, 2, 0)
    assert features.do_nothing_ede_m == pytest.approx(min(0.4, features.mean_ueb_m), abs=1e-3)
    features = measure(things, scene(here, (0.1, 0.0)), scene(there, here))
    assert (features.occupied, features.cycles) == (1, 0)
    assert not features.fit(level(1)) and not features.fit(level(4))


def test_waits_in_circles_are_counted_once_each():
    assert _cycles({"a": {"b"}, "b": {"c"}, "c": {"a"}, "d": {"a"}}) == 1
    assert _cycles({"a": {"b"}, "b": {"a"}, "c": {"d"}, "d": {"c"}}) == 2
    assert _cycles({"a": {"b"}, "b": {"c"}, "c": set()}) == 0


def test_a_can_upside_down_is_the_same_and_a_lying_one_is_not():
    up, down, aside = np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, -1.0]), np.array([1.0, 0.0, 0.0])
    assert CAN.tilt(up, down) == pytest.approx(0.0, abs=1e-6)
    assert CAN.tilt(up, aside) == pytest.approx(math.pi / 2)


@given(yaw=st.floats(-3, 3))
def test_turning_about_the_vertical_is_no_tilt(yaw):
    R = yawed(CAN.resting[0], yaw)
    assert CAN.tilt(R[2], CAN.resting[0][2]) == pytest.approx(0.0, abs=1e-6)
