"""Task -> task.yaml."""

from __future__ import annotations

import os
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import yaml

from tamp.task.model import At, Box, Capsule, Cylinder, Limits, Mesh, Object, On, Shape, Sphere, Symmetry, Table, Task
from tamp.task.pose import Pose
from tamp.task.robots import is_path

if TYPE_CHECKING:
    from _typeshed import StrPath

_DUMPER: Any = getattr(yaml, "CSafeDumper", yaml.SafeDumper)


def save_task(task: Task, path: StrPath) -> None:
    """Write a task.yaml that `load_task` reads back as the same task; meshes are referred to relative to its folder.

    Raises:
        OSError: where it cannot be written.
    """
    path = Path(path)
    data = as_mapping(task, path.resolve().parent)
    text = yaml.dump(data, Dumper=_DUMPER, sort_keys=False, default_flow_style=None, width=120)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def as_mapping(task: Task, folder: Path) -> dict[str, Any]:
    """The task as plain values in the form of task.yaml, for a file in `folder`."""
    data: dict[str, Any] = {"name": task.name, "robot": _robot(task, folder)}
    if task.base is not None:
        data["base"] = _pose_mapping(task.base)
    if task.home is not None:
        data["home"] = list(task.home)
    if task.level is not None:
        data["level"] = task.level
    data["objects"] = [_object_mapping(o, folder) for o in task.objects]
    if task.regions:
        data["regions"] = [
            {"name": r.name, "box": {"center": list(r.center), "size": list(r.size)}} for r in task.regions
        ]
    if task.table != Table():
        table = task.table
        data["table"] = {"center": list(table.center), "size": list(table.size), "thickness": table.thickness}
    if task.domain != Task.domain:
        data["domain"] = task.domain
    data |= {name: [list(fact) for fact in getattr(task, name)] for name in ("init", "goal") if getattr(task, name)}
    named = ("strategy", "search", "motion_planner", "simulator", "perceive")
    data |= {name: getattr(task, name) for name in named if getattr(task, name) is not None}
    if task.samplers:
        data["samplers"] = dict(task.samplers)
    if task.limits != Limits():
        data["limits"] = {"planning_s": task.limits.planning_s, "execution_sim_s": task.limits.execution_sim_s}
    return data


def _robot(task: Task, folder: Path) -> str:
    """Its name, or the path as it is seen from the folder."""
    if not is_path(task.robot):
        return task.robot
    own = Path() if task.path is None else task.path.parent
    return Path(os.path.relpath((own / task.robot).resolve(), folder)).as_posix()


def _object_mapping(o: Object, folder: Path) -> dict[str, Any]:
    data: dict[str, Any] = {"name": o.name, "shape": _shape_mapping(o.shape, folder), "pose": _pose_mapping(o.pose)}
    if isinstance(o.goal, At):
        data["goal"] = {"pose": _pose_mapping(o.goal.pose)}
    elif o.goal is not None:
        data["goal"] = {"on" if isinstance(o.goal, On) else "in": o.goal.target}
    data |= {"mass": o.mass, "friction": o.friction}
    if o.symmetry != Symmetry():
        data["symmetry"] = asdict(o.symmetry)
    if o.category is not None:
        data["category"] = o.category
    if o.inertia is not None:
        data["inertia"] = {"frame": _pose_mapping(o.inertia.frame), "moments": list(o.inertia.moments)}
    return data


def _shape_mapping(shape: Shape, folder: Path) -> dict[str, Any]:
    match shape:
        case Box(size):
            return {"box": list(size)}
        case Cylinder(radius, height):
            return {"cylinder": {"radius": radius, "height": height}}
        case Sphere(radius):
            return {"sphere": {"radius": radius}}
        case Capsule(radius, height):
            return {"capsule": {"radius": radius, "height": height}}
        case Mesh(path, scale, stand_in):
            file = Path(os.path.relpath(path.resolve(), folder)).as_posix()
            return {"mesh": file, "scale": scale} | ({"stand_in": True} if stand_in else {})


def _pose_mapping(pose: Pose) -> dict[str, Any]:
    data: dict[str, Any] = {"xyz": list(pose.xyz)}
    if pose.quat != (0.0, 0.0, 0.0, 1.0):
        data["quat"] = list(pose.quat)
    return data
