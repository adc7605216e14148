"""Is what is lifted stuck in something, wherever it is moved a little aside?"""

from __future__ import annotations

from itertools import product

import numpy as np
from scipy.spatial.transform import Rotation

from tests.checking.oracle.bodies import Body, depth, near

LIFTED = 0.006  # where it is asked: so far from where it rests [m]
STUCK = 0.0002  # deeper than that it is in it [m]
SHIFTS = np.linspace(-0.003, 0.003, 7)  # [m]
TURNS = (-0.02, 0.0, 0.02)  # [rad]


def stuck(body: Body, T: np.ndarray, around: Body, T_around: np.ndarray) -> bool:
    """Whether a body, at poses T of shape (n, 4, 4) from where it rests, is wedged in another as it leaves."""
    gone = np.linalg.norm(T[:, :3, 3] - T[0, :3, 3], axis=1) > LIFTED
    if not gone.any() or not near(body, T, around, T_around):
        return False
    at = T[int(gone.argmax())]
    for x, y, turn in product(SHIFTS, SHIFTS, TURNS):
        moved = at.copy()
        moved[:3, :3] = Rotation.from_rotvec((0.0, 0.0, turn)).as_matrix() @ at[:3, :3]
        moved[:2, 3] += (x, y)
        if depth(body, moved, around, T_around) < STUCK:
            return False
    return True
