"""Roll, pitch and yaw: what is read is what was written."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st

from tamp.formats.angles import roll_pitch_yaw
from tamp.task import Pose

part = st.floats(-1, 1)
quaternions = st.tuples(part, part, part, part).filter(lambda q: math.hypot(*q) > 0.1)
hundredths = st.integers(-157, 157).map(lambda n: n / 100)
wide = st.integers(-314, 314).map(lambda n: n / 100)


@given(quaternions)
@example((0.5, 0.5, -0.5, 0.5))
@example((0.0, math.sqrt(0.5), 0.0, math.sqrt(0.5)))
def test_the_angles_give_the_orientation_back(quat: tuple[float, float, float, float]) -> None:
    pose = Pose((0, 0, 0), quat)
    back = Pose.from_rpy((0, 0, 0), roll_pitch_yaw(pose))
    np.testing.assert_allclose(back.matrix, pose.matrix, atol=1e-12)


@given(wide, hundredths, wide)
def test_rounded_angles_come_out_as_they_were(roll: float, pitch: float, yaw: float) -> None:
    assert roll_pitch_yaw(Pose.from_rpy((0.1, 0.2, 0.3), (roll, pitch, yaw))) == (roll, pitch, yaw)
