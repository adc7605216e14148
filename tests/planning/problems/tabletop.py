"""Discs on a table, with a hand that reaches everywhere from above: the tabletop domain's form without its geometry.

Grasps are directions, a handling sweeps the hand's two fingers through the plane, and motions always succeed.
"""

import math
from collections.abc import Iterator
from typing import Any

from tamp.planning import Problem

DOMAIN = """
(define (domain discs)
  (:requirements :strips :equality :derived-predicates)
  (:predicates
    (Movable ?o) (Placeable ?o ?s) (Stackable ?o ?s) (Grasp ?o ?g) (Placement ?o ?p) (Conf ?q)
    (OnTable ?o ?p) (InRegion ?o ?p ?s) (RestsOn ?o ?p ?s ?ps) (Handling ?o ?p ?g ?a ?l ?h) (HandlingOf ?o ?h)
    (FreeMotion ?q1 ?q2 ?t) (HoldingMotion ?o ?g ?q1 ?q2 ?t)
    (CFreePlacements ?o ?p ?o2 ?p2) (CFreeHandling ?o ?h ?o2 ?p2)
    (AtPose ?o ?p) (AtGrasp ?o ?g) (HandEmpty) (AtConf ?q)
    (Covered ?o) (Unsupported ?o ?p) (UnsafePlacement ?o ?p) (UnsafeHandling ?o ?h) (On ?o ?s))
  (:action move-free
    :parameters (?q1 ?q2 ?t)
    :precondition (and (FreeMotion ?q1 ?q2 ?t) (AtConf ?q1) (HandEmpty))
    :effect (and (AtConf ?q2) (not (AtConf ?q1))))
  (:action move-holding
    :parameters (?o ?g ?q1 ?q2 ?t)
    :precondition (and (HoldingMotion ?o ?g ?q1 ?q2 ?t) (AtConf ?q1) (AtGrasp ?o ?g))
    :effect (and (AtConf ?q2) (not (AtConf ?q1))))
  (:action pick
    :parameters (?o ?p ?g ?a ?l ?h)
    :precondition (and (Handling ?o ?p ?g ?a ?l ?h) (OnTable ?o ?p) (AtPose ?o ?p) (HandEmpty) (AtConf ?a)
                       (not (Covered ?o)) (not (UnsafeHandling ?o ?h)))
    :effect (and (AtGrasp ?o ?g) (AtConf ?l) (not (AtPose ?o ?p)) (not (HandEmpty)) (not (AtConf ?a))))
  (:action unstack
    :parameters (?o ?p ?s ?ps ?g ?a ?l ?h)
    :precondition (and (Handling ?o ?p ?g ?a ?l ?h) (RestsOn ?o ?p ?s ?ps) (AtPose ?o ?p) (AtPose ?s ?ps) (HandEmpty)
                       (AtConf ?a) (not (Covered ?o)) (not (UnsafeHandling ?o ?h)))
    :effect (and (AtGrasp ?o ?g) (AtConf ?l) (not (AtPose ?o ?p)) (not (HandEmpty)) (not (AtConf ?a))))
  (:action place
    :parameters (?o ?p ?g ?a ?l ?h)
    :precondition (and (Handling ?o ?p ?g ?a ?l ?h) (OnTable ?o ?p) (AtGrasp ?o ?g) (AtConf ?l)
                       (not (UnsafePlacement ?o ?p)) (not (UnsafeHandling ?o ?h)))
    :effect (and (AtPose ?o ?p) (HandEmpty) (AtConf ?a) (not (AtGrasp ?o ?g)) (not (AtConf ?l))))
  (:derived (Covered ?s)
    (exists (?o ?p ?ps) (and (RestsOn ?o ?p ?s ?ps) (AtPose ?o ?p) (AtPose ?s ?ps))))
  (:derived (UnsafePlacement ?o ?p)
    (exists (?o2 ?p2) (and (Placement ?o ?p) (Placement ?o2 ?p2) (not (= ?o ?o2))
                           (AtPose ?o2 ?p2) (not (CFreePlacements ?o ?p ?o2 ?p2)))))
  (:derived (UnsafeHandling ?o ?h)
    (exists (?o2 ?p2) (and (HandlingOf ?o ?h) (Placement ?o2 ?p2) (not (= ?o ?o2))
                           (AtPose ?o2 ?p2) (not (CFreeHandling ?o ?h ?o2 ?p2)))))
  (:derived (On ?o ?s) (exists (?p) (and (InRegion ?o ?p ?s) (AtPose ?o ?p)))))
"""

STREAMS = """
(define (stream discs)
  (:stream sample-grasp :inputs (?o) :domain (Movable ?o) :outputs (?g) :certified (Grasp ?o ?g))
  (:stream sample-placement
    :inputs (?o ?s) :domain (Placeable ?o ?s) :outputs (?p)
    :certified (and (Placement ?o ?p) (OnTable ?o ?p) (InRegion ?o ?p ?s)))
  (:stream inverse-kinematics
    :inputs (?o ?p ?g) :domain (and (Placement ?o ?p) (Grasp ?o ?g)) :outputs (?a ?l ?h)
    :certified (and (Conf ?a) (Conf ?l) (HandlingOf ?o ?h) (Handling ?o ?p ?g ?a ?l ?h)))
  (:stream plan-free-motion
    :inputs (?q1 ?q2) :domain (and (Conf ?q1) (Conf ?q2)) :fluents (AtPose) :outputs (?t)
    :certified (FreeMotion ?q1 ?q2 ?t))
  (:stream plan-holding-motion
    :inputs (?o ?g ?q1 ?q2) :domain (and (Grasp ?o ?g) (Conf ?q1) (Conf ?q2)) :fluents (AtPose) :outputs (?t)
    :certified (HoldingMotion ?o ?g ?q1 ?q2 ?t))
  (:stream test-cfree-placements
    :inputs (?o ?p ?o2 ?p2) :domain (and (Placement ?o ?p) (Placement ?o2 ?p2))
    :certified (CFreePlacements ?o ?p ?o2 ?p2))
  (:stream test-cfree-handling
    :inputs (?o ?h ?o2 ?p2) :domain (and (HandlingOf ?o ?h) (Placement ?o2 ?p2))
    :certified (CFreeHandling ?o ?h ?o2 ?p2)))
"""

Point = tuple[float, float]
RADIUS = 0.04
FINGERS = 0.065
"""Distance of the fingers' centres from the object's [m]; each is a disc of 0.012."""

Region = tuple[Point, Point]


def sample_grasp(context: Any, obj: str) -> Iterator[float]:
    for angle in context.rng.permutation(16):
        yield float(angle) * math.pi / 16


def sample_placement(context: Any, obj: str, region: str) -> Iterator[Point | None]:
    lower, upper = context.scene[region]
    blind = 0
    while True:
        taken = [f[2] for f in context.bound if f[0] == "atpose" and f[1] != obj]
        points = context.rng.uniform(lower, upper, size=(30, 2))
        free = [p for p in points if all(math.dist(p, q) > 3.2 * RADIUS for q in taken)]
        blind += 1
        if free or blind % 4 == 0:
            x, y = (free or points)[0]
            yield float(x), float(y)
        else:
            context.fail("no room")
            yield None


def inverse_kinematics(context: Any, obj: str, pose: Point, grasp: float) -> Iterator[tuple[Any, Any, Any]]:
    if context.rng.random() < 0.8:
        yield ("approach", obj, pose, grasp), ("lift", obj, pose, grasp), (pose, grasp)
    else:
        context.fail("no inverse kinematics")


def motion(context: Any, *args: Any) -> Iterator[Any]:
    yield ("path", *args[-2:])


def cfree_placements(context: Any, o: str, p: Point, o2: str, p2: Point) -> bool:
    return math.dist(p, p2) > 2 * RADIUS


def cfree_handling(context: Any, o: str, h: tuple[Point, float], o2: str, p2: Point) -> bool:
    (x, y), angle = h
    fingers = [(x + s * FINGERS * math.cos(angle), y + s * FINGERS * math.sin(angle)) for s in (-1, 1)]
    return all(math.dist(f, p2) > RADIUS + 0.012 for f in fingers)


SAMPLERS = {
    "sample-grasp": sample_grasp,
    "sample-placement": sample_placement,
    "inverse-kinematics": inverse_kinematics,
    "plan-free-motion": motion,
    "plan-holding-motion": motion,
    "test-cfree-placements": cfree_placements,
    "test-cfree-handling": cfree_handling,
}


def _problem(
    starts: list[Point], regions: dict[str, Region], goal: list[Any], extra: list[Any], buffers: bool
) -> Problem:
    init: list[Any] = [("Conf", "home"), ("AtConf", "home"), ("HandEmpty",)]
    for i, start in enumerate(starts):
        init += [
            ("Movable", f"o{i}"),
            ("Placement", f"o{i}", start),
            ("OnTable", f"o{i}", start),
            ("AtPose", f"o{i}", start),
        ]
        init += [("Placeable", f"o{i}", "table")] if buffers else []
    return Problem(
        domain=DOMAIN, streams=STREAMS, samplers=SAMPLERS, init=init + extra,
        goal=("and", *goal, ("HandEmpty",), ("AtConf", "home")), scene=regions,
    )  # fmt: skip


def _grid(n: int, pitch: float, x0: float = -0.3) -> list[Point]:
    side = math.ceil(math.sqrt(n))
    return [(x0 + pitch * (i % side), -0.4 + pitch * (i // side)) for i in range(n)]


def _regions(n: int) -> dict[str, Region]:
    grow = math.sqrt(max(n, 10) / 10)
    return {"table": ((-1.2 * grow, -0.6), (-0.5, 1.2 * grow)), "goal": ((2.0, 0.0), (2.0 + 0.55 * grow, 0.6 * grow))}


def sort(n: int) -> Problem:
    """n objects apart; all must come into a region."""
    extra = [("Placeable", f"o{i}", "goal") for i in range(n)]
    return _problem(_grid(n, 0.16), _regions(n), [("On", f"o{i}", "goal") for i in range(n)], extra, True)


def clutter(n: int) -> Problem:
    """Objects so close that no finger fits between them; the one in the middle must come into a region."""
    middle = f"o{n // 2}"
    return _problem(_grid(n, 0.085), _regions(n), [("On", middle, "goal")], [("Placeable", middle, "goal")], True)


def permutation(n: int, shift: int = 1) -> Problem:
    """Each object's goal is where the next one stands: a cycle, which needs a buffer."""
    starts = _grid(n, 0.16)
    goal = [("AtPose", f"o{i}", starts[(i + shift) % n]) for i in range(n)]
    extra = [
        fact
        for i in range(n)
        for p in [starts[(i + shift) % n]]
        for fact in (("Placement", f"o{i}", p), ("OnTable", f"o{i}", p))
    ]
    return _problem(starts, _regions(n), goal, extra, True)
