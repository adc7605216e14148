from __future__ import annotations

import math

import numpy as np
import pytest

from tamp.streams.values import ArmPath, Configuration, Placement
from tamp.task import Pose


@pytest.mark.parametrize(("pose", "on"), [(Pose((0.0, 0.0, 0.1)), "table"), ((0.0, 0.0, 0.1), ("table",))])
def test_a_placement_is_refused_whose_names_are_one_text_or_whose_pose_is_none(pose, on):
    with pytest.raises(TypeError, match="a tuple of names such as"):
        Placement(pose, on)


@pytest.mark.parametrize(("q", "opening"), [((0.0, math.nan), 0.08), ((0.0, 0.0), math.inf), (np.zeros(7), 0.08)])
def test_a_configuration_is_of_finite_numbers(q, opening):
    with pytest.raises(TypeError, match="a Configuration is a tuple of finite joint positions"):
        Configuration(q, opening)


@pytest.mark.parametrize("points", [np.zeros(7), np.zeros((1, 7)), np.zeros((2, 3, 7)), [(0.0,), (1.0,)]])
def test_a_path_has_two_points_at_least(points):
    with pytest.raises(TypeError, match=r"an ArmPath is an array of shape \(n, joints\) with two points at least"):
        ArmPath(points)
