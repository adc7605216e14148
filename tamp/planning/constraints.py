"""Constraints on plans: a skeleton to follow, with wildcards and variables, and actions that must not occur."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from types import EllipsisType
from typing import Any

from tamp.errors import DomainError, meant
from tamp.language import Domain
from tamp.planning.model.objects import Objects

ActionPattern = tuple[Any, ...]
"""An action's name and its arguments; `...` stands for any argument, a string such as "?x" for the same one wherever it
occurs in a skeleton or a forbidden pattern, and ("pick",) alone for any arguments."""

Bindings = tuple[tuple[str, int], ...]
"""Variables of patterns and the objects that they stand for, sorted."""


@dataclass(frozen=True)
class Constraints:
    """What a plan must look like.

    Attributes:
        skeleton: the actions in order, each a pattern such as `("pick", "red", ..., "?g")`; `...` alone between them
            stands for any number of actions. None leaves the plan free. Moves that the planner fills in by itself need
            not be named. An object that the problem does not name is one that a stream may yet give.
        forbidden: patterns of actions that must not occur.
    """

    skeleton: tuple[ActionPattern | EllipsisType, ...] | None = None
    forbidden: tuple[ActionPattern, ...] = ()

    def patterns(self) -> tuple[ActionPattern, ...]:
        """All patterns of both kinds."""
        return (*(p for p in self.skeleton or () if not isinstance(p, EllipsisType)), *self.forbidden)

    def objects(self) -> Iterator[Any]:
        """The objects that patterns name, in order, with repetitions."""
        for pattern in self.patterns():
            yield from (a for a in pattern[1:] if a is not ... and not is_variable(a))

    def check(self, domain: Domain) -> None:
        """Check that the patterns are about actions of a domain.

        Raises:
            DomainError: naming the pattern and what would be valid.
        """
        for pattern in self.patterns():
            if not isinstance(pattern, tuple) or not pattern or not isinstance(pattern[0], str):
                raise DomainError(f"constraints: expected a pattern such as ('pick', 'red', ...), found {pattern!r}")
            action = domain.actions.get(pattern[0].lower())
            if action is None:
                hint = meant(pattern[0], domain.actions)
                raise DomainError(
                    f"constraints: unknown action {pattern[0]!r}; {hint}there are: {', '.join(domain.actions)}"
                )
            if len(pattern) > 1 and len(pattern) - 1 != len(action.parameters):
                raise DomainError(
                    f"constraints: {pattern[0]} takes {len(action.parameters)} arguments, {pattern!r} has "
                    f"{len(pattern) - 1}"
                )


def is_variable(argument: Any) -> bool:
    """Whether an argument of a pattern is a variable."""
    return isinstance(argument, str) and argument.startswith("?")


def match(
    pattern: ActionPattern, name: str, args: Sequence[int], bindings: Bindings, objects: Objects, hopeful: bool
) -> Bindings | None:
    """The bindings under which an action fits a pattern; None where it does not.

    With `hopeful`, a placeholder may turn out to be any object.
    """
    if name != str(pattern[0]).lower():
        return None
    found = dict(bindings)
    for wanted, arg in zip(pattern[1:], args, strict=False):
        if wanted is ...:
            continue
        known = found.setdefault(wanted, arg) if is_variable(wanted) else objects.find(wanted)
        if known == arg:
            continue
        if not (hopeful and not (objects.is_real(arg) and (known is None or objects.is_real(known)))):
            return None
        if is_variable(wanted) and objects.is_real(arg):
            found[wanted] = arg
    return tuple(sorted(found.items()))


class Forbidden:
    """Tells actions that must not occur."""

    def __init__(self, patterns: Sequence[ActionPattern], objects: Objects) -> None:
        self._patterns = tuple(patterns)
        self._objects = objects

    def __call__(self, name: str, args: Iterable[int]) -> bool:
        """Whether an action matches one of the patterns."""
        args = tuple(args)
        return any(match(p, name, args, (), self._objects, hopeful=False) is not None for p in self._patterns)


@dataclass(frozen=True)
class Progress:
    """How much of a skeleton is done: which pattern comes next, and what its variables stand for."""

    place: int = 0
    bindings: Bindings = ()


class Course:
    """A skeleton as a nondeterministic automaton over actions."""

    def __init__(self, constraints: Constraints, objects: Objects, filled_in: frozenset[str]) -> None:
        """`filled_in` names the actions that the planner puts in by itself."""
        self._objects = objects
        self._patterns: list[ActionPattern] = []
        self._gaps = [constraints.skeleton is None]
        for pattern in constraints.skeleton or ():
            if isinstance(pattern, EllipsisType):
                self._gaps[-1] = True
            elif str(pattern[0]).lower() not in filled_in:
                self._patterns.append(pattern)
                self._gaps.append(False)

    @property
    def free(self) -> bool:
        """Whether every plan follows it."""
        return not self._patterns and self._gaps[0]

    def done(self, progress: Progress) -> bool:
        """Whether a plan may end here."""
        return progress.place == len(self._patterns)

    def after(self, progress: Progress, name: str, args: Sequence[int], hopeful: bool) -> Iterator[Progress]:
        """Where an action may lead; nowhere where it does not follow the skeleton."""
        place = progress.place
        if self._gaps[place]:
            yield progress
        if place < len(self._patterns):
            pattern = self._patterns[place]
            found = match(pattern, name, args, progress.bindings, self._objects, hopeful)
            if found is not None:
                yield Progress(place + 1, found)
