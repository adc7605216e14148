"""Limits end a run with a status that says so, and keep the best plan found by then. No test here measures time."""

from __future__ import annotations

import itertools
import math
import signal
import time

import pytest

from tamp.errors import DomainError
from tamp.planning import Problem, SearchResult, solve
from tamp.planning.search.best_first import BuiltinSearch
from tests.planning.problems import blocksworld, costs, unsolvable
from tests.planning.test_problems import check

ALGORITHMS = ("adaptive", "focused", "incremental")


class Interrupted:
    """The built-in search for a number of calls; those after them end as `how` says."""

    def __init__(self, calls, how):
        self.calls = itertools.count(1)
        self.last = calls
        self.how = how

    def __call__(self, task, timeout, bound=None, effort=math.inf):
        if next(self.calls) > self.last:
            return self.how()
        return BuiltinSearch()(task, timeout, bound, effort)


def interrupt():
    """The user presses Ctrl-C meanwhile."""
    signal.raise_signal(signal.SIGINT)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_no_time_at_all(algorithm):
    solution = solve(blocksworld.inversion(3), algorithm=algorithm, timeout=0.0)
    assert (solution.plan, solution.cost, solution.status) == (None, math.inf, "timeout")
    assert solution.report.message == "The time limit of 0 s was reached."


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_searches_are_told_how_much_time_is_left(algorithm):
    given = []

    def search(task, timeout, bound=None, effort=math.inf):
        given.append(timeout)
        return SearchResult(None, timed_out=True)

    assert solve(unsolvable.endless(), algorithm=algorithm, timeout=0.3, search=search).status == "timeout"
    assert all(timeout <= 0.3 for timeout in given)


def test_samplers_are_told_the_deadline_and_cooperate():
    latest = time.monotonic() + 0.3

    def slow(context, thing):
        while time.monotonic() < context.deadline:
            time.sleep(0.01)
        assert context.deadline >= latest
        yield from ()

    domain = "(define (domain d) (:predicates (thing ?x) (made ?x ?y) (done)) (:action go :parameters (?x ?y)"
    domain += " :precondition (made ?x ?y) :effect (done)))"
    streams = "(define (stream s) (:stream make :inputs (?x) :domain (thing ?x) :outputs (?y) :certified (made ?x ?y)))"
    problem = Problem(domain=domain, streams=streams, samplers={"make": slow}, init=[("thing", 1)], goal=("done",))
    assert solve(problem, timeout=0.3).status == "timeout"


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_iterations(algorithm):
    solution = solve(unsolvable.endless(), algorithm=algorithm, timeout=20.0, max_iterations=3)
    assert (solution.plan, solution.status) == (None, "failed")
    assert solution.report.message == "The limit of 3 iterations was reached."


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_memory(algorithm):
    solution = solve(unsolvable.endless(), algorithm=algorithm, timeout=20.0, max_memory=1.0)
    assert (solution.plan, solution.status) == (None, "failed")
    assert solution.report.message == "The memory limit of 1 MB was reached."
    assert solve(blocksworld.inversion(3), algorithm=algorithm, max_memory=1e6).status == "solved"


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_an_interrupt_keeps_the_best_plan(algorithm):
    problem = costs.delivery()
    for calls in range(1, 40):
        solution = solve(
            problem, algorithm=algorithm, success_cost=0.0, search=Interrupted(calls, interrupt), timeout=20.0
        )
        assert solution.status == "interrupted"
        if solution.plan is not None:
            break
    check(problem, solution)


def test_an_interrupt_inside_a_sampler():
    problem = costs.delivery()
    name = problem.parsed_streams.streams[0].name
    samplers = {**problem.samplers, name: lambda *args: interrupt()}
    roadless = [fact for fact in problem.init if fact[0] != "Road"]
    broken = Problem(problem.domain, problem.streams, samplers, roadless, problem.goal, problem.scene)
    for strategy in ("all-at-once", "serialized"):
        solution = solve(broken, timeout=20.0, strategy=strategy)
        assert (solution.plan, solution.status) == (None, "interrupted")


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_iterations_keep_the_best_plan(algorithm):
    problem = costs.delivery()
    found = [
        solve(problem, algorithm=algorithm, success_cost=0.0, max_iterations=n, timeout=20.0) for n in range(1, 12)
    ]
    assert [s.status for s in found] == ["solved" if s.plan else "failed" for s in found]
    assert [s.cost for s in found] == sorted((s.cost for s in found), reverse=True)
    check(problem, found[-1])


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_a_search_that_gives_up_proves_nothing(algorithm):
    search = Interrupted(0, lambda: SearchResult(None))
    solution = solve(blocksworld.inversion(3), algorithm=algorithm, search=search, timeout=20.0)
    assert (solution.plan, solution.status) == (None, "failed")


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"algorithm": None}, "unknown algorithm None; there are: adaptive, binding"),
        ({"algorithm": ["focused"]}, r"unknown algorithm \['focused'\]; there are: adaptive"),
        ({"timeout": None}, "timeout is None; valid are numbers, and math.inf for no limit"),
        ({"timeout": math.nan}, "timeout is nan; valid are numbers"),
        ({"max_cost": "5"}, "max_cost is '5'; valid are numbers"),
        ({"max_iterations": None}, "max_iterations is None; valid are numbers"),
        ({"seed": 1.5}, "seed is 1.5; valid are whole numbers"),
        ({"reuse": 3}, "reuse is 3; valid are what Reuse.after makes of a solution, and None"),
        ({"constraints": 3}, "constraints is 3; valid are Constraints, PlanConstraints and None"),
    ],
)
def test_an_option_that_is_none_is_refused_in_one_sentence(given, said):
    with pytest.raises(DomainError, match=said):
        solve(blocksworld.inversion(2), **given)
