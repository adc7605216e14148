"""Do the arm's joints bear what the hand holds or pushes? Torques by the principle of virtual work, at rest."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.checking.robot.kinematics import KinematicTree

    Array = NDArray[np.float64]


def overloaded(tree: KinematicTree, q: Array, points: Array, forces: Array) -> tuple[int, str] | None:
    """Where and how a force at the hand asks more of a joint than it bears; the arm's own weight is left out.

    Args:
        tree: the arm.
        q: its configurations, shape (n, joints) [rad].
        points: where the force acts on the hand, or on what it holds, shape (n, 3) [m], in the world.
        forces: the force, shape (n, 3) or (3,) [N].

    Returns:
        The index of the worst configuration, and a sentence's end; None where every joint bears it.
    """
    placed = tree.forward(q, 0.0)
    arm = [joint for joint in tree.joints if joint.name in tree.path_to(tree.spec.tool_parent)]
    needed = np.zeros((len(arm), len(q)))
    for row, joint in enumerate(arm):
        T = placed[joint.child]
        axis = T[:, :3, :3] @ joint.axis
        way = axis if joint.kind == "prismatic" else np.cross(axis, points - T[:, :3, 3])
        needed[row] = np.abs((way * forces).sum(axis=1))
    shares = needed / np.array([[joint.effort] for joint in arm])
    row, worst = (int(i) for i in np.unravel_index(shares.argmax(), shares.shape))
    if shares[row, worst] <= 1.0:
        return None
    joint, unit = arm[row], "N" if arm[row].kind == "prismatic" else "N m"
    return worst, f"asks {needed[row, worst]:.0f} {unit} of {joint.name}, which bears {joint.effort:.0f}"
