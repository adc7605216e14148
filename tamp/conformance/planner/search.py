"""Holding a classical search against its protocol: plans that are plans, proofs that are none too many, and limits."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import permutations
from typing import Any

from tamp.conformance.checks import Check, Fault, Said, asked, judged
from tamp.conformance.findings import PartJudgement
from tamp.conformance.planner.problems import SOLVABLE
from tamp.pipeline.options.own import load_search
from tamp.pipeline.options.settings import SEARCHES
from tamp.planning import Problem, Search, SearchResult, solve
from tamp.planning.grounding.ground_task import GroundTask
from tamp.planning.keywords import search_of
from tamp.planning.run import searcher
from tamp.planning.search.best_first import misfit
from tamp.planning.search.elimination import reaches

LIMIT_S = 5.0
"""What a search is given for a task of a handful of atoms [s]."""

BRIEF_S = 0.5
"""What it is given for a task that it cannot solve by then [s]."""

PUZZLE = """
(define (domain puzzle)
  (:predicates (at ?t ?x) (blank ?x) (beside ?x ?y))
  (:action slide :parameters (?t ?x ?y) :precondition (and (at ?t ?x) (blank ?y) (beside ?x ?y))
    :effect (and (at ?t ?y) (blank ?x) (not (at ?t ?x)) (not (blank ?y)))))
"""


def check_search(search: str | Search) -> PartJudgement:
    """Hold a search against `tamp.planning.Search`: call, answers, plans, proofs, bound, repetition, limit.

    Args:
        search: a function or an instance, or its name: a built-in one, an installed one, or "package.module:NAME".

    Raises:
        TampError: where a name says no search.
    """
    name = search if isinstance(search, str) else getattr(search, "__qualname__", type(search).__name__)
    return judged("search", name, _checks(_found(search)))


def _found(search: Any) -> Any:
    if not isinstance(search, str):
        return search
    return searcher(search_of(search)) if search in SEARCHES else load_search(search, SEARCHES)


def _checks(search: Any) -> Iterator[Check]:
    solvable = {what: ground(make()) for what, make in SOLVABLE.items()}
    yield "call", lambda: _called(search)
    yield "plans", lambda: _plans(search, solvable)
    yield "proofs", lambda: _proofs(search)
    yield "bound", lambda: _bound(search, solvable)
    yield "repetition", lambda: _repeated(search, solvable)
    yield "limit", lambda: _limit(search)


def ground(problem: Problem) -> GroundTask:
    """The ground task of a problem without streams, as the planner gives it to its search."""
    tasks: list[GroundTask] = []

    def listening(task: GroundTask, timeout: float, bound: int | None = None, effort: float = math.inf) -> SearchResult:
        tasks.append(task)
        return SearchResult(None, timed_out=True)

    solve(problem, search=listening, max_iterations=1)
    return tasks[-1]


def _asked(search: Any, what: str, task: GroundTask, limit: float, bound: int | None = None) -> SearchResult:
    """A search's answer, which is of the right kind and whose plan leads to the goal."""
    result: Any = asked(what, lambda: search(task, limit, bound, math.inf), limit)
    if not isinstance(result, SearchResult):
        raise Fault(f"{what}: expected a SearchResult, found {result!r:.60}")
    if result.plan is not None and not reaches(task, result.plan):
        raise Fault(f"{what}: its plan does not lead from what is initial in the task to the task's goal")
    return result


def _called(search: Any) -> Said:
    if wrong := misfit(search):
        raise Fault(f"it {wrong}")
    return "ok", "takes (task, timeout, bound, effort)"


def _plans(search: Any, tasks: dict[str, GroundTask]) -> Said:
    found = 0
    for what, task in tasks.items():
        result = _asked(search, what, task, LIMIT_S)
        if result.plan is None and result.proven:
            raise Fault(f"{what}: it says that it is proven that there is no plan, and there is one")
        found += result.plan is not None
    if not found:
        raise Fault(f"it finds no plan for any of {len(tasks)} tasks of a handful of atoms")
    text = f"for {found} of {len(tasks)} tasks"
    return ("ok", text) if found == len(tasks) else ("note", f"{text}: it is not complete")


def _proofs(search: Any) -> Said:
    task = _unsolvable()
    result = _asked(search, "a puzzle that cannot be solved", task, LIMIT_S)
    if result.proven:
        return "ok", "what has no plan is proven to have none"
    return "note", "it does not prove that there is no plan: with it no problem is called infeasible by its searches"


def _unsolvable() -> GroundTask:
    """Two tiles that no slide swaps, on a board of two by two: a goal that is in reach without deletes."""
    return ground(_puzzle(2, ((1, 1), (0, 1), (1, 0), (0, 0)), {"t0": (1, 0), "t1": (0, 1), "t2": (1, 1)}))


def _bound(search: Any, tasks: dict[str, GroundTask]) -> Said:
    heeded = True
    for what, task in tasks.items():
        free = _asked(search, what, task, LIMIT_S)
        cost = sum(operator.cost for operator in free.plan or ())
        if cost:
            again = _asked(search, f"{what}, with a bound of {cost}", task, LIMIT_S, cost)
            heeded &= again.plan is None or sum(operator.cost for operator in again.plan) < cost
    if heeded:
        return "ok", "plans cost less than the bound"
    return "note", "plans may cost as much as the bound, or more: better plans are not found with it"


def _repeated(search: Any, tasks: dict[str, GroundTask]) -> Said:
    for what, task in tasks.items():
        first, second = (_asked(search, what, task, LIMIT_S).plan for _ in range(2))
        if first != second:
            raise Fault(f"{what}: a second call gives another plan; what one seed gives must repeat")
    return "ok", "a second call gives the same plans"


def _limit(search: Any) -> Said:
    _asked(search, "a task that takes longer than its time limit", _long(), BRIEF_S)
    return "ok", f"comes back where its time is up, here {BRIEF_S:g} s"


def _long() -> GroundTask:
    """The puzzle of 24 tiles, far from its goal."""
    cells = [(x, y) for x in range(5) for y in range(5)]
    start = cells[::-1]
    return ground(_puzzle(5, start, {f"t{i}": cell for i, cell in enumerate(cells[:-1])}))


def _puzzle(size: int, start: Any, goal: dict[str, tuple[int, int]]) -> Problem:
    """Tiles on a board; the cell that comes last in `start` is blank."""
    cells = [(x, y) for x in range(size) for y in range(size)]
    near = [pair for pair in permutations(cells, 2) if math.dist(*pair) == 1.0]
    init: list[tuple[Any, ...]] = [("beside", *pair) for pair in near] + [("blank", start[-1])]
    init += [("at", f"t{i}", cell) for i, cell in enumerate(start[:-1])]
    return Problem(domain=PUZZLE, init=init, goal=("and", *(("at", tile, cell) for tile, cell in goal.items())))
