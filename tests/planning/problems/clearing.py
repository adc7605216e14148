"""A robot on a line lifts what bars its way: where paths are free is known only once they are asked for."""

from collections.abc import Iterator
from typing import Any

from tamp.planning import Problem

DOMAIN = """
(define (domain clearing)
  (:requirements :strips)
  (:predicates (Stop ?q) (Path ?q1 ?q2 ?t) (Way ?t) (Pose ?b ?p) (Beside ?q ?b ?p) (Free ?t ?p) (At ?q) (On ?b ?p)
               (Barred ?t))
  (:action go
    :parameters (?q1 ?q2 ?t)
    :precondition (and (Path ?q1 ?q2 ?t) (At ?q1) (not (Barred ?t)))
    :effect (and (At ?q2) (not (At ?q1))))
  (:action lift
    :parameters (?q ?b ?p) :precondition (and (Beside ?q ?b ?p) (At ?q) (On ?b ?p)) :effect (not (On ?b ?p)))
  (:derived (Barred ?t) (exists (?b ?p) (and (Way ?t) (Pose ?b ?p) (not (Free ?t ?p)) (On ?b ?p)))))
"""

STREAMS = """
(define (stream clearing)
  (:stream find-stop
    :inputs (?b ?p) :domain (Pose ?b ?p) :outputs (?q) :certified (and (Beside ?q ?b ?p) (Stop ?q)))
  (:stream find-path
    :inputs (?q1 ?q2) :domain (and (Stop ?q1) (Stop ?q2)) :outputs (?t) :certified (and (Path ?q1 ?q2 ?t) (Way ?t)))
  (:stream test-free :inputs (?t ?p) :domain (and (Way ?t) (Spot ?p)) :certified (Free ?t ?p)))
"""


def row(n: int) -> Problem:
    """n things between the robot and its goal, each of which can be lifted from either side of it."""

    def find_stop(context: Any, thing: str, pose: float) -> Iterator[tuple[str, float]]:
        yield from (("stop", pose - 1.0), ("stop", pose + 1.0))

    def find_path(context: Any, start: tuple[str, float], end: tuple[str, float]) -> Iterator[tuple[str, float, float]]:
        yield ("path", start[1], end[1])

    def free(context: Any, path: tuple[str, float, float], pose: float) -> bool:
        return not min(path[1:]) - 0.5 <= pose <= max(path[1:]) + 0.5

    start, goal = ("stop", 0.0), ("stop", 2.0 * n + 4.0)
    init: list[Any] = [("Stop", start), ("Stop", goal), ("At", start)]
    for i in range(n):
        pose = 2.0 * i + 2.0
        init += [("Spot", pose), ("Pose", f"b{i}", pose), ("On", f"b{i}", pose)]
    samplers = {"find-stop": find_stop, "find-path": find_path, "test-free": free}
    return Problem(DOMAIN, STREAMS, samplers, init, ("At", goal))
