"""Problems without a solution: some are proven to have none, others can only run out of time."""

from collections.abc import Iterator
from typing import Any

from tamp.planning import Problem

DOMAIN = """
(define (domain reach)
  (:requirements :strips)
  (:predicates (Thing ?x) (Grasp ?x ?g) (Kin ?x ?g ?q) (Held ?x) (HandEmpty))
  (:action take
    :parameters (?x ?g ?q)
    :precondition (and (Kin ?x ?g ?q) (HandEmpty))
    :effect (and (Held ?x) (not (HandEmpty)))))
"""

STREAMS = """
(define (stream reach)
  (:stream sample-grasp :inputs (?x) :domain (Thing ?x) :outputs (?g) :certified (Grasp ?x ?g))
  (:stream inverse-kinematics
    :inputs (?x ?g) :domain (Grasp ?x ?g) :outputs (?q) :certified (Kin ?x ?g ?q)))
"""


def three_grasps(context: Any, thing: str) -> Iterator[int]:
    yield from range(3)


def endless_grasps(context: Any, thing: str) -> Iterator[float]:
    while True:
        yield float(context.rng.random())


def out_of_reach(context: Any, thing: str, grasp: float) -> Iterator[Any]:
    yield from ()


def in_reach(context: Any, thing: str, grasp: float) -> Iterator[Any]:
    yield ("q", grasp)


def never_yet(context: Any, thing: str) -> Iterator[None]:
    while True:
        yield None


def _reach(grasps: Any, kinematics: Any, goal: Any) -> Problem:
    samplers = {"sample-grasp": grasps, "inverse-kinematics": kinematics}
    init = [("Thing", "cup"), ("Thing", "jug"), ("HandEmpty",)]
    return Problem(domain=DOMAIN, streams=STREAMS, samplers=samplers, init=init, goal=goal)


def exhausted() -> Problem:
    """Three grasps, none of them reachable: infeasible once all are tried."""
    return _reach(three_grasps, out_of_reach, ("Held", "cup"))


def impossible_goal() -> Problem:
    """Each thing can be held, but one hand cannot hold two: infeasible with finite streams."""
    return _reach(three_grasps, in_reach, ("and", ("Held", "cup"), ("Held", "jug")))


def unknown_thing() -> Problem:
    """Nobody says that the ghost is a thing: infeasible without a single sample."""
    return _reach(three_grasps, in_reach, ("Held", "ghost"))


def never_undone() -> Problem:
    """The jug shall be no thing any more, which no action can bring about: infeasible without a single sample."""
    return _reach(endless_grasps, in_reach, ("and", ("Held", "cup"), ("not", ("Thing", "jug"))))


def never_undone_though_told() -> Problem:
    """The same of a fact that a test with fluents is told."""
    domain = """(define (domain doors) (:requirements :adl) (:predicates (Door ?d) (Locked ?d) (Passed ?d) (Free ?d))
                  (:action pass :parameters (?d) :precondition (Free ?d) :effect (Passed ?d)))"""
    streams = """(define (stream doors)
                  (:stream test-free :inputs (?d) :domain (Door ?d) :fluents (Locked Passed) :certified (Free ?d)))"""
    samplers = {"test-free": lambda context, door: True}
    init = [("Door", "front"), ("Locked", "front")]
    return Problem(domain, streams, samplers, init, ("and", ("Passed", "front"), ("not", ("Locked", "front"))))


def contradicting() -> Problem:
    """The cup shall be held and not held: infeasible, whatever streams without an end may give."""
    return _reach(endless_grasps, in_reach, ("and", ("Held", "cup"), ("not", ("Held", "cup"))))


def endless() -> Problem:
    """Ever new grasps, none of them reachable: nothing is proven, time runs out."""
    return _reach(endless_grasps, out_of_reach, ("Held", "cup"))


def undecided() -> Problem:
    """A sampler that always asks to be asked again: nothing is proven, time runs out."""
    return _reach(never_yet, in_reach, ("Held", "cup"))


def no_streams() -> Problem:
    """A switch that must be on and off: infeasible, and the planner has no streams to wait for."""
    domain = """(define (domain switch) (:requirements :strips) (:predicates (on) (used))
                  (:action flip :precondition (not (used)) :effect (and (on) (used))))"""
    return Problem(domain=domain, init=[], goal=("and", ("on",), ("not", ("used",))))
