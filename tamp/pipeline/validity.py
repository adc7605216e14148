"""What geometry says against a task: bodies in each other, off the table, or goals in the air."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping

from tamp.errors import TaskError
from tamp.streams.values import Placement
from tamp.task import At, Mesh, Object, Pose, Task
from tamp.task.document import FieldPath, read_document
from tamp.world.world import World

INSIDE = 0.025  # rounding lets given poses overlap a little; deeper than this, two objects are inside each other [m]
THIN = 0.9  # of what is thin, less: spoons were found 13 mm deep in the plates they shall lie on
IN_THE_AIR = 0.05  # a goal that settles farther than this rests on nothing [m]


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
            raise _refusal(task, field, f"{second.name} is inside {first.name}; move one of them")
        if (
            isinstance(first.goal, At)
            and isinstance(second.goal, At)
            and _inside(world, first.name, first.goal.pose, second.name, second.goal.pose)
        ):
            goal_field = ("objects", second_index, "goal", "pose")
            raise _refusal(
                task, goal_field, f"the goal of {second.name} is inside that of {first.name}; move one of them"
            )


def check_settled(task: Task, start: Mapping[str, Pose], goals: Mapping[str, Placement]) -> None:
    """Refuse objects that fall off the table and goals that nothing supports.

    Where something stands in for a mesh that is missing nothing is refused: it pushes away what should lie in it.

    Raises:
        TaskError: names the object, its line in the file, and what would be valid.
    """
    if any(map(_stands_in, task.objects)):
        return
    for index, obj in enumerate(task.objects):
        if start[obj.name].xyz[2] < -task.table.thickness:
            field: FieldPath = ("objects", index, "pose")
            raise _refusal(task, field, f"{obj.name} does not stay on the table; give it a pose that is supported")
        if isinstance(obj.goal, At):
            fallen = math.dist(obj.goal.pose.xyz, goals[obj.name].pose.xyz)
            if fallen > IN_THE_AIR:
                raise _refusal(
                    task,
                    ("objects", index, "goal", "pose"),
                    f"nothing supports {obj.name} there: it would fall {100 * fallen:.0f} cm; "
                    f"give a goal that rests on the table or on another goal",
                )


def _check_on_table(task: Task, world: World, field: FieldPath, name: str, pose: Pose) -> None:
    geometry, table = world.geometries[name], task.table
    center = pose.matrix[:3, :3] @ geometry.center_of_mass + pose.matrix[:3, 3]
    low = [c - s / 2 for c, s in zip(table.center, table.size, strict=True)]
    high = [c + s / 2 for c, s in zip(table.center, table.size, strict=True)]
    if not all(lo <= c <= hi for lo, c, hi in zip(low, center, high, strict=False)):
        raise _refusal(
            task,
            field,
            f"{name} is off the table, which spans x {low[0]:.2f} to {high[0]:.2f} and y {low[1]:.2f} to {high[1]:.2f}",
        )
    if center[2] < 0:
        raise _refusal(task, field, f"{name} is under the table top, which is at z = 0")


def _inside(world: World, a: str, pose_a: Pose, b: str, pose_b: Pose) -> bool:
    thinnest = min(float((world.geometries[n].upper - world.geometries[n].lower).min()) for n in (a, b))
    return world.overlap(a, pose_a.matrix, b, pose_b.matrix, tolerance=min(INSIDE, THIN * thinnest))


def _refusal(task: Task, field: FieldPath, complaint: str) -> TaskError:
    if task.path is None:
        return TaskError(f"task {task.name}: {complaint}")
    return TaskError(f"{read_document(task.path).where(field)}: {complaint}")
