"""A pinhole camera without distortion, and where it is mounted.

Optical frame: z forward, x to the right, y down; pixel (u, v) has its centre at (u + 0.5, v + 0.5).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import lru_cache
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from tamp.errors import ModelError
from tamp.task.pose import Pose

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

WORLD = "world"
"""The parent of a camera that is not mounted on the robot."""

FARTHEST = 1000.0
"""No camera and no object is farther from the world's origin along an axis: no task's file allows more [m]."""

BASE_TO_OPTICAL = Pose(quat=(-0.5, 0.5, -0.5, 0.5))
"""`T_base_optical` of a camera body whose x looks forward, y to the left and z up (ROS REP 103)."""


@dataclass(frozen=True)
class Intrinsics:
    """Size [pixels], focal lengths and principal point [pixels] of a pinhole camera."""

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float

    @staticmethod
    def from_field_of_view(width: int, height: int, vertical: float) -> Intrinsics:
        """Square pixels, principal point at the middle, and a vertical field of view [rad]."""
        f = height / 2 / math.tan(vertical / 2)
        return Intrinsics(width, height, f, f, width / 2, height / 2)

    @property
    def matrix(self) -> Array:
        """K, shape (3, 3)."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    def scaled(self, factor: float) -> Intrinsics:
        """The same camera with pictures `factor` times as wide and high, of one pixel at least."""
        size = max(1, round(self.width * factor)), max(1, round(self.height * factor))
        return Intrinsics(*size, *(factor * value for value in (self.fx, self.fy, self.cx, self.cy)))

    def rays(self) -> NDArray[np.float32]:
        """The direction of each pixel's centre at depth 1, optical frame, shape (height, width, 3); read-only."""
        return _rays(self)

    def points(self, depth: NDArray[np.float32]) -> NDArray[np.float32]:
        """Points of a depth picture (height, width) [m] in the optical frame, shape (height, width, 3)."""
        return self.rays() * depth[..., None]

    def points_every(self, depth: NDArray[np.float32], step: int) -> NDArray[np.float32]:
        """The same of a picture of which only every `step`th row and column is given."""
        return self.rays()[::step, ::step] * depth[..., None]

    def project(self, points: Array) -> tuple[Array, Array]:
        """Pixel coordinates (n, 2) and depths (n,) [m] of points (n, 3) in the optical frame; depth must not be 0."""
        depth = points[:, 2]
        pixels = points[:, :2] / depth[:, None] * (self.fx, self.fy) + (self.cx, self.cy)
        return pixels, depth


@lru_cache(maxsize=8)
def _rays(k: Intrinsics) -> NDArray[np.float32]:
    u = (np.arange(k.width, dtype=np.float32) + 0.5 - k.cx) / k.fx
    v = (np.arange(k.height, dtype=np.float32) + 0.5 - k.cy) / k.fy
    rays = np.empty((k.height, k.width, 3), dtype=np.float32)
    rays[..., 0], rays[..., 1], rays[..., 2] = u[None, :], v[:, None], 1.0
    rays.setflags(write=False)
    return rays


class CheckedNoise:
    """A noise whose numbers, the fields of a dataclass, are looked at as it is made.

    Raises:
        ModelError: says which field is wrong, and what would be valid.
    """

    MOST: ClassVar[Mapping[str, float]] = MappingProxyType({})
    """Field -> the largest value that it may have; fields absent here may be any number of at least 0."""

    def __post_init__(self) -> None:
        for item in fields(self):  # type: ignore[arg-type]  # a dataclass wherever one is made
            if wrong := self.unfit(item.name, getattr(self, item.name)):
                raise ModelError(f"{item.name}: {wrong}")
        near, far = getattr(self, "near", 0.0), getattr(self, "far", math.inf)
        if near >= far:
            raise ModelError(f"near: {near:g} m is not nearer than far, {far:g} m")

    @classmethod
    def unfit(cls, name: str, value: object) -> str:
        """Why a value is none of a field; empty where it is one."""
        whole = cls.__annotations__[name] == "int"
        number, most = ("whole number" if whole else "number"), cls.MOST.get(name, math.inf)
        kinds = int if whole else (int, float)
        if isinstance(value, kinds) and not isinstance(value, bool) and 0 <= value <= most and value < math.inf:
            return ""
        return f"{value!r} is not a {number} of at least 0" + (f" and at most {most:g}" if most < math.inf else "")


@dataclass(frozen=True)
class StereoNoise(CheckedNoise):
    """How an active stereo camera errs; defaults after the D435's data sheet (baseline 50 mm, error under 2 % at 2 m).

    The depth error grows with the square of the distance: sigma_z = z^2 * sigma_d / (f * baseline).

    Attributes:
        baseline: between the two imagers [m].
        disparity: standard deviation of the disparity [pixels]; the product's subpixel error is about 0.08.
        correlation: width over which the error is alike [pixels]: that of the matching window.
        quantum: step of the disparity [pixels].
        fattening: how far a near edge covers what is behind it [pixels]: half of the matching window.
        grazing: surfaces seen at a smaller angle than this [rad] are not matched.
        holes: share of matching windows that fail elsewhere.
        near, far: range within which there is a depth [m].
    """

    baseline: float = 0.050
    disparity: float = 0.08
    correlation: float = 3.0
    quantum: float = 1 / 32
    fattening: int = 2
    grazing: float = math.radians(8)
    holes: float = 0.01
    near: float = 0.17
    far: float = 3.0

    MOST: ClassVar[Mapping[str, float]] = MappingProxyType(
        {"correlation": 100.0, "fattening": 100, "grazing": math.pi / 2, "holes": 1.0}
    )


@dataclass(frozen=True)
class TimeOfFlightNoise(CheckedNoise):
    """How a time-of-flight camera errs; defaults after Microsoft's data sheet of the Azure Kinect DK.

    It promises a random error of at most 17 mm and a systematic one below 11 mm + 0.1 % of the distance without
    multipath; means of several frames, as a set-up that stands still takes, and the narrow field of view do better.

    Attributes:
        range_error: standard deviation per pixel at 1 m, growing with the square of the distance [m].
        offset: standard deviation of an error common to a whole picture [m].
        mixed: share of pixels on a depth edge that lie between near and far (flying pixels).
        edge: depth differences between neighbours over this are an edge [m].
        dropped: share of edge pixels without a depth.
        grazing: surfaces seen at a smaller angle than this [rad] return too little light.
        near, far: range within which there is a depth [m].
    """

    range_error: float = 0.0015
    offset: float = 0.001
    mixed: float = 0.5
    edge: float = 0.01
    dropped: float = 0.3
    grazing: float = math.radians(6)
    near: float = 0.25
    far: float = 3.9

    MOST: ClassVar[Mapping[str, float]] = MappingProxyType({"mixed": 1.0, "dropped": 1.0, "grazing": math.pi / 2})


Noise = StereoNoise | TimeOfFlightNoise


@dataclass(frozen=True)
class CalibrationNoise(CheckedNoise):
    """How far the believed pose of a camera is from the true one; standard deviations a coordinate.

    Attributes:
        mount_m, mount_rad: of the mount (hand-eye, or the stationary camera's), the same in all views of a scene.
        view_m, view_rad: of each view: the arm's repeatability and encoder offsets.
    """

    mount_m: float = 0.001
    mount_rad: float = 0.002
    view_m: float = 0.0005
    view_rad: float = 0.001

    MOST: ClassVar[Mapping[str, float]] = MappingProxyType({"mount_m": FARTHEST, "view_m": FARTHEST})


@dataclass(frozen=True)
class Camera:
    """A colour and depth camera of a set-up, both pictures registered and of one size.

    Attributes:
        name: unique in its set-up.
        intrinsics: of both pictures.
        parent: "world", or the robot's link that carries it.
        T_parent_camera: pose of the optical frame in the parent's.
        noise: how the depth errs; None is a perfect sensor.
        calibration: how the believed pose errs; None is perfect.
        viewpoints: arm configurations from which pictures are taken [rad]; empty for a camera in the world, which takes
            one with the arm at home.
    """

    name: str
    intrinsics: Intrinsics
    parent: str
    T_parent_camera: Pose
    noise: Noise | None = None
    calibration: CalibrationNoise | None = None
    viewpoints: tuple[tuple[float, ...], ...] = ()


def looking_at(eye: Array, target: Array) -> Array:
    """The pose (4, 4) of an optical frame at a point, looking at another, upright."""
    z = target - eye
    z /= np.linalg.norm(z)
    x = np.cross(z, [0.0, 0.0, 1.0])
    x = np.array([1.0, 0.0, 0.0]) if np.linalg.norm(x) < 1e-9 else x / np.linalg.norm(x)
    T = np.eye(4)
    T[:3, 0], T[:3, 1], T[:3, 2], T[:3, 3] = x, np.cross(z, x), z, eye
    return T


@dataclass(frozen=True, eq=False)
class Frame:
    """What a camera saw, as a perceiver is given it.

    Attributes:
        camera: the camera's name.
        intrinsics: of both pictures.
        T_world_camera: pose of the optical frame as calibration and encoders have it, shape (4, 4).
        color: shape (height, width, 3), uint8.
        depth: shape (height, width), float32 [m] along the optical axis; 0 is no measurement.
        robot: where the robot is in the picture, by its known configuration; bool (height, width).
        instances: per pixel the index of the object in the list of models, -1 for anything else, where masks are given;
            int16 (height, width).
    """

    camera: str
    intrinsics: Intrinsics
    T_world_camera: Array
    color: NDArray[np.uint8]
    depth: NDArray[np.float32]
    robot: NDArray[np.bool_]
    instances: NDArray[np.int16] | None = None
