"""Problems in forms that PDDLStream's users write: constants, rules, streams without inputs, costs of objects."""

from collections.abc import Iterator
from typing import Any

from tamp.planning import Problem

GRID = """
(define (domain grid)
  (:requirements :strips :equality)
  (:constants q0)
  (:predicates (Conf ?q) (Block ?b) (Pose ?p) (Kin ?q ?p) (AtPose ?b ?p) (AtConf ?q) (Holding ?b) (HandEmpty)
               (CFree ?p1 ?p2) (Unsafe ?p) (CanMove))
  (:functions (Distance ?q1 ?q2))
  (:action move
    :parameters (?q1 ?q2)
    :precondition (and (Conf ?q1) (Conf ?q2) (AtConf ?q1) (CanMove))
    :effect (and (AtConf ?q2) (not (AtConf ?q1)) (not (CanMove)) (increase (total-cost) (Distance ?q1 ?q2))))
  (:action pick
    :parameters (?b ?p ?q)
    :precondition (and (Block ?b) (Kin ?q ?p) (AtConf ?q) (AtPose ?b ?p) (HandEmpty))
    :effect (and (Holding ?b) (CanMove) (not (AtPose ?b ?p)) (not (HandEmpty)) (increase (total-cost) 1)))
  (:action place
    :parameters (?b ?p ?q)
    :precondition (and (Block ?b) (Kin ?q ?p) (AtConf ?q) (Holding ?b) (not (Unsafe ?p)))
    :effect (and (AtPose ?b ?p) (HandEmpty) (CanMove) (not (Holding ?b)) (increase (total-cost) 1)))
  (:derived (Unsafe ?p1)
    (exists (?b ?p2) (and (Pose ?p1) (Pose ?p2) (Block ?b) (not (CFree ?p1 ?p2)) (AtPose ?b ?p2)))))
"""

GRID_STREAMS = """
(define (stream grid)
  ; poses come from nowhere, and what a rule says needs no sampler
  (:function (Distance ?q1 ?q2) (and (Conf ?q1) (Conf ?q2)))
  (:stream sample-pose :inputs () :domain () :outputs (?p) :certified (and (Place ?p)))
  (:rule :inputs (?p) :domain (Place ?p) :certified (Pose ?p))
  (:stream inverse-kinematics :inputs (?p) :domain (Pose ?p) :outputs (?q) :certified (and (Conf ?q) (Kin ?q ?p)))
  (:stream collision-free :inputs (?p1 ?p2) :domain (and (Pose ?p1) (Pose ?p2)) :outputs () :certified (CFree ?p1 ?p2)))
"""


def sample_pose(context: Any) -> Iterator[tuple[int, int]]:
    for i in range(50):
        yield (i, 0)


def inverse_kinematics(context: Any, pose: tuple[int, int]) -> Iterator[tuple[int, int]]:
    yield (pose[0], pose[1] + 5)


def distance(context: Any, q1: Any, q2: Any) -> float:
    a, b = ((0, 5) if q == "q0" else q for q in (q1, q2))
    return float(abs(a[0] - b[0]) + abs(a[1] - b[1]))


def grid(n: int) -> Problem:
    """n blocks in a row of cells; the first is to be where the last is, in PDDLStream's discrete form."""
    init: list[Any] = [("Conf", "q0"), ("AtConf", "q0"), ("CanMove",), ("HandEmpty",)]
    for i in range(n):
        init += [("Block", f"b{i}"), ("Pose", (i, 0)), ("AtPose", f"b{i}", (i, 0))]
    samplers = {
        "sample-pose": sample_pose,
        "inverse-kinematics": inverse_kinematics,
        "collision-free": lambda context, p1, p2: p1 != p2,
        "distance": distance,
    }
    goal = ("and", ("AtPose", "b0", (n - 1, 0)), ("AtConf", "q0"))
    return Problem(domain=GRID, streams=GRID_STREAMS, samplers=samplers, init=init, goal=goal)


BELIEF = """
(define (domain belief)
  (:requirements :strips)
  (:predicates (Obj ?o) (Loc ?l) (BLoc ?o ?d) (MoveProb ?l1 ?l2 ?d1 ?d2) (LookProb ?l ?d1 ?d2) (GE ?d ?l ?p)
               (BLocGE ?o ?l ?p) (BCollision ?l ?d) (Unsafe ?l))
  (:functions (MoveCost ?l1 ?l2) (LookCost ?l ?d))
  (:action move
    :parameters (?o ?l1 ?l2 ?d1 ?d2)
    :precondition (and (Obj ?o) (MoveProb ?l1 ?l2 ?d1 ?d2) (Bloc ?o ?d1) (not (Unsafe ?l2)))
    :effect (and (BLoc ?o ?d2) (not (BLoc ?o ?d1)) (increase (total-cost) (MoveCost ?l1 ?l2))))
  (:action look
    :parameters (?o ?l ?d1 ?d2)
    :precondition (and (Obj ?o) (LookProb ?l ?d1 ?d2) (BLoc ?o ?d1))
    :effect (and (BLoc ?o ?d2) (not (BLoc ?o ?d1)) (increase (total-cost) (LookCost ?l ?d1))))
  (:derived (BLocGE ?o ?l ?p) (exists (?d) (and (Obj ?o) (GE ?d ?l ?p) (BLoc ?o ?d))))
  (:derived (Unsafe ?l) (exists (?o ?d) (and (Obj ?o) (BCollision ?l ?d) (BLoc ?o ?d)))))
"""

BELIEF_STREAMS = """
(define (stream belief)
  (:function (MoveCost ?l1 ?l2) (and (Location ?l1) (Location ?l2)))
  (:function (LookCost ?l ?d1) (and (Location ?l) (Dist ?d1)))
  (:predicate (BCollision ?l ?d) (and (Location ?l) (Dist ?d)))
  (:stream ge :inputs (?d ?l ?p) :domain (and (Dist ?d) (Location ?l) (Prob ?p)) :outputs () :certified (GE ?d ?l ?p))
  (:stream prob-after-move
    :inputs (?l1 ?l2 ?d1)
    :domain (and (Location ?l1) (Location ?l2) (Dist ?d1))
    :outputs (?d2)
    :certified (and (Dist ?d2) (MoveProb ?l1 ?l2 ?d1 ?d2)))
  (:stream prob-after-look
    :inputs (?l ?d1)
    :domain (and (Location ?l) (Dist ?d1))
    :outputs (?d2)
    :certified (and (Dist ?d2) (LookProb ?l ?d1 ?d2))))
"""

Belief = tuple[float, ...]
"""How likely an object is at each location, in hundredths."""


def after_move(context: Any, start: int, end: int, before: Belief) -> Iterator[Belief]:
    """A move succeeds with probability 0.8."""
    if start != end and before[start] > 0:
        after = list(before)
        moved = round(0.8 * before[start], 2)
        after[start], after[end] = round(before[start] - moved, 2), round(before[end] + moved, 2)
        yield tuple(after)


def after_look(context: Any, location: int, before: Belief) -> Iterator[Belief]:
    """A look that sees the object, by a detector that is right 9 times of 10; only where it is likely enough."""
    weights = [p * (0.9 if i == location else 0.1) for i, p in enumerate(before)]
    if before[location] > 20:
        yield tuple(round(100 * weight / sum(weights), 2) for weight in weights)


def likely(belief: Belief, location: int, probability: float) -> bool:
    return belief[location] >= 100 * probability


def move_cost(start: int, end: int) -> float:
    return 1.0 + abs(start - end)


def look_cost(location: int, belief: Belief) -> float:
    return 1.0 + (100.0 - belief[location]) / 100.0


def belief_collision(location: int, belief: Belief) -> bool:
    return belief[location] > 30


def belief(n: int) -> Problem:
    """One object at one of n locations; in the end it is at the last with a probability of 0.9."""
    start = (100.0, *([0.0] * (n - 1)))
    init: list[Any] = [("Obj", "cup"), ("Dist", start), ("BLoc", "cup", start), ("Prob", 0.9)]
    init += [("Location", i) for i in range(n)]
    samplers = {
        "prob-after-move": after_move,
        "prob-after-look": after_look,
        "ge": lambda context, *args: likely(*args),
        "bcollision": lambda context, *args: belief_collision(*args),
        "movecost": lambda context, *args: move_cost(*args),
        "lookcost": lambda context, *args: look_cost(*args),
    }
    return Problem(
        domain=BELIEF, streams=BELIEF_STREAMS, samplers=samplers, init=init, goal=("BLocGE", "cup", n - 1, 0.9)
    )


SPAWN = """
(define (domain blocks)
  (:requirements :strips :equality)
  (:predicates (clear ?x) (ontable ?x) (arm-empty) (holding ?x) (on ?x ?y) (isblock ?x))
  (:action pickup
    :parameters (?x) :precondition (and (isblock ?x) (clear ?x) (ontable ?x) (arm-empty))
    :effect (and (holding ?x) (not (clear ?x)) (not (ontable ?x)) (not (arm-empty))))
  (:action stack
    :parameters (?x ?y) :precondition (and (clear ?y) (holding ?x))
    :effect (and (arm-empty) (clear ?x) (on ?x ?y) (not (clear ?y)) (not (holding ?x)))))
"""

SPAWN_STREAMS = """
(define (stream blocks)
  (:stream new-block :outputs (?b) :certified (and (isblock ?b) (ontable ?b)))
  (:stream test-clear :inputs (?b) :domain (isblock ?b) :certified (clear ?b)))
"""


def new_block(context: Any) -> Iterator[str]:
    i = 0
    while True:
        yield f"new{i}"
        i += 1


def spawn(n: int) -> Problem:
    """Streams make the blocks, and certify facts that actions change; every other new block is covered.

    On the one block of the start n others shall stand.
    """
    clear = lambda context, block: block == "base" or int(block[3:]) % 2 == 1  # noqa: E731
    variables = [f"?b{i}" for i in range(n)]
    tower = zip(variables, ["base", *variables], strict=False)
    goal = ("exists", tuple(variables), ("and", *(("on", above, below) for above, below in tower)))
    init = [("isblock", "base"), ("ontable", "base"), ("arm-empty",)]
    samplers = {"new-block": new_block, "test-clear": clear}
    return Problem(domain=SPAWN, streams=SPAWN_STREAMS, samplers=samplers, init=init, goal=goal)
