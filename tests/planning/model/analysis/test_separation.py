from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from tamp.planning import Certified, Problem, solve
from tamp.planning.run import PlanningRun
from tests.planning.test_problems import ALGORITHMS, check

DOMAIN = """
(define (domain desk)
  (:predicates (robot ?r) (cup ?c) (place ?x ?p) (way ?r ?p ?t ?p2) (reach ?r ?p ?c ?p2) (at ?x ?p) (held ?c) (free ?r)
               (on ?c ?p) (mobile ?x))
  (:action move :parameters (?r ?p ?t ?p2) :precondition (and (way ?r ?p ?t ?p2) (at ?r ?p))
    :effect (and (at ?r ?p2) (not (at ?r ?p))))
  (:action pick :parameters (?r ?p ?c ?p2) :precondition (and (reach ?r ?p ?c ?p2) (at ?r ?p) (at ?c ?p2) (free ?r))
    :effect (and (held ?c) (not (at ?c ?p2)) (not (free ?r))))
  (:action put :parameters (?r ?p ?c ?p2) :precondition (and (reach ?r ?p ?c ?p2) (at ?r ?p) (held ?c))
    :effect (and (at ?c ?p2) (free ?r) (not (held ?c))))
  (:derived (on ?c ?p) (and (cup ?c) (at ?c ?p))))
"""

STREAMS = """
(define (stream desk)
  (:stream stand :inputs (?r ?c ?p2) :domain (and (robot ?r) (cup ?c) (place ?c ?p2)) :outputs (?p)
    :certified (and (place ?r ?p) (reach ?r ?p ?c ?p2)))
  (:stream find-way :inputs (?r ?p ?p2) :domain (and (robot ?r) (place ?r ?p) (place ?r ?p2)) :fluents (at)
    :outputs (?t) :certified (way ?r ?p ?t ?p2)))
"""


def desk(told: list[Any], robots: tuple[str, ...] = ("r",), more: tuple[Any, ...] = (), wild: bool = False) -> Problem:
    """Where robots are and where cups are is one predicate; ways depend on it."""

    def stand(context: Any, robot: str, cup: str, place: float) -> Iterator[Any]:
        yield Certified(place + 0.5, (("robot", cup),)) if wild else place + 0.5

    def find_way(context: Any, robot: str, start: float, end: float) -> Iterator[tuple[float, float]]:
        told.append(context.fluents)
        yield start, end

    init: list[Any] = [*more]
    for robot in robots:
        init += [("robot", robot), ("at", robot, 9.0), ("place", robot, 9.0), ("free", robot)]
    for i, cup in enumerate(("a", "b")):
        init += [("cup", cup), ("place", cup, float(i)), ("at", cup, float(i)), ("place", cup, 5.0)]
    goal = ("and", ("on", "a", 5.0), *(("at", robot, 9.0) for robot in robots))
    return Problem(
        domain=DOMAIN, streams=STREAMS, samplers={"stand": stand, "find-way": find_way}, init=init, goal=goal
    )


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("robots", [("r",), ("r", "s")])
def test_moves_are_left_out_of_the_search_where_things_are_said_to_be_at_places_too(algorithm, robots):
    told: list[Any] = []
    problem = desk(told, robots)
    solution = solve(problem, algorithm=algorithm)
    check(problem, solution)
    assert {tuple(fact[0] for fact in facts) for facts in told} <= {("at",) * n for n in (2, 3, 4)}
    assert any(("at", "b", 1.0) in facts for facts in told)
    run = PlanningRun(problem)
    run.solve()
    schema = run._session.schema  # nobody else can tell
    assert schema.part is not None and schema.part.fluent == "at" and schema.part.position == 1


def test_questions_go_on_from_a_committed_state():
    run = PlanningRun(desk([]))
    assert run.solve().solved
    run.commit()
    second = run.solve(("and", ("at", "b", 5.0), ("at", "r", 9.0)))
    assert [action.name for action in second.plan] == ["move", "pick", "move", "put", "move"]
    third = run.solve(("and", ("at", "a", 5.0), ("at", "r", 9.0)))
    assert third.plan == ()


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_what_may_be_both_is_not_told_apart(algorithm):
    problem = desk([], more=(("cup", "r"),))
    solution = solve(problem, algorithm=algorithm)
    check(problem, solution)
    run = PlanningRun(problem)
    run.solve()
    assert run._session.schema.part is None


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_streams_that_certify_more_than_they_promise(algorithm):
    problem = desk([], wild=True)
    check(problem, solve(problem, algorithm=algorithm))
