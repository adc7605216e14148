"""An oven with room for one thing at a time, which shows only in the ways that the hand would go to it."""

from collections.abc import Iterator
from typing import Any

from tamp.planning import Problem

OVEN = """
(define (domain oven)
  (:requirements :strips :equality)
  (:predicates (Thing ?o) (Pose ?o ?p) (Supported ?o ?p ?r) (Reach ?o ?p ?t) (Clear ?t ?o ?p) (Oven ?r)
               (AtPose ?o ?p) (Held ?o) (Empty) (Baked ?o) (In ?o ?r))
  (:action pick
    :parameters (?o ?p ?t)
    :precondition (and (Reach ?o ?p ?t) (AtPose ?o ?p) (Empty)
                       (forall (?o2 ?p2) (imply (and (AtPose ?o2 ?p2) (not (= ?o ?o2))) (Clear ?t ?o2 ?p2))))
    :effect (and (Held ?o) (not (AtPose ?o ?p)) (not (Empty))))
  (:action place
    :parameters (?o ?p ?t)
    :precondition (and (Reach ?o ?p ?t) (Held ?o)
                       (forall (?o2 ?p2) (imply (and (AtPose ?o2 ?p2) (not (= ?o ?o2))) (Clear ?t ?o2 ?p2))))
    :effect (and (AtPose ?o ?p) (Empty) (not (Held ?o))))
  (:action bake
    :parameters (?o ?r)
    :precondition (and (Oven ?r) (In ?o ?r))
    :effect (Baked ?o))
  (:derived (In ?o ?r) (exists (?p) (and (Supported ?o ?p ?r) (AtPose ?o ?p)))))
"""

OVEN_STREAMS = """
(define (stream oven)
  (:stream sample-pose
    :inputs (?o ?r) :domain (Fits ?o ?r) :outputs (?p) :certified (and (Pose ?o ?p) (Supported ?o ?p ?r)))
  (:stream find-reach :inputs (?o ?p) :domain (Pose ?o ?p) :outputs (?t) :certified (and (Way ?t) (Reach ?o ?p ?t)))
  (:stream test-clear :inputs (?t ?o ?p) :domain (and (Way ?t) (Pose ?o ?p)) :certified (Clear ?t ?o ?p)))
"""


def oven(things: int, width: float = 1.0) -> Problem:
    """Things of which the first is to be baked, and the others are to be in the oven in the end.

    `width`: how far apart places in the oven may be; from 1.2 on there is room for two things.
    """
    regions = {"table": (0.0, 20.0), "oven": (30.0, 30.0 + width)}

    def sample_pose(context: Any, thing: str, region: str) -> Iterator[float]:
        while True:
            yield context.rng.uniform(*regions[region])

    def find_reach(context: Any, thing: str, pose: float) -> Iterator[tuple[str, float, float]]:
        while True:
            yield thing, pose, context.rng.uniform(-0.1, 0.1)

    init: list[Any] = [("Empty",), ("Oven", "oven")]
    for i in range(things):
        thing, pose = f"thing {i}", 2.0 + 3.0 * i
        init += [("Thing", thing), ("Pose", thing, pose), ("AtPose", thing, pose)]
        init += [("Supported", thing, pose, "table"), *(("Fits", thing, region) for region in regions)]
    return Problem(
        domain=OVEN,
        streams=OVEN_STREAMS,
        samplers={
            "sample-pose": sample_pose,
            "find-reach": find_reach,
            "test-clear": lambda context, way, thing, pose: way[0] == thing or abs(way[1] - pose) > 1.2,
        },
        init=init,
        goal=("and", ("Baked", "thing 0"), *(("In", f"thing {i}", "oven") for i in range(1, things))),
    )
