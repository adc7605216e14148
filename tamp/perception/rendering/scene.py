"""What there is to see: bodies with their looks, each where it stands."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tamp.errors import TampError
from tamp.perception.rendering.robot import robot_surface
from tamp.perception.rendering.surface import TABLE_COLOR, Surface, plain, surface_of
from tamp.task.model import Box, Shape, Table, Task
from tamp.task.pose import Pose
from tamp.task.robot import RobotSpec

if TYPE_CHECKING:
    from numpy.typing import NDArray

TABLE, ROBOT = "table", "robot"


@dataclass(frozen=True, eq=False)
class Body:
    """A rigid thing in a picture.

    Attributes:
        name: "table", "robot", or an object's.
        surface: in the body's frame.
        T_world_body: shape (4, 4).
    """

    name: str
    surface: Surface
    T_world_body: NDArray[np.float64]


def surfaces(task: Task, visuals: Path | None = None) -> dict[str, Surface]:
    """Object -> what it looks like, see `surface_of`.

    Objects that look the same have one surface, also where their meshes are files of different names.

    Raises:
        TampError: where `visuals` is no folder: all would be grey without a word.
    """
    if visuals is not None and not visuals.is_dir():
        raise TampError(f"{visuals}: there is no such folder of coloured meshes, MODEL.ply")
    known: dict[Shape, Surface] = {}
    same: dict[tuple[bytes, ...], Surface] = {}
    for obj in task.objects:
        if obj.shape not in known:
            surface = surface_of(obj, visuals)
            content = tuple(array.tobytes() for array in (surface.vertices, surface.faces, surface.colors))
            known[obj.shape] = same.setdefault(content, surface)
    return {obj.name: known[obj.shape] for obj in task.objects}


def objects_at(looks: Mapping[str, Surface], poses: Mapping[str, Pose]) -> list[Body]:
    """The objects that have a pose, in the order of `looks`."""
    return [Body(name, surface, poses[name].matrix) for name, surface in looks.items() if name in poses]


def table_body(table: Table) -> Body:
    """The table top, as thick as it is."""
    pose = Pose((*table.center, -table.thickness / 2))
    return Body(TABLE, plain(Box((*table.size, table.thickness)), TABLE_COLOR), pose.matrix)


def robot_body(spec: RobotSpec, q: Sequence[float], opening: float | None = None) -> Body:
    """The robot at a configuration [rad], its fingers `opening` apart [m] (wide open where it is None)."""
    return Body(ROBOT, robot_surface(spec, q, spec.gripper.stroke if opening is None else opening), np.eye(4))
