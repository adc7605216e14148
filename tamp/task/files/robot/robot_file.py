"""robot.yaml -> RobotSpec."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import math
from collections.abc import Mapping
from pathlib import Path

from pydantic import ValidationError

from tamp.errors import RobotError, TaskError, meant
from tamp.task.files.errors import sentence
from tamp.task.files.robot import robot_schema as schema
from tamp.task.files.robot.mechanism import misfits
from tamp.task.files.robot.urdf_file import Attachment, Driven, Urdf, followers, read_urdf
from tamp.task.files.robot.urdf_grammar import MOVABLE
from tamp.task.files.yaml_document import Document, FieldPath, read_document
from tamp.task.pose import Pose
from tamp.task.robot import Gripper, RobotSpec

DEPTHS = (1.0, 2 / 3, 1 / 3, 1 / 6)
"""Shares of a pad's length at which it grips where the file names no depths."""

FULL_TURN = 2 * math.pi


def read_robot(path: Path) -> RobotSpec:
    """Read a robot.yaml from any folder; the folder's name is the robot's.

    Raises:
        RobotError: where the file is missing, is no YAML, lacks something, or its URDF cannot be used; says where.
    """
    try:
        document = read_document(path)
        if not isinstance(document.value, Mapping):
            valid = ", ".join(schema.RobotModel.model_fields)
            raise RobotError(f"{path}: the file is empty or no mapping; a robot has the fields {valid}")
        model = schema.RobotModel.model_validate(document.value)
    except TaskError as error:
        raise RobotError(str(error)) from None
    except ValidationError as error:
        raise RobotError(sentence(error, document, schema.RobotModel)) from None
    return _Reader(document, path.resolve().parent).spec(model)


def _mirrored(driver: str, other: str, urdf: Urdf) -> bool:
    """Whether a joint's range is another's the other way round, as [-0.04, 0] is that of [0, 0.04]."""
    try:
        one, two = urdf.limits(driver), urdf.limits(other)
    except RobotError:  # no limits
        return False
    return one is not None and two is not None and two != one and two == (-one[1], -one[0])


class _Reader:
    """Turns the file's models into the robot."""

    def __init__(self, document: Document, folder: Path) -> None:
        self._document = document
        self._folder = folder

    def spec(self, model: schema.RobotModel) -> RobotSpec:
        urdf = self._urdf(model)
        for misfit in misfits(model, urdf):
            raise self._refused(*misfit)
        arm, tool, count = model.arm, model.tool, len(model.arm.joints)
        lower, upper = self._position_limits(model, urdf)
        velocity = _each(arm.velocity or tuple(urdf.largest(name, "velocity") for name in arm.joints), count)
        effort = _each(arm.effort or tuple(urdf.largest(name, "effort") for name in arm.joints), count)
        gripper, driven = self._gripper(model.gripper, urdf)
        driven |= dict(zip(arm.joints, map(Driven, lower, upper, effort, velocity), strict=True))
        for index, (low, value, high) in enumerate(zip(lower, arm.home, upper, strict=True)):
            if not low <= value <= high:
                raise self._refused(
                    ("arm", "home", index), f"{value:g} is outside the joint's limits of {low:g} to {high:g}"
                )
        return RobotSpec(
            name=self._folder.name,
            urdf=urdf.path,
            description=urdf.described(driven, model.posture),
            joints=arm.joints,
            lower=lower,
            upper=upper,
            velocity=velocity,
            acceleration=_each(arm.acceleration, count),
            jerk=_each(arm.jerk, count),
            home=tuple(map(float, arm.home)),
            reach=(float(arm.reach[0]), float(arm.reach[1])),
            T_world_base=Pose.from_rpy(model.base.xyz, model.base.rpy),
            base_radius=float(model.base.radius),
            tool_parent=tool.parent,
            T_parent_tool=Pose.from_rpy(tool.xyz, tool.rpy),
            gripper=gripper,
            still=urdf.still(driven, model.posture),
            disabled_collisions=tuple(sorted({(min(pair), max(pair)) for pair in model.disable_collisions})),
        )

    def _urdf(self, model: schema.RobotModel) -> Urdf:
        folders = [self._path(text, ("meshes", i)) for i, text in enumerate(model.meshes)]
        for index, folder in enumerate(folders):
            if not folder.is_dir():
                raise self._refused(("meshes", index), f"there is no folder {folder}")
        given = model.gripper.attach
        attachment = None
        if given is not None:
            file = self._path(given.urdf, ("gripper", "attach", "urdf"))
            arm = read_urdf(self._path(model.urdf, ("urdf",)), None, folders)
            if given.parent not in arm.links:
                near = f"{meant(given.parent, arm.links)}the URDF has {', '.join(sorted(arm.links))}"
                raise self._refused(("gripper", "attach", "parent"), f"there is no link {given.parent!r}; {near}")
            attachment = Attachment(file, given.parent, Pose.from_rpy(given.xyz, given.rpy), given.prefix)
        return read_urdf(self._path(model.urdf, ("urdf",)), attachment, folders)

    def _position_limits(self, model: schema.RobotModel, urdf: Urdf) -> tuple[tuple[float, ...], tuple[float, ...]]:
        found, theirs = [], model.arm.lower is None and model.arm.upper is None
        for index, name in enumerate(model.arm.joints):
            own = model.arm.lower is None or model.arm.upper is None
            # One that turns without end gets a turn to each side of home: more of it reaches nothing else.
            ends = urdf.limits(name) if own or urdf.joint(name).get("type") not in ("revolute", "continuous") else None
            if ends is None:
                ends = model.arm.home[index] - FULL_TURN, model.arm.home[index] + FULL_TURN
            low = ends[0] if model.arm.lower is None else model.arm.lower[index]
            high = ends[1] if model.arm.upper is None else model.arm.upper[index]
            if not low < high:
                told = f"joint {name} has limits of {low:g} to {high:g}; the lower comes first"
                if theirs:
                    raise RobotError(f"{urdf.path}: {told}, there or in arm.lower and arm.upper of robot.yaml")
                raise self._refused(("arm",), told)
            found.append((float(low), float(high)))
        return tuple(low for low, _ in found), tuple(high for _, high in found)

    def _gripper(self, model: schema.GripperModel, urdf: Urdf) -> tuple[Gripper, dict[str, Driven]]:
        """The gripper, and its joints with their limits."""
        driver = model.joints[0]
        law = {driver: (1.0, 0.0)}
        follow = followers(driver, urdf.mimics())
        law |= {name: (m, b) for name, m, b in follow if urdf.joint(name).get("type") in MOVABLE}
        for name in model.joints:
            law.setdefault(name, (-1.0 if _mirrored(driver, name, urdf) else 1.0, 0.0))
        kinds = {name: urdf.joint(name).get("type") for name in law}
        if model.pads is None and (set(kinds.values()) != {"prismatic"} or any(m != 1.0 or b for m, b in law.values())):
            raise self._refused(
                ("gripper",),
                "needs pads, the middle of each pad's surface in its finger link's frame: its joints do not all slide "
                "by half of the opening. With [[0, 0, 0], [0, 0, 0]] there `tamp robots check` says where they are",
            )
        ends = model.limits or urdf.limits(driver)
        if ends is None or not ends[0] < ends[1]:
            told = f"{driver} has no range in the URDF; give [lower, upper]"
            told = "the lower one comes first" if model.limits else told
            raise self._refused(("gripper", "limits"), told)
        norm = math.hypot(*model.axis)
        if norm < 1e-6 or abs(model.axis[2]) > 1e-6 * norm:
            raise self._refused(("gripper", "axis"), "must be a direction across the tool's z, as [0, 1, 0]")
        x, y, z = (v / norm for v in model.axis)
        left, right = model.fingers
        gripper = Gripper(
            joints=tuple(law),
            multipliers=tuple(m for m, _ in law.values()),
            offsets=tuple(b for _, b in law.values()),
            limits=(float(ends[0]), float(ends[1])),
            fingers=(left, right),
            pads=None if model.pads is None else (model.pads[0], model.pads[1]),
            stroke=float(model.stroke),
            force=float(model.force),
            axis=(x, y, z),
            pad=model.pad,
            depths=model.depths or tuple(share * model.pad[2] for share in DEPTHS),
            fingertip=model.fingertip or model.pad[1],
        )
        driven = {}
        for name, (m, b) in law.items():
            one, other = m * ends[0] + b, m * ends[1] + b
            # How hard fingers press is asked of them anew for each thing that they hold, how fast they go as well.
            driven[name] = Driven(min(one, other), max(one, other), gripper.force, 0.0)
        return gripper, driven

    def _path(self, text: str, field: FieldPath) -> Path:
        """A path of the file: `python://PACKAGE/REST`, `dist://DISTRIBUTION/REST`, absolute, or beside the file."""
        scheme, _, rest = text.rpartition("://")
        name, _, inner = rest.partition("/")
        if scheme not in ("", "python", "dist") or "\0" in text:
            told = f"{text!r} is no path; it may begin with python://PACKAGE/ or dist://DISTRIBUTION/"
            raise self._refused(field, told)
        if scheme == "":
            try:
                return (self._folder / Path(text).expanduser()).resolve()
            except RuntimeError:  # a user's home that is not known
                raise self._refused(field, f"there is no folder {Path(text).parts[0]}") from None
        if scheme == "python":
            found = _package(name)
            if found is None:
                told = f"the Python package {name!r} is not installed; `tamp doctor` says what brings the extras"
                raise self._refused(field, told)
            return found / inner
        try:
            return Path(str(importlib.metadata.distribution(name).locate_file(inner)))
        except (importlib.metadata.PackageNotFoundError, ValueError):
            raise self._refused(field, f"the distribution {name!r} is not installed") from None

    def _refused(self, field: FieldPath, complaint: str) -> RobotError:
        return RobotError(f"{self._document.where(field)}: {complaint}")


def _each(values: float | tuple[float, ...], count: int) -> tuple[float, ...]:
    return tuple(map(float, values)) if isinstance(values, tuple) else (float(values),) * count


def _package(name: str) -> Path | None:
    """The folder of an installed Python package, None where there is none."""
    try:
        found = importlib.util.find_spec(name)
    except (ImportError, ValueError):
        return None
    return None if found is None or not found.submodule_search_locations else Path(found.submodule_search_locations[0])
