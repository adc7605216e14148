"""Poses as messages and as matrices."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tamp.contest.adapters.messages import Point, Pose, Quaternion, matrix_of, pose_of

NUMBERS = st.floats(-3, 3)


@given(st.lists(NUMBERS, min_size=4, max_size=4).filter(lambda q: np.linalg.norm(q) > 0.1), st.tuples(*[NUMBERS] * 3))
def test_a_pose_is_its_matrix_and_back(quaternion: list[float], place: tuple[float, float, float]) -> None:
    T = matrix_of(Pose(Point(*place), Quaternion(*quaternion)))
    assert np.allclose(T[:3, :3], Rotation.from_quat(quaternion).as_matrix()) and tuple(T[:3, 3]) == place
    again = pose_of(T)
    assert np.allclose(matrix_of(again), T) and again.orientation.w >= 0
