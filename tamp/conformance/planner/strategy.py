"""Holding a strategy against its protocol: plans that are plans, an honest status, its record, and the time limit."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from tamp.conformance.checks import Check, Fault, Said, asked, judged
from tamp.conformance.findings import PartJudgement
from tamp.conformance.planner.problems import IMPOSSIBLE, SOLVABLE, carried_out, impossible, painting, workshop
from tamp.pipeline.options.own import load_strategy
from tamp.planning import Problem, Solution, Strategy, solve
from tamp.planning.solve import STRATEGIES
from tamp.planning.strategies.strategy import misfit, record, supports_soft_goals

LIMIT_S = 5.0
"""What a strategy is given for a problem of a handful of facts [s]."""

BRIEF_S = 1.0
"""What it is given for one that it cannot solve [s]."""

SOFT = ((("made", "chair"), 100.0), (("made", "table"), 1.0))
"""Soft goals of which the first is worth its cost and the second is not."""


def check_strategy(strategy: str | Strategy, *, seed: int = 0) -> PartJudgement:
    """Hold a strategy against `tamp.planning.Strategy`: call, record, plans, status, repetition, limit.

    Args:
        strategy: an instance, or its name: a built-in one, an installed one, or "package.module:NAME".
        seed: decides every random choice.

    Raises:
        TampError: where a name says no strategy.
    """
    found: Any = strategy
    if isinstance(strategy, str):
        found = STRATEGIES[strategy]() if strategy in STRATEGIES else load_strategy(strategy, (*STRATEGIES,))
    name = strategy if isinstance(strategy, str) else getattr(strategy, "name", None) or repr(strategy)
    return judged("strategy", str(name), _checks(found, seed))


def _checks(strategy: Any, seed: int) -> Iterator[Check]:
    yield "call", lambda: _called(strategy)
    yield "record", lambda: _recorded(strategy)
    yield "plans", lambda: _plans(strategy, seed)
    yield "status", lambda: _status(strategy, seed)
    yield "repetition", lambda: _repeated(strategy, seed)
    yield "limit", lambda: _limit(strategy, seed)
    if supports_soft_goals(strategy):
        yield "soft goals", lambda: _soft(strategy, seed)


def _asked(strategy: Any, what: str, problem: Problem, seed: int, limit: float) -> Solution:
    """A strategy's answer, whose plan reaches the goal."""
    if supports_soft_goals(strategy) and not problem.soft_goals:  # nothing is worth anything: it decides nothing
        problem = replace(problem, soft_goals=((("burnt",), 1e-3),))
    solution = asked(what, lambda: solve(problem, strategy=strategy, seed=seed, timeout=limit), limit)
    if solution.plan is not None:
        try:
            carried_out(problem, solution)
        except Fault as fault:
            raise Fault(f"{what}: {fault}") from None
    return solution


def _called(strategy: Any) -> Said:
    if wrong := misfit(strategy):
        raise Fault(f"it {wrong}")
    return "ok", "takes (problem, settings)"


def _recorded(strategy: Any) -> Said:
    options = asked("its options", lambda: record(strategy))
    try:
        return "ok", json.dumps(options)
    except (TypeError, ValueError) as error:
        raise Fault(f"its options {options!r:.100} cannot be written into a run's record: {error}") from None


def _plans(strategy: Any, seed: int) -> Said:
    problems = {**SOLVABLE, "a problem with a stream": painting}
    found = 0
    for what, make in problems.items():
        solution = _asked(strategy, what, make(), seed, LIMIT_S)
        if solution.status == "infeasible":
            raise Fault(f"{what}: its status is 'infeasible', and there is a plan")
        found += solution.plan is not None
    if not found:
        raise Fault(f"it plans for none of {len(problems)} problems of a handful of facts")
    return "ok" if found == len(problems) else "note", f"for {found} of {len(problems)} problems"


def _status(strategy: Any, seed: int) -> Said:
    status = _asked(strategy, IMPOSSIBLE, impossible(), seed, BRIEF_S).status
    if status == "infeasible":
        return "ok", "what has no plan is called infeasible"
    return "note", f"what has no plan is called {status!r}: with it nothing is proven infeasible"


def _repeated(strategy: Any, seed: int) -> Said:
    for what, make in {**SOLVABLE, "a problem with a stream": painting}.items():
        first, second = (_asked(strategy, what, make(), seed, LIMIT_S).plan for _ in range(2))
        if first != second:
            raise Fault(f"{what}: the same seed gives another plan; draw from the seed of settings.options alone")
    return "ok", "the same seed gives the same plans"


def _limit(strategy: Any, seed: int) -> Said:
    what = "a stream that goes on for ever and gives nothing"
    _asked(strategy, what, painting(drying=False), seed, BRIEF_S)
    return "ok", f"comes back where its time is up, here {BRIEF_S:g} s"


def _soft(strategy: Any, seed: int) -> Said:
    problem = workshop(("open",), soft=SOFT)
    solution = _asked(strategy, "soft goals", problem, seed, LIMIT_S)
    if solution.plan is None:
        raise Fault(f"soft goals: the hard one can be reached, and its status is {solution.status!r}")
    state = carried_out(problem, solution)
    missed = {goal for goal, _ in SOFT if goal not in state}
    if missed != set(solution.forgone):
        raise Fault(f"soft goals: its plan leaves {_listed(missed)}, and it says {_listed(solution.forgone)}")
    return ("ok" if missed == {SOFT[1][0]} else "note"), f"its plan leaves {_listed(missed)}"


def _listed(goals: Any) -> str:
    return ", ".join(sorted(f"({' '.join(goal)})" for goal in goals)) or "none"
