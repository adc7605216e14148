"""A plan in words."""

from __future__ import annotations

from collections.abc import Mapping

from tamp.task import Action, Move, Plan, Release


def sentences(plan: Plan, words: Mapping[str, str]) -> list[str]:
    """One line an action that does more than move: what, from or onto what, to where, and how long it takes.

    Args:
        plan: the plan.
        words: action -> what it does, as its domain says: "{0}" is the first argument, "{rest}" the others. An action
            whose words name nothing, as a mere motion's, has no line: its time counts for the next.
    """
    told = []
    since = 0.0
    for action in plan.actions:
        since += sum(step.trajectory.duration for step in action.steps if isinstance(step, Move))
        said = words.get(action.name, action.name + (" {0} with {rest}" if action.arguments[1:] else " {0}"))
        if "{" not in said:
            continue
        told.append(f"{_sentence(action, said)} ({since:.1f} s)")
        since = 0.0
    return told


def _sentence(action: Action, said: str) -> str:
    subject, *others = action.arguments or ("",)
    text = said.replace("{0}", subject).replace("{rest}", " and ".join(others))
    released = [step for step in action.steps if isinstance(step, Release)]
    if not released:
        return text
    x, y, z = (100 * value for value in released[-1].pose.xyz)
    return f"{text}, at ({x:.1f}, {y:.1f}, {z:.1f}) cm"
