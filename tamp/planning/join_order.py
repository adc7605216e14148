"""In which order a rule's body is looked up in the facts, beginning with any of its patterns."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

from tamp.planning.objects import Pattern


@dataclass(frozen=True)
class Step:
    """Looks up one pattern of a body when some of its variables are bound already."""

    position: int
    index: tuple[str, tuple[int, ...]]
    key: tuple[tuple[bool, int], ...]  # (is a slot, slot or handle) for each indexed position
    binds: tuple[tuple[int, int], ...]  # (position in the fact, slot)
    repeats: tuple[tuple[int, int], ...]
    unequal: tuple[tuple[int, int], ...]


@lru_cache(maxsize=4096)
def join_order(
    variables: tuple[str, ...], body: tuple[Pattern, ...], unequal: tuple[tuple[str | int, str | int], ...], first: int
) -> tuple[Step, ...]:
    """The order in which to look a body up from pattern `first` on: next the one with the fewest unbound variables.

    A pattern that any object fits comes last: by then another one may have bound its variable. Answers are kept, as
    replanning asks for the same rules again and again.
    """
    slot = {variable: i for i, variable in enumerate(variables)}
    bound: set[str] = set()
    rest = list(range(len(body)))
    open_pairs = list(unequal)
    steps: list[Step] = []
    while rest:
        position = first if not steps else min(rest, key=lambda i: _openness(body[i], bound))
        rest.remove(position)
        ready = frozenset(t for t in body[position][1:] if isinstance(t, str)) | bound
        pairs = [pair for pair in open_pairs if all(isinstance(t, int) or t in ready for t in pair)]
        open_pairs = [pair for pair in open_pairs if pair not in pairs]
        steps.append(
            _step(body[position], position, slot, bound, tuple((_code(a, slot), _code(b, slot)) for a, b in pairs))
        )
        bound |= ready
    return tuple(steps)


def _step(
    pattern: Pattern, position: int, slot: dict[str, int], bound: set[str], unequal: tuple[tuple[int, int], ...]
) -> Step:
    positions: list[int] = []
    key: list[tuple[bool, int]] = []
    binds: dict[int, int] = {}
    repeats: list[tuple[int, int]] = []
    for i, term in enumerate(pattern[1:], start=1):
        if isinstance(term, int):
            positions.append(i)
            key.append((False, term))
        elif term in bound:
            positions.append(i)
            key.append((True, slot[term]))
        elif slot[term] in binds.values():
            repeats.append((i, slot[term]))
        else:
            binds[i] = slot[term]
    index = (str(pattern[0]), tuple(positions))
    return Step(position, index, tuple(key), tuple(binds.items()), tuple(repeats), unequal)


def _openness(pattern: Pattern, bound: set[str]) -> tuple[bool, int]:
    unbound = len({term for term in pattern[1:] if isinstance(term, str)} - bound)
    return pattern[0] == "object" and unbound > 0, unbound


def _code(term: str | int, slot: dict[str, int]) -> int:
    """A slot as itself, a handle as a negative number."""
    return -term - 1 if isinstance(term, int) else slot[term]
