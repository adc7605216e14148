"""A narrow ledge for two things: each is held some way, and reached from somewhere, and neither helps a bad place."""

from collections.abc import Iterator
from typing import Any

from tamp.planning import Problem

LEDGE = """
(define (domain ledge)
  (:requirements :strips :equality)
  (:predicates (Thing ?o) (Pose ?o ?p) (On ?o ?p) (Hold ?o ?h) (Reach ?o ?p ?h ?t) (Clear ?t ?o ?p)
               (AtPose ?o ?p) (Held ?o ?h) (Empty) (Placed ?o))
  (:action pick
    :parameters (?o ?p ?h ?t)
    :precondition (and (Reach ?o ?p ?h ?t) (AtPose ?o ?p) (Empty))
    :effect (and (Held ?o ?h) (not (AtPose ?o ?p)) (not (Empty))))
  (:action place
    :parameters (?o ?p ?h ?t)
    :precondition (and (Reach ?o ?p ?h ?t) (Held ?o ?h)
                       (forall (?o2 ?p2) (imply (and (AtPose ?o2 ?p2) (not (= ?o ?o2))) (Clear ?t ?o2 ?p2))))
    :effect (and (AtPose ?o ?p) (Empty) (not (Held ?o ?h))))
  (:derived (Placed ?o) (exists (?p) (and (On ?o ?p) (AtPose ?o ?p)))))
"""

LEDGE_STREAMS = """
(define (stream ledge)
  (:stream sample-place :inputs (?o) :domain (Thing ?o) :outputs (?p) :certified (and (Pose ?o ?p) (On ?o ?p)))
  (:stream sample-hold :inputs (?o) :domain (Thing ?o) :outputs (?h) :certified (Hold ?o ?h))
  (:stream find-reach
    :inputs (?o ?p ?h) :domain (and (Pose ?o ?p) (Hold ?o ?h)) :outputs (?t)
    :certified (and (Way ?t) (Reach ?o ?p ?h ?t)))
  (:stream test-clear :inputs (?t ?o ?p) :domain (and (Way ?t) (Pose ?o ?p)) :certified (Clear ?t ?o ?p)))
"""


def ledge(length: float) -> Problem:
    """Two things that need 1 of a length of places each, from which one is reached in any number of ways."""

    def sample_place(context: Any, thing: str) -> Iterator[float]:
        while True:
            yield context.rng.uniform(0.0, length)

    def sample_hold(context: Any, thing: str) -> Iterator[float]:
        while True:
            yield context.rng.uniform(0.0, 1.0)

    def find_reach(context: Any, thing: str, place: float, hold: float) -> Iterator[tuple[str, float, float]]:
        while True:
            yield thing, place, context.rng.uniform(0.0, 1.0)

    init: list[Any] = [("Empty",)]
    for thing, place in (("cup", -5.0), ("jar", -8.0)):
        init += [("Thing", thing), ("Pose", thing, place), ("AtPose", thing, place)]
    return Problem(
        domain=LEDGE,
        streams=LEDGE_STREAMS,
        samplers={
            "sample-place": sample_place,
            "sample-hold": sample_hold,
            "find-reach": find_reach,
            "test-clear": lambda context, way, thing, place: abs(way[1] - place) > 1.0,
        },
        init=init,
        goal=("and", ("Placed", "cup"), ("Placed", "jar")),
    )
