"""Predicates that a stream alone names are likely misspelt: warned of once, with what was likely meant."""

from __future__ import annotations

import warnings
from dataclasses import replace

import pytest

from tamp.errors import DomainWarning, TampError
from tamp.planning import PlanningRun, Problem, solve

DOMAIN = """
(define (domain shelf)
  (:predicates (thing ?o) (spot ?p) (near ?o ?p) (declared ?p) (at ?o ?p))
  (:action put :parameters (?o ?p) :precondition (near ?o ?p) :effect (at ?o ?p)))
"""
STREAMS = """
(define (stream shelf)
  (:stream spots :inputs (?o) :domain (and (thing ?o) (kept ?o)) :outputs (?p)
    :certified (and (spot ?p) (declared ?p) (seen ?p) (asked ?p) (wanted ?p)))
  (:stream is-near :inputs (?o ?p) :domain (and (thing ?o) (spot ?p) (seen ?p))
    :fluents (asked) :certified (near ?o ?p))
  (:function (height ?p) (spot ?p))
  (:rule :inputs (?p) :domain (spot ?p) :certified (declared ?p)))
"""


def shelf(old="", new="", soft_goals=()):
    samplers = {
        "spots": lambda context, thing: iter([1]),
        "is-near": lambda context, thing, spot: iter([()]),
        "height": lambda context, spot: 1.0,
    }
    assert old in STREAMS
    return Problem(
        domain=DOMAIN,
        streams=STREAMS.replace(old, new, 1),
        samplers=samplers,
        init=[("thing", "cup"), ("kept", "cup")],
        goal=("exists", ("?p",), ("and", ("at", "cup", "?p"), ("wanted", "?p"))),
        soft_goals=soft_goals,
    )


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "(near ?o ?p)",
            "(nere ?o ?p)",
            r"^stream:6:\d+: stream 'is-near' certifies 'nere', which nothing reads; .*'near'",
        ),
        (
            "(thing ?o) (kept",
            "(thng ?o) (kept",
            r"^stream:3:\d+: the :domain of stream 'spots' names 'thng', .*'thing'",
        ),
        ("(spot ?p))\n  (:rule", "(spott ?p))\n  (:rule", r"the :domain of function 'height' names 'spott', .*'spot'"),
        (":certified (declared ?p)", ":certified (declred ?p)", r"the rule certifies 'declred', .*'declared'"),
    ],
)
def test_misspelt_predicates_are_warned_of_once(old, new, message):
    problem = shelf(old, new)
    with pytest.warns(DomainWarning, match=message) as caught:
        run = PlanningRun(problem)
        run.solve(("thing", "cup"), budget=2.0)
        run.solve(("spot", "cup"), budget=0.1)
    assert len(caught) == 1


@pytest.mark.parametrize("strategy", ["all-at-once", "serialized"])
def test_what_is_read_or_given_anywhere_is_no_slip(strategy):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert solve(shelf(), strategy=strategy, timeout=5.0).solved


def test_what_a_soft_goal_reads_is_no_slip():
    goals = ((("exists", ("?p",), ("extra", "?p")), 2.0),)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        solve(shelf("(wanted ?p)", "(wanted ?p) (extra ?p)", goals), strategy="net-benefit", timeout=2.0)


def test_a_wild_stream_may_give_what_no_file_names():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        PlanningRun(
            shelf(
                "(:stream is-near :inputs (?o ?p) :domain (and",
                "(:wild-stream is-near :inputs (?o ?p) :domain (and (odd ?o)",
            )
        )


def test_a_fact_at_the_start_that_is_nearly_one_that_is_read_is_warned_of():
    problem = shelf()
    with pytest.warns(DomainWarning, match="^init has 'thng', which nothing reads; did you mean 'thing'"):
        solve(replace(problem, init=[*problem.init, ("Thng", "cup")]), timeout=5.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert solve(replace(problem, init=[*problem.init, ("Comment", "cup")]), timeout=5.0).solved


@pytest.mark.parametrize(
    ("field", "given", "said"),
    [
        ("init", None, "init: expected a list of facts such as .* found None"),
        ("init", "thing", "init: expected a list of facts such as .* found 'thing'"),
        ("samplers", None, "samplers: expected a mapping from streams' names, found None"),
        ("info", ["spots"], r"info: expected a mapping from streams' names, found \['spots'\]"),
        ("info", {"spots": "fresh"}, "info for stream 'spots': expected a StreamInfo, found 'fresh'"),
    ],
)
def test_a_problem_is_made_of_facts_and_mappings(field, given, said):
    with pytest.raises(TampError, match=said):
        replace(shelf(), **{field: given})
