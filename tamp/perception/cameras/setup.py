"""A set-up of cameras, read from YAML; OCRTOC's stands beside this file."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any, TypeVar

from tamp.errors import ModelError, RobotError, TaskError, meant
from tamp.perception.cameras.camera import (
    BASE_TO_OPTICAL,
    FARTHEST,
    WORLD,
    CalibrationNoise,
    Camera,
    CheckedNoise,
    Intrinsics,
    Noise,
    StereoNoise,
    TimeOfFlightNoise,
)
from tamp.perception.rendering.robot import camera_pose
from tamp.task.files.yaml_document import Document, FieldPath, read_document
from tamp.task.pose import Pose
from tamp.task.robot import RobotSpec

OCRTOC_2021 = Path(__file__).parent / "ocrtoc2021.yaml"
"""The contest's stationary camera and the one on the wrist."""

FIELDS = (
    "name",
    "parent",
    "pose",
    "frame",
    "size",
    "field_of_view",
    "intrinsics",
    "noise",
    "calibration",
    "viewpoints",
)
SENSORS: dict[str, type[Noise]] = {"stereo": StereoNoise, "time_of_flight": TimeOfFlightNoise}
LARGEST = 8192
"""Pixels along a side of a picture; those of more no memory holds."""

NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]*")
"""What a camera may be called: pictures are filed under it."""

SLACK = 1e-6
"""By which a viewpoint may pass a joint's limits, for what was rounded as it was written [rad]."""

Record = TypeVar("Record", bound=CheckedNoise)


def load_setup(path: Path = OCRTOC_2021, robot: RobotSpec | None = None) -> tuple[Camera, ...]:
    """The cameras of a set-up's file.

    Args:
        path: the file.
        robot: whose links carry cameras and whose arm goes to their viewpoints; None leaves both unlooked at.

    Raises:
        TaskError: names file, line and field, and what would be valid.
    """
    document = read_document(path)
    rows = document.value.get("cameras") if isinstance(document.value, Mapping) else None
    if not isinstance(rows, tuple) or not rows:
        raise TaskError(f"{path}: expected cameras: followed by a list of cameras")
    cameras = tuple(_Reader(document, ("cameras", i)).camera(row) for i, row in enumerate(rows))
    names = [camera.name for camera in cameras]
    for i, name in enumerate(names):
        if name in names[:i]:
            raise TaskError(f"{document.where(('cameras', i, 'name'))}: a second camera is called {name!r}")
        if robot is not None:
            _check_mount(cameras[i], robot, document, ("cameras", i))
    return cameras


def _check_mount(camera: Camera, robot: RobotSpec, document: Document, field: FieldPath) -> None:
    """Refuse a camera that the robot cannot carry, or take to its viewpoints."""
    try:
        camera_pose(camera, robot, robot.home)
    except RobotError as error:
        raise TaskError(f"{document.where((*field, 'parent'))}: {error}; or {WORLD}") from None
    for number, viewpoint in enumerate(camera.viewpoints):
        where, joints = document.where((*field, "viewpoints", number)), len(robot.home)
        if len(viewpoint) != joints:
            raise TaskError(f"{where}: expected {joints} numbers, one for each of the arm's joints")
        for joint, angle, lower, upper in zip(robot.joints, viewpoint, robot.lower, robot.upper, strict=True):
            if not lower - SLACK <= angle <= upper + SLACK:
                raise TaskError(f"{where}: {joint} goes from {lower:g} to {upper:g} rad, not to {angle:g}")


class _Reader:
    """Reads one camera and says where in the file it is wrong."""

    def __init__(self, document: Document, field: FieldPath) -> None:
        self._document, self._field = document, field

    def camera(self, row: Any) -> Camera:
        row = self._mapping(row, (), FIELDS)
        for key in ("name", "parent", "pose", "size"):
            if key not in row:
                raise self._error((), f"{key} is missing")
        name, parent = (self._text(row[key], (key,)) for key in ("name", "parent"))
        if not NAME.fullmatch(name):
            raise self._error(("name",), f"{name!r} has other signs than letters, digits, and _ . - between them")
        pose = self._pose(row["pose"])
        if self._word(row.get("frame", "optical"), ("frame",), ("body", "optical")) == "body":
            pose = pose @ BASE_TO_OPTICAL
        views = row.get("viewpoints", ())
        if not isinstance(views, tuple):
            raise self._error(("viewpoints",), "expected a list of arm configurations")
        if views and parent == WORLD:
            raise self._error(
                ("viewpoints",), f"a camera in the {WORLD} does not go where the arm does; leave them out"
            )
        viewpoints = tuple(self._numbers(view, ("viewpoints", i)) for i, view in enumerate(views))
        calibration = self._record(row.get("calibration"), ("calibration",), CalibrationNoise)
        return Camera(name, self._intrinsics(row), parent, pose, self._noise(row.get("noise")), calibration, viewpoints)

    def _intrinsics(self, row: Mapping[str, Any]) -> Intrinsics:
        size = self._numbers(row["size"], ("size",), 2)
        if any(not value.is_integer() or not 1 <= value <= LARGEST for value in size):
            raise self._error(("size",), f"expected [width, height] in pixels, 1 to {LARGEST} each")
        width, height = int(size[0]), int(size[1])
        if ("field_of_view" in row) == ("intrinsics" in row):
            raise self._error((), "expected either field_of_view [rad] or intrinsics: [fx, fy, cx, cy]")
        if "intrinsics" in row:
            fx, fy, cx, cy = self._numbers(row["intrinsics"], ("intrinsics",), 4)
            if fx <= 0 or fy <= 0:
                raise self._error(("intrinsics",), f"fx and fy must be over 0 pixels, not {fx:g} and {fy:g}")
            if not (0 <= cx <= width and 0 <= cy <= height):
                told = f"the principal point, {cx:g}, {cy:g}, is not in a picture of {width} x {height} pixels"
                raise self._error(("intrinsics",), f"{told}; expected [fx, fy, cx, cy], in pixels of this size")
            return Intrinsics(width, height, fx, fy, cx, cy)
        angle = row["field_of_view"]
        if type(angle) not in (int, float) or not 0.01 < angle < 3.0:
            raise self._error(("field_of_view",), f"{angle!r} is not an angle between 0.01 and 3 rad")
        return Intrinsics.from_field_of_view(width, height, float(angle))

    def _noise(self, value: Any) -> StereoNoise | TimeOfFlightNoise | None:
        if value is None:
            return None
        if not isinstance(value, Mapping) or "kind" not in value:
            raise self._error(("noise",), f"expected kind: {' or '.join(SENSORS)}")
        kind = SENSORS[self._word(value["kind"], ("noise", "kind"), tuple(SENSORS))]
        return self._record({key: v for key, v in value.items() if key != "kind"}, ("noise",), kind)

    def _record(self, value: Any, field: FieldPath, kind: type[Record]) -> Record | None:
        """A noise of numbers; None stays None."""
        if value is None:
            return None
        names = tuple(item.name for item in fields(kind))  # type: ignore[arg-type]  # each is a dataclass
        row = self._mapping(value, field, names)
        for key, number in row.items():
            if wrong := kind.unfit(key, number):
                raise self._error((*field, key), wrong)
        try:
            return kind(**row)
        except ModelError as error:
            raise self._error(field, str(error)) from None

    def _pose(self, value: Any) -> Pose:
        row = self._mapping(value, ("pose",), ("xyz", "quat"))
        if set(row) != {"xyz", "quat"}:
            raise self._error(("pose",), "expected {xyz: [x, y, z], quat: [x, y, z, w]}")
        xyz, quat = (self._numbers(row[key], ("pose", key), n) for key, n in (("xyz", 3), ("quat", 4)))
        if max(map(abs, xyz)) > FARTHEST:
            raise self._error(("pose", "xyz"), f"a camera is at most {FARTHEST:g} m away, along each axis")
        try:
            return Pose((xyz[0], xyz[1], xyz[2]), (quat[0], quat[1], quat[2], quat[3]))
        except ValueError as error:
            raise self._error(("pose",), str(error)) from None

    def _mapping(self, value: Any, field: FieldPath, names: tuple[str, ...]) -> Mapping[str, Any]:
        if not isinstance(value, Mapping):
            raise self._error(field, f"expected a mapping of {', '.join(names)}")
        for key in value:
            if key not in names:
                raise self._error((*field, key), f"unknown; {meant(key, names)}valid are {', '.join(names)}")
        return value

    def _numbers(self, value: Any, field: FieldPath, count: int | None = None) -> tuple[float, ...]:
        right = isinstance(value, tuple) and count in (None, len(value))
        if not right or not all(type(v) in (int, float) and math.isfinite(v) for v in value):
            raise self._error(field, "expected numbers" if count is None else f"expected {count} numbers")
        return tuple(map(float, value))

    def _text(self, value: Any, field: FieldPath) -> str:
        if not isinstance(value, str) or not value:
            raise self._error(field, "expected a name")
        return value

    def _word(self, value: Any, field: FieldPath, words: tuple[str, ...]) -> str:
        if value not in words:
            raise self._error(field, f"{value!r} is unknown; valid are {', '.join(words)}")
        return str(value)

    def _error(self, field: FieldPath, text: str) -> TaskError:
        where = (*self._field, *field)
        return TaskError(f"{self._document.where(where)}: {text}")
