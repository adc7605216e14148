"""Does the arm bear a force at its hand? Torques at rest, by virtual work; the arm's own weight is left out."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.world.robot.chain import chain
from tamp.world.robot.model import RobotModel

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

GRAVITY = 9.81  # [m/s^2]
SPARED = 0.98  # share of what a joint bears that is counted on


def always_borne(robot: RobotModel, force: float, beyond: float) -> bool:
    """Whether no configuration asks too much of any joint, for a force [N] no farther from the tool than this [m]."""
    arm = chain(robot)
    links = np.append(np.linalg.norm(arm.offset[1:], axis=1), np.linalg.norm(arm.tool[:3, 3]))
    if arm.slides.any():
        return False
    levers = np.cumsum(links[::-1])[::-1] + beyond
    return bool((force * levers <= SPARED * _efforts(robot)).all())


def overloaded(robot: RobotModel, q: Array, points: Array, force: Array) -> str | None:
    """What a force asks of a joint that does not bear it, in words; None where all joints bear it all the time.

    The words are the same for the same joint, so that whoever counts reasons counts them together.

    Args:
        robot: the arm.
        q: configurations, shape (n, dof) [rad].
        points: where the force acts at each, in the world, shape (n, 3) [m].
        force: the force, shape (3,) [N].
    """
    arm, efforts = chain(robot), _efforts(robot)
    frames = arm.frames(q)
    axes: Array = np.einsum("jnab,jb->jna", frames[..., :3, :3], arm.axis)
    ways = np.where(arm.slides[:, None, None], axes, np.cross(axes, points - frames[..., :3, 3]))
    asked = np.abs(ways @ force)
    joint, worst = np.unravel_index((asked / efforts[:, None]).argmax(), asked.shape)
    if asked[joint, worst] <= SPARED * efforts[joint]:
        return None
    unit = "N" if arm.slides[joint] else "N m"
    name = robot.spec.joints[joint]
    return f"more of {name} than the {efforts[joint]:.0f} {unit} that it bears"


def _efforts(robot: RobotModel) -> Array:
    """The most that each joint of the arm bears, shape (dof,) [N m or N]; without end where the URDF does not say."""
    model = robot.model
    limits = np.array([model.effortLimit[model.joints[model.getJointId(name)].idx_v] for name in robot.spec.joints])
    return np.where(limits > 0.0, limits, np.inf)
