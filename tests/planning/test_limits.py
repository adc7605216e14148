"""Time limits end samplers that do not look at the clock, and leave a run that answers the next question rightly."""

from __future__ import annotations

import re
import threading
import time
from contextlib import suppress

import pytest

from tamp import clock
from tamp.clock import TimeUp, ended_at
from tamp.planning import Options, PlanningRun, Problem, Settings, from_fn, from_test, solve
from tests.planning.test_problems import check

DOMAIN = """
(define (domain shelf)
  (:requirements :action-costs)
  (:predicates (thing ?o) (spot ?o ?p) (good ?o ?p) (placed ?o))
  (:functions (total-cost) (height ?o ?p))
  (:action put :parameters (?o ?p) :precondition (and (spot ?o ?p) (good ?o ?p))
    :effect (and (placed ?o) (increase (total-cost) (height ?o ?p)))))
"""
STREAMS = """
(define (stream shelf)
  (:stream spots :inputs (?o) :domain (thing ?o) :outputs (?p) :certified (spot ?o ?p))
  (:stream is-good :inputs (?o ?p) :domain (spot ?o ?p) :certified (good ?o ?p))
  (:function (height ?o ?p) (spot ?o ?p)))
"""
LONG_S, ENOUGH_S = 20.0, 8.0
"""How long a slow sampler takes, and how soon it must have been ended on a busy machine [s]."""


def spin(*inputs):
    end = time.monotonic() + LONG_S
    while time.monotonic() < end:
        pass


def two(context, thing):
    yield from ("low", "high")


def sleeping(context, thing):
    time.sleep(LONG_S)
    yield "low"


def slow_second(context, thing):
    yield "low"
    spin()


def stubborn(context, thing):
    while True:
        with suppress(Exception):
            spin()


def is_high(context, thing, spot):
    return spot == "high"


def shelf(spots=two, is_good=is_high, height=lambda context, thing, spot: 1.0, things=("cup", "jug")):
    return Problem(
        domain=DOMAIN,
        streams=STREAMS,
        samplers={"spots": spots, "is-good": is_good, "height": height},
        init=[("thing", thing) for thing in things],
        goal=("and", *(("placed", thing) for thing in things)),
    )


SLOW = {
    "a stream": shelf(sleeping),
    "a second draw": shelf(slow_second),
    "a stream that catches exceptions": shelf(stubborn),
    "a wrapped function": shelf(from_fn(lambda thing: time.sleep(LONG_S))),
    "a test": shelf(is_good=spin),
    "a wrapped test": shelf(is_good=from_test(lambda thing, spot: spin())),
    "a function": shelf(height=spin),
}


@pytest.mark.parametrize("strategy", ["all-at-once", "serialized"])
@pytest.mark.parametrize("name", SLOW)
def test_slow_samplers_are_ended(name, strategy):
    before = time.monotonic()
    solution = solve(SLOW[name], timeout=0.2, strategy=strategy)
    assert time.monotonic() - before < ENOUGH_S
    assert (solution.plan, solution.status) == (None, "timeout")
    told = r": the sampler of .* went on past the limit .*test_limits\.py:\d+" if strategy == "all-at-once" else ""
    assert re.match(rf"The time limit of 0\.2 s was reached{told}\.", solution.report.message), solution.report.message


def test_the_best_plan_by_then_is_returned():
    def slow_third(context, thing):
        yield from ("low", "high")
        spin()

    problem = shelf(slow_third, height=lambda context, thing, spot: 1.0)
    solution = solve(problem, timeout=0.5, success_cost=0.5)
    assert solution.solved and solution.report.total_s < ENOUGH_S
    check(problem, solution)


@pytest.mark.parametrize("committed", [False, True])
def test_a_run_answers_rightly_after_it_was_ended(committed):
    asked = []

    def once_slow(context, thing, spot):
        asked.append(thing)
        if thing == "jug" and asked.count("jug") == 1:
            spin()
        return spot == "high"

    problem = shelf(is_good=once_slow)
    run = PlanningRun(problem, Settings(options=Options(timeout=20.0)))
    assert run.solve(("placed", "cup")).solved
    if committed:
        run.commit()
    assert run.solve(budget=0.2).status == "timeout" and "jug" in asked
    plan = run.solve().plan
    assert {a.args for a in plan} == {("jug", "high")} | ({("cup", "high")} if not committed else set())


def test_goal_by_goal_keeps_the_whole_limit_and_not_that_of_a_part():
    asked = []

    def slowish(context, thing):
        asked.append(thing)
        time.sleep(0.7)  # more than a first look at one goal may take, here 0.1 s, and being patient with it
        yield "high"

    solution = solve(shelf(slowish), timeout=5.0, strategy="serialized")
    assert solution.solved and asked == ["cup", "jug"]


def test_the_limit_of_whoever_asks_is_theirs():
    with pytest.raises(TimeUp, match="sampler of stream 'spots' went on past"), ended_at(clock.now() + 0.2):
        solve(shelf(sleeping), timeout=5.0)


def test_another_thread_waits_for_its_sampler():
    def patient(context, thing):
        time.sleep(1.0)
        yield "low"

    solutions = []
    thread = threading.Thread(target=lambda: solutions.append(solve(shelf(patient), timeout=0.2)))
    thread.start()
    thread.join()
    assert solutions[0].status == "timeout"
