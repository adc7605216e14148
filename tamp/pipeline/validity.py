"""What a task must be to be planned at all: objects that can part, on a table that they stay on."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from tamp.errors import TaskError
from tamp.streams.values import Placement
from tamp.task import At, Mesh, Object, Pose, Task
from tamp.task.files.yaml_document import FieldPath, read_document
from tamp.world.world import World

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.task.mesh.parts import Part

INSIDE = 0.025  # rounding lets given poses overlap a little; deeper than this, two objects are inside each other [m]
THIN = 0.9  # of what is thin, less: spoons were found 13 mm deep in the plates they shall lie on
SUNK = 0.01  # no rounding brings a body's centre of mass deeper than this into another body [m]
IN_THE_AIR = 0.05  # a goal that settles farther than this, and than the object is long, may rest on nothing [m]
DROP = 0.005  # between the heights at which something is looked for under it [m]
WORTH_SAYING = 0.02  # what settles this far from where it was given is said in the result [m]


def _stands_in(obj: Object) -> bool:
    """Whether no more than an object's size is known."""
    return isinstance(obj.shape, Mesh) and obj.shape.stand_in


def check_geometry(task: Task, world: World) -> None:
    """Refuse objects inside each other and objects that stand off the table; what stands in for a mesh may overlap.

    Raises:
        TaskError: names the object, its line in the file, and what would be valid.
    """
    for index, obj in enumerate(task.objects):
        _check_on_table(task, world, ("objects", index, "pose"), obj.name, obj.pose)
        if isinstance(obj.goal, At):
            _check_on_table(task, world, ("objects", index, "goal", "pose"), obj.name, obj.goal.pose)
    known = [(index, obj) for index, obj in enumerate(task.objects) if not _stands_in(obj)]
    for (_, first), (second_index, second) in itertools.combinations(known, 2):
        if _inside(world, first.name, first.pose, second.name, second.pose):
            field = ("objects", second_index, "pose")
            raise refusal(task, field, f"{second.name} is inside {first.name}; move one of them")
        if (
            isinstance(first.goal, At)
            and isinstance(second.goal, At)
            and _inside(world, first.name, first.goal.pose, second.name, second.goal.pose)
        ):
            goal_field = ("objects", second_index, "goal", "pose")
            raise refusal(
                task, goal_field, f"the goal of {second.name} is inside that of {first.name}; move one of them"
            )


def check_settled(task: Task, world: World, start: Mapping[str, Pose], goals: Mapping[str, Placement]) -> None:
    """Refuse objects that fall off the table and goals in the air, with nothing under them.

    What stands on something and falls off it is planned for where it comes to rest: rounded poses do that.
    Where something stands in for a mesh that is missing nothing is refused: it pushes away what should lie in it.

    Raises:
        TaskError: names the object, its line in the file, and what would be valid.
    """
    if any(map(_stands_in, task.objects)):
        return
    for index, obj in enumerate(task.objects):
        if _center(world, obj.name, start[obj.name])[2] < -task.table.thickness:
            field: FieldPath = ("objects", index, "pose")
            raise refusal(task, field, f"{obj.name} does not stay on the table; give it a pose that is supported")
        if isinstance(obj.goal, At):
            fallen = _moved(world, obj.name, obj.goal.pose, goals[obj.name].pose)
            if fallen > max(IN_THE_AIR, _diagonal(world, obj.name)) and _in_the_air(task, world, obj.name):
                raise refusal(
                    task,
                    ("objects", index, "goal", "pose"),
                    f"nothing supports {obj.name} there: it would fall {100 * fallen:.0f} cm; "
                    f"give a goal that rests on the table or on another goal",
                )


def _in_the_air(task: Task, world: World, name: str) -> bool:
    """Whether nothing that shall stand somewhere, nor the table, is within reach under an object's goal."""
    goals = {obj.name: obj.goal.pose for obj in task.objects if isinstance(obj.goal, At)}
    goals |= {obj.name: obj.pose for obj in task.objects if obj.goal is None}
    T = goals.pop(name).matrix
    geometry = world.geometries[name]
    if (geometry.hull.vertices @ T[2, :3]).min() + T[2, 3] < IN_THE_AIR:
        return False
    drops = np.arange(0.0, IN_THE_AIR, DROP)
    lowered = [Pose((T[0, 3], T[1, 3], T[2, 3] - drop), Pose.from_matrix(T).quat) for drop in drops]
    return not any(
        world.overlap(name, at.matrix, other, pose.matrix) for at in lowered for other, pose in goals.items()
    )


def _check_on_table(task: Task, world: World, field: FieldPath, name: str, pose: Pose) -> None:
    center, table = _center(world, name, pose), task.table
    low = [c - s / 2 for c, s in zip(table.center, table.size, strict=True)]
    high = [c + s / 2 for c, s in zip(table.center, table.size, strict=True)]
    if not all(lo <= c <= hi for lo, c, hi in zip(low, center, high, strict=False)):
        raise refusal(
            task,
            field,
            f"{name} is off the table, which spans x {low[0]:.2f} to {high[0]:.2f} and y {low[1]:.2f} to {high[1]:.2f}",
        )
    if center[2] < 0:
        raise refusal(task, field, f"{name} is under the table top, which is at z = 0")


def _center(world: World, name: str, pose: Pose) -> NDArray[np.float64]:
    """Where the centre of mass is in the world, shape (3,) [m]: a mesh's origin may be anywhere."""
    T = pose.matrix
    center: NDArray[np.float64] = T[:3, :3] @ world.geometries[name].center_of_mass + T[:3, 3]
    return center


def _moved(world: World, name: str, given: Pose, settled: Pose) -> float:
    """How far the centre of mass is from where a pose has it [m]."""
    return math.dist(_center(world, name, given), _center(world, name, settled))


def _inside(world: World, a: str, pose_a: Pose, b: str, pose_b: Pose) -> bool:
    """Whether two bodies are so deep in each other that settling cannot part them as they were meant."""
    thinnest = min(float((world.geometries[n].upper - world.geometries[n].lower).min()) for n in (a, b))
    deep = world.overlap(a, pose_a.matrix, b, pose_b.matrix, tolerance=min(INSIDE, THIN * thinnest))
    return deep and max(_sunk(world, a, pose_a, b, pose_b), _sunk(world, b, pose_b, a, pose_a)) > SUNK


def _sunk(world: World, a: str, pose_a: Pose, b: str, pose_b: Pose) -> float:
    """How deep the centre of mass of `a` is in a convex part of `b` [m]; negative outside."""
    center = pose_b.inverse().matrix @ pose_a.matrix @ np.append(world.geometries[a].center_of_mass, 1.0)
    return max(_depth(part, center[:3]) for part in world.geometries[b].parts)


def _depth(part: Part, point: NDArray[np.float64]) -> float:
    corners = part.vertices[part.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normals, axis=1)
    flat = length > 0.0  # a face without area has no side
    heights = np.einsum("ij,ij->i", corners[flat, 0] - point, normals[flat]) / length[flat]
    return float(heights.min())


def _diagonal(world: World, name: str) -> float:
    geometry = world.geometries[name]
    return float(np.linalg.norm(geometry.upper - geometry.lower))


def remarks(task: Task, start: Mapping[str, Pose], goals: Mapping[str, Placement]) -> Iterator[str]:
    """Yield a sentence for each pose that is not where the object comes to rest, by more than a little.

    Args:
        task: the poses as they were given, which the score is measured against.
        start: object -> where it settles.
        goals: object -> what its goal means.
    """
    for obj in task.objects:
        moved = math.dist(obj.pose.xyz, start[obj.name].xyz)
        if moved > WORTH_SAYING:
            yield f"{obj.name} settles {100 * moved:.0f} cm from its start pose"
        if isinstance(obj.goal, At):
            moved = math.dist(obj.goal.pose.xyz, goals[obj.name].pose.xyz)
            if moved > WORTH_SAYING:
                yield f"the goal of {obj.name} settles {100 * moved:.0f} cm from its pose, which the score counts from"


def refusal(task: Task, field: FieldPath, complaint: str) -> TaskError:
    """What is wrong with a field of a task, with file and line where it came from a file."""
    if task.path is None:
        return TaskError(f"task {task.name}: {complaint}")
    return TaskError(f"{read_document(task.path).where(field)}: {complaint}")
