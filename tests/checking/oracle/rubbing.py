"""Does something that moves press on an object that stands, and slide along it?"""

from __future__ import annotations

import numpy as np

from tests.checking.oracle.bodies import Body, depth, near

PRESSED = 0.0004  # deeper than that it presses [m]
BEARS = 0.00006  # and so deep where it comes from above [m]
RAISED = 0.0003  # so much higher it would not touch then [m]
ALONG = 0.012  # so far it takes it along [m]


def rubs(moving: Body, T: np.ndarray, still: Body, T_still: np.ndarray) -> bool:
    """Whether a body at poses T, shape (n, 4, 4), goes along another one while it is a little in it."""
    pressed = [k for k in near(moving, T, still, T_still) if _presses(moving, T[k], still, T_still)]
    ways = [np.linalg.norm(T[k, :3, 3] - T[k - 1, :3, 3]) for k in pressed if k - 1 in pressed]
    return bool(sum(ways) > ALONG)


def _presses(moving: Body, T: np.ndarray, still: Body, T_still: np.ndarray) -> bool:
    deep = depth(moving, T, still, T_still)
    raised = T.copy()
    raised[2, 3] += RAISED
    return deep > PRESSED or (deep > BEARS and depth(moving, raised, still, T_still) <= 0.0)
