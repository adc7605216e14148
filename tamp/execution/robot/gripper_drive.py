"""What the motors of a gripper's joints do for an opening, and for a force between the pads.

All joints follow one driver. By virtual work a force F of each finger needs the driver's torque F * J, J being how fast
the pads part as it moves. Where nothing is held, joint i gets m_i / sum(m^2) of it, m being the multipliers, so that
all are driven alike. What is held presses on each joint by F times how fast the pads part as that joint moves alone;
with just that torque, in place of its share, nothing is left to the couplings, which give way. Of two fingers that
slide each gets F.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING
from xml.etree import ElementTree

import numpy as np

from tamp.task import RobotSpec
from tamp.world.robot.linkage import Linkage, linkage, pad_rates

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Vector = NDArray[np.float64]

FINGER_SPEED = 0.1
"""How fast a finger moves [m/s]; half as fast where it squeezes."""

FINGER_STIFFNESS, FINGER_DAMPING = 4000.0, 80.0
"""Of the servo that opens a finger [N/m], [N s/m]."""

FINGER_ARMATURE = 0.1
"""Inertia of a finger's motor as the finger feels it [kg]."""


@dataclass(frozen=True, eq=False)
class GripperDrive:
    """Quantities of fingers as those of joints. Arrays have one value for each joint of the gripper, shape (k,).

    Attributes:
        linkage: how joints and opening go together.
        multipliers, offsets: of each joint against the driver.
        rates: how fast the pads part as each joint moves alone, at the openings of the linkage's grid, shape (n, k).
        scale: a joint's stiffness, damping and inertia for each one of a finger, [m^2/rad^2] or 1.
        sliding: whether all joints slide; else links swing.
    """

    linkage: Linkage
    multipliers: Vector
    offsets: Vector
    rates: Vector
    scale: float
    sliding: bool

    @property
    def stiffness(self) -> float:
        """Of each joint's servo [N m/rad or N/m]."""
        return FINGER_STIFFNESS * self.scale

    @property
    def damping(self) -> float:
        """Of each joint's servo [N m s/rad or N s/m]."""
        return FINGER_DAMPING * self.scale

    @property
    def armature(self) -> float:
        """Inertia of each joint's motor [kg m^2 or kg]."""
        return FINGER_ARMATURE * self.scale

    def opening(self, positions: Vector) -> float:
        """The distance between the pads at joint positions (k,); [m]."""
        return self.linkage.opening(float(((positions - self.offsets) / self.multipliers).mean()))

    def joints(self, opening: float) -> Vector:
        """Joint positions for a distance between the pads [m]."""
        return self.linkage.joints(opening)

    def speed(self, positions: Vector, velocities: Vector) -> float:
        """Speed of the fastest finger [m/s]."""
        fastest = float(np.abs(velocities / self.multipliers).max())
        return fastest * abs(self.linkage.per_driver(self.opening(positions))) / 2

    def forces(self, force: float, opening: float) -> Vector:
        """The joints' equal shares of what makes each finger press outwards by `force` [N]; torques or forces, (k,)."""
        found: Vector = force * self.linkage.per_driver(opening) * self.multipliers / (self.multipliers**2).sum()
        return found

    def balance(self, force: float, opening: float) -> Vector:
        """What each joint bears where each pad presses outwards by `force` [N]; torques or forces, shape (k,)."""
        grid = self.linkage.grid
        return force * np.array([np.interp(opening, grid, rate) for rate in self.rates.T])

    def damping_at(self, force: float, opening: float, speed: float) -> Vector:
        """Damping of each joint with which `force` [N] moves each finger by `speed` [m/s]; [N m s/rad or N s/m]."""
        found: Vector = np.abs(self.forces(force, opening) / self.velocities(speed, opening))
        return found

    def velocities(self, speed: float, opening: float) -> Vector:
        """Joint velocities with which each finger moves outwards by `speed` [m/s]."""
        found: Vector = 2.0 * speed / self.linkage.per_driver(opening) * self.multipliers
        return found


def gripper_drive(robot: RobotSpec) -> GripperDrive:
    """The drive of a robot's gripper; RobotError where its linkage cannot be."""
    link = linkage(robot)
    multipliers, offsets = np.array(link.gripper.multipliers), np.array(link.gripper.offsets)
    rate = link.per_driver(robot.gripper.stroke / 2)
    rates = pad_rates(robot, np.array([link.driver(opening) for opening in link.grid]))
    kinds = {joint.get("name"): joint.get("type") for joint in ElementTree.fromstring(robot.description).iter("joint")}
    sliding = all(kinds.get(name) == "prismatic" for name in robot.gripper.joints)
    return GripperDrive(link, multipliers, offsets, rates, rate**2 / (2.0 * float((multipliers**2).sum())), sliding)
