"""Forward search that asks the tests with fluents in each state that it comes to.

What such a test says of one state tells little of others where it is not monotone: a frame may stand with these bars
and with all of them, and fall with some. A search that must be taught what is barred, a state at a time, is taught
without end. So tests are attached to the search (Dornhege et al., "Semantic attachments for domain-independent planning
systems", ICAPS 2009); each is asked once for the part of the state that it is told, and its inputs.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from itertools import count

from tamp.planning.grounding.ground_task import GroundTask, TaskOperator
from tamp.planning.model.fact_store import Knowledge
from tamp.planning.model.normal_form import Condition
from tamp.planning.model.objects import Fact
from tamp.planning.model.state import State
from tamp.planning.model.stream_instances import ground
from tamp.planning.sampling.evaluation import Evaluator
from tamp.planning.search.best_first import SearchResult, Space

Literal = tuple[Fact, bool]


class Attached:
    """What the state decides through tests, of the operators and the goal of one task."""

    def __init__(self, task: GroundTask, knowledge: Knowledge, evaluator: Evaluator, hidden: str) -> None:
        """`hidden`: a fluent that the task does not follow; what tests say that are told of it is assumed."""
        schema = knowledge.schema
        deaf = {name for name, tests in schema.state_tests.items() if any(hidden in test.fluents for test in tests)}
        deciding = schema.state_tests.keys()
        self._told = {
            name: not (found := schema.influences(name) & deciding).isdisjoint(deciding) and found.isdisjoint(deaf)
            for name in (*deciding, *schema.derived)
        }
        self._evaluator = evaluator
        followed = {i: fact for i, fact in enumerate(task.atoms) if fact[0] in schema.fluents}
        self._moving = tuple(followed.items())
        self._resting = tuple(fact for fact in knowledge.state if fact not in set(followed.values()))
        self._answers: dict[tuple[Literal, int], bool] = {}
        self._at = -1, State(())
        self._literals: dict[TaskOperator, tuple[Literal, ...]] = {}
        self._goal = self._decided(_ground(schema.goal))

    def allows(self, op: TaskOperator, state: int) -> bool:
        """Whether tests let an operator be taken in a state."""
        if op.source is None:
            return True
        if op not in self._literals:
            wanted = ((fact, True) for fact in (*op.source.static, *op.source.positive))
            barred = ((fact, False) for fact in (*op.source.absent, *op.source.negative))
            self._literals[op] = self._decided((*wanted, *barred))
        return self._hold(self._literals[op], state)

    def fulfils(self, state: int) -> bool:
        """Whether tests say that the goal holds in a state."""
        return self._hold(self._goal, state)

    def allow(self, plan: Sequence[TaskOperator], task: GroundTask) -> bool:
        """Whether tests let the actions of a plan be taken in turn, and then say that the goal holds."""
        space = Space(replace(task, operators=tuple(plan)))
        state = space.close(sum(1 << atom for atom in task.initial))
        for step, op in enumerate(plan):
            if not self.allows(op, state):
                return False
            state = space.close(space.apply(step, state))
        return self.fulfils(state)

    def _decided(self, literals: Iterable[Literal]) -> tuple[Literal, ...]:
        return tuple(dict.fromkeys(literal for literal in literals if self._told.get(str(literal[0][0]), False)))

    def _hold(self, literals: tuple[Literal, ...], state: int) -> bool:
        return all(self._holds(literal, state) for literal in literals)

    def _holds(self, literal: Literal, state: int) -> bool:
        found = self._answers.get((literal, state))
        if found is None:
            if self._at[0] != state:
                facts = (fact for i, fact in self._moving if state >> i & 1)
                self._at = state, State([*self._resting, *facts])
            found = (self._evaluator.support(literal[0], self._at[1]) is not None) == literal[1]
            self._answers[literal, state] = found
        return found


def _ground(condition: Condition) -> Iterable[Literal]:
    yield from ((ground(pattern, {}), True) for pattern in condition.positive)
    yield from ((ground(pattern, {}), False) for pattern in condition.negative)


def search_attached(
    task: GroundTask, attached: Attached, check: Callable[[], None], bound: int | None, most: float
) -> SearchResult:
    """Greedy best-first search that asks heuristic and tests of states as they are taken up, not as they are come to.

    Args:
        task: what is searched.
        attached: what tests say of its states.
        check: ends the search at a limit.
        bound: the cost at which a plan is of no use any more.
        most: how many states are looked at.
    """
    space, order = Space(task), count(1)
    start = space.close(sum(1 << atom for atom in task.initial))
    parents: dict[int, tuple[int, int] | None] = {}
    costs: dict[int, float] = {}
    queue: list[tuple[int, int, int, int, int]] = [(0, 0, start, -1, 0)]
    states = 0
    while queue and states < most:
        check()
        _, _, before, index, cost = heapq.heappop(queue)
        state = start if index < 0 else space.close(space.apply(index, before))
        if costs.get(state, math.inf) <= cost or (index >= 0 and not attached.allows(task.operators[index], before)):
            continue
        states += 1
        costs[state], parents[state] = cost, (before, index) if index >= 0 else None
        if space.is_goal(state) and attached.fulfils(state):
            return SearchResult(space.plan(parents, state), states=states)
        estimate = space.estimate(state)
        if estimate is None:
            continue
        for i, op in enumerate(task.operators):
            total = cost + op.cost
            if space.applicable(i, state) and (bound is None or total < bound):
                heapq.heappush(queue, (estimate, next(order), state, i, total))
    return SearchResult(None, proven=not queue, timed_out=bool(queue), states=states)
