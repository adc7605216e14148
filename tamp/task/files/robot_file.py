"""robot.yaml -> RobotSpec."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import math
from collections.abc import Mapping
from pathlib import Path

from pydantic import ValidationError

from tamp.errors import RobotError, TaskError
from tamp.task.files import robot_schema as schema
from tamp.task.files.errors import sentence
from tamp.task.files.urdf_file import MOVABLE, Attachment, Urdf, followers, read_urdf
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


class _Reader:
    """Turns the file's models into the robot."""

    def __init__(self, document: Document, folder: Path) -> None:
        self._document = document
        self._folder = folder

    def spec(self, model: schema.RobotModel) -> RobotSpec:
        urdf = self._urdf(model)
        arm, tool = model.arm, model.tool
        for link in (tool.parent, *model.gripper.fingers):
            urdf.require_link(link)
        lower, upper = self._position_limits(model, urdf)
        gripper, driven = self._gripper(model.gripper, urdf)
        driven |= dict(zip(arm.joints, zip(lower, upper, strict=True), strict=True))
        for name in model.posture:
            urdf.joint(name)
            if name in driven:
                raise self._refused(("posture", name), "is a joint of arm or gripper; only others have a posture")
        for index, (low, value, high) in enumerate(zip(lower, arm.home, upper, strict=True)):
            if not low <= value <= high:
                raise self._refused(
                    ("arm", "home", index), f"{value:g} is outside the joint's limits of {low:g} to {high:g}"
                )
        count = len(arm.joints)
        return RobotSpec(
            name=self._folder.name,
            urdf=urdf.path,
            description=urdf.described(driven, model.posture),
            joints=arm.joints,
            lower=lower,
            upper=upper,
            velocity=_each(arm.velocity or tuple(urdf.velocity(name) for name in arm.joints), count),
            acceleration=_each(arm.acceleration, count),
            jerk=_each(arm.jerk, count),
            home=tuple(map(float, arm.home)),
            reach=(float(arm.reach[0]), float(arm.reach[1])),
            T_world_base=Pose.from_rpy(model.base.xyz, model.base.rpy),
            base_radius=float(model.base.radius),
            tool_parent=tool.parent,
            T_parent_tool=Pose.from_rpy(tool.xyz, tool.rpy),
            gripper=gripper,
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
            attachment = Attachment(file, given.parent, Pose.from_rpy(given.xyz, given.rpy), given.prefix)
        return read_urdf(self._path(model.urdf, ("urdf",)), attachment, folders)

    def _position_limits(self, model: schema.RobotModel, urdf: Urdf) -> tuple[tuple[float, ...], tuple[float, ...]]:
        found = []
        for index, name in enumerate(model.arm.joints):
            own = model.arm.lower is None or model.arm.upper is None
            # One that turns without end gets a turn to each side of home: more of it reaches nothing else.
            ends = urdf.limits(name) if own or urdf.joint(name).get("type") not in ("revolute", "continuous") else None
            if ends is None:
                ends = model.arm.home[index] - FULL_TURN, model.arm.home[index] + FULL_TURN
            low = ends[0] if model.arm.lower is None else model.arm.lower[index]
            high = ends[1] if model.arm.upper is None else model.arm.upper[index]
            if not low < high:
                raise self._refused(("arm",), f"joint {name} has limits of {low:g} to {high:g}; the lower comes first")
            found.append((float(low), float(high)))
        return tuple(low for low, _ in found), tuple(high for _, high in found)

    def _gripper(self, model: schema.GripperModel, urdf: Urdf) -> tuple[Gripper, dict[str, tuple[float, float]]]:
        """The gripper, and its joints with their limits."""
        driver, mimics = model.joints[0], urdf.mimics()
        if driver in mimics:
            raise self._refused(
                ("gripper", "joints"), f"{driver} mimics {mimics[driver].joint}; name the joint that is driven first"
            )
        law = {driver: (1.0, 0.0)}
        follow = followers(driver, mimics)
        law |= {name: (m, b) for name, m, b in follow if urdf.joint(name).get("type") in MOVABLE}
        for name in model.joints:
            urdf.joint(name)
            law.setdefault(name, (1.0, 0.0))
        kinds = {name: urdf.joint(name).get("type") for name in law}
        if model.pads is None and (set(kinds.values()) != {"prismatic"} or any(m != 1.0 or b for m, b in law.values())):
            raise self._refused(
                ("gripper",),
                "needs pads, the middle of each pad's surface in its finger link's frame: its joints do not all slide "
                "by half of the opening",
            )
        ends = model.limits or urdf.limits(driver)
        if ends is None or not ends[0] < ends[1]:
            raise self._refused(("gripper", "limits"), f"{driver} has no limits in the URDF; give [lower, upper]")
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
        return gripper, {
            name: (min(m * ends[0], m * ends[1]) + b, max(m * ends[0], m * ends[1]) + b) for name, (m, b) in law.items()
        }

    def _path(self, text: str, field: FieldPath) -> Path:
        """A path of the file: `python://PACKAGE/REST`, `dist://DISTRIBUTION/REST`, absolute, or beside the file."""
        scheme, _, rest = text.rpartition("://")
        name, _, inner = rest.partition("/")
        if scheme == "":
            return (self._folder / Path(text).expanduser()).resolve()
        if scheme == "python":
            try:
                found = importlib.util.find_spec(name)
            except ModuleNotFoundError:
                found = None
            if found is None or not found.submodule_search_locations:
                told = f"the Python package {name!r} is not installed; `tamp doctor` says what brings the extras"
                raise self._refused(field, told)
            return Path(next(iter(found.submodule_search_locations))) / inner
        if scheme == "dist":
            try:
                return Path(str(importlib.metadata.distribution(name).locate_file(inner)))
            except importlib.metadata.PackageNotFoundError:
                raise self._refused(field, f"the distribution {name!r} is not installed") from None
        raise self._refused(field, f"{text!r} is no path; it may begin with python://PACKAGE/ or dist://DISTRIBUTION/")

    def _refused(self, field: FieldPath, complaint: str) -> RobotError:
        return RobotError(f"{self._document.where(field)}: {complaint}")


def _each(values: float | tuple[float, ...], count: int) -> tuple[float, ...]:
    return tuple(map(float, values)) if isinstance(values, tuple) else (float(values),) * count
