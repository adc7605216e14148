"""A robot as data: its description, joints and gripper, limits, home, tool frame. Read by `tamp.task.robots`."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from tamp.task.pose import Pose, Vector3

DEFAULT_ROBOT = "panda"
"""Of a task that names none."""

PAD_FRICTION = 1.0
"""Coefficient of lateral friction of finger pads; a contact has the product of its two bodies'."""

LEAST_FRICTION = 0.04
"""What a coefficient between pads and an object must be at least: pads that are a degree from parallel squeeze out what
is more slippery. A simulator loses what has 0.02, and at times 0.03; it keeps what has 0.05."""

GENTLE_FORCE = 20.0
"""Force of a finger that opens, or that holds something light [N]."""

GENTLE_SHARE = 200.0
"""How many times its weight a finger presses on something light, at most: what is squeezed by more shoots out of
fingers in a simulator, as three grams do at 20 N."""

LEVERAGE = 10.0
"""How many times the force that just carries an object it takes to keep it from turning, held beside its centre."""


@dataclass(frozen=True)
class Gripper:
    """A gripper of two fingers whose pads stay parallel.

    All its joints follow one, the driver, the first of `joints`: each is at multiplier * driver + offset. Where `pads`
    are given, driver and opening belong together as the links have it, and the pads may move along the approach as
    well. Where there are none, every joint is prismatic and moves by half of the opening.

    Attributes:
        joints: names of all joints that move the fingers.
        multipliers, offsets: of each joint against the driver [rad/rad, rad/m, ...], [rad or m].
        limits: of the driver [rad or m].
        fingers: names of the two links that carry the pads.
        pads: the middle of each pad's surface in its finger link's frame [m]; or none.
        stroke: largest distance between the pads [m].
        force: the largest closing force of one finger [N].
        axis: closing direction in the tool frame, a unit vector.
        pad: a pad's size along (closing axis, width, approach) [m].
        depths: how far behind the fingertips objects are gripped [m].
        fingertip: width of a fingertip, with which things are pushed [m].
    """

    joints: tuple[str, ...]
    multipliers: tuple[float, ...]
    offsets: tuple[float, ...]
    limits: tuple[float, float]
    fingers: tuple[str, str]
    pads: tuple[Vector3, Vector3] | None
    stroke: float
    force: float
    axis: Vector3
    pad: Vector3
    depths: tuple[float, ...]
    fingertip: float

    def holding_force(self, weight: float, friction: float) -> float:
        """What each finger presses with to hold an object of a weight [N] and a friction coefficient [N]."""
        carries = weight / (2 * PAD_FRICTION * friction)
        return min(self.force, max(min(GENTLE_FORCE, GENTLE_SHARE * weight), LEVERAGE * carries))

    def pressing(self, weight: float, friction: float, force: float | None) -> tuple[float, float]:
        """What each finger presses with on such an object as it closes and before it opens, and as it carries it [N].

        Closing as hard as some hold takes would move what stands there.

        Args:
            weight: of the object [N].
            friction: its coefficient of lateral friction.
            force: what the plan asks for as it is carried [N]; None where it asks for nothing.
        """
        gentle = self.holding_force(weight, friction)
        return gentle, max(gentle, force or 0.0)


@dataclass(frozen=True)
class RobotSpec:
    """What a robot's folder says. Arrays follow the order of `joints`; radians, metres, seconds.

    Attributes:
        name: the folder's.
        urdf: path of the arm's URDF, for messages.
        description: the URDF that counts, as text: with the gripper attached, the paths of meshes absolute, and only
            the joints of arm and gripper movable, each with limits.
        joints: names of the arm's joints.
        lower, upper: position limits [rad].
        velocity, acceleration, jerk: largest absolute values [rad/s, rad/s^2, rad/s^3].
        home: rest configuration [rad].
        reach: distances from the base's axis, along the table, between which the arm works well [m].
        T_world_base: where the base stands, unless a task says otherwise.
        base_radius: round the base's axis, where the robot stands itself [m].
        tool_parent: link that carries the tool frame.
        T_parent_tool: tool frame in that link: z the approach direction, the pads' middle on its axis.
        gripper: the gripper.
        still: the URDF's other movable joints, which nothing drives, and where each stands [rad or m].
        disabled_collisions: pairs of links that are not looked at against each other, each pair in order.
    """

    name: str
    urdf: Path
    description: str = field(repr=False)
    joints: tuple[str, ...]
    lower: tuple[float, ...]
    upper: tuple[float, ...]
    velocity: tuple[float, ...]
    acceleration: tuple[float, ...]
    jerk: tuple[float, ...]
    home: tuple[float, ...]
    reach: tuple[float, float]
    T_world_base: Pose
    base_radius: float
    tool_parent: str
    T_parent_tool: Pose
    gripper: Gripper
    still: tuple[tuple[str, float], ...] = ()
    disabled_collisions: tuple[tuple[str, str], ...] = ()

    def may_touch(self, one: str, other: str) -> bool:
        """Whether two links are not looked at against each other, since the robot's file says so."""
        return (min(one, other), max(one, other)) in self.disabled_collisions
