"""Negated streams: as `not` of a test in axioms and preconditions, and as `not` of a :predicate."""

from collections.abc import Iterator
from typing import Any

from tamp.planning import Problem

DOMAIN = """
(define (domain parking)
  (:requirements :strips :negative-preconditions :derived-predicates)
  (:predicates (Car ?c) (Spot ?c ?s) (Free ?s ?s2) (Steep ?s) (Narrow ?c ?s) (At ?c ?s) (Waiting ?c) (Crowded ?s)
               (Chained ?c) (Parked ?c))
  (:action park
    :parameters (?c ?s)
    :precondition (and (Waiting ?c) (Spot ?c ?s) (not (Steep ?s)) (not (Narrow ?c ?s)) (not (Crowded ?s)))
    :effect (and (At ?c ?s) (Parked ?c) (not (Waiting ?c))))
  (:action chain
    :parameters (?c ?s)
    :precondition (and (At ?c ?s) (Steep ?s))
    :effect (Chained ?c))
  (:derived (Crowded ?s)
    (exists (?c2 ?s2) (and (Spot ?c2 ?s2) (At ?c2 ?s2) (not (Free ?s ?s2))))))
"""

STREAMS = """
(define (stream parking)
  (:stream sample-spot :inputs (?c) :domain (Car ?c) :outputs (?s) :certified (and (Spot ?c ?s) (Place ?s)))
  (:stream test-free :inputs (?s ?s2) :domain (and (Place ?s) (Place ?s2)) :certified (Free ?s ?s2))
  (:predicate (Steep ?s) (Place ?s))
  (:predicate (Narrow ?c ?s) (and (Car ?c) (Place ?s))))
"""


def sample_spot(context: Any, car: str) -> Iterator[float]:
    while True:
        yield float(context.rng.uniform(0, context.scene))


def free(spot: float, other: float) -> bool:
    return abs(spot - other) > 1.0


def steep(spot: float) -> bool:
    return int(spot) % 3 == 0


def narrow(car: str, spot: float) -> bool:
    return car.startswith("truck") and spot < 4.0


SAMPLERS = {
    "sample-spot": sample_spot,
    "test-free": lambda context, spot, other: free(spot, other),
    "steep": lambda context, spot: steep(spot),
    "narrow": lambda context, car, spot: narrow(car, spot),
}


def parking(n: int) -> Problem:
    """n cars along a street of 6n + 6 metres, in no steep and no narrow spot, with a metre between any two."""
    cars = [f"truck{i}" if i % 2 else f"car{i}" for i in range(n)]
    init = [fact for car in cars for fact in (("Car", car), ("Waiting", car))]
    goal = ("and", *(("Parked", car) for car in cars))
    return Problem(domain=DOMAIN, streams=STREAMS, samplers=SAMPLERS, init=init, goal=goal, scene=6.0 * n + 6.0)


TESTED = """
(define (domain inspection)
  (:requirements :strips :negative-preconditions)
  (:predicates (Part ?p) (Sound ?p) (Shelf ?p) (Scrap ?p))
  (:action keep
    :parameters (?p) :precondition (and (Part ?p) (Sound ?p) (not (Scrap ?p))) :effect (Shelf ?p))
  (:action discard
    :parameters (?p) :precondition (and (Part ?p) (not (Sound ?p)) (not (Shelf ?p))) :effect (Scrap ?p)))
"""

TESTED_STREAMS = """
(define (stream inspection)
  (:predicate (Sound ?p) (Part ?p)))
"""


def sound(part: int) -> bool:
    return part % 3 != 0


def inspection(n: int) -> Problem:
    """Each of n parts must go where it belongs, which only its test can tell: on the shelf, or to the scrap."""
    init = [("Part", i) for i in range(n)]
    goal = ("forall", ("?p",), ("or", ("not", ("Part", "?p")), ("Shelf", "?p"), ("Scrap", "?p")))
    samplers = {"sound": lambda context, part: sound(part)}
    return Problem(domain=TESTED, streams=TESTED_STREAMS, samplers=samplers, init=init, goal=goal)
