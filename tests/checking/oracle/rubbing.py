"""Does something that moves press on an object that stands, and slide along it?"""

from __future__ import annotations

import numpy as np

from tests.checking.oracle.bodies import Body, depth, near

PRESSED = 0.0004  # deeper than that it presses [m]
ALONG = 0.012  # so far it takes it along [m]


def rubs(moving: Body, T: np.ndarray, still: Body, T_still: np.ndarray) -> bool:
    """Whether a body at poses T, shape (n, 4, 4), goes along another one while it is a little in it."""
    pressed = [k for k in near(moving, T, still, T_still) if depth(moving, T[k], still, T_still) > PRESSED]
    ways = [np.linalg.norm(T[k, :3, 3] - T[k - 1, :3, 3]) for k in pressed if k - 1 in pressed]
    return bool(sum(ways) > ALONG)
