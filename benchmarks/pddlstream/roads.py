"""Problems on graphs in PDDLStream's form: trucks on roads that tests close, and roadmaps that a wild stream brings."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from tamp.planning import Problem
from tamp.planning.pddlstream import WildOutput, from_fn, from_gen_fn, from_stream_map, from_test

ROADS = """
(define (domain roads)
  (:requirements :strips)
  (:predicates (Truck ?t) (Package ?p) (Road ?l1 ?l2) (Open ?l1 ?l2) (At ?x ?l) (In ?p ?t))
  (:functions (Length ?l1 ?l2))
  (:action drive
    :parameters (?t ?l1 ?l2) :precondition (and (Truck ?t) (Road ?l1 ?l2) (Open ?l1 ?l2) (At ?t ?l1))
    :effect (and (At ?t ?l2) (not (At ?t ?l1)) (increase (total-cost) (Length ?l1 ?l2))))
  (:action load
    :parameters (?p ?t ?l) :precondition (and (Truck ?t) (Package ?p) (At ?t ?l) (At ?p ?l))
    :effect (and (In ?p ?t) (not (At ?p ?l)) (increase (total-cost) 1)))
  (:action unload
    :parameters (?p ?t ?l) :precondition (and (Truck ?t) (Package ?p) (At ?t ?l) (In ?p ?t))
    :effect (and (At ?p ?l) (not (In ?p ?t)) (increase (total-cost) 1))))
"""

ROADS_STREAMS = """
(define (stream roads)
  (:stream test-open :inputs (?l1 ?l2) :domain (Road ?l1 ?l2) :certified (Open ?l1 ?l2))
  (:function (Length ?l1 ?l2) (Road ?l1 ?l2)))
"""


def logistics(places: int, packages: int, trucks: int, share: float = 0.7) -> Problem:
    """Packages are brought where they belong; about a `share` of the roads between near places is open."""
    rng = np.random.default_rng(0)
    points = rng.uniform(0.0, 1.0, (places, 2))
    lengths = np.linalg.norm(points[:, None] - points, axis=2)
    opened: dict[tuple[int, int], bool] = {}
    for i in range(places):
        for rank, j in enumerate(np.argsort(lengths[i])[1:5].tolist()):
            passable = rank == 0 or bool(rng.random() < share)
            opened.setdefault((i, j), passable)
            opened.setdefault((j, i), opened[i, j])
    reached = [0]
    for place in reached:  # grows while it is walked through
        reached += [j for (i, j), passable in opened.items() if passable and i == place and j not in reached]
    reached.sort()
    init: list[Any] = [("Road", i, j) for i, j in opened]
    for t in range(trucks):
        init += [("Truck", f"t{t}"), ("At", f"t{t}", reached[t % len(reached)])]
    goal: list[Any] = ["and"]
    for p in range(packages):
        start, end = rng.choice(reached, 2, replace=False).tolist()
        init += [("Package", f"p{p}"), ("At", f"p{p}", start)]
        goal += [("At", f"p{p}", end)]
    stream_map = {
        "test-open": from_test(lambda i, j: opened[i, j]),
        "length": lambda i, j: 1.0 + round(10.0 * float(lengths[i, j])),
    }
    return Problem(ROADS, ROADS_STREAMS, from_stream_map(stream_map), init, tuple(goal))


VISITS = """
(define (domain visits)
  (:requirements :strips)
  (:predicates (Conf ?q) (Region ?r) (Of ?q ?r) (Track ?t) (Line ?q1 ?t ?q2) (AtConf ?q) (Visited ?r))
  (:functions (Length ?t))
  (:action move
    :parameters (?q1 ?t ?q2) :precondition (and (Line ?q1 ?t ?q2) (AtConf ?q1))
    :effect (and (AtConf ?q2) (not (AtConf ?q1)) (increase (total-cost) (Length ?t))))
  (:action visit
    :parameters (?q ?r) :precondition (and (Of ?q ?r) (AtConf ?q))
    :effect (and (Visited ?r) (increase (total-cost) 1))))
"""

VISITS_STREAMS = """
(define (stream visits)
  (:function (Length ?t) (Track ?t))
  (:stream sample-region :inputs (?r) :domain (Region ?r) :outputs (?q) :certified (and (Conf ?q) (Of ?q ?r)))
  (:wild-stream connect
    :inputs (?q1 ?q2) :domain (and (Conf ?q1) (Conf ?q2)) :outputs (?t)
    :certified (and (Track ?t) (Line ?q1 ?t ?q2))))
"""


def visits(regions: int, vertices: int = 60) -> Problem:
    """Corners of the unit square are visited round two walls; what connects two points is a roadmap of its own."""
    rng = np.random.default_rng(0)
    corners = {f"r{i}": np.array([0.1 + 0.8 * (i % 2), 0.1 + 0.8 * (i // 2)]) for i in range(regions)}
    walls = [((0.45, 0.0), (0.55, 0.8)), ((0.0, 0.45), (0.3, 0.55))]

    def free(a: np.ndarray, b: np.ndarray) -> bool:
        points = a + np.linspace(0.0, 1.0, 50)[:, None] * (b - a)
        return not any(bool(np.any(np.all((points > low) & (points < high), axis=1))) for low, high in walls)

    def sample_region(region: str) -> Iterator[tuple[np.ndarray]]:
        while True:
            yield (corners[region] + rng.uniform(-0.05, 0.05, 2),)

    def connect(start: np.ndarray, end: np.ndarray) -> WildOutput:
        points = [start, end, *rng.uniform(0.0, 1.0, (vertices, 2))]
        facts: list[Any] = [("Conf", point) for point in points[2:]]
        for a in points:
            near = (b for b in points if b is not a and np.linalg.norm(a - b) < 0.3)
            tracks = [(a, b) for b in near if free(a, b)]
            facts += [fact for track in tracks for fact in (("Track", track), ("Line", a, track, track[1]))]
        return WildOutput([], facts)

    home = np.array([0.1, 0.9])
    stream_map = {
        "sample-region": from_gen_fn(sample_region),
        "connect": from_fn(connect),
        "length": lambda line: float(np.linalg.norm(line[1] - line[0])),
    }
    init = [("Conf", home), ("AtConf", home), *(("Region", name) for name in corners)]
    goal = ("and", *(("Visited", name) for name in corners))
    return Problem(VISITS, VISITS_STREAMS, from_stream_map(stream_map), init, goal)
