"""Where is in truth what a plan says a little elsewhere, by shifts that are each within tolerance?"""

from __future__ import annotations

import numpy as np

from tamp.task.robot import Gripper

ASIDE = 0.001  # smaller shifts are none [m]


def hanging(gripper: Gripper, tool: np.ndarray, stood: np.ndarray, said: np.ndarray) -> np.ndarray:
    """Where an object is once fingers have closed on it: it moves along their axis alone, as it is said to.

    All are poses in the world, shape (4, 4): of the tool, of the object as it stood, and as the plan has it held.
    """
    axis, lies = tool[:3, :3] @ gripper.axis, stood.copy()
    lies[:3, 3] += axis * (axis @ (said - stood)[:3, 3])
    return lies


def let_go_aside(lies: np.ndarray, said: np.ndarray) -> np.ndarray | None:
    """Where an object stands that was let go where it lies in the hand, (4, 4), if that is not where it is said to."""
    if np.linalg.norm((lies - said)[:2, 3]) < ASIDE:
        return None
    stands = said.copy()
    stands[:2, 3] = lies[:2, 3]
    return stands
