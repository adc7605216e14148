"""Problems in PDDLStream's form in which ways cost what they are long, and may be barred by what stands in them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from tamp.planning import Problem
from tamp.planning.pddlstream import from_fn, from_gen_fn, from_stream_map, from_test

ALLEY = """
(define (domain alley)
  (:requirements :strips :equality)
  (:predicates (Crane ?c) (Crate ?b) (Spot ?b ?p) (Hook ?q) (Over ?b ?q ?p) (Run ?q1 ?t ?q2) (Track ?t) (Bay ?b ?s)
               (Inside ?b ?p ?s) (Oven ?s) (Apart ?b1 ?p1 ?b2 ?p2) (Past ?t ?b ?p) (AtSpot ?b ?p) (AtHook ?c ?q)
               (Lifted ?c ?b) (Idle ?c) (MayGo ?c) (Dry ?b) (In ?b ?s) (Taken ?b ?p) (Barred ?t))
  (:functions (Far ?t) (Effort))
  (:action go
    :parameters (?c ?q1 ?t ?q2)
    :precondition (and (Crane ?c) (Run ?q1 ?t ?q2) (AtHook ?c ?q1) (MayGo ?c) (not (Barred ?t)))
    :effect (and (AtHook ?c ?q2) (not (AtHook ?c ?q1)) (not (MayGo ?c)) (increase (total-cost) (Far ?t))))
  (:action lift
    :parameters (?c ?b ?p ?q)
    :precondition (and (Crane ?c) (Over ?b ?q ?p) (AtHook ?c ?q) (AtSpot ?b ?p) (Idle ?c))
    :effect (and (Lifted ?c ?b) (MayGo ?c) (not (AtSpot ?b ?p)) (not (Idle ?c)) (increase (total-cost) (Effort))))
  (:action lower
    :parameters (?c ?b ?p ?q)
    :precondition (and (Crane ?c) (Over ?b ?q ?p) (AtHook ?c ?q) (Lifted ?c ?b) (not (Taken ?b ?p)))
    :effect (and (AtSpot ?b ?p) (Idle ?c) (MayGo ?c) (not (Lifted ?c ?b)) (increase (total-cost) (Effort))))
  (:action dry
    :parameters (?c ?b ?s)
    :precondition (and (Crane ?c) (Oven ?s) (Bay ?b ?s) (In ?b ?s))
    :effect (and (Dry ?b) (MayGo ?c) (increase (total-cost) 1)))
  (:derived (In ?b ?s) (exists (?p) (and (Inside ?b ?p ?s) (AtSpot ?b ?p))))
  (:derived (Taken ?b1 ?p1)
    (exists (?b2 ?p2) (and (Spot ?b1 ?p1) (Spot ?b2 ?p2) (not (= ?b1 ?b2)) (not (Apart ?b1 ?p1 ?b2 ?p2))
                           (AtSpot ?b2 ?p2))))
  (:derived (Barred ?t) (exists (?b ?p) (and (Track ?t) (Spot ?b ?p) (not (Past ?t ?b ?p)) (AtSpot ?b ?p)))))
"""

ALLEY_STREAMS = """
(define (stream alley)
  (:function (Far ?t) (Track ?t))
  (:stream find-spot
    :inputs (?b ?s) :domain (Bay ?b ?s) :outputs (?p) :certified (and (Spot ?b ?p) (Inside ?b ?p ?s)))
  (:stream hang-over :inputs (?b ?p) :domain (Spot ?b ?p) :outputs (?q) :certified (and (Hook ?q) (Over ?b ?q ?p)))
  (:stream find-run
    :inputs (?q1 ?q2) :domain (and (Hook ?q1) (Hook ?q2)) :outputs (?t) :certified (and (Track ?t) (Run ?q1 ?t ?q2)))
  (:stream test-apart
    :inputs (?b1 ?p1 ?b2 ?p2) :domain (and (Spot ?b1 ?p1) (Spot ?b2 ?p2)) :certified (Apart ?b1 ?p1 ?b2 ?p2))
  (:stream test-past :inputs (?t ?b ?p) :domain (and (Track ?t) (Spot ?b ?p)) :certified (Past ?t ?b ?p)))
"""

BAYS = {"yard": (-20.0, 20.0), "bay": (5.0, 8.0), "oven": (-9.0, -7.0)}


def alley(
    starts: dict[str, float],
    goals: dict[str, str],
    cranes: int = 1,
    high: tuple[str, ...] = (),
    bays: dict[str, tuple[float, float]] | None = None,
) -> Problem:
    """Crates of width 1 along a line, into bays, the oven to be dried in; cranes go home in the end.

    Args:
        starts: crate -> where it stands.
        goals: crate -> its bay.
        cranes: how many there are.
        high: crates that no way leads past.
        bays: name -> lower and upper bound, where they differ from `BAYS`.
    """
    bounds = {**BAYS, **(bays or {})}
    rng = np.random.default_rng(0)

    def find_spot(crate: str, bay: str) -> Iterator[tuple[np.ndarray]]:
        low, high = bounds[bay]
        while True:
            yield (np.array([rng.uniform(low + 0.5, high - 0.5), 0.0]),)

    def past(track: np.ndarray, crate: str, spot: np.ndarray) -> bool:
        low, high_end = sorted((track[0][0], track[-1][0]))
        return crate not in high or not low + 1.0 < spot[0] < high_end - 1.0

    init: list[Any] = [("=", ("Effort",), 1.0), ("Oven", "oven")]
    goal: list[Any] = ["and"]
    for i in range(cranes):
        hook = np.array([-5.0 + 10.0 * i, 5.0])
        init += [("Crane", i), ("Hook", hook), ("AtHook", i, hook), ("Idle", i), ("MayGo", i)]
        goal += [("AtHook", i, hook)]
    for crate, start in starts.items():
        spot = np.array([start, 0.0])
        init += [("Crate", crate), ("Spot", crate, spot), ("AtSpot", crate, spot), ("Bay", crate, "yard")]
    for crate, bay in goals.items():
        init += [("Bay", crate, bay)]
        goal += [("Dry", crate) if bay == "oven" else ("In", crate, bay)]
    stream_map = {
        "find-spot": from_gen_fn(find_spot),
        "hang-over": from_fn(lambda crate, spot: (spot + np.array([0.0, 1.0]),)),
        "find-run": from_fn(lambda a, b: (np.array([a, [a[0], 6.0], [b[0], 6.0], b]),)),
        "test-apart": from_test(lambda b1, p1, b2, p2: abs(p1[0] - p2[0]) >= 1.0),
        "test-past": from_test(past),
        "far": lambda track: float(np.abs(np.diff(track, axis=0)).sum()),
    }
    return Problem(ALLEY, ALLEY_STREAMS, from_stream_map(stream_map), init, tuple(goal))


SURVEY = """
(define (domain survey)
  (:requirements :strips :equality)
  (:predicates (Drone ?v) (Post ?q) (Leg ?q1 ?t ?q2) (Way ?t) (Site ?o) (Well ?r) (Tower ?b) (Sees ?o ?q ?y) (Beam ?y)
               (Above ?r ?q) (Hears ?b ?q ?y) (Apart ?q1 ?q2) (At ?v ?q) (Focused ?v) (HasPicture ?v ?o) (Picture ?o)
               (HasWater ?v ?r) (Water ?r) (Empty ?v) (Crowded ?v ?q))
  (:functions (Far ?t))
  (:action fly
    :parameters (?v ?q1 ?t ?q2)
    :precondition (and (Drone ?v) (Leg ?q1 ?t ?q2) (At ?v ?q1) (not (Crowded ?v ?q2)))
    :effect (and (At ?v ?q2) (not (At ?v ?q1)) (increase (total-cost) (Far ?t))))
  (:action focus
    :parameters (?v ?o ?q ?y)
    :precondition (and (Drone ?v) (Sees ?o ?q ?y) (At ?v ?q))
    :effect (and (Focused ?v) (increase (total-cost) 1)))
  (:action shoot
    :parameters (?v ?o ?q ?y)
    :precondition (and (Drone ?v) (Sees ?o ?q ?y) (At ?v ?q) (Focused ?v))
    :effect (and (HasPicture ?v ?o) (not (Focused ?v)) (increase (total-cost) 1)))
  (:action draw
    :parameters (?v ?r ?q)
    :precondition (and (Drone ?v) (Above ?r ?q) (At ?v ?q) (Empty ?v))
    :effect (and (HasWater ?v ?r) (not (Empty ?v)) (increase (total-cost) 1)))
  (:action send
    :parameters (?v ?b ?q ?y ?o)
    :precondition (and (Drone ?v) (Hears ?b ?q ?y) (At ?v ?q) (HasPicture ?v ?o))
    :effect (and (Picture ?o) (increase (total-cost) 1)))
  (:action pour
    :parameters (?v ?b ?q ?y ?r)
    :precondition (and (Drone ?v) (Hears ?b ?q ?y) (At ?v ?q) (HasWater ?v ?r))
    :effect (and (Water ?r) (Empty ?v) (not (HasWater ?v ?r)) (increase (total-cost) 1)))
  (:derived (Crowded ?v ?q)
    (exists (?v2 ?q2) (and (Drone ?v) (Drone ?v2) (not (= ?v ?v2)) (Post ?q) (Post ?q2) (not (Apart ?q ?q2))
                           (At ?v2 ?q2)))))
"""

SURVEY_STREAMS = """
(define (stream survey)
  (:function (Far ?t) (Way ?t))
  (:stream find-leg
    :inputs (?q1 ?q2) :domain (and (Post ?q1) (Post ?q2)) :outputs (?t) :certified (and (Way ?t) (Leg ?q1 ?t ?q2)))
  (:stream look :inputs (?o) :domain (Site ?o) :outputs (?q ?y) :certified (and (Post ?q) (Beam ?y) (Sees ?o ?q ?y)))
  (:stream hover :inputs (?r) :domain (Well ?r) :outputs (?q) :certified (and (Post ?q) (Above ?r ?q)))
  (:stream link
    :inputs (?b) :domain (Tower ?b) :outputs (?q ?y) :certified (and (Post ?q) (Beam ?y) (Hears ?b ?q ?y)))
  (:stream test-apart :inputs (?q1 ?q2) :domain (and (Post ?q1) (Post ?q2)) :certified (Apart ?q1 ?q2)))
"""


def survey(drones: int, sites: int, wells: int) -> Problem:
    """Drones take pictures and draw water, bring both to a tower in the middle, keep apart, and fly home."""
    rng = np.random.default_rng(0)
    names = [f"site{i}" for i in range(sites)] + [f"well{i}" for i in range(wells)]
    places = {**{name: rng.uniform(0.0, 10.0, 2) for name in names}, "tower": np.array([5.0, 5.0])}

    def near(name: str, most: float) -> np.ndarray:
        angle, far = rng.uniform(0.0, 2.0 * math.pi), rng.uniform(0.0, most)
        return np.array(places[name] + far * np.array([math.cos(angle), math.sin(angle)]))

    def posts(most: float, beams: bool) -> Any:
        def posts_near(name: str) -> Iterator[tuple[Any, ...]]:
            while True:
                post = near(name, most)
                yield (post, (name, tuple(post))) if beams else (post,)

        return from_gen_fn(posts_near)

    init: list[Any] = [("Tower", "tower")]
    init += [("Site" if name.startswith("site") else "Well", name) for name in names]
    goal: list[Any] = ["and"]
    goal += [("Picture" if name.startswith("site") else "Water", name) for name in names]
    for i in range(drones):
        home = np.array([2.0 + 6.0 * i, -3.0])
        init += [("Drone", i), ("Post", home), ("At", i, home), ("Empty", i)]
        goal += [("At", i, home)]
    stream_map = {
        "find-leg": from_fn(lambda a, b: ((tuple(a), tuple(b)),)),
        "look": posts(3.0, beams=True),
        "hover": posts(0.5, beams=False),
        "link": posts(4.0, beams=True),
        "test-apart": from_test(lambda a, b: bool(np.linalg.norm(a - b) > 1.0)),
        "far": lambda way: math.dist(*way),
    }
    return Problem(SURVEY, SURVEY_STREAMS, from_stream_map(stream_map), init, tuple(goal))
