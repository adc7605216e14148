"""A thing that can be held in many ways, of which few lead past what stands beside it."""

from collections.abc import Iterator
from typing import Any

from tamp.planning import Problem

HANDFUL = """
(define (domain handful)
  (:requirements :strips :equality)
  (:predicates (Thing ?o) (Hold ?o ?h) (Way ?t) (Reach ?o ?h ?t) (Past ?t ?o) (Stands ?o) (Held ?o))
  (:action take
    :parameters (?o ?h ?t)
    :precondition (and (Reach ?o ?h ?t) (Stands ?o)
                       (forall (?o2) (imply (and (Stands ?o2) (not (= ?o ?o2))) (Past ?t ?o2))))
    :effect (and (Held ?o) (not (Stands ?o)))))
"""

HANDFUL_STREAMS = """
(define (stream handful)
  (:stream sample-hold :inputs (?o) :domain (Thing ?o) :outputs (?h) :certified (Hold ?o ?h))
  (:stream find-way :inputs (?o ?h) :domain (Hold ?o ?h) :outputs (?t) :certified (and (Way ?t) (Reach ?o ?h ?t)))
  (:stream test-past :inputs (?t ?o) :domain (and (Way ?t) (Thing ?o)) :certified (Past ?t ?o)))
"""


def handful(ways: int, past: int) -> Problem:
    """A cup that is to be taken from beside a jar, which the first `past` of so many ways do not lead past."""

    def sample_hold(context: Any, thing: str) -> Iterator[tuple[str, int]]:
        yield from ((thing, number) for number in range(ways if thing == "cup" else 0))

    def find_way(context: Any, thing: str, hold: tuple[str, int]) -> Iterator[tuple[str, int]]:
        yield "way", hold[1]

    init: list[Any] = [fact for thing in ("cup", "jar") for fact in (("Thing", thing), ("Stands", thing))]
    return Problem(
        domain=HANDFUL,
        streams=HANDFUL_STREAMS,
        samplers={
            "sample-hold": sample_hold,
            "find-way": find_way,
            "test-past": lambda context, way, thing: way[1] >= past,
        },
        init=init,
        goal=("Held", "cup"),
    )
