"""The symbolic search of one run: the ground task of the moment, and how long it may be searched."""

from __future__ import annotations

import math
import reprlib
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

from tamp import clock
from tamp.errors import PartError, TampError, told
from tamp.planning.binding.attempt import BoundStep
from tamp.planning.grounding.blame import Blame
from tamp.planning.grounding.ground_task import GroundTask
from tamp.planning.grounding.grounder import Grounder
from tamp.planning.grounding.task_builder import Scope, TaskBuilder
from tamp.planning.model.fact_store import Knowledge
from tamp.planning.model.schema import Schema
from tamp.planning.model.stream_instances import ground
from tamp.planning.sampling.evaluation import Evaluator
from tamp.planning.search.attached import Attached, search_attached
from tamp.planning.search.best_first import Search, SearchResult
from tamp.planning.search.elimination import eliminate, reaches
from tamp.planning.search.windows import cost, improve_windows, seen_as

SEARCH_S = 2.0
"""Processor time of the first search before more is sampled instead; doubled each time that it was not enough [s]."""

IMPROVING_S = 0.08
"""Processor time of a search for a plan that is cheaper than the best one [s]."""

ASKED = 400
"""States that a search which asks tests in each of them may look at; doubled each time that it was not enough."""

BRIEF_S = 1.0
"""Processor time of a search that leaves something out, before the full one has its turn [s]."""


class SymbolicSearch:
    """Searches for plans over the optimistic facts of a moment.

    Attributes:
        operators: how many the last task had.
    """

    def __init__(
        self,
        schema: Schema,
        knowledge: Knowledge,
        evaluator: Evaluator,
        grounder: Grounder,
        builder: TaskBuilder,
        search: Search,
    ) -> None:
        self.operators = 0
        self._schema = schema
        self._knowledge = knowledge
        self._evaluator = evaluator
        self._grounder = grounder
        self._builder = builder
        self._search = search
        self._timeouts = 0
        self._asked = ASKED
        self._asked_of: tuple[int, int | None] | None = None
        self._asked_in_vain = False
        self._barren: tuple[GroundTask, int | None] | None = None  # what was last searched to its end in vain

    @property
    def size(self) -> int:
        """How many operators there are to search with."""
        return len(self._grounder.operators)

    def task(self, blames: dict[int, Blame], scope: Scope) -> GroundTask:
        """The ground task of this moment; `blames`: what is discouraged."""
        goal = self._schema.goal
        changing = self._schema.fluents | self._schema.derived
        positive = [ground(p, {}) for p in goal.positive]
        negative = [ground(p, {}) for p in goal.negative]
        static = [f for f in positive if f[0] not in changing]
        barred = any(f in self._knowledge.real for f in negative if f[0] not in changing)
        if barred or not all(self._knowledge.usable(f) or self._evaluator.truth(f) for f in static):
            return GroundTask((), frozenset(), (), (), (), (), solvable=False)
        literals = (
            tuple(f for f in positive if f[0] in changing),
            tuple(f for f in negative if f[0] in changing),
        )
        return self._builder.build(self._grounder.operators, self._grounder.axioms, literals, blames, scope)

    def run(self, task: GroundTask, left: float, bound: int | None, brief: bool) -> SearchResult:
        """Search a task.

        Args:
            task: what `task` gave.
            left: of the run's time [s].
            bound: the cost at which a plan is of no use any more.
            brief: whether there is another search where this one takes long.

        Raises:
            TampError: where the search returned something else than a SearchResult.
        """
        first = SEARCH_S if bound is None else BRIEF_S  # where there is a plan already, no single search is all
        effort = BRIEF_S if brief else first * 2**self._timeouts
        result = self._searched(task, left, bound, effort)
        self._timeouts += result.timed_out and not brief
        self.operators = len(task.operators)
        return result

    def ask(self, hidden: str, bound: int | None, check: Callable[[], None], most: float = math.inf) -> SearchResult:
        """Search among real values, and ask the tests that are told the state in each state that it comes to.

        As long as nothing new is known, it is done once; what is proven is that none of these values makes a plan.

        Args:
            hidden: the fluent that the task does not follow; empty where it follows all.
            bound: the cost at which a plan is of no use any more.
            check: ends the run at a limit.
            most: how many states may be looked at.
        """
        self._knowledge.refresh()
        asked_of = (self._knowledge.version, bound)
        if not self._schema.state_tests or self._asked_of == asked_of:
            return SearchResult(None, proven=self._asked_in_vain)
        self._asked_of, self._asked_in_vain = asked_of, False
        task = self.task({}, Scope(sure=True, exact=True, asking=True))
        if not task.solvable:
            return SearchResult(None)
        attached = Attached(task, self._knowledge, self._evaluator, hidden)
        result = search_attached(task, attached, check, bound, min(self._asked, most))
        self._asked *= 2 if result.states >= self._asked else 1
        self._asked_in_vain = result.proven
        if result.plan is None:
            return result
        shorter = eliminate(task, result.plan)
        return replace(result, plan=shorter if attached.allow(shorter, task) else result.plan)

    def improve(
        self, task: GroundTask, left: float, bound: int, near: bool = False, best: Iterable[BoundStep] = ()
    ) -> SearchResult:
        """Look for a plan that costs less than `bound`, for a moment, or for two and then in windows of that plan.

        Where none is found, windows of the best plan are searched, for as much work again.

        Args:
            task: what `task` gave.
            left: of the run's time [s].
            bound: the cost at which a plan is of no use any more.
            near: whether what the search sees is like the best plan, so that more comes of it.
            best: the actions of that plan.

        Raises:
            TampError: where the search returned something else than a SearchResult.
        """
        deadline = clock.now() + left
        result = self._searched(task, left, bound, IMPROVING_S * (1 + near))
        plan, most = result.plan, math.inf
        if near and plan is None and result.timed_out:
            plan, most = seen_as(task, ((step.schema, step.binding) for step in best)), result.states
        if not near or plan is None:
            return result
        looked = 0

        def search(part: GroundTask, least: int) -> SearchResult:
            nonlocal looked
            rest = deadline - clock.now()
            if rest <= 0.0 or looked >= most:
                return SearchResult(None)
            found = self._searched(part, rest, least, IMPROVING_S)
            looked += found.states
            return found

        better = improve_windows(task, plan, search)
        worth = better.plan is not None and cost(better.plan) < bound
        return replace(better, plan=better.plan if worth else None, states=better.states + result.states)

    def _theirs(self, task: GroundTask, left: float, bound: int | None, effort: float) -> SearchResult:
        """What a search from outside finds, once it is known to be what it says.

        Raises:
            TampError: where it raises, returns something else than a SearchResult, or a plan that is none.
        """
        search = f"search {getattr(self._search, '__qualname__', type(self._search).__name__)}"
        try:
            result: Any = self._search(task, left, bound, effort)
            valid = isinstance(result, SearchResult) and (result.plan is None or reaches(task, result.plan))
        except TampError:
            raise
        except (Exception, SystemExit) as error:
            raise PartError(f"{search} raised {told(error)}") from error
        if not isinstance(result, SearchResult):
            raise PartError(f"{search}: expected a SearchResult, found {reprlib.repr(result)}")
        if not valid:
            raise PartError(f"{search}: its plan does not lead from what is initial in the task to the task's goal")
        return result

    def _searched(self, task: GroundTask, left: float, bound: int | None, effort: float) -> SearchResult:
        if self._barren == (task, bound):
            return SearchResult(None, proven=True)
        ours = type(self._search).__module__.startswith(f"{__package__}.")
        result = self._search(task, left, bound, effort) if ours else self._theirs(task, left, bound, effort)
        if result.plan is None:
            self._barren = (task, bound) if result.proven else self._barren
            return result
        return replace(result, plan=eliminate(task, result.plan))
