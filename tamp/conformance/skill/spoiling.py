"""Actions spoilt in ways that no rule of the checker may accept."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from tamp.task import Action, Move, Trajectory

STRANGER = "nobody"
"""The name of an object that no task has."""

STILL = 1e-3
"""What moves by less stays where it is [rad]."""


def spoilt(action: Action) -> Iterator[tuple[str, Action]]:
    """An action in forms that nobody may accept, each with words for what was done to it."""
    if action.arguments:
        yield f"of {STRANGER!r}, which the task has not", replace(action, arguments=(STRANGER, *action.arguments[1:]))
    if action.steps:
        yield "without steps", replace(action, steps=())
    if any(isinstance(step, Move) and _is_moving(step) for step in action.steps):
        yield "while the arm stays where it is", replace(action, steps=tuple(map(_still, action.steps)))


def _is_moving(move: Move) -> bool:
    return bool(np.ptp(move.trajectory.positions, axis=0).max() > STILL)


def _still(step: Any) -> Any:
    """A step; a motion as one that takes as long and stays where it begins."""
    if not isinstance(step, Move):
        return step
    timed = step.trajectory
    stays = np.repeat(timed.positions[:1], len(timed.times), axis=0)
    return replace(step, trajectory=Trajectory(timed.times, stays, np.zeros_like(stays)))
