"""Names, order and limits of a plan: all that needs no geometry."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tamp.task import Action, Fall, Grip, Move, Plan, Release, RobotSpec, Trajectory, load_robot

LATE = 4.0  # [s]
COMMAND = 0.001  # [s]
STEPS = {
    "pick": [Grip],
    "unstack": [Grip],
    "place": [Release],
    "stack": [Release],
    "lay": [Release, Fall],
    "lay-on": [Release, Fall],
    "slide": [],
    "topple": [Fall],
    "nudge": [],
    "move": [],
}


def bookkeeping(plan: Plan) -> str | None:
    """What is wrong with names, order or limits, or None."""
    q, held, opening, spec = np.array(plan.home), None, None, load_robot("panda")
    if np.abs(q - spec.home).max() > 1e-3:
        return "the arm does not start at home"
    for action in map(_alone, plan.actions):
        if (text := _kinds(action) or _misnamed(action) or _late(action)) is not None:
            return text
        if action.name == "move" and action.arguments and (held is None or held.object != action.arguments[0]):
            return "moves what it does not hold"
        for step in action.steps:
            if isinstance(step, Move):
                if np.abs(step.trajectory.positions[0] - q).max() > 1e-3:
                    return "the arm jumps"
                if step.held != held or (held and opening != step.opening):
                    return "what is held changes by itself"
                if (text := _limits(step.trajectory, spec)) is not None:
                    return text
                q, opening = step.trajectory.positions[-1], step.opening
            elif isinstance(step, Grip):
                if held is not None or step.attachment.object != action.arguments[0]:
                    return "grips with a full hand, or another object"
                held, opening = step.attachment, step.width
            elif isinstance(step, Release):
                if held is None or held.object != step.object or step.object != action.arguments[0]:
                    return "releases what it does not hold"
                if step.opening - opening < 5e-4:
                    return "the fingers do not open"
                held, opening = None, step.opening
            elif held is not None or step.object != action.arguments[0]:
                return "what falls was not let go"
    return "ends with an object in the hand" if held else None


def _alone(action: Action) -> Action:
    """The action without what it says in the end of things that gave way."""
    own = [k for k, s in enumerate(action.steps) if not isinstance(s, Fall) or s.object in action.arguments[:1]]
    return replace(action, steps=action.steps[: max(own, default=-1) + 1])


def _kinds(action: Action) -> str | None:
    """What is wrong with the kinds of steps that an action has, or None."""
    kinds = [type(step) for step in action.steps if not isinstance(step, Move)]
    if kinds != STEPS.get(action.name):
        return f"{action.name} has the wrong steps"
    pushed = [s.pushed.object for s in action.steps if isinstance(s, Move) and s.pushed is not None]
    if pushed != (list(action.arguments[:1]) if action.name in ("slide", "topple", "nudge") else []):
        return f"{action.name} pushes the wrong things"
    return None


def _misnamed(action: Action) -> str | None:
    """Whether a motion has the name of one before, or after, what the action does, and is not there."""
    does = [not isinstance(step, Move) or step.pushed is not None for step in action.steps]
    for k, step in enumerate(action.steps):
        if isinstance(step, Move) and step.phase in ("approach", "lower") and any(does[:k]):
            return f"{step.phase} after what is done"
        if isinstance(step, Move) and step.phase in ("lift", "retreat") and any(does) and not any(does[:k]):
            return f"{step.phase} before what is done"
    return None


def _late(action: Action) -> str | None:
    """Whether something falls long after it was let go or pushed over."""
    waited = 0.0
    for step in action.steps:
        if isinstance(step, Release) or (isinstance(step, Move) and step.pushed is not None):
            waited = 0.0
        elif isinstance(step, Move):
            waited += step.trajectory.duration
        elif isinstance(step, Fall) and waited > LATE:
            return "falls long after it was let go"
    return None


def _limits(t: Trajectory, spec: RobotSpec) -> str | None:
    h = np.diff(t.times)[:, None]
    if (np.abs(t.velocities) > 1.01 * np.array(spec.velocity)).any():
        return "too fast"
    if (np.abs(np.diff(t.velocities, axis=0)) > 1.02 * np.array(spec.acceleration) * h).any():
        return "too much acceleration"
    if (t.positions < np.array(spec.lower) - 1e-3).any() or (t.positions > np.array(spec.upper) + 1e-3).any():
        return "beyond the joint limits"
    mean = (t.velocities[1:] + t.velocities[:-1]) / 2
    if (np.abs(np.diff(t.positions, axis=0) - mean * h) > 0.26 * np.array(spec.acceleration) * h**2 + 1e-5).any():
        return "positions do not follow velocities"
    if (_jumps(t) > 1.5 * np.array(spec.jerk) * COMMAND).any():
        return "accelerations jump"
    return "not at rest" if max(np.abs(t.velocities[0]).max(), np.abs(t.velocities[-1]).max()) > 0.01 else None


def _jumps(t: Trajectory) -> np.ndarray:
    """By how much the acceleration of each joint is another one just after each inner sample, (n - 2, joints)."""
    from scipy.interpolate import CubicHermiteSpline

    curve = CubicHermiteSpline(t.times, t.positions, t.velocities)
    cubic, square = curve.c[:2]
    h = np.diff(t.times)[:-1, None]
    return np.abs(2 * square[1:] - 2 * square[:-1] - 6 * cubic[:-1] * h)
