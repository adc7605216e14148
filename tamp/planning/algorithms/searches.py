"""The searches of one question: over optimistic facts, among real values, below the cost of the best plan."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from tamp.planning.grounding.task_builder import EVERYTHING, Scope
from tamp.planning.search.best_first import SearchResult

if TYPE_CHECKING:
    from tamp.planning.algorithms.incumbent import Found
    from tamp.planning.binding.learning import Lessons
    from tamp.planning.grounding.ground_task import GroundTask, TaskOperator
    from tamp.planning.model.analysis.transit_actions import Connectors
    from tamp.planning.model.fact_store import Knowledge
    from tamp.planning.options import Limits
    from tamp.planning.sampling.stream_calls import Stopwatch
    from tamp.planning.search.symbolic_search import SymbolicSearch

    Plan = tuple[TaskOperator, ...]

SEARCH_CALLS, OPERATORS_A_CALL, STATES_A_CALL = 20, 5, 24_000
"""How many calls of streams a search counts for at least, where work is compared; how many operators count for one, and
how many states times operators."""


class Searches:
    """Searches for plans, and how much work they were.

    Attributes:
        work: of all searches, in calls of streams.
        looking: the part of that which is due to the states that they looked at.
    """

    def __init__(
        self,
        symbolic: SymbolicSearch,
        knowledge: Knowledge,
        connectors: Connectors,
        lessons: Lessons,
        found: Found,
        limits: Limits,
        stopwatch: Stopwatch,
        eager: bool,
    ) -> None:
        """`eager`: whether they see real values alone."""
        self.work = self.looking = 0
        self._symbolic, self._knowledge, self._connectors = symbolic, knowledge, connectors
        self._lessons, self._found, self._limits, self._stopwatch = lessons, found, limits, stopwatch
        self._eager = eager

    def search(self, scope: Scope = EVERYTHING) -> SearchResult:
        """Search for a plan over optimistic facts, and under guesses at why streams with fluents failed.

        Where guesses bar every plan, there is a search without them, if nothing else that was learnt is left out.
        Among real values there is no need to guess: the tests are asked in the states that a search comes to. Where it
        has come to all of them in vain, there is no plan among these values.

        Raises:
            Ended: at a limit.
        """
        if self._asks and (scope.sure or self._eager):
            result = self._asked()
            if result.plan is not None or (result.proven and (scope.sure or not self._assumed_in_states)):
                return result
        result = self._searched_under(scope)
        partial = scope.clear or scope.arriving
        if result.plan is None and not result.timed_out and not partial and self._lessons.guessed:
            return self._searched_under(replace(scope, exact=True))
        return result

    @property
    def _asks(self) -> bool:
        """Whether the search cannot be taught what tests with fluents say no to, or it is a guess."""
        return self._lessons.guessed or (self._knowledge.schema.undecided and bool(self._lessons.tried))

    @property
    def _assumed_in_states(self) -> bool:
        """Whether streams give values in each state anew: they are assumed among real values, too."""
        return any(external.fluents and external.outputs for external in self._knowledge.schema.externals.values())

    def _asked(self, most: float = math.inf) -> SearchResult:
        """A search of real values that asks tests in each of `most` states at most; each is as much work as a call."""
        with self._stopwatch.timed("search"):
            result = self._symbolic.ask(self._connectors.fluent, self._found.bound(), self._limits.check, most)
        self.work += result.states
        self.looking += result.states
        return result

    def _searched_under(self, scope: Scope) -> SearchResult:
        """One search, or two where nothing is assumed, but moves that are left out of the search."""
        if scope.sure and self._connectors.connectors:  # they lead anywhere: no plan with them where none without
            result = self._searched(replace(scope, moves=False))
            if result.plan is None:
                return result
        return self._searched(scope)

    def _searched(self, scope: Scope) -> SearchResult:
        """One search."""
        self._limits.check()
        self._limits.iterations += 1
        with self._stopwatch.timed("grounding"):
            self._knowledge.refresh()
            task = self._symbolic.task(self._lessons.blames, scope)
        if not task.solvable:
            self._count(task, SearchResult(None))
            return SearchResult(None, proven=True)
        bound = self._found.bound()
        with self._stopwatch.timed("search"):
            left = self._limits.left_to_search
            result = self._symbolic.run(task, left, bound, brief=scope.clear or scope.arriving or scope.sure)
        self._count(task, result)
        self._lessons.proofs &= result.plan is not None or result.proven or result.timed_out or bound is not None
        self._limits.check()
        return result

    def _count(self, task: GroundTask, result: SearchResult) -> None:
        """Count the work of a search."""
        looked = result.states * len(task.operators) // STATES_A_CALL
        self.work += SEARCH_CALLS + len(task.operators) // OPERATORS_A_CALL + looked
        self.looking += looked

    def cheaper(self, enough: int, scope: Scope, below: int | None = None) -> Plan | None:
        """What a brief search finds below the cost of the best plan, and `below` another; None where it finds none.

        Where that would be far more work of searches than `enough` in all, only values that are real are looked at.

        Raises:
            Ended: at a limit.
        """
        bound = self._found.bound(scope.pairs)
        asked = self._asked(enough - self.work) if self._asks and not scope.pairs else SearchResult(None)
        if asked.plan is not None:
            return asked.plan
        with self._stopwatch.timed("grounding"):
            self._knowledge.refresh()
            work = SEARCH_CALLS + self._symbolic.size // OPERATORS_A_CALL
            dear = work > 4 * (enough - self.work)
            task = self._symbolic.task(self._lessons.blames, replace(scope, sure=scope.sure or dear))
        if bound is None or not task.solvable:
            return None
        bound = bound if below is None else min(bound, below)
        with self._stopwatch.timed("search"):
            near, best = scope.among is not None, self._found.best or ()
            result = self._symbolic.improve(task, self._limits.left_to_search, bound, near, best)
        self._count(task, result)
        self._limits.check()
        return result.plan
