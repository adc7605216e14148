"""Further problems in PDDLStream's form and in the shapes of its examples: a line, states as values, a field, tea."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from tamp.planning import Problem
from tamp.planning.pddlstream import from_fn, from_gen_fn, from_stream_map, from_test

SHELF = """
(define (domain shelf)
  (:requirements :strips :equality)
  (:predicates (Arm ?a) (Block ?b) (Pose ?b ?p) (Grip ?b ?g) (Conf ?q) (Within ?b ?p ?s) (Reach ?b ?q ?p ?g) (Stove ?s)
               (Path ?q1 ?t ?q2) (Apart ?b1 ?p1 ?b2 ?p2) (MayBe ?b ?s) (AtPose ?b ?p) (AtGrip ?a ?b ?g) (AtConf ?a ?q)
               (Empty ?a) (MayMove ?a) (Cooked ?b) (In ?b ?s) (Blocked ?b ?p))
  (:functions (Length ?q1 ?q2))
  (:action move
    :parameters (?a ?q1 ?t ?q2)
    :precondition (and (Arm ?a) (Path ?q1 ?t ?q2) (AtConf ?a ?q1) (MayMove ?a))
    :effect (and (AtConf ?a ?q2) (not (AtConf ?a ?q1)) (not (MayMove ?a)) (increase (total-cost) (Length ?q1 ?q2))))
  (:action pick
    :parameters (?a ?b ?p ?g ?q)
    :precondition (and (Arm ?a) (Reach ?b ?q ?p ?g) (AtConf ?a ?q) (AtPose ?b ?p) (Empty ?a))
    :effect (and (AtGrip ?a ?b ?g) (MayMove ?a) (not (AtPose ?b ?p)) (not (Empty ?a)) (increase (total-cost) 1)))
  (:action place
    :parameters (?a ?b ?p ?g ?q)
    :precondition (and (Arm ?a) (Reach ?b ?q ?p ?g) (AtConf ?a ?q) (AtGrip ?a ?b ?g) (not (Blocked ?b ?p)))
    :effect (and (AtPose ?b ?p) (Empty ?a) (MayMove ?a) (not (AtGrip ?a ?b ?g)) (increase (total-cost) 1)))
  (:action cook
    :parameters (?a ?b ?s)
    :precondition (and (Arm ?a) (Stove ?s) (MayBe ?b ?s) (In ?b ?s))
    :effect (and (Cooked ?b) (MayMove ?a) (increase (total-cost) 1)))
  (:derived (In ?b ?s) (exists (?p) (and (Within ?b ?p ?s) (AtPose ?b ?p))))
  (:derived (Blocked ?b1 ?p1)
    (exists (?b2 ?p2) (and (Pose ?b1 ?p1) (Pose ?b2 ?p2) (not (= ?b1 ?b2)) (not (Apart ?b1 ?p1 ?b2 ?p2))
                           (AtPose ?b2 ?p2)))))
"""

SHELF_STREAMS = """
(define (stream shelf)
  (:stream sample-grip :inputs (?b) :domain (Block ?b) :outputs (?g) :certified (Grip ?b ?g))
  (:stream sample-pose
    :inputs (?b ?s) :domain (MayBe ?b ?s) :outputs (?p) :certified (and (Pose ?b ?p) (Within ?b ?p ?s)))
  (:stream inverse-kinematics
    :inputs (?b ?p ?g) :domain (and (Pose ?b ?p) (Grip ?b ?g)) :outputs (?q)
    :certified (and (Conf ?q) (Reach ?b ?q ?p ?g)))
  (:stream plan-path :inputs (?q1 ?q2) :domain (and (Conf ?q1) (Conf ?q2)) :outputs (?t) :certified (Path ?q1 ?t ?q2))
  (:stream test-apart
    :inputs (?b1 ?p1 ?b2 ?p2) :domain (and (Pose ?b1 ?p1) (Pose ?b2 ?p2)) :certified (Apart ?b1 ?p1 ?b2 ?p2))
  (:stream test-within :inputs (?b ?p ?s) :domain (and (Pose ?b ?p) (MayBe ?b ?s)) :certified (Within ?b ?p ?s))
  (:function (Length ?q1 ?q2) (and (Conf ?q1) (Conf ?q2))))
"""

WIDTH = 2.0
"""Of a block, and so the least distance between two [cells]."""

ABOVE = np.array([0.0, 5.0])
"""From a block's pose to the arm that picks it."""


def shelf(
    starts: list[float],
    goals: dict[str, Any],
    regions: dict[str, tuple[float, float]],
    arms: int = 1,
    rng: np.random.Generator | None = None,
) -> Problem:
    """Blocks on a line, picked from above by arms that go home in the end; numbers are arrays, which have no hash.

    Args:
        starts: where the blocks "A", "B" ... stand; they may be anywhere in the region "floor".
        goals: block -> a region, several of which one will do, or a pose; the region "stove" wants it cooked besides.
        regions: name -> lower and upper bound.
        arms: how many there are.
        rng: what poses are drawn from; always the same ones without it.
    """
    names = "ABCDEFGH"[: len(starts)]
    init: list[Any] = [("Stove", "stove")]
    goal: list[Any] = ["and"]
    for name, start in zip(names, starts, strict=True):
        pose = np.array([start, 0.0])
        init += [("Block", name), ("Pose", name, pose), ("AtPose", name, pose), ("MayBe", name, "floor")]
    for i in range(arms):
        home = np.array([5.0 - 10.0 * (i == 0), 6.0])
        init += [("Arm", i), ("MayMove", i), ("Conf", home), ("AtConf", i, home), ("Empty", i)]
        goal += [("AtConf", i, home)]
    for name, wanted in goals.items():
        if isinstance(wanted, float):
            pose = np.array([wanted, 0.0])
            init += [("Pose", name, pose)]
            goal += [("AtPose", name, pose)]
            continue
        choices = [wanted] if isinstance(wanted, str) else wanted
        init += [("MayBe", name, choice) for choice in choices]
        goal += [("or", *(("In", name, choice) for choice in choices if choice != "stove"))]
        goal += [("Cooked", name)] if "stove" in choices else []
    random = rng or np.random.default_rng(0)

    def sample_pose(block: str, region: str) -> Iterator[tuple[np.ndarray]]:
        low, high = regions[region]
        while high - low >= WIDTH:
            yield (np.array([random.uniform(low + WIDTH / 2, high - WIDTH / 2), 0.0]),)

    def within(block: str, pose: np.ndarray, region: str) -> bool:
        return bool(regions[region][0] + WIDTH / 2 <= pose[0] <= regions[region][1] - WIDTH / 2)

    stream_map = {
        "sample-grip": from_fn(lambda block: ("top",)),
        "sample-pose": from_gen_fn(sample_pose),
        "inverse-kinematics": from_fn(lambda block, pose, grip: (pose + ABOVE,)),
        "plan-path": from_fn(lambda a, b: ([a, b],)),
        "test-apart": from_test(lambda b1, p1, b2, p2: abs(p1[0] - p2[0]) > WIDTH),
        "test-within": from_test(within),
        "length": lambda a, b: 10.0 + float(np.abs(a - b).sum()),
    }
    return Problem(SHELF, SHELF_STREAMS, from_stream_map(stream_map), init, tuple(goal))


STATES = """
(define (domain states)
  (:requirements :strips)
  (:predicates (State ?s) (Arm ?a) (Block ?b) (Cell ?x) (Way ?x ?t ?y) (Went ?s1 ?a ?x ?t ?y ?s2)
               (Took ?s1 ?a ?b ?x ?s2) (Left ?s1 ?a ?b ?x ?s2) (Now ?s) (Good ?s) (Done))
  (:action go
    :parameters (?s1 ?a ?x ?t ?y ?s2) :precondition (and (Went ?s1 ?a ?x ?t ?y ?s2) (Now ?s1))
    :effect (and (Now ?s2) (not (Now ?s1))))
  (:action take
    :parameters (?s1 ?a ?b ?x ?s2) :precondition (and (Took ?s1 ?a ?b ?x ?s2) (Now ?s1))
    :effect (and (Now ?s2) (not (Now ?s1))))
  (:action leave
    :parameters (?s1 ?a ?b ?x ?s2) :precondition (and (Left ?s1 ?a ?b ?x ?s2) (Now ?s1))
    :effect (and (Now ?s2) (not (Now ?s1))))
  (:derived (Done) (exists (?s) (and (Good ?s) (Now ?s)))))
"""

STATES_STREAMS = """
(define (stream states)
  (:stream sample-cell :inputs (?b) :domain (Block ?b) :outputs (?x) :certified (Cell ?x))
  (:stream plan-way :inputs (?x ?y) :domain (and (Cell ?x) (Cell ?y)) :outputs (?t) :certified (Way ?x ?t ?y))
  (:stream after-going
    :inputs (?s1 ?a ?x ?t ?y) :domain (and (State ?s1) (Arm ?a) (Way ?x ?t ?y)) :outputs (?s2)
    :certified (and (State ?s2) (Went ?s1 ?a ?x ?t ?y ?s2)))
  (:stream after-taking
    :inputs (?s1 ?a ?b ?x) :domain (and (State ?s1) (Arm ?a) (Block ?b) (Cell ?x)) :outputs (?s2)
    :certified (and (State ?s2) (Took ?s1 ?a ?b ?x ?s2)))
  (:stream after-leaving
    :inputs (?s1 ?a ?b ?x) :domain (and (State ?s1) (Arm ?a) (Block ?b) (Cell ?x)) :outputs (?s2)
    :certified (and (State ?s2) (Left ?s1 ?a ?b ?x ?s2)))
  (:stream test-good :inputs (?s) :domain (State ?s) :certified (Good ?s)))
"""

World = dict[str, Any]
"""Where the arm is, what it holds, and where each block stands."""


def states(target: float) -> Problem:
    """A block is carried beyond a point and the arm goes home; a whole state is one value, and a dictionary at that."""
    rng = np.random.default_rng(0)
    home, start = np.array([-5.0]), np.array([0.0])
    first: World = {"arm": home, "held": None, "a": start}

    def sample_cell(block: str) -> Iterator[tuple[np.ndarray]]:
        while True:
            yield (np.array([rng.uniform(-10.0, 10.0)]),)

    def going(state: World, arm: str, x: np.ndarray, way: Any, y: np.ndarray) -> tuple[World] | None:
        return ({**state, arm: y},) if np.allclose(state[arm], x) else None

    def taking(state: World, arm: str, block: str, x: np.ndarray) -> tuple[World] | None:
        here = state["held"] is None and np.allclose(state[arm], x) and np.allclose(state[block], x)
        return ({**state, "held": block, block: np.array([math.nan])},) if here else None

    def leaving(state: World, arm: str, block: str, x: np.ndarray) -> tuple[World] | None:
        here = state["held"] == block and np.allclose(state[arm], x)
        return ({**state, "held": None, block: x},) if here else None

    stream_map = {
        "sample-cell": from_gen_fn(sample_cell),
        "plan-way": from_fn(lambda x, y: ([x, y],)),
        "after-going": from_fn(going),
        "after-taking": from_fn(taking),
        "after-leaving": from_fn(leaving),
        "test-good": from_test(lambda state: np.allclose(state["arm"], home) and bool(state["a"][0] > target)),
    }
    init = [("State", first), ("Now", first), ("Arm", "arm"), ("Block", "a"), ("Cell", home), ("Cell", start)]
    return Problem(STATES, STATES_STREAMS, from_stream_map(stream_map), init, ("Done",))


FIELD = """
(define (domain field)
  (:requirements :strips)
  (:predicates (Point ?q) (Area ?r) (Line ?q1 ?q2) (Of ?q ?r) (At ?q) (Inside ?r))
  (:functions (Far ?q1 ?q2))
  (:action walk
    :parameters (?q1 ?q2) :precondition (and (Line ?q1 ?q2) (At ?q1))
    :effect (and (At ?q2) (not (At ?q1)) (increase (total-cost) (Far ?q1 ?q2))))
  (:derived (Inside ?r) (exists (?q) (and (Point ?q) (Area ?r) (Of ?q ?r) (At ?q)))))
"""

FIELD_STREAMS = """
(define (stream field)
  (:function (Far ?q1 ?q2) (and (Point ?q1) (Point ?q2)))
  (:stream sample-point :inputs (?r) :domain (Area ?r) :outputs (?q) :certified (and (Point ?q) (Of ?q ?r)))
  (:stream test-line :inputs (?q1 ?q2) :domain (and (Point ?q1) (Point ?q2)) :certified (Line ?q1 ?q2)))
"""


def field(reach: float, area: bool = True) -> Problem:
    """From one corner of the unit square round a box to an area at the other, or to that corner; lines are short."""
    rng = np.random.default_rng(0)
    areas = {"all": (0.0, 1.0), "corner": (0.6, 1.0)}

    def sample_point(name: str) -> Iterator[tuple[np.ndarray]]:
        low, high = areas[name]
        while True:
            yield (rng.uniform(low, high, 2),)

    def line(a: np.ndarray, b: np.ndarray) -> bool:
        if np.linalg.norm(b - a) > reach:
            return False
        points = a + np.linspace(0.0, 1.0, 1 + int(50 * reach))[:, None] * (b - a)
        return not bool(np.any(np.all((points > 0.4) & (points < 0.6), axis=1)))

    start, end = np.zeros(2), np.ones(2)
    init: list[Any] = [("Point", start), ("At", start), *(("Area", name) for name in areas)]
    stream_map = {
        "sample-point": from_gen_fn(sample_point),
        "test-line": from_test(line),
        "far": lambda a, b: float(np.linalg.norm(b - a)),
    }
    goal: Any = ("Inside", "corner") if area else ("At", end)
    return Problem(FIELD, FIELD_STREAMS, from_stream_map(stream_map), init + [("Point", end)] * (not area), goal)


TEA = """
(define (domain tea)
  (:requirements :strips)
  (:predicates (Hand ?h) (Cup ?c) (Spoon ?s) (Place ?x ?p) (Grip ?x ?g) (Grasps ?h ?q ?x ?p ?g)
               (Pours ?h ?q ?c ?g ?d ?p) (Stirs ?h ?q ?s ?g ?d ?p) (Pushes ?h ?q ?q2 ?x ?p ?p2) (Path ?h ?q ?t ?q2)
               (Tray ?x) (Table ?p) (At ?x ?p) (Held ?x ?g) (Empty ?h) (Free ?h) (Milk ?c) (Stirred ?c) (On ?x ?y)
               (Rests ?x ?p ?y ?p2))
  (:action move
    :parameters (?h ?q ?t ?q2) :precondition (and (Path ?h ?q ?t ?q2) (At ?h ?q))
    :effect (and (At ?h ?q2) (not (At ?h ?q)) (not (Free ?h))))
  (:action push
    :parameters (?h ?q ?q2 ?x ?p ?p2)
    :precondition (and (Pushes ?h ?q ?q2 ?x ?p ?p2) (At ?h ?q) (At ?x ?p) (Empty ?h))
    :effect (and (At ?h ?q2) (At ?x ?p2) (Free ?h) (not (At ?h ?q)) (not (At ?x ?p))))
  (:action pick
    :parameters (?h ?q ?x ?p ?g) :precondition (and (Grasps ?h ?q ?x ?p ?g) (At ?h ?q) (At ?x ?p) (Empty ?h))
    :effect (and (Held ?x ?g) (Free ?h) (not (At ?x ?p)) (not (Empty ?h))))
  (:action place
    :parameters (?h ?q ?x ?p ?g) :precondition (and (Grasps ?h ?q ?x ?p ?g) (At ?h ?q) (Held ?x ?g) (Table ?p))
    :effect (and (At ?x ?p) (Empty ?h) (Free ?h) (not (Held ?x ?g))))
  (:action stack
    :parameters (?h ?q ?x ?p ?g ?y ?p2)
    :precondition (and (Grasps ?h ?q ?x ?p ?g) (Rests ?x ?p ?y ?p2) (At ?h ?q) (Held ?x ?g) (At ?y ?p2))
    :effect (and (At ?x ?p) (Empty ?h) (Free ?h) (not (Held ?x ?g))))
  (:action pour
    :parameters (?h ?q ?c ?g ?d ?p)
    :precondition (and (Pours ?h ?q ?c ?g ?d ?p) (At ?h ?q) (Held ?c ?g) (At ?d ?p) (Milk ?c))
    :effect (and (Milk ?d) (Free ?h) (not (Milk ?c))))
  (:action stir
    :parameters (?h ?q ?s ?g ?d ?p)
    :precondition (and (Stirs ?h ?q ?s ?g ?d ?p) (At ?h ?q) (Held ?s ?g) (At ?d ?p) (Milk ?d))
    :effect (and (Stirred ?d) (Free ?h)))
  (:derived (On ?x ?y) (exists (?p ?p2) (and (Rests ?x ?p ?y ?p2) (At ?x ?p) (At ?y ?p2)))))
"""

TEA_STREAMS = """
(define (stream tea)
  (:stream find-path
    :inputs (?h ?q ?q2) :domain (and (Hand ?h) (Place ?h ?q) (Place ?h ?q2)) :fluents (At Held) :outputs (?t)
    :certified (Path ?h ?q ?t ?q2))
  (:stream find-grip :inputs (?x) :domain (Cup ?x) :outputs (?g) :certified (Grip ?x ?g))
  (:stream find-hold :inputs (?x) :domain (Spoon ?x) :outputs (?g) :certified (Grip ?x ?g))
  (:stream find-grasp
    :inputs (?h ?x ?p ?g) :domain (and (Hand ?h) (Place ?x ?p) (Grip ?x ?g)) :outputs (?q)
    :certified (and (Grasps ?h ?q ?x ?p ?g) (Place ?h ?q)))
  (:stream find-push
    :inputs (?h ?x ?p ?p2) :domain (and (Hand ?h) (Tray ?x) (Place ?x ?p) (Place ?x ?p2)) :outputs (?q ?q2)
    :certified (and (Pushes ?h ?q ?q2 ?x ?p ?p2) (Place ?h ?q) (Place ?h ?q2)))
  (:stream find-rest
    :inputs (?x ?y ?p2) :domain (and (Cup ?x) (Tray ?y) (Place ?y ?p2)) :outputs (?p)
    :certified (and (Rests ?x ?p ?y ?p2) (Place ?x ?p)))
  (:stream find-pour
    :inputs (?h ?c ?g ?d ?p) :domain (and (Hand ?h) (Cup ?c) (Grip ?c ?g) (Cup ?d) (Place ?d ?p)) :outputs (?q)
    :certified (and (Pours ?h ?q ?c ?g ?d ?p) (Place ?h ?q)))
  (:stream find-stir
    :inputs (?h ?s ?g ?d ?p) :domain (and (Hand ?h) (Spoon ?s) (Grip ?s ?g) (Cup ?d) (Place ?d ?p)) :outputs (?q)
    :certified (and (Stirs ?h ?q ?s ?g ?d ?p) (Place ?h ?q))))
"""


def tea(cups: int) -> Problem:
    """Milk is poured into a cup and stirred, the cup stands on a tray, and that is pushed away; no samplers at all."""
    places = {"hand": 0.0, "spoon": 1.0, "tray": 2.0, **{f"cup{i}": 3.0 + i for i in range(cups)}}
    init: list[Any] = [("Hand", "hand"), ("Spoon", "spoon"), ("Tray", "tray"), ("Empty", "hand"), ("Free", "hand")]
    init += [("Cup", f"cup{i}") for i in range(cups)] + [("Milk", "cup1"), ("Place", "tray", -9.0)]
    for thing, place in places.items():
        init += [("Place", thing, place), ("At", thing, place), ("Table", place)]
    goal = ("and", ("Stirred", "cup0"), ("On", "cup0", "tray"), ("At", "tray", -9.0), ("Empty", "hand"))
    return Problem(TEA, TEA_STREAMS, "debug", init, goal)
