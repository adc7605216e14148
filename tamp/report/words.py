"""A plan in words, and why runs failed, in words that can be counted."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence

from tamp.results import Result
from tamp.task import Action, Move, Plan, Release

LINKS = {
    "pick": "from",
    "unstack": "from",
    "place": "on",
    "stack": "on",
    "slide": "over",
    "topple": "on",
    "nudge": "in",
}


def sentences(plan: Plan) -> list[str]:
    """One line an action that does more than move: what, from or onto what, to where, and how long it takes."""
    told = []
    since = 0.0
    for action in plan.actions:
        since += sum(step.trajectory.duration for step in action.steps if isinstance(step, Move))
        if all(isinstance(step, Move) and step.pushed is None for step in action.steps):
            continue
        told.append(f"{_sentence(action)} ({since:.1f} s)")
        since = 0.0
    return told


def _sentence(action: Action) -> str:
    subject, *others = action.arguments or ("",)
    link = LINKS.get(action.name, "with")
    words = f"{action.name} {subject}" + (f" {link} {' and '.join(others)}" if others else "")
    released = [step for step in action.steps if isinstance(step, Release)]
    if not released:
        return words
    x, y, z = (100 * value for value in released[-1].pose.xyz)
    return f"{words}, at ({x:.1f}, {y:.1f}, {z:.1f}) cm"


def reasons(results: Iterable[Result]) -> list[tuple[str, int]]:
    """Why runs are not solved, commonest first: the parts of messages without objects' names and numbers."""
    counts: Counter[str] = Counter()
    for result in results:
        if not result.solved:
            names = sorted({*result.goals_met, *(o["name"] for o in result.objects)}, key=len, reverse=True)
            parts = {_general(part, names) for part in result.message.split("; ") if part}
            counts.update(parts or {result.status})
    return sorted(counts.items(), key=lambda item: (-item[1], item[0]))


def _general(text: str, names: Sequence[str]) -> str:
    if text.startswith("goals not reached"):
        return "goals not reached"
    for name in names:
        text = re.sub(rf"(?<!\w){re.escape(name)}(?!\w)", "an object", text)
    # Runs without execution do not list their objects: what a part begins with is one, if it is no exception.
    text = re.sub(r"^(?!\w+Error:)\S+(?=( left)?: )", "an object", text)
    return re.sub(r"\d+(\.\d+)?", "#", text)
