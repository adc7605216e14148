"""Constraints on plans: skeletons to follow, with wildcards and variables, and actions that must not occur."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from types import EllipsisType
from typing import Any

from tamp.errors import DomainError, meant
from tamp.language import Domain
from tamp.planning.model.objects import Objects

ActionPattern = tuple[Any, ...]
"""An action's name and its arguments; `...` stands for any argument, a string such as "?x" for the same one wherever it
occurs in a skeleton or a forbidden pattern, and ("pick",) alone for any arguments."""

Skeleton = tuple[ActionPattern | EllipsisType, ...]
"""Patterns in order; `...` alone between them stands for any number of actions."""

Bindings = tuple[tuple[str, int], ...]
"""Variables of patterns and the objects that they stand for, sorted."""


@dataclass(frozen=True)
class Constraints:
    """What a plan must look like.

    Attributes:
        skeleton: the actions in order, each a pattern such as `("pick", "red", ..., "?g")`; `...` alone between them
            stands for any number of actions. None leaves the plan free. Moves that the planner fills in by itself need
            not be named: where a skeleton names none of an action, it is filled in wherever it is needed. An object
            that the problem does not name is one that a stream may yet give.
        forbidden: patterns of actions that must not occur.
        skeletons: others beside `skeleton`; a plan follows one of them all.
        groups: name -> objects. Where a pattern has the name as an argument, one of them stands; the same one wherever
            it occurs where the name is a variable such as "?x".
        exact: whether nothing is filled in: moves must be named as well.
    """

    skeleton: Skeleton | None = None
    forbidden: tuple[ActionPattern, ...] = ()
    skeletons: tuple[Skeleton, ...] = ()
    groups: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)
    exact: bool = False

    @property
    def alternatives(self) -> tuple[Skeleton, ...]:
        """The skeletons of which a plan follows one; none where it is free."""
        return (*(() if self.skeleton is None else (self.skeleton,)), *self.skeletons)

    def patterns(self) -> tuple[ActionPattern, ...]:
        """All patterns of both kinds."""
        steps = (step for skeleton in self.alternatives for step in skeleton)
        return (*(step for step in steps if not isinstance(step, EllipsisType)), *self.forbidden)

    def bind(self, action: str) -> bool:
        """Whether an action may not be filled in unseen: a pattern names it, or nothing is filled in."""
        return (self.exact and bool(self.alternatives)) or action in _names(self.patterns())

    def objects(self) -> Iterator[Any]:
        """The objects that patterns and groups name, in order, with repetitions."""
        for pattern in self.patterns():
            for arg in pattern[1:]:
                if is_name(arg, self.groups):
                    yield from self.groups[arg]
                elif arg is not ... and not is_variable(arg):
                    yield arg

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


def _variables(patterns: Iterable[ActionPattern]) -> frozenset[str]:
    return frozenset(arg for pattern in patterns for arg in pattern[1:] if is_variable(arg))


def _names(patterns: Iterable[ActionPattern]) -> frozenset[str]:
    return frozenset(str(pattern[0]).lower() for pattern in patterns)


def is_name(argument: Any, names: Iterable[str]) -> bool:
    """Whether an argument of a pattern, which may have no hash, is one of some names."""
    return isinstance(argument, str) and argument in names


Groups = Mapping[str, tuple[Any, ...]]


def match(
    pattern: ActionPattern,
    name: str,
    args: Sequence[int],
    bindings: Bindings,
    objects: Objects,
    optimistic: bool,
    groups: Groups | None = None,
) -> Bindings | None:
    """The bindings under which an action fits a pattern; None where it does not.

    With `optimistic`, a placeholder may turn out to be any object.
    """
    if name != str(pattern[0]).lower():
        return None
    found = dict(bindings)
    for wanted, arg in zip(pattern[1:], args, strict=False):
        if wanted is ...:
            continue
        if groups and is_name(wanted, groups):
            if (objects.is_real(arg) or not optimistic) and arg not in map(objects.find, groups[wanted]):
                return None
            if not is_variable(wanted):
                continue
        known = found.setdefault(wanted, arg) if is_variable(wanted) else objects.find(wanted)
        if known == arg:
            continue
        if not (optimistic and not (objects.is_real(arg) and (known is None or objects.is_real(known)))):
            return None
        if is_variable(wanted) and objects.is_real(arg):
            found[wanted] = arg
    return tuple(sorted(found.items()))


class Forbidden:
    """Tells actions that must not occur."""

    def __init__(self, constraints: Constraints, objects: Objects) -> None:
        self._patterns = constraints.forbidden
        self._groups = constraints.groups
        self._objects = objects

    def __call__(self, name: str, args: Iterable[int]) -> bool:
        """Whether an action matches one of the patterns."""
        args, groups = tuple(args), self._groups
        return any(match(p, name, args, (), self._objects, False, groups) is not None for p in self._patterns)


@dataclass(frozen=True)
class Progress:
    """How much of which skeleton is done: which pattern comes next, and what its variables stand for."""

    place: int = 0
    bindings: Bindings = ()
    number: int = 0


class Course:
    """Skeletons as a nondeterministic automaton over actions.

    Attributes:
        starts: the progress of each skeleton before any action.
    """

    def __init__(self, constraints: Constraints, objects: Objects, filled_in: frozenset[str]) -> None:
        """`filled_in` names the actions that the planner may put in by itself where a skeleton does not name them."""
        self._objects = objects
        self._groups = constraints.groups
        self._patterns: list[list[ActionPattern]] = []
        self._gaps: list[list[bool]] = []
        self._filled_in: list[frozenset[str]] = []
        self._later: list[list[frozenset[str]]] = []
        for skeleton in constraints.alternatives or ((...,),):
            patterns: list[ActionPattern] = []
            gaps = [False]
            for pattern in skeleton:
                if isinstance(pattern, EllipsisType):
                    gaps[-1] = True
                else:
                    patterns.append(pattern)
                    gaps.append(False)
            self._filled_in.append(frozenset() if constraints.exact else filled_in - _names(patterns))
            self._patterns.append(patterns)
            self._gaps.append(gaps)
            self._later.append([_variables(patterns[place:]) for place in range(len(patterns) + 1)])
        self.starts = tuple(Progress(number=number) for number in range(len(self._patterns)))

    @property
    def free(self) -> bool:
        """Whether every plan follows it."""
        return any(not patterns and gaps[0] for patterns, gaps in zip(self._patterns, self._gaps, strict=True))

    def done(self, progress: Progress) -> bool:
        """Whether a plan may end here."""
        return progress.place == len(self._patterns[progress.number])

    def after(self, progress: Progress, name: str, args: Sequence[int], optimistic: bool) -> Iterator[Progress]:
        """Where an action may lead; nowhere where it does not follow the skeleton.

        Variables that no later pattern has are forgotten: else there would be a way for each combination of all values.
        """
        place, patterns = progress.place, self._patterns[progress.number]
        if self._gaps[progress.number][place] or name in self._filled_in[progress.number]:
            yield progress
        if place < len(patterns):
            found = match(patterns[place], name, args, progress.bindings, self._objects, optimistic, self._groups)
            if found is not None:
                later = self._later[progress.number][place + 1]
                kept = tuple(binding for binding in found if binding[0] in later)
                yield Progress(place + 1, kept, progress.number)
