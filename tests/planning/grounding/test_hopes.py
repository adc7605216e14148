"""What the search looks at: bounded quantifiers, and real values where hopes keep failing."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.pddlstream.features import cash
from benchmarks.pddlstream.small import filling
from tamp import clock
from tamp.planning import Problem, solve
from tamp.planning.algorithms.session import Session
from tamp.planning.grounding.task_builder import EVERYTHING
from tamp.planning.model.objects import Objects
from tamp.planning.model.schema import Schema
from tamp.planning.options import Options
from tamp.planning.run import PlanningRun
from tamp.planning.search.fast_downward import FastDownward

DOMAIN = """
(define (domain shelf)
  (:predicates (Block ?b) (Pose ?p) (Kin ?b ?p) (Free ?p ?p2) (At ?b ?p) (Held ?b))
  (:action place :parameters (?b ?p)
    :precondition (and (Held ?b) (Kin ?b ?p) (forall (?b2 ?p2) (imply (and (Pose ?p2) (At ?b2 ?p2)) (Free ?p ?p2))))
    :effect (and (At ?b ?p) (not (Held ?b)))))
"""
STREAMS = """
(define (stream shelf)
  (:stream sample-pose :inputs (?b) :domain (Block ?b) :outputs (?p) :certified (and (Pose ?p) (Kin ?b ?p)))
  (:stream test-free :inputs (?p ?p2) :domain (and (Pose ?p) (Pose ?p2)) :certified (Free ?p ?p2)))
"""
ROADMAP = """
(define (domain roadmap)
  (:predicates (Conf ?q) (Connected ?q1 ?q2) (AtConf ?q))
  (:action move :parameters (?q1 ?q2)
    :precondition (and (Connected ?q1 ?q2) (AtConf ?q1)) :effect (and (AtConf ?q2) (not (AtConf ?q1)))))
"""
ROADMAP_STREAMS = """
(define (stream roadmap)
  (:stream sample-conf :outputs (?q) :certified (Conf ?q))
  (:stream connect :inputs (?q1 ?q2) :domain (and (Conf ?q1) (Conf ?q2)) :certified (Connected ?q1 ?q2)))
"""


def test_forall_is_bounded_by_what_the_action_knows() -> None:
    problem = Problem(
        domain=DOMAIN,
        streams=STREAMS,
        samplers={"sample-pose": lambda context, block: iter(()), "test-free": lambda context, p, p2: True},
        init=[("Block", "a"), ("Held", "a")],
        goal=("Held", "a"),
    )
    schema = Schema(problem, Objects())
    [axiom] = [a for a in schema.axioms if str(a.head[0]).startswith("@some")]
    assert [[pattern[0] for pattern in bound] for bound in schema.bounds(axiom)] == [["kin"]]


@pytest.mark.parametrize("algorithm", ["adaptive", "incremental"])
def test_a_roadmap_of_short_edges_is_found_in_few_searches(algorithm: str) -> None:
    def sample_conf(context):
        while True:
            yield tuple(context.rng.uniform(size=2))

    problem = Problem(
        domain=ROADMAP,
        streams=ROADMAP_STREAMS,
        samplers={
            "sample-conf": sample_conf,
            "connect": lambda context, a, b: np.hypot(a[0] - b[0], a[1] - b[1]) < 0.35,
        },
        init=[("Conf", (0.0, 0.0)), ("Conf", (1.0, 1.0)), ("AtConf", (0.0, 0.0))],
        goal=("AtConf", (1.0, 1.0)),
    )
    solution = solve(problem, algorithm=algorithm, max_iterations=60, timeout=120.0)
    assert solution.status == "solved"


@pytest.mark.parametrize("algorithm", ["adaptive", "incremental"])
def test_streams_that_multiply_leave_the_search_its_turns(algorithm: str) -> None:
    """Each value may be followed by a pour of each ladle into each amount: hopes come by portions, not by powers."""
    solution = solve(filling(50.0), algorithm=algorithm, seed=0)
    assert solution.plan is not None, str(solution.report)
    assert 48.0 <= solution.cost < 60.0
    assert solution.plan[-1].name == "close"


@pytest.mark.parametrize("algorithm", ["adaptive", "binding"])
def test_actions_that_rest_on_hopes_are_hopes_as_well(algorithm: str) -> None:
    """A thousand sums brought 32,000 ways to draw money, at two machines each, before any was looked at."""
    solution = solve(cash(40.0), algorithm=algorithm, seed=0, timeout=30.0)
    assert solution.plan is not None, str(solution.report)
    assert solution.report.counts["operators"] < 6000


TANKS = """
(define (domain tanks)
  (:predicates (Tank ?t) (Number ?n) (Sum ?a ?b ?c) (Holds ?t ?n))
  (:action fill :parameters (?t ?before ?size ?after)
    :precondition (and (Tank ?t) (Sum ?before ?size ?after) (Holds ?t ?before))
    :effect (and (Holds ?t ?after) (not (Holds ?t ?before)))))
"""
TANK_STREAMS = """
(define (stream tanks)
  (:stream test-sum :inputs (?a ?b ?c) :domain (and (Number ?a) (Number ?b) (Number ?c)) :certified (Sum ?a ?b ?c)))
"""


@pytest.mark.parametrize("algorithm", ["adaptive", "focused"])
@pytest.mark.parametrize("mostly", [False, True])
def test_a_test_is_asked_of_all_its_many_inputs_where_it_mostly_says_no(algorithm: str, mostly: bool) -> None:
    problem = Problem(
        domain=TANKS,
        streams=TANK_STREAMS,
        samplers={"test-sum": lambda context, a, b, c: (a + b == c) != mostly},
        init=[*(("Number", n) for n in range(9)), ("Holds", "t", 0), ("Tank", "t")],
        goal=("Holds", "t", 8),
    )
    solution = solve(problem, algorithm=algorithm, timeout=20.0)
    assert solution.status == "solved"
    [calls] = [stream.calls for stream in solution.report.streams if stream.name == "test-sum"]
    assert calls < 60 if mostly else calls == 9**3
    # Of what was refuted before the tank was known there is no operator; each hope was one.
    assert solution.report.counts["operators"] < (1000 if mostly else 250)


STORED = """
(define (domain stored)
  (:predicates (Thing ?x) (Spot ?p) (Fits ?x ?p) (At ?x ?p) (Stored ?x))
  (:action put :parameters (?x ?p) :precondition (and (Thing ?x) (Spot ?p)) :effect (At ?x ?p))
  (:derived (Stored ?x) (exists (?p) (and (Fits ?x ?p) (At ?x ?p)))))
"""
STORED_STREAMS = """
(define (stream stored)
  (:stream test-fits :inputs (?x ?p) :domain (and (Thing ?x) (Spot ?p)) :certified (Fits ?x ?p)))
"""


@pytest.mark.parametrize("free", [False, True])
def test_what_is_hoped_for_free_is_no_step_of_a_search(free: bool) -> None:
    """Where plans must be cheap no hope costs anything, and each was an action: all sets of them were looked at."""
    samplers = {"test-fits": lambda context, thing, spot: spot == 3}
    init = [("Thing", "a"), *(("Spot", n) for n in range(5))]
    problem = Problem(STORED, STORED_STREAMS, samplers, init, ("Stored", "a"))
    session = Session(problem, Options(), FastDownward(), False, clock.now())
    session.begin()
    if free:
        session.costs.prefer_cheap(10.0)
    task = session.symbolic.task({}, EVERYTHING)
    assert task.solvable
    assert sum(op.source is None for op in task.operators) == (0 if free else 5)


IDLE = """
(define (domain idle)
  (:predicates (Spot ?p) (Guard ?g) (Sees ?g ?p) (At ?p) (Watched ?p))
  (:action go
    :parameters (?p ?p2) :precondition (and (Spot ?p) (Spot ?p2) (At ?p)) :effect (and (At ?p2) (not (At ?p))))
  (:derived (Watched ?p) (exists (?g) (and (Guard ?g) (Spot ?p) (Sees ?g ?p)))))
"""
IDLE_STREAMS = """
(define (stream idle)
  (:predicate (Sees ?g ?p) (and (Guard ?g) (Spot ?p))))
"""


def test_nothing_is_grounded_or_asked_for_an_axiom_that_nothing_asks_for() -> None:
    """All were asked who sees whom, 324 times, though no action minds; the next question may mind."""
    samplers = {"sees": lambda context, guard, spot: (guard, spot) == (7, 17)}
    init = [("At", 0), *(("Spot", n) for n in range(18)), *(("Guard", n) for n in range(18))]
    run = PlanningRun(Problem(IDLE, IDLE_STREAMS, samplers, init, ("At", 17)))
    solution = run.solve()
    assert solution.status == "solved"
    assert sum(stream.calls for stream in solution.report.streams) == 0
    assert run.solve(("Watched", 17)).status == "solved"
