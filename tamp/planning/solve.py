"""The entry point: `solve` runs an algorithm on a problem and says what came of it."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

from tamp.errors import DomainError
from tamp.planning.algorithms import adaptive, focused, incremental
from tamp.planning.constraints import Constraints, Reuse
from tamp.planning.fast_downward import FastDownward
from tamp.planning.options import Ended, Options, Restart
from tamp.planning.picture import draw_plan
from tamp.planning.problem import GroundAction, Problem, Solution
from tamp.planning.report import Report
from tamp.planning.search import BuiltinSearch, Search
from tamp.planning.session import Session

ALGORITHMS: dict[str, Callable[[Session], None]] = {
    "adaptive": adaptive,
    "focused": focused,
    "incremental": incremental,
}


def solve(
    problem: Problem,
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
    constraints: Constraints | None = None,
    reuse: Reuse | None = None,
) -> Solution:
    """Plan.

    Args:
        problem: what to solve.
        algorithm: "adaptive", "focused" or "incremental".
        timeout: when to end [s]; the best plan found by then is returned.
        seed: decides every random choice.
        max_cost: plans that cost more do not count.
        success_cost: a plan that costs at most this ends the run; above it, better ones are looked for.
        unit_costs: let each action cost 1, whatever the domain says.
        search: "builtin", one of Fast Downward's configurations by name, or any function that fits `Search`.
        max_iterations: how many searches may be run.
        max_memory: resident memory of this process at which to end [MB]; Fast Downward's own is bounded apart from it.
        constraints: a skeleton to follow, actions to avoid.
        reuse: what to keep of an earlier plan, see `Reuse.after`; algorithm "adaptive" tries its actions first.

    Raises:
        DomainError: for an unknown algorithm or search.
        SamplerError: where a sampler's output does not fit its stream.
    """
    if algorithm not in ALGORITHMS:
        raise DomainError(f"unknown algorithm {algorithm!r}; there are: {', '.join(ALGORITHMS)}")
    searcher: Search = _searcher(search) if isinstance(search, str) else search
    constraints = constraints or Constraints()
    constraints.check(problem.parsed_domain)
    options = Options(
        seed,
        timeout,
        max_cost,
        success_cost,
        unit_costs,
        max_iterations,
        max_memory,
        constraints=constraints,
        reuse=reuse,
    )
    started = time.monotonic()
    session = Session(problem, options, searcher, algorithm == "incremental", started)
    try:
        while (restart := _run(session, algorithm)) is not None:
            session = Session(problem, restart.options, searcher, algorithm == "incremental", started)
        raise AssertionError("algorithms end by raising Ended or Restart")
    except Ended as ended:
        status, message = ended.status, ended.message
    except KeyboardInterrupt:
        status, message = "interrupted", "The run was interrupted."
    return _solution(session, algorithm, status, message)


def _run(session: Session, algorithm: str) -> Restart | None:
    try:
        session.begin()
        ALGORITHMS[algorithm](session)
    except Restart as restart:
        return restart
    return None


def _searcher(name: str) -> Search:
    return BuiltinSearch() if name == "builtin" else FastDownward(name)


def _solution(session: Session, algorithm: str, status: str, message: str) -> Solution:
    objects, best = session.objects, session.found.best
    plan = None
    if best is not None:
        plan = tuple(GroundAction(step.schema.name, tuple(map(objects.value, step.args))) for step in best)
        if status != "interrupted":
            status = "solved"
    seconds = {**session.stopwatch.seconds, "sampling": session.sampling.seconds}
    report = Report(
        algorithm,
        status,
        session.found.cost,
        time.monotonic() - session.started,
        seconds,
        session.sampling.report(),
        tuple(session.lessons.reports()),
        {
            "iterations": session.limits.iterations,
            "operators": session.symbolic.operators,
            "instances": len(session.knowledge.instances()),
        },
        message,
    )
    certified = tuple(objects.values_of(fact) for fact in (*session.knowledge.real, *session.knowledge.state))
    picture = draw_plan(best, session.knowledge) if best is not None else ""
    return Solution(plan, session.found.cost, status, certified, report, picture)
