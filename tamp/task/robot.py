"""A robot as data: which URDF, which joints and gripper, limits, home, tool frame. Read from robots/NAME/robot.yaml."""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path

from tamp.errors import RobotError
from tamp.task.pose import Pose, Vector3

PAD_FRICTION = 1.0
"""Coefficient of lateral friction of finger pads; a contact has the product of its two bodies'."""

GENTLE_FORCE = 20.0
"""Force of a finger that opens, or that holds something light [N]."""

LEVERAGE = 10.0
"""How many times the force that just carries an object it takes to keep it from turning, held beside its centre."""


@dataclass(frozen=True)
class Gripper:
    """A parallel gripper.

    Attributes:
        joints: names of the finger joints; each moves by half of the opening.
        fingers: names of the finger links.
        stroke: largest distance between the pads [m].
        force: the largest closing force of one finger [N].
        axis: closing direction in the tool frame, a unit vector.
        pad: a pad's size along (closing axis, width, approach) [m].
    """

    joints: tuple[str, ...]
    fingers: tuple[str, ...]
    stroke: float
    force: float
    axis: Vector3
    pad: Vector3

    def holding_force(self, weight: float, friction: float) -> float:
        """What each finger presses with to hold an object of a weight [N] and a friction coefficient [N]."""
        carries = weight / (2 * PAD_FRICTION * friction)
        return min(self.force, max(GENTLE_FORCE, LEVERAGE * carries))


@dataclass(frozen=True)
class RobotSpec:
    """What a robot's folder says. Arrays follow the order of `joints`; radians, metres, seconds.

    Attributes:
        urdf: path of the URDF.
        mesh_root: folder that `package://` in the URDF stands for.
        joints: names of the arm's joints.
        lower, upper: position limits [rad].
        velocity, acceleration, jerk: largest absolute values [rad/s, rad/s^2, rad/s^3].
        home: rest configuration [rad].
        reach: distances from the base's axis, along the table, between which the arm works well [m].
        T_world_base: where the base stands.
        base_radius: round the base's axis, where the robot stands itself [m].
        tool_parent: link that carries the tool frame.
        T_parent_tool: tool frame in that link: origin between the pads' centres, z the approach direction.
        gripper: the gripper.
    """

    name: str
    urdf: Path
    mesh_root: Path
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


def robot_names() -> tuple[str, ...]:
    """Names of the installed robots, sorted."""
    root = Path(str(files("tamp"))) / "robots"
    return tuple(sorted(p.parent.name for p in root.glob("*/robot.yaml")))


@cache
def load_robot(name: str) -> RobotSpec:
    """Read robots/NAME/robot.yaml.

    Raises:
        RobotError: where there is no such robot, or its data is incomplete.
    """
    if name not in robot_names():
        raise RobotError(f"unknown robot {name!r}; installed are: {', '.join(robot_names())}")
    return read_robot(Path(str(files("tamp"))) / "robots" / name / "robot.yaml")


def read_robot(path: Path) -> RobotSpec:
    """Read a robot.yaml from any folder; the folder's name is the robot's.

    Raises:
        RobotError: where the file is missing, is no YAML, or lacks something; says which.
    """
    import yaml

    try:
        data = yaml.safe_load(path.read_text(encoding="utf-8"))
        return _spec(path.parent.name, path.parent, data)
    except KeyError as error:
        raise RobotError(f"{path}: cannot read the robot: {error.args[0]!r} is missing") from error
    except (OSError, TypeError, ValueError, yaml.YAMLError) as error:
        reason = " ".join(str(error).split())
        raise RobotError(f"{path}: cannot read the robot: {reason}") from error


def _spec(name: str, folder: Path, data: dict) -> RobotSpec:  # type: ignore[type-arg]
    arm, tool, grip = data["arm"], data["tool"], data["gripper"]
    root = _mesh_root(folder, data["mesh_root"])
    joints = tuple(arm["joints"])
    per_joint = {
        key: tuple(map(float, arm[key])) for key in ("lower", "upper", "velocity", "acceleration", "jerk", "home")
    }
    for key, values in per_joint.items():
        if len(values) != len(joints):
            raise ValueError(f"arm.{key} has {len(values)} values for {len(joints)} joints")
    gripper = Gripper(
        joints=tuple(grip["joints"]),
        fingers=tuple(grip["fingers"]),
        stroke=float(grip["stroke"]),
        force=float(grip["force"]),
        axis=tuple(map(float, grip["axis"])),  # type: ignore[arg-type]
        pad=tuple(map(float, grip["pad"])),  # type: ignore[arg-type]
    )
    return RobotSpec(
        name=name,
        urdf=root / data["urdf"],
        mesh_root=root / data.get("package", "."),
        joints=joints,
        **per_joint,
        reach=_reach(arm["reach"]),
        T_world_base=Pose.from_rpy(tuple(data["base"]["xyz"]), tuple(data["base"]["rpy"])),
        base_radius=float(data["base"]["radius"]),
        tool_parent=tool["parent"],
        T_parent_tool=Pose.from_rpy(tuple(tool["xyz"]), tuple(tool["rpy"])),
        gripper=gripper,
    )


def _reach(values: object) -> tuple[float, float]:
    match values:
        case [float() | int() as near, float() | int() as far] if 0.0 <= near < far:
            return float(near), float(far)
    raise ValueError(f"arm.reach is {values}; give two distances, the smaller one first")


def _mesh_root(folder: Path, text: str) -> Path:
    """A folder beside robot.yaml, or `python://PACKAGE` for the folder of an installed Python package."""
    if not text.startswith("python://"):
        return folder / text
    package = text.removeprefix("python://")
    found = importlib.util.find_spec(package)
    if found is None or not found.submodule_search_locations:
        raise ValueError(f"mesh_root names the Python package {package!r}, which is not installed")
    return Path(found.submodule_search_locations[0])
