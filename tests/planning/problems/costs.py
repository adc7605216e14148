"""Action costs: numbers, functions given in the initial facts, and functions computed by a sampler."""

from collections.abc import Iterator
from typing import Any

from tamp.planning import Problem

DOMAIN = """
(define (domain delivery)
  (:requirements :strips :action-costs)
  (:predicates (Place ?p) (Road ?p ?q) (At ?p) (Stop ?p) (Leg ?p ?s ?q) (Delivered))
  (:functions (total-cost) (Length ?p ?q) (Toll ?p))
  (:action drive
    :parameters (?p ?q)
    :precondition (and (Road ?p ?q) (At ?p))
    :effect (and (At ?q) (not (At ?p)) (increase (total-cost) (Length ?p ?q)) (increase (total-cost) (Toll ?q))))
  (:action fly
    :parameters (?p ?s ?q)
    :precondition (and (Leg ?p ?s ?q) (At ?p))
    :effect (and (At ?q) (not (At ?p)) (increase (total-cost) 25)))
  (:action deliver
    :parameters (?p)
    :precondition (and (Stop ?p) (At ?p))
    :effect (Delivered)))
"""

STREAMS = """
(define (stream delivery)
  (:function (Length ?p ?q) (Road ?p ?q))
  (:stream find-flight :inputs (?p ?q) :domain (and (Place ?p) (Stop ?q)) :outputs (?s) :certified (Leg ?p ?s ?q)))
"""

ROADS = ((0, 1), (1, 2), (2, 9), (0, 3), (3, 9))
TOLLS = {3: 50.0}


def length(context: Any, start: int, end: int) -> float:
    return abs(start - end) + 0.25


def find_flight(context: Any, start: int, end: int) -> Iterator[str]:
    yield f"flight {start}-{end}"


def delivery() -> Problem:
    """From 0 to 9: the short way of 2 roads has a toll of 50, that of 3 roads costs 9.75, a flight 25."""
    init: list[Any] = [("At", 0), ("Stop", 9), *(("Road", a, b) for a, b in ROADS)]
    init += [("Place", place) for place in (0, 1, 2, 3, 9)]
    init += [("=", ("Toll", place), TOLLS.get(place, 0)) for place in (0, 1, 2, 3, 9)]
    return Problem(
        domain=DOMAIN,
        streams=STREAMS,
        samplers={"length": length, "find-flight": find_flight},
        init=init,
        goal=("Delivered",),
    )


BEST_COST = 9.75
