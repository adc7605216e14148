"""The entry point: `solve` has a strategy ask the stream planner, and says what came of it."""

from __future__ import annotations

import math
import reprlib
from dataclasses import replace
from typing import Any

from tamp import clock
from tamp.clock import TimeUp
from tamp.errors import DomainError, PartError, TampError, told
from tamp.planning.constraints import Constraints
from tamp.planning.keywords import (
    SERIALIZED,
    PDDLProblem,
    PlanConstraints,
    algorithm_of,
    constraints_of,
    problem_of,
    search_of,
    understood,
)
from tamp.planning.options import Options, Reuse, Settings
from tamp.planning.problem import GroundAction, Problem, Solution
from tamp.planning.report import Report
from tamp.planning.search.best_first import Search
from tamp.planning.search.best_first import misfit as no_search
from tamp.planning.strategies.all_at_once import AllAtOnce
from tamp.planning.strategies.net_benefit import NetBenefit
from tamp.planning.strategies.serialized import Serialized
from tamp.planning.strategies.strategy import Strategy, misfit, record, supports_soft_goals

STRATEGIES: dict[str, type[AllAtOnce] | type[Serialized] | type[NetBenefit]] = {
    each.name: each for each in (AllAtOnce, Serialized, NetBenefit)
}

STATUSES = ("solved", "infeasible", "timeout", "failed", "interrupted")


def solve(
    problem: Problem | PDDLProblem,
    *,
    algorithm: str = "adaptive",
    timeout: float = 60.0,
    seed: int = 0,
    max_cost: float = math.inf,
    success_cost: float = math.inf,
    unit_costs: bool = False,
    search: str | Search = "ff",
    max_iterations: int = 1_000_000,
    max_memory: float = math.inf,
    constraints: Constraints | PlanConstraints | None = None,
    reuse: Reuse | None = None,
    strategy: str | Strategy = "all-at-once",
    **pddlstream: Any,
) -> Solution:
    """Plan.

    Args:
        problem: what to solve; a `PDDLProblem` as well.
        algorithm: "adaptive", "binding", "focused" or "incremental", or by PDDLStream's names.
        timeout: when to end [s]; the best plan found by then is returned.
        seed: decides every random choice.
        max_cost: plans that cost more do not count.
        success_cost: a plan that costs at most this ends the run; above it, better ones are looked for.
        unit_costs: let each action cost 1, whatever the domain says.
        search: "builtin", one of Fast Downward's configurations by name, or any function that fits `Search`; also one
            of PDDLStream's planners.
        max_iterations: how many searches may be run.
        max_memory: resident memory of this process at which to end [MB]; Fast Downward's own is bounded apart from it.
        constraints: a skeleton to follow, actions to avoid; `PlanConstraints` as well.
        reuse: what to keep of an earlier plan, see `Reuse.after`; algorithm "adaptive" tries its actions first.
        strategy: "all-at-once", "serialized" (goal by goal) or "net-benefit" (soft goals), or one with its options,
            such as `Serialized(ladder=(0.1, 0.5))`; anything that fits `Strategy`.
        pddlstream: what PDDLStream's solvers take: `planner` for `search`, `max_time` for `timeout`, `stream_info` for
            what is `info` of a problem, `max_planner_time` [s] for each search, `verbose` to print the report; a
            warning names those that have no effect here.

    Raises:
        DomainError: for an unknown algorithm, search or strategy, or what a strategy cannot respect.
        SamplerError: where a sampler's output does not fit its stream.
        TypeError: for a keyword that neither this planner nor PDDLStream has.
    """
    keywords = understood(pddlstream)
    problem = problem_of(problem, keywords.get("stream_info"))
    timeout = keywords.get("max_time", timeout)
    search = keywords.get("planner", search)
    constraints, most = constraints_of(constraints)
    if algorithm == SERIALIZED:
        algorithm, strategy = "adaptive", SERIALIZED
    if isinstance(strategy, str):
        if strategy not in STRATEGIES:
            raise DomainError(f"unknown strategy {strategy!r}; there are: {', '.join(STRATEGIES)}")
        strategy = STRATEGIES[strategy]()
    if wrong := misfit(strategy):
        raise DomainError(f"strategy: {reprlib.repr(strategy)} {wrong}")
    if problem.soft_goals and not supports_soft_goals(strategy):
        able = "'net-benefit' does, and one of your own whose class says supports_soft_goals: ClassVar[bool] = True"
        raise DomainError(f"strategy {strategy.name!r} does not plan for soft_goals; {able}")
    options = Options(
        seed,
        timeout,
        max_cost if most == math.inf else min(max_cost, most),
        success_cost,
        unit_costs,
        max_iterations,
        max_memory,
        max_search_s=keywords.get("max_planner_time", math.inf),
        constraints=constraints or Constraints(),
        reuse=reuse,
    )
    if isinstance(search, str):
        search = search_of(search)
    elif wrong := no_search(search):
        raise DomainError(f"search: {reprlib.repr(search)} {wrong}")
    solution: Solution = _answered(strategy, problem, Settings(algorithm_of(algorithm), search, options))
    if wrong := _unfit(solution, problem):
        raise PartError(f"strategy {strategy.name!r}: {wrong}")
    solution = replace(solution, report=replace(solution.report, strategy=record(strategy)))
    if keywords.get("verbose", False):
        print(solution.report)
    return solution


def _answered(strategy: Strategy, problem: Problem, settings: Settings) -> Any:
    """What a strategy answers; a timeout for one from outside that goes on past the limit without a look at the clock.

    Raises:
        PartError: where one from outside raises something that is no sentence to the user.
        TimeUp: where the limit is that of whoever asks, who ends all that they do by it.
    """
    if type(strategy) in STRATEGIES.values():
        return strategy(problem, settings)
    started, limit, ours = clock.now(), settings.options.timeout, clock.is_free()
    try:
        with clock.ended_at(started + limit, gives_way=True):
            return strategy(problem, settings)
    except TampError:
        raise
    except TimeUp as late:
        if not ours:
            raise
        message = f"The time limit of {limit:g} s was reached: strategy {strategy.name!r} was {late}."
    except (Exception, SystemExit) as error:
        raise PartError(f"strategy {strategy.name!r} raised {told(error)}") from error
    report = Report(settings.algorithm, "timeout", math.inf, clock.now() - started, {}, (), (), {}, message)
    return Solution(None, math.inf, "timeout", (), report)


def _unfit(solution: Any, problem: Problem) -> str:
    """What is wrong with the form of a strategy's answer; empty where nothing is."""
    if not isinstance(solution, Solution):
        return f"expected a Solution, found {reprlib.repr(solution)}"
    if solution.status not in STATUSES:
        return f"its status is {solution.status!r}; valid are {', '.join(STATUSES)}"
    # Who is interrupted keeps the best plan.
    if (solution.plan is not None) != (solution.status == "solved") and solution.status != "interrupted":
        return f"its status is {solution.status!r}, with {'no' if solution.plan is None else 'a'} plan"
    if solution.plan is None:
        return ""
    actions = problem.parsed_domain.actions
    for step in solution.plan:
        if not isinstance(step, GroundAction) or step.name not in actions:
            return f"expected a plan of GroundAction, each an action of the domain, found {reprlib.repr(step)}"
        if len(step.args) != len(actions[step.name].parameters):
            return f"{step.name} has {len(actions[step.name].parameters)} parameters, in its plan {len(step.args)}"
    return ""
