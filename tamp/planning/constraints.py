"""Constraints on plans: a skeleton to follow, actions to avoid, and what to keep of an earlier plan."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from types import EllipsisType
from typing import TYPE_CHECKING, Any

from tamp.errors import DomainError
from tamp.language import Domain
from tamp.planning.objects import Objects

if TYPE_CHECKING:
    from tamp.planning.problem import GroundAction, Solution

ActionPattern = tuple[Any, ...]
"""An action's name and its arguments; `...` stands for any argument, and ("pick",) alone for any arguments."""


@dataclass(frozen=True)
class Constraints:
    """What a plan must look like.

    Attributes:
        skeleton: the actions in order, each a pattern such as `("pick", "red", ...)`; `...` alone between them stands
            for any number of actions. None leaves the plan free. Moves that the planner fills in by itself need not be
            named.
        forbidden: patterns of actions that must not occur.
    """

    skeleton: tuple[ActionPattern | EllipsisType, ...] | None = None
    forbidden: tuple[ActionPattern, ...] = ()

    def patterns(self) -> tuple[ActionPattern, ...]:
        """All patterns of both kinds."""
        return (*(p for p in self.skeleton or () if not isinstance(p, EllipsisType)), *self.forbidden)

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
                near = difflib.get_close_matches(pattern[0].lower(), domain.actions, n=1)
                hint = f"; did you mean {near[0]!r}?" if near else ""
                raise DomainError(
                    f"constraints: unknown action {pattern[0]!r}; there are: {', '.join(domain.actions)}{hint}"
                )
            if len(pattern) > 1 and len(pattern) - 1 != len(action.parameters):
                raise DomainError(
                    f"constraints: {pattern[0]} takes {len(action.parameters)} arguments, {pattern!r} has "
                    f"{len(pattern) - 1}"
                )


@dataclass(frozen=True)
class Reuse:
    """What may be kept of an earlier plan: the actions that are still to be done, and what is known of their values.

    Attributes:
        actions: tried first, as they are; where they no longer work, a new plan may still use their values.
        facts: facts without fluents that were certified of those values.
    """

    actions: tuple[GroundAction, ...]
    facts: tuple[tuple[Any, ...], ...]

    @staticmethod
    def after(solution: Solution, executed: int) -> Reuse:
        """What is left of a solution once its first `executed` actions are done.

        Raises:
            ValueError: where the solution has no plan.
        """
        if solution.plan is None:
            raise ValueError("there is nothing to reuse of a solution without a plan")
        return Reuse(solution.plan[executed:], solution.certified)


class Matcher:
    """Patterns over handles."""

    def __init__(self, patterns: Sequence[ActionPattern], objects: Objects) -> None:
        self._patterns = [
            (str(p[0]).lower(), tuple(None if a is ... else objects.intern(a) for a in p[1:])) for p in patterns
        ]

    def __call__(self, name: str, args: Iterable[int]) -> bool:
        """Whether an action matches one of the patterns."""
        args = tuple(args)
        return any(
            name == wanted and (not terms or all(t is None or t == a for t, a in zip(terms, args, strict=True)))
            for wanted, terms in self._patterns
        )


@dataclass(frozen=True)
class Place:
    """A place between two actions of a skeleton: which action comes next, and whether others may come before it."""

    matches: Matcher | None
    gap: bool


def places(constraints: Constraints, objects: Objects, filled_in: frozenset[str]) -> tuple[Place, ...]:
    """A skeleton as places to pass in order; the last one has no action. Without a skeleton one place with a gap.

    `filled_in` names the actions that the planner puts in by itself.
    """
    if constraints.skeleton is None:
        return (Place(None, gap=True),)
    found: list[Place] = []
    gap = False
    for pattern in constraints.skeleton:
        if isinstance(pattern, EllipsisType):
            gap = True
        elif pattern[0].lower() not in filled_in:
            found.append(Place(Matcher((pattern,), objects), gap))
            gap = False
    return (*found, Place(None, gap))
