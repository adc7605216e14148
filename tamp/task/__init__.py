"""The nouns every other room shares: Task, Object, Pose, Goal, RobotSpec, Plan, Trajectory. No geometry, no search."""

from tamp.task.model import (
    At,
    Box,
    Capsule,
    Cylinder,
    Goal,
    In,
    Inertia,
    Limits,
    Mesh,
    Object,
    On,
    Region,
    Shape,
    Sphere,
    SymbolicFact,
    Symmetry,
    Table,
    Task,
)
from tamp.task.plan import Action, Attachment, Fall, Grip, Move, Plan, Release, Step, Trajectory
from tamp.task.pose import Pose
from tamp.task.robot import DEFAULT_ROBOT, Gripper, RobotSpec
from tamp.task.robots import load_robot, robot_names, task_robot

__all__ = [
    "Action", "At", "Attachment", "Box", "Capsule", "Cylinder", "DEFAULT_ROBOT", "Fall", "Goal", "Grip",
    "Gripper", "In", "Inertia",
    "Limits", "Mesh", "Move", "Object", "On", "Plan", "Pose", "Region", "Release", "RobotSpec", "Shape", "Sphere",
    "Step", "SymbolicFact", "Symmetry", "Table", "Task", "Trajectory", "load_robot", "robot_names", "task_robot",
]  # fmt: skip
