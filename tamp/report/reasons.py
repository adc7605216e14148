"""How runs ended and why they failed, in words that can be counted."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence

from tamp.results import Result


def outcomes(results: Sequence[Result]) -> str:
    """How many runs ended how, and the commonest reason for what is not solved."""
    counts = Counter(result.status for result in results)
    told = ", ".join(f"{count} {status}" for status, count in counts.most_common())
    return "; ".join([told, *(f"{count} times: {reason}" for reason, count in reasons(results)[:1])])


def reasons(results: Iterable[Result]) -> list[tuple[str, int]]:
    """Why runs are not solved, commonest first: the parts of messages without objects' names and numbers."""
    counts: Counter[str] = Counter()
    for result in results:
        if not result.solved:
            names = sorted({*result.goals_met, *(o["name"] for o in result.objects)}, key=len, reverse=True)
            whole = result.status in ("error", "invalid")  # one sentence; of others each goal's reason is a part
            said = [result.message] if whole else result.message.split("; ")
            parts = {_general(part, names) for part in said if part}
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
