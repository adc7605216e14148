"""Building blocks for samplers, in one place: what streams hand to each other, and how to ask the world.

The manual's page on building blocks has a runnable example of each; see there for frames, units, and which
configurations must be free of collision.
"""

from tamp.domains.learned import with_model
from tamp.domains.samplers import load_sampler
from tamp.streams.cache import recalled
from tamp.streams.collisions import ARM_MARGIN, CONTACT_DEPTH
from tamp.streams.context import Context
from tamp.streams.hand.clearance import opening_for
from tamp.streams.motion.handling_contacts import approach_contact, lift_contact
from tamp.streams.placing.sampler import RELEASE_HEIGHT
from tamp.streams.values import ArmPath, Configuration, Grasp, Handling, Placement
from tamp.streams.workspace import TABLE, Workspace, held, standing
from tamp.task import Pose
from tamp.world.collision.checker import CollisionChecker, Contact
from tamp.world.kinematics.inverse import inverse, reachable, straight_line, straight_lines
from tamp.world.motion.planner import MotionResult, plan_motion, planner_names
from tamp.world.robot.model import RobotModel
from tamp.world.scene import Scene
from tamp.world.transforms import moved
from tamp.world.world import World

__all__ = [
    "ARM_MARGIN", "ArmPath", "CONTACT_DEPTH", "CollisionChecker", "Configuration", "Contact", "Context", "Grasp",
    "Handling", "MotionResult", "Placement", "Pose", "RELEASE_HEIGHT", "RobotModel", "Scene", "TABLE", "Workspace",
    "World", "approach_contact", "held", "inverse", "lift_contact", "load_sampler", "moved", "opening_for",
    "plan_motion", "planner_names", "reachable", "recalled", "standing", "straight_line", "straight_lines",
    "with_model",
]  # fmt: skip
