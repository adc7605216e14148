"""The search behind one small protocol, and one built in: greedy best-first search with the FF heuristic."""

from __future__ import annotations

import heapq
import inspect
import math
import time
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import count
from typing import Protocol

from tamp import clock
from tamp.planning.grounding.ground_task import GroundTask, TaskOperator, axiom_layers


@dataclass(frozen=True, slots=True)
class SearchResult:
    """A plan, or None; `proven` where there is none for sure; how many `states` were looked at, where it is known."""

    plan: tuple[TaskOperator, ...] | None
    proven: bool = False
    timed_out: bool = False
    states: int = 0


class Search(Protocol):
    """Finds a plan of a ground task."""

    def __call__(
        self, task: GroundTask, timeout: float, bound: int | None = None, effort: float = math.inf
    ) -> SearchResult:
        """Search for a plan that costs less than `bound`, for at most `timeout` seconds.

        `effort` [s] is bounded by processor time, so that a busy machine finds what an idle one finds.
        """
        ...


def misfit(search: object) -> str:
    """Why something cannot be called as a search is; empty where it can."""
    if inspect.isclass(search):
        return f"is the class {search.__qualname__}; give an instance, such as {search.__qualname__}()"
    if not callable(search):
        return "cannot be called; a search is called with (task, timeout, bound, effort)"
    try:
        inspect.signature(search).bind(None, 0.0, None, 0.0)
    except TypeError as error:
        return f"must take (task, timeout, bound=None, effort=math.inf): {error}"
    return ""


class BuiltinSearch:
    """Greedy best-first search guided by the FF heuristic's relaxed plans, its helpful actions first.

    States are integers, one bit an atom. Complete: it sees the whole space where there is no plan (Hoffmann and Nebel,
    "The FF planning system", 2001).
    """

    def __call__(
        self, task: GroundTask, timeout: float, bound: int | None = None, effort: float = math.inf
    ) -> SearchResult:
        """Search for a plan that costs less than `bound`, for `timeout` seconds or `effort` of processor time."""
        deadline, enough = clock.now() + timeout, time.process_time() + effort
        space = Space(task)
        start = space.close(sum(1 << atom for atom in task.initial))
        estimate = space.estimate(start)
        if estimate is None:
            return SearchResult(None, proven=True)
        order = count()
        queue = [(estimate, next(order), start, 0)]
        parents: dict[int, tuple[int, int] | None] = {start: None}
        while queue:
            if clock.now() > deadline or time.process_time() > enough:
                return SearchResult(None, timed_out=True)
            _, _, state, cost = heapq.heappop(queue)
            if space.is_goal(state):
                return SearchResult(space.plan(parents, state))
            for index in range(len(task.operators)):
                if not space.applicable(index, state):
                    continue
                successor = space.close(space.apply(index, state))
                total = cost + task.operators[index].cost
                if successor in parents or (bound is not None and total >= bound):
                    continue
                parents[successor] = (state, index)
                estimate = space.estimate(successor)
                if estimate is not None:
                    heapq.heappush(queue, (estimate, next(order), successor, total))
        return SearchResult(None, proven=bound is None)


class Space:
    """The transition system of a ground task over bit masks."""

    def __init__(self, task: GroundTask) -> None:
        self.task = task
        self._positive = [_mask(op.positive) for op in task.operators]
        self._negative = [_mask(op.negative) for op in task.operators]
        self._effects = [
            [(e.adds, 1 << e.atom, _mask(e.positive), _mask(e.negative)) for e in op.effects] for op in task.operators
        ]
        self._goal = _mask(task.goal_positive), _mask(task.goal_negative)
        layer = axiom_layers(task.axioms)
        self._derived = _mask(layer)
        self._strata = [
            [(1 << a.head, _mask(a.positive), _mask(a.negative)) for a in task.axioms if layer[a.head] == k]
            for k in sorted(set(layer.values()))
        ]
        self._relaxed = _relaxed_rules(task)
        self._uses: dict[int, list[int]] = {}
        for i, (needed, _, _) in enumerate(self._relaxed):
            for atom in needed:
                self._uses.setdefault(atom, []).append(i)

    def close(self, state: int) -> int:
        """The state with its derived atoms."""
        state &= ~self._derived
        for stratum in self._strata:
            changed = True
            while changed:
                changed = False
                for head, positive, negative in stratum:
                    if not state & head and state & positive == positive and not state & negative:
                        state |= head
                        changed = True
        return state

    def applicable(self, index: int, state: int) -> bool:
        """Whether the operator of that number can be taken."""
        return state & self._positive[index] == self._positive[index] and not state & self._negative[index]

    def is_goal(self, state: int) -> bool:
        """Whether the goal holds."""
        return state & self._goal[0] == self._goal[0] and not state & self._goal[1]

    def apply(self, index: int, state: int) -> int:
        """The state after an operator, before its derived atoms are worked out anew."""
        added = deleted = 0
        for adds, atom, positive, negative in self._effects[index]:
            if state & positive == positive and not state & negative:
                if adds:
                    added |= atom
                else:
                    deleted |= atom
        return (state & ~deleted) | added

    def estimate(self, state: int) -> int | None:
        """The cost of a relaxed plan that h_add's best supporters give; None where the goal is out of reach."""
        cost: dict[int, int] = {}
        supporter: dict[int, int] = {}
        missing = [len(needed) for needed, _, _ in self._relaxed]
        total = [weight for _, _, weight in self._relaxed]
        queue = [(0, atom) for atom in range(len(self.task.atoms)) if state >> atom & 1]
        best = {atom: 0 for _, atom in queue}

        def reach(index: int) -> None:
            atom = self._relaxed[index][1]
            if total[index] < best.get(atom, total[index] + 1):
                best[atom] = total[index]
                supporter[atom] = index
                heapq.heappush(queue, (total[index], atom))

        for index, needed in enumerate(missing):
            if not needed:
                reach(index)
        while queue:
            value, atom = heapq.heappop(queue)
            if atom in cost:
                continue
            cost[atom] = value
            for index in self._uses.get(atom, ()):
                total[index] += value
                missing[index] -= 1
                if not missing[index]:
                    reach(index)
        if any(atom not in cost for atom in self.task.goal_positive):
            return None
        chosen: dict[int, None] = {}
        pending = list(self.task.goal_positive)
        while pending:
            index = supporter.get(pending.pop(), -1)
            if index >= 0 and index not in chosen:
                chosen[index] = None
                pending.extend(self._relaxed[index][0])
        return sum(self._relaxed[index][2] for index in chosen)

    def plan(self, parents: dict[int, tuple[int, int] | None], state: int) -> tuple[TaskOperator, ...]:
        """The operators that lead to a state, by the step that led to each."""
        steps: list[TaskOperator] = []
        while (step := parents[state]) is not None:
            state, index = step
            steps.append(self.task.operators[index])
        return tuple(reversed(steps))


def _relaxed_rules(task: GroundTask) -> list[tuple[tuple[int, ...], int, int]]:
    """(needed atoms, atom, cost) of each addition, and of each axiom at no cost; deletes and negations are ignored."""
    rules = [
        (tuple(dict.fromkeys(op.positive + effect.positive)), effect.atom, max(1, op.cost))
        for op in task.operators
        for effect in op.effects
        if effect.adds
    ]
    return rules + [(tuple(dict.fromkeys(a.positive)), a.head, 0) for a in task.axioms]


def _mask(atoms: Iterable[int]) -> int:
    mask = 0
    for atom in atoms:
        mask |= 1 << atom
    return mask
