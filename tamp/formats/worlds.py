"""OCRTOC 2020: pairs of SDF 1.4 worlds. An object's name is its alias in the world; a mesh address names its model."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree

from tamp.errors import TaskError
from tamp.formats.models import Library, check_name
from tamp.task.model import At, Inertia, Object, Symmetry, Table, Task
from tamp.task.pose import Pose

if TYPE_CHECKING:
    from tamp.task.pose import Vector3

TABLE_2020 = Table(center=(0.0, 0.0), size=(0.8, 1.0))

ROBOT_2020 = "ur5e_2f85"
"""The robot of 2020, as it is called here."""

BASE_2020 = Pose.from_rpy((-0.24, -0.005, 0.0), (0.0, 0.0, -math.pi / 2))
"""Where it stood (world frame)."""

HOME_2020 = (-1.57, -1.57, 1.57, 0.0, 0.0, 0.0)
"""The joint positions that it started from [rad]."""

_LEVEL = re.compile(r"(\d+)-\d+")


@dataclass(frozen=True)
class _Body:
    """What a world says about one object."""

    model: str
    scale: float
    mass: float
    friction: float
    inertia: Inertia | None
    pose: Pose


def read_worlds(folder: Path, stand_ins: Path) -> tuple[tuple[Task, ...], tuple[str, ...]]:
    """All tasks of `folder`/tasks, and what could not be taken over.

    Meshes are looked for in `folder`/models*/NAME and in `folder`/../2021/models/NAME. Where there is none, a box of
    the size in objects.csv is written below `stand_ins` and a warning says so.

    Raises:
        TaskError: where a world cannot be read, or neither mesh nor size of an object is known.
    """
    library = Library(folder, stand_ins)
    worlds = sorted(folder.glob("tasks/*/input.world"))
    tasks = tuple(_task(path.parent.name, path, path.with_name("target.world"), library) for path in worlds)
    return tasks, tuple(library.warnings)


def level_of(name: str) -> int | None:
    """The level in a task's name, which OCRTOC 2020 gives as LEVEL-NUMBER; None in a name of another form."""
    match = _LEVEL.fullmatch(name)
    return int(match[1]) if match else None


def _task(name: str, start: Path, target: Path, library: Library) -> Task:
    starts, goals = _bodies(start), _bodies(target)
    unknown = sorted(goals.keys() - starts.keys())
    if unknown:
        raise TaskError(f"{target}: {', '.join(unknown)} not in {start}")
    objects = []
    for alias, body in starts.items():
        goal = At(goals[alias].pose) if alias in goals else None
        shape = library.mesh(body.model, start, body.scale)
        model = library.model(body.model)
        symmetry, category = (Symmetry(), None) if model is None else (model.symmetry, model.category or None)
        objects.append(
            Object(alias, shape, body.pose, goal, body.mass, body.friction, symmetry, category, body.inertia)
        )
    return Task(name=name, objects=tuple(objects), table=TABLE_2020, level=level_of(name))


def _bodies(path: Path) -> dict[str, _Body]:
    try:
        root = ElementTree.fromstring(path.read_bytes())
    except OSError as error:
        raise TaskError(f"{path}: cannot be read: {error.strerror}") from error
    except ElementTree.ParseError as error:
        raise TaskError(f"{path}: not XML: {error}") from error
    bodies: dict[str, _Body] = {}
    for model in root.iterfind("./world/model"):
        alias = model.get("name", "")
        try:
            if alias in bodies:
                raise ValueError("stands twice; names must differ")
            bodies[check_name(alias)] = _body(model)
        except ValueError as error:
            raise TaskError(f"{path}: model {alias!r}: {error}") from None
    return bodies


def _body(model: ElementTree.Element) -> _Body:
    address = _text(model, "link/collision/geometry/mesh/uri")
    scales = set(_numbers(model, "link/collision/geometry/mesh/scale", 3))
    if not address.startswith("model://"):
        raise ValueError(f"its mesh address is {address!r}; expected model://NAME/...")
    if len(scales) != 1:
        raise ValueError("its scale differs between axes")
    return _Body(
        model=check_name(address.removeprefix("model://").partition("/")[0]),
        scale=_positive("scale", scales.pop()),
        mass=_positive("mass", *_numbers(model, "link/inertial/mass", 1)),
        friction=_positive("friction", *_numbers(model, "link/collision/surface/friction/ode/mu", 1)),
        inertia=_inertia(model),
        pose=_pose(model, "pose"),
    )


def _inertia(model: ElementTree.Element) -> Inertia | None:
    """How its mass is spread, told about principal axes; None where the world does not say."""
    if model.find("link/inertial/inertia") is None:
        return None
    xx, yy, zz, xy, xz, yz = (_numbers(model, f"link/inertial/inertia/i{i}", 1)[0] for i in _PRODUCTS)
    frame = _pose(model, "link/inertial/pose")
    plain = xy == xz == yz == 0
    return Inertia(frame, (xx, yy, zz)) if plain else _principal(frame, (xx, yy, zz), (xy, xz, yz))


_PRODUCTS = ("xx", "yy", "zz", "xy", "xz", "yz")


def _principal(frame: Pose, moments: Vector3, products: Vector3) -> Inertia:
    """The same spread of mass about axes that have no products of inertia."""
    import numpy as np

    xy, xz, yz = products
    matrix = np.array([[moments[0], xy, xz], [xy, moments[1], yz], [xz, yz, moments[2]]])
    if not np.isfinite(matrix).all():
        raise ValueError("its inertia is not finite")
    values, axes = np.linalg.eigh(matrix)
    T = np.eye(4)
    T[:3, :3] = axes * [1.0, 1.0, np.linalg.det(axes)]
    return Inertia(frame @ Pose.from_matrix(T), (float(values[0]), float(values[1]), float(values[2])))


def _pose(model: ElementTree.Element, tag: str) -> Pose:
    x, y, z, roll, pitch, yaw = _numbers(model, tag, 6)
    return Pose.from_rpy((x, y, z), (roll, pitch, yaw))


def _positive(what: str, value: float) -> float:
    if not 0.0 < value <= 1e6:
        raise ValueError(f"its {what} is {value:g}; expected a positive number")
    return value


def _text(model: ElementTree.Element, tag: str) -> str:
    text = model.findtext(tag)
    if text is None:
        raise ValueError(f"has no <{tag}>")
    return text.strip()


def _numbers(model: ElementTree.Element, tag: str, count: int) -> tuple[float, ...]:
    values = tuple(map(float, _text(model, tag).split()))
    if len(values) != count:
        raise ValueError(f"<{tag}> has {len(values)} numbers; expected {count}")
    return values
