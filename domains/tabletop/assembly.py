"""From a symbolic solution to a plan that a robot can run: every handling and path timed, in order."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from tamp.streams.values import ArmPath, Configuration, Grasp, Handling
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import Action, Attachment, Grip, Move, Release, Step


GENTLE = 0.4  # share of the limits while near or lifting an object


def assemble(workspace: Workspace, solution: Sequence[Any]) -> tuple[Action, ...]:
    """Turn ground actions of the tabletop domain into timed actions.

    Args:
        workspace: where they happen.
        solution: the planner's ground actions, each with `name` and `args`.
    """
    return tuple(_action(workspace, ground.name, ground.args) for ground in solution)


def _action(workspace: Workspace, name: str, args: Sequence[Any]) -> Action:
    match name:
        case "move-free":
            return Action("move", (), tuple(_transit(workspace, *args)))
        case "move-holding":
            obj, grasp, _, _, path = args
            return Action("move", (obj,), (_move(workspace, "transfer", path, grasp.width, _held(obj, grasp)),))
        case "pick" | "unstack":
            handling: Handling = args[-1]
            return Action(name, _arguments(handling), tuple(_pick(workspace, handling)))
        case "place" | "stack":
            handling = args[-1]
            return Action(name, _arguments(handling), tuple(_place(workspace, handling)))
    raise ValueError(f"the tabletop domain has no action {name!r}")


def _arguments(handling: Handling) -> tuple[str, ...]:
    return (handling.object, *handling.placement.on)


def _transit(workspace: Workspace, start: Configuration, goal: Configuration, path: ArmPath) -> Iterator[Step]:
    yield _move(workspace, "transit", path, min(start.opening, goal.opening), None)


def _pick(workspace: Workspace, handling: Handling) -> Iterator[Step]:
    held = _held(handling.object, handling.grasp)
    yield _move(workspace, "approach", handling.approach, handling.opening, None, _finger_contact(handling))
    yield Grip(held, handling.grasp.width)
    yield _move(workspace, "lift", handling.lift, handling.grasp.width, held, _support_contacts(workspace, handling))


def _place(workspace: Workspace, handling: Handling) -> Iterator[Step]:
    held = _held(handling.object, handling.grasp)
    contacts = _support_contacts(workspace, handling)
    yield _move(workspace, "lower", handling.lift[::-1], handling.grasp.width, held, contacts)
    yield Release(handling.object, handling.placement.pose, handling.opening)
    yield _move(workspace, "retreat", handling.approach[::-1], handling.opening, None, _finger_contact(handling))


def _move(
    workspace: Workspace,
    phase: str,
    path: Any,
    opening: float,
    held: Attachment | None,
    contacts: frozenset[tuple[str, str]] = frozenset(),
) -> Move:
    points = path.points if isinstance(path, ArmPath) else np.asarray(path)
    speed = 1.0 if phase in ("transit", "transfer") else GENTLE
    trajectory = time_path(points, workspace.world.robot.spec, speed=speed)
    return Move(phase, trajectory, opening, held, contacts)


def _held(obj: str, grasp: Grasp) -> Attachment:
    return Attachment(obj, grasp.T_object_tool.inverse())


def _finger_contact(handling: Handling) -> frozenset[tuple[str, str]]:
    return frozenset({("robot", handling.object)})


def _support_contacts(workspace: Workspace, handling: Handling) -> frozenset[tuple[str, str]]:
    """The lifted object may slide along everything it stands on or beside at its placement."""
    others = {TABLE, *workspace.start} - {handling.object}
    return frozenset((handling.object, other) for other in others)
