"""Which robots there are and where: installed ones, those of other packages, of the user's folders, of a task's."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import os
import sys
from dataclasses import replace
from functools import lru_cache
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING

from tamp.errors import RobotError, meant
from tamp.task.files.regular_file import followed

if TYPE_CHECKING:
    from tamp.task.model import Task
    from tamp.task.robot import RobotSpec

GROUP = "tamp.robots"
"""Entry points of other packages: NAME = "package.of.the.folder"."""

VARIABLE = "TAMP_ROBOTS"
"""Environment variable: folders in which NAME/robot.yaml stand, parted as PATH is."""

FILE = "robot.yaml"


def robot_names() -> tuple[str, ...]:
    """Names of all robots that can be named without a path, sorted."""
    return tuple(sorted(robot_files()))


def robot_files() -> dict[str, Path]:
    """Each robot's file by its name.

    Raises:
        RobotError: where two have one name.
    """
    found: dict[str, Path] = {}
    for folder in (Path(str(files("tamp"))) / "robots", *_folders()):
        for path in sorted(folder.glob(f"*/{FILE}")):
            _add(found, path.parent.name, path)
    for entry in _entries(tuple((folder, _changed(folder)) for folder in sys.path)):
        _add(found, entry.name, _entry_file(entry))
    return found


def _add(found: dict[str, Path], name: str, path: Path) -> None:
    if name in found and found[name].resolve() != path.resolve():
        raise RobotError(f"robot {name!r} is there twice: {found[name]} and {path}; rename one of the folders")
    found[name] = path


def _folders() -> tuple[Path, ...]:
    folders = tuple(Path(text).expanduser() for text in os.environ.get(VARIABLE, "").split(os.pathsep) if text)
    for folder in folders:
        if not folder.is_dir():
            raise RobotError(f"{VARIABLE} names {folder}, which is no folder")
    return folders


@lru_cache(maxsize=4)
def _entries(installed: tuple[tuple[str, int], ...]) -> tuple[importlib.metadata.EntryPoint, ...]:
    """Entry points for robots, looked up once while no package comes to the folders on sys.path, or leaves them."""
    return tuple(sorted(importlib.metadata.entry_points(group=GROUP)))


def _changed(path: str | Path) -> int:
    """When a file or folder was last changed [ns]; 0 where it is not there."""
    try:
        return Path(path).stat().st_mtime_ns
    except OSError:
        return 0


def _entry_file(entry: importlib.metadata.EntryPoint) -> Path:
    try:
        found = importlib.util.find_spec(entry.value)
    except ModuleNotFoundError:
        found = None
    if found is None or not found.submodule_search_locations:
        raise RobotError(f"entry point {entry.name} of {GROUP} names {entry.value!r}, which is no installed package")
    return Path(next(iter(found.submodule_search_locations))) / FILE


def is_path(robot: str) -> bool:
    """Whether a robot is meant by its file, not by its name."""
    return robot.endswith((".yaml", ".yml")) or "/" in robot or os.sep in robot


def load_robot(robot: str, folder: Path | None = None) -> RobotSpec:
    """The robot of a name, or of a path to its robot.yaml or to the folder that it is in.

    Args:
        robot: name or path.
        folder: what a path is relative to; the working folder where it is None.

    Raises:
        RobotError: where there is no such robot, or its data is incomplete.
    """
    if is_path(robot):
        path = (folder or Path()) / Path(robot).expanduser()
        return _read(path / FILE if path.is_dir() else path)
    known = robot_files()
    if robot not in known:
        valid = f"there are {', '.join(sorted(known))}, or give the path of a {FILE}"
        raise RobotError(f"unknown robot {robot!r}; {meant(robot, known)}{valid}")
    return _read(known[robot])


def task_robot(task: Task) -> RobotSpec:
    """The robot of a task, its base and its home where the task says.

    Raises:
        RobotError: as `load_robot`; where the task's home is none of that robot.
    """
    spec = load_robot(task.robot, None if task.path is None else task.path.parent)
    if task.base is not None:
        spec = replace(spec, T_world_base=task.base)
    return spec if task.home is None else replace(spec, home=_home(task.home, spec))


def _home(home: tuple[float, ...], spec: RobotSpec) -> tuple[float, ...]:
    if len(home) != len(spec.joints):
        raise RobotError(f"the task's home has {len(home)} joints, but the arm of {spec.name} has {len(spec.joints)}")
    for name, low, value, high in zip(spec.joints, spec.lower, home, spec.upper, strict=True):
        if not low <= value <= high:
            raise RobotError(f"the task's home has {name} at {value:g}, outside its limits of {low:g} to {high:g}")
    return home


def with_robot(task: Task, robot: str | None) -> Task:
    """The task for another robot, named or by a path that is relative to the working folder; its own where it is None.

    Raises:
        RobotError: where there is no such robot.
    """
    if robot is None:
        return task
    load_robot(robot)
    if is_path(robot) and task.path is not None:  # relative as in the task's file, so that plans can be carried away
        robot = Path(os.path.relpath(followed(Path(robot).expanduser()), task.path.parent)).as_posix()
    return replace(task, robot=robot, home=None)


def _read(path: Path) -> RobotSpec:
    return _read_once(followed(path), _changed(path))


@lru_cache(maxsize=64)
def _read_once(path: Path, changed: int) -> RobotSpec:
    from tamp.task.files.robot.robot_file import read_robot  # here: pydantic is slow to load

    return read_robot(path)
