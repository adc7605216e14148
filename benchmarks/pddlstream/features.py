"""Problems in PDDLStream's form that lean on one feature each: counting, cutting, sums, latent values, pushes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from tamp.planning import Problem
from tamp.planning.pddlstream import from_fn, from_gen_fn, from_sampler, from_stream_map, from_test

COUNTING = """
(define (domain counting)
  (:predicates (Number ?x) (Large ?x) (Small ?x) (Near ?x ?y) (Reached) (Left))
  (:action up :parameters (?x) :precondition (Large ?x) :effect (Reached))
  (:action down :parameters (?x) :precondition (Small ?x) :effect (Left)))
"""

COUNTING_STREAMS = """
(define (stream counting)
  (:stream more :inputs (?x) :domain (Number ?x) :outputs (?y) :certified (Number ?y))
  (:stream less :inputs (?x) :domain (Number ?x) :outputs (?y) :certified (Number ?y))
  (:stream test-large :inputs (?x) :domain (Number ?x) :certified (Large ?x))
  (:stream test-small :inputs (?x) :domain (Number ?x) :certified (Small ?x)))
"""


def counting(far: int, both: bool = False) -> Problem:
    """A number beyond some other is reached by steps of one; or one in each direction."""
    stream_map = {
        "more": from_fn(lambda x: (x + 1,)),
        "less": from_fn(lambda x: (x - 1,)),
        "test-large": from_test(lambda x: x >= far),
        "test-small": from_test(lambda x: x <= -far),
    }
    goal = ("and", ("Reached",), ("Left",)) if both else ("Reached",)
    return Problem(COUNTING, COUNTING_STREAMS, from_stream_map(stream_map), [("Number", 0)], goal)


CUTTING = """
(define (domain cutting)
  (:predicates (Rope ?c) (Cut ?c ?s ?c1 ?c2) (Place ?l) (At ?c ?l))
  (:functions (Waste ?c ?s))
  (:action carry
    :parameters (?c ?l1 ?l2) :precondition (and (Rope ?c) (Place ?l1) (Place ?l2) (At ?c ?l1))
    :effect (and (At ?c ?l2) (not (At ?c ?l1)) (increase (total-cost) 1)))
  (:action cut
    :parameters (?l ?c ?s ?c1 ?c2) :precondition (and (Place ?l) (Cut ?c ?s ?c1 ?c2) (At ?c ?l))
    :effect (and (At ?c1 ?l) (At ?c2 ?l) (not (At ?c ?l)) (increase (total-cost) (Waste ?c ?s)))))
"""

CUTTING_STREAMS = """
(define (stream cutting)
  (:stream sample-share :outputs (?s) :certified (Share ?s))
  (:stream halves
    :inputs (?c ?s) :domain (and (Rope ?c) (Share ?s)) :outputs (?c1 ?c2)
    :certified (and (Rope ?c1) (Rope ?c2) (Cut ?c ?s ?c1 ?c2)))
  (:function (Waste ?c ?s) (and (Rope ?c) (Share ?s))))
"""


def cutting(places: int) -> Problem:
    """A rope is cut so often that there is a piece in each of some places."""
    rng = np.random.default_rng(0)

    def halves(rope: tuple[float, float], share: float) -> tuple[tuple[float, float], tuple[float, float]]:
        middle = rope[0] + share * (rope[1] - rope[0])
        return (rope[0], middle), (middle, rope[1])

    def waste(rope: tuple[float, float], share: float) -> float:
        return 1.0 / max(1e-3, (rope[1] - rope[0]) * min(share, 1.0 - share))

    names = [f"place{i}" for i in range(places)]
    rope = (0.0, 1.0)
    goal = ("and", *(("exists", ("?c",), ("and", ("Place", name), ("At", "?c", name))) for name in names))
    stream_map = {
        "sample-share": from_sampler(lambda: (round(float(rng.uniform(0.1, 0.9)), 2),)),
        "halves": from_fn(halves),
        "waste": waste,
    }
    init = [("Rope", rope), ("At", rope, names[0]), *(("Place", name) for name in names)]
    return Problem(CUTTING, CUTTING_STREAMS, from_stream_map(stream_map), init, goal)


CASH = """
(define (domain cash)
  (:requirements :typing)
  (:constants @amount)
  (:predicates (Person ?p) (Machine ?m) (Purse ?c) (Drawn ?c) (Left ?c) (Target ?c) (Ge ?c1 ?c2) (Sum ?c1 ?c2 ?c3)
               (Has ?p ?c) (Holds ?m ?c) (Done))
  (:action withdraw
    :parameters (?p ?m ?c ?p1 ?p2 ?m1 ?m2)
    :precondition (and (Person ?p) (Machine ?m) (Sum ?p1 ?c ?p2) (Sum ?m2 ?c ?m1) (Has ?p ?p1) (Holds ?m ?m1))
    :effect (and (Has ?p ?p2) (Holds ?m ?m2) (not (Has ?p ?p1)) (not (Holds ?m ?m1)) (increase (total-cost) 2)))
  (:action finish
    :parameters (?p ?c) :precondition (and (Person ?p) (Ge ?c @amount) (Has ?p ?c))
    :effect (and (Done) (increase (total-cost) 1))))
"""

CASH_STREAMS = """
(define (stream cash)
  (:stream sample-amount :outputs (?c) :certified (Drawn ?c))
  (:stream test-ge :inputs (?c1 ?c2) :domain (and (Purse ?c1) (Target ?c2)) :certified (Ge ?c1 ?c2))
  (:stream add
    :inputs (?c1 ?c2) :domain (and (Purse ?c1) (Drawn ?c2)) :outputs (?c3)
    :certified (and (Purse ?c3) (Sum ?c1 ?c2 ?c3) (Ge ?c3 ?c1)))
  (:stream subtract
    :inputs (?c3 ?c2) :domain (and (Left ?c3) (Drawn ?c2)) :outputs (?c1)
    :certified (and (Left ?c1) (Sum ?c1 ?c2 ?c3))))
"""


def cash(target: float, machines: int = 2, stock: float = 30.0) -> Problem:
    """Money is drawn from machines that run out, in amounts of any size, until there is enough."""
    rng = np.random.default_rng(0)
    stream_map = {
        "sample-amount": from_sampler(lambda: (round(float(rng.uniform(1.0, stock)), 2),)),
        "test-ge": from_test(lambda a, b: a >= b),
        "add": from_fn(lambda a, b: (round(a + b, 2),)),
        "subtract": from_fn(lambda a, b: (round(a - b, 2),) if a >= b else None),
    }
    init: list[Any] = [("Person", "p"), ("Purse", 2.0), ("Target", target), ("Has", "p", 2.0)]
    for i in range(machines):
        init += [("Machine", f"m{i}"), ("Left", stock + i), ("Holds", f"m{i}", stock + i)]
    samplers = from_stream_map(stream_map)
    return Problem(CASH, CASH_STREAMS, samplers, init, ("Done",), constants={"@amount": target})


LATENT = """
(define (domain latent)
  (:predicates (Conf ?q) (Block ?b) (Pose ?p) (Kin ?q ?p) (Path ?q1 ?t ?q2) (AtPose ?b ?p) (AtConf ?q) (Holding ?b)
               (Empty) (Seen ?p) (Called))
  (:action move
    :parameters (?q1 ?t ?q2) :precondition (and (Path ?q1 ?t ?q2) (AtConf ?q1))
    :effect (and (AtConf ?q2) (not (AtConf ?q1))))
  (:action pick
    :parameters (?b ?p ?q) :precondition (and (Block ?b) (Kin ?q ?p) (AtConf ?q) (Seen ?p) (AtPose ?b ?p) (Empty))
    :effect (and (Holding ?b) (not (AtPose ?b ?p)) (not (Empty))))
  (:action look
    :parameters (?b ?p) :precondition (and (Block ?b) (Pose ?p)) :effect (Seen ?p)))
"""

LATENT_STREAMS = """
(define (stream latent)
  (:stream inverse-kinematics
    :inputs (?p) :domain (and (Pose ?p) (Seen ?p)) :outputs (?q) :certified (and (Conf ?q) (Kin ?q ?p)))
  (:stream plan-path
    :inputs (?q1 ?q2) :domain (and (Conf ?q1) (Conf ?q2)) :outputs (?t) :certified (Path ?q1 ?t ?q2)))
"""


class Unknown:
    """A pose that is not known before it is looked at, and what is computed of it."""


def latent(blocks: int) -> Problem:
    """The last of some blocks is picked up; where it stands must be looked at before anything is computed of it."""
    stream_map = {
        "inverse-kinematics": from_fn(lambda pose: (Unknown(),)),
        "plan-path": from_fn(lambda a, b: (Unknown(),)),
    }
    home = np.array([0.0, 1.0])
    init: list[Any] = [("Conf", home), ("AtConf", home), ("Empty",)]
    for i in range(blocks):
        pose = Unknown()
        init += [("Block", f"b{i}"), ("Pose", pose), ("AtPose", f"b{i}", pose)]
    return Problem(LATENT, LATENT_STREAMS, from_stream_map(stream_map), init, ("Holding", f"b{blocks - 1}"))


PUSHING = """
(define (domain pushing)
  (:requirements :strips :equality)
  (:predicates (Conf ?q) (Block ?b) (Pose ?p) (Wanted ?p) (AtPose ?b ?p) (AtConf ?q) (Push ?p1 ?q1 ?p2 ?q2)
               (Apart ?p1 ?p2) (Blocked ?b ?p))
  (:action move
    :parameters (?q1 ?q2) :precondition (and (Conf ?q1) (Conf ?q2) (AtConf ?q1))
    :effect (and (AtConf ?q2) (not (AtConf ?q1)) (increase (total-cost) 1)))
  (:action push
    :parameters (?b ?p1 ?q1 ?p2 ?q2)
    :precondition (and (Block ?b) (Push ?p1 ?q1 ?p2 ?q2) (AtPose ?b ?p1) (AtConf ?q1) (not (Blocked ?b ?p2)))
    :effect (and (AtPose ?b ?p2) (AtConf ?q2) (not (AtPose ?b ?p1)) (not (AtConf ?q1)) (increase (total-cost) 1)))
  (:derived (Blocked ?b ?p)
    (exists (?b2 ?p2) (and (Block ?b) (Pose ?p) (Block ?b2) (Pose ?p2) (not (= ?b ?b2)) (AtPose ?b2 ?p2)
                           (not (Apart ?p ?p2))))))
"""

PUSHING_STREAMS = """
(define (stream pushing)
  (:rule :inputs (?p1 ?q1 ?p2 ?q2) :domain (Push ?p1 ?q1 ?p2 ?q2)
         :certified (and (Pose ?p1) (Conf ?q1) (Pose ?p2) (Conf ?q2)))
  (:stream push-to
    :inputs (?p1 ?p2) :domain (and (Pose ?p1) (Wanted ?p2)) :outputs (?q1 ?q2) :certified (Push ?p1 ?q1 ?p2 ?q2))
  (:stream push-along
    :inputs (?p1) :domain (Pose ?p1) :outputs (?q1 ?p2 ?q2) :certified (Push ?p1 ?q1 ?p2 ?q2))
  (:stream test-apart :inputs (?p1 ?p2) :domain (and (Pose ?p1) (Pose ?p2)) :certified (Apart ?p1 ?p2)))
"""


def pushing(blocks: int, cells: int = 6) -> Problem:
    """Blocks on a grid are pushed one to the right of where they stand, straight ways only; they stand side by side."""

    def way(start: np.ndarray, end: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        step = np.sign(end - start)
        return start - step, end - step

    def push_to(start: np.ndarray, end: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        straight = int(np.count_nonzero(end - start)) == 1
        return way(start, end) if straight else None

    def push_along(start: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        for step in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            end = start + np.array(step)
            if np.all((end >= 0) & (end < cells)):
                before, after = way(start, end)
                yield before, end, after

    home = np.array([-5, -5])
    init: list[Any] = [("Conf", home), ("AtConf", home)]
    goal: list[Any] = ["and"]
    poses = [np.array([x, 0]) for x in range(blocks + 1)]
    init += [("Pose", pose) for pose in poses] + [("Wanted", pose) for pose in poses[1:]]
    for i in range(blocks):
        init += [("Block", f"b{i}"), ("AtPose", f"b{i}", poses[i])]
        goal += [("AtPose", f"b{i}", poses[i + 1])]
    stream_map = {
        "push-to": from_fn(push_to),
        "push-along": from_gen_fn(push_along),
        "test-apart": from_test(lambda a, b: bool(np.abs(a - b).sum() > 0)),
    }
    return Problem(PUSHING, PUSHING_STREAMS, from_stream_map(stream_map), init, tuple(goal))


MODES = """
(define (domain modes)
  (:predicates (Conf ?m ?q) (Mode ?m) (Next ?m1 ?m2) (Path ?m ?q1 ?t ?q2) (Switch ?m1 ?m2 ?q) (Good ?m) (InMode ?m)
               (AtConf ?q) (MayMove) (Done))
  (:action move
    :parameters (?m ?q1 ?t ?q2) :precondition (and (Path ?m ?q1 ?t ?q2) (InMode ?m) (AtConf ?q1) (MayMove))
    :effect (and (AtConf ?q2) (not (MayMove)) (not (AtConf ?q1))))
  (:action switch
    :parameters (?m1 ?m2 ?q) :precondition (and (Switch ?m1 ?m2 ?q) (InMode ?m1) (AtConf ?q))
    :effect (and (InMode ?m2) (MayMove) (not (InMode ?m1))))
  (:derived (Done) (exists (?m) (and (Good ?m) (InMode ?m)))))
"""

MODES_STREAMS = """
(define (stream modes)
  (:stream next-mode :inputs (?m1) :domain (Mode ?m1) :outputs (?m2) :certified (and (Mode ?m2) (Next ?m1 ?m2)))
  (:stream meeting
    :inputs (?m1 ?m2) :domain (Next ?m1 ?m2) :outputs (?q)
    :certified (and (Conf ?m1 ?q) (Conf ?m2 ?q) (Switch ?m1 ?m2 ?q)))
  (:stream connect
    :inputs (?m ?q1 ?q2) :domain (and (Conf ?m ?q1) (Conf ?m ?q2)) :outputs (?t) :certified (Path ?m ?q1 ?t ?q2))
  (:stream test-good :inputs (?m) :domain (Mode ?m) :certified (Good ?m)))
"""


def modes(target: float) -> Problem:
    """A block is carried beyond a point; whether and how it is held, and where it stands, is one value: the mode."""
    rng = np.random.default_rng(0)

    def next_mode(mode: tuple[str, float]) -> Iterator[tuple[tuple[str, float]]]:
        if mode[0] == "stands":
            yield (("held", 0.0),)
        while mode[0] == "held":
            yield (("stands", round(float(rng.uniform(-10.0, 10.0)), 2)),)

    def meeting(before: tuple[str, float], after: tuple[str, float]) -> tuple[float]:
        return (before[1] if before[0] == "stands" else after[1],)

    stream_map = {
        "next-mode": from_gen_fn(next_mode),
        "meeting": from_fn(meeting),
        "connect": from_fn(lambda mode, a, b: ((a, b),)),
        "test-good": from_test(lambda mode: mode[0] == "stands" and mode[1] > target),
    }
    start = ("stands", 0.0)
    init = [("Mode", start), ("InMode", start), ("Conf", start, -5.0), ("AtConf", -5.0), ("MayMove",)]
    return Problem(MODES, MODES_STREAMS, from_stream_map(stream_map), init, ("Done",))


FLOORS = """
(define (domain floors)
  (:requirements :adl)
  (:predicates (Region ?r) (Slot ?r1 ?r2) (Movable ?o) (Thing ?o) (Empty) (Holding ?o) (On ?t ?b) (In ?t ?b) (Clear ?b))
  (:action pick
    :parameters (?t ?b)
    :precondition (and (Movable ?t) (Thing ?b) (not (= ?t ?b)) (Empty) (On ?t ?b) (Clear ?t))
    :effect (and (Holding ?t) (when (Movable ?b) (Clear ?b)) (not (Empty)) (not (On ?t ?b))))
  (:action place
    :parameters (?t ?b)
    :precondition (and (Movable ?t) (Thing ?b) (not (= ?t ?b)) (Holding ?t) (or (Region ?b) (Clear ?b)))
    :effect (and (Empty) (On ?t ?b) (when (Movable ?b) (not (Clear ?b))) (not (Holding ?t))))
  (:action push
    :parameters (?o ?r1 ?r2) :precondition (and (Movable ?o) (Slot ?r1 ?r2) (Empty) (On ?o ?r1) (Clear ?o))
    :effect (and (In ?o ?r2) (not (On ?o ?r1)))))
"""


def floors(boxes: int) -> Problem:
    """Boxes are stored: one pushed into a shelf from its slot, two stacked; effects are conditional, no streams."""
    regions = ["start", "shelf", "slot"]
    names = [f"box{i}" for i in range(boxes)]
    init: list[Any] = [("Empty",), ("Slot", "slot", "shelf"), *(("Region", r) for r in regions)]
    init += [("Thing", name) for name in (*regions, *names)]
    for name in names:
        init += [("Movable", name), ("On", name, "start"), ("Clear", name)]
    goal = ("and", ("In", names[0], "shelf"), ("On", names[2], names[1]), ("On", names[3], names[2]))
    return Problem(FLOORS, None, {}, init, goal)
