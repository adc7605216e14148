"""What can be wrong with a task before any geometry is looked at: names, sizes, references, cycles, regions."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from tamp.errors import TaskError, meant
from tamp.task.files.yaml_document import Document, FieldPath, dotted
from tamp.task.model import At, Box, Capsule, In, Mesh, On, Region, Shape, Sphere, Table, Task
from tamp.task.pose import Pose
from tamp.task.robots import is_path, robot_names

RESERVED_NAMES = ("table", "robot")
THINNEST, LARGEST = 1e-4, 2.0
"""Least and largest side of an object's shape [m]; meshes are judged when they are read."""
LARGEST_TABLE = 10.0

Refuse = Callable[[FieldPath, str], TaskError]
"""Makes the error about a field."""


def validate(task: Task, document: Document | None = None) -> None:
    """Check a task's names, sizes and references.

    Args:
        task: the task, from a file or built in code.
        document: the file it came from, where it is at hand; without it messages name the field alone.

    Raises:
        TaskError: in one sentence that says where and what would be valid.
    """

    def refuse(field: FieldPath, complaint: str) -> TaskError:
        return TaskError(f"{document.where(field)}: {complaint}") if document else _refusal(task, field, complaint)

    if not is_path(task.robot) and task.robot not in robot_names():
        valid = f"installed are {', '.join(robot_names())}, or give the path of a robot.yaml"
        raise refuse(("robot",), f"unknown robot {task.robot!r}; {meant(task.robot, robot_names())}{valid}")
    _check_names(task, refuse)
    check_sizes(task, refuse)
    _check_places(task, refuse)
    for name in ("planning_s", "execution_sim_s"):
        if not getattr(task.limits, name) > 0:  # nor is NaN
            complaint = f"is {getattr(task.limits, name)!r}; valid are positive numbers of seconds"
            raise refuse(("limits", name), complaint)
    _check_goals(task, refuse)
    _check_facts(task, refuse)
    for index, region in enumerate(task.regions):
        if not _on_table(region, task.table):
            raise refuse(
                ("regions", index, "box"), f"the region reaches beyond the table, which spans {_span(task.table)}"
            )


def _check_names(task: Task, refuse: Refuse) -> None:
    seen: set[str] = set()
    named = [(("objects", i), o.name) for i, o in enumerate(task.objects)]
    named += [(("regions", i), r.name) for i, r in enumerate(task.regions)]
    for field, name in named:
        if name in RESERVED_NAMES:
            raise refuse((*field, "name"), f"{name!r} is reserved; choose another name")
        if name in seen:
            raise refuse((*field, "name"), f"{name!r} is taken; names of objects and regions must differ")
        seen.add(name)


def check_sizes(task: Task, refuse: Refuse | None = None) -> None:
    """Refuse shapes of objects, and a table, that are too small or too large to be any, or whose size is no number.

    Args:
        task: the task.
        refuse: makes the error; without it that names the task and the field.

    Raises:
        TaskError: as `refuse` makes it.
    """
    refuse = refuse or (lambda field, complaint: _refusal(task, field, complaint))
    for index, o in enumerate(task.objects):
        if not isinstance(o.shape, Shape):
            complaint = f"{o.shape!r} is no shape; valid are tamp.Box, Cylinder, Sphere, Capsule and Mesh"
            raise refuse(("objects", index, "shape"), complaint)
        sides = _sides(o.shape)
        if not all(THINNEST <= side <= LARGEST for side in sides):
            said = " x ".join(f"{side:.3g}" for side in sides)
            complaint = f"measures {said} m; sides are {THINNEST:g} to {LARGEST:g} m long"
            raise refuse(("objects", index, "shape"), complaint)
    if not all(THINNEST <= side <= LARGEST_TABLE for side in (*task.table.size, task.table.thickness)):
        raise refuse(("table",), f"sides and thickness are {THINNEST:g} to {LARGEST_TABLE:g} m long")


def _refusal(task: Task, field: FieldPath, complaint: str) -> TaskError:
    return TaskError(f"task {task.name}: {dotted(field)}: {complaint}")


def _sides(shape: Shape) -> tuple[float, ...]:
    """Sides of the box round a shape [m]; none for a mesh."""
    if isinstance(shape, Mesh):
        return ()
    if isinstance(shape, Box):
        return shape.size
    if isinstance(shape, Sphere):
        return (2 * shape.radius,)
    return (2 * shape.radius, shape.height + (2 * shape.radius if isinstance(shape, Capsule) else 0.0))


def _check_places(task: Task, refuse: Refuse) -> None:
    """Refuse what stands, or shall stand, off the table; what a mesh's centre is, is known once it is read."""
    (x_low, x_high), (y_low, y_high) = _spans(task.table)
    for index, o in enumerate(task.objects):
        if isinstance(o.shape, Mesh):
            continue
        places: list[tuple[FieldPath, Pose]] = [(("objects", index, "pose"), o.pose)]
        places += [(("objects", index, "goal", "pose"), o.goal.pose)] if isinstance(o.goal, At) else []
        for field, pose in places:
            x, y, z = (pose if o.inertia is None else pose @ o.inertia.frame).xyz
            if not (x_low <= x <= x_high and y_low <= y <= y_high):
                span = f"x {x_low:.2f} to {x_high:.2f} and y {y_low:.2f} to {y_high:.2f}"
                raise refuse(field, f"{o.name} is off the table, which spans {span}")
            if z < 0:
                raise refuse(field, f"{o.name} is under the table top, which is at z = 0")


def _check_goals(task: Task, refuse: Refuse) -> None:
    objects = [o.name for o in task.objects]
    regions = [r.name for r in task.regions]
    rests_on: dict[str, str] = {}
    for index, o in enumerate(task.objects):
        if not isinstance(o.goal, (On, In)):
            continue
        key, valid = ("on", [*regions, *objects]) if isinstance(o.goal, On) else ("in", objects)
        field = ("objects", index, "goal", key)
        if o.goal.target not in valid or o.goal.target == o.name:
            others = [name for name in valid if name != o.name]
            near = "" if o.goal.target == o.name else meant(o.goal.target, others)
            there = f"{near}valid are {', '.join(others)}" if others else f"the task has nothing to be {key}"
            raise refuse(field, f"{o.goal.target!r} is no possible target; {there}")
        rests_on[o.name] = o.goal.target
        chain = [o.name]
        while chain[-1] in rests_on:
            chain.append(rests_on[chain[-1]])
            if chain[-1] == o.name:
                raise refuse(field, f"the goals rest on each other in a circle: {' on '.join(chain)}")


def _check_facts(task: Task, refuse: Refuse) -> None:
    """The domain knows which predicates there are; here, whether what they are about is there."""
    valid = [*(o.name for o in task.objects), *(r.name for r in task.regions), "table"]
    for field, facts in (("init", task.init), ("goal", task.goal)):
        for index, (predicate, *names) in enumerate(facts):
            if strangers := [name for name in names if name not in valid]:
                complaint = (
                    f"{predicate} is said of {strangers[0]!r}; {meant(strangers[0], valid)}valid are {', '.join(valid)}"
                )
                raise refuse((field, index), complaint)


def _on_table(region: Region, table: Table) -> bool:
    return all(
        abs(rc - tc) + rs / 2 <= ts / 2 + 1e-9
        for rc, rs, tc, ts in zip(region.center, region.size, table.center, table.size, strict=True)
    )


def _spans(table: Table) -> Iterator[tuple[float, float]]:
    """From where to where the table reaches along x and along y [m]."""
    return ((c - s / 2, c + s / 2) for c, s in zip(table.center, table.size, strict=True))


def _span(table: Table) -> str:
    return ", ".join(f"{axis} {low:.3f} to {high:.3f} m" for axis, (low, high) in zip("xy", _spans(table), strict=True))
