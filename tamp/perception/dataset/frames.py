"""Pictures with their labels, whatever layout they are written in, and what the layouts share in writing them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tamp.perception.cameras.camera import Intrinsics
from tamp.task.pose import Pose

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

DEPTH_UNIT = 1e-4
"""What a step of a depth picture is [m]."""


@dataclass(frozen=True, eq=False)
class Label:
    """An object in a picture.

    Attributes:
        name: the object's.
        T_camera_object: shape (4, 4).
        whole: pixels that it would cover if nothing stood before it, bool (height, width).
        visible: pixels that show it, bool (height, width).
    """

    name: str
    T_camera_object: Array
    whole: NDArray[np.bool_]
    visible: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class LabelledFrame:
    """A picture with its labels.

    Attributes:
        intrinsics: of colour and depth.
        T_world_camera: shape (4, 4).
        color: shape (height, width, 3), uint8.
        depth: shape (height, width), uint16 in steps of 0.1 mm; 0 is no measurement.
        labels: the objects that are there, in view or not.
    """

    intrinsics: Intrinsics
    T_world_camera: Array
    color: NDArray[np.uint8]
    depth: NDArray[np.uint16]
    labels: tuple[Label, ...]


def steps(depth: NDArray[np.float32], whole: int = 1) -> NDArray[np.uint16]:
    """A depth picture [m] in steps of 0.1 mm, in multiples of `whole`; what is over 6.55 m away is no measurement."""
    counted = whole * np.rint(depth / (whole * DEPTH_UNIT))
    return np.where(counted < 2**16, counted, 0).astype(np.uint16)


def object_pose(frame: LabelledFrame, label: Label) -> Pose:
    """`T_world_object` of a label."""
    return Pose.from_matrix(frame.T_world_camera @ label.T_camera_object)


def save_image(path: Path, image: NDArray[Any]) -> None:
    """Write a picture as PNG."""
    from PIL import Image

    Image.fromarray(image).save(path, compress_level=1)


def load_image(path: Path) -> NDArray[Any]:
    """A picture as it was written."""
    from PIL import Image

    with Image.open(path) as image:
        return np.asarray(image)
