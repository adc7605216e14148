"""Small problems in PDDLStream's form: continuous values, several robots, costs, roadmaps, pushes and beliefs."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations
from typing import Any

from tamp.planning import Certified, Problem

Point = tuple[float, float]

PACKING = """
(define (domain packing)
  (:requirements :strips :equality)
  (:predicates (Block ?b) (Region ?r) (Pose ?b ?p) (Contained ?b ?p ?r) (CFree ?b1 ?p1 ?b2 ?p2) (Robot ?a) (Conf ?a ?q)
               (Kin ?a ?b ?p ?q) (AtPose ?b ?p) (AtConf ?a ?q) (Holding ?a ?b) (HandEmpty ?a) (In ?b ?r)
               (Blocked ?b ?p))
  (:functions (total-cost) (Distance ?q1 ?q2))
  (:action move
    :parameters (?a ?q1 ?q2)
    :precondition (and (Conf ?a ?q1) (Conf ?a ?q2) (AtConf ?a ?q1))
    :effect (and (AtConf ?a ?q2) (not (AtConf ?a ?q1)) MOVECOST))
  (:action pick
    :parameters (?a ?b ?p ?q)
    :precondition (and (Kin ?a ?b ?p ?q) (AtPose ?b ?p) (HandEmpty ?a) (AtConf ?a ?q))
    :effect (and (Holding ?a ?b) (not (AtPose ?b ?p)) (not (HandEmpty ?a)) HANDCOST))
  (:action place
    :parameters (?a ?b ?p ?q)
    :precondition (and (Kin ?a ?b ?p ?q) (Holding ?a ?b) (AtConf ?a ?q) (not (Blocked ?b ?p)))
    :effect (and (AtPose ?b ?p) (HandEmpty ?a) (not (Holding ?a ?b)) HANDCOST))
  (:derived (In ?b ?r) (exists (?p) (and (Contained ?b ?p ?r) (AtPose ?b ?p))))
  (:derived (Blocked ?b1 ?p1)
    (exists (?b2 ?p2) (and (Pose ?b1 ?p1) (Pose ?b2 ?p2) (not (= ?b1 ?b2)) (AtPose ?b2 ?p2)
                           (not (CFree ?b1 ?p1 ?b2 ?p2))))))
"""

PACKING_STREAMS = """
(define (stream packing)
  (:stream sample-pose
    :inputs (?b ?r) :domain (and (Block ?b) (Region ?r))
    :outputs (?p) :certified (and (Pose ?b ?p) (Contained ?b ?p ?r)))
  (:stream inverse-kinematics
    :inputs (?a ?b ?p) :domain (and (Robot ?a) (Pose ?b ?p))
    :outputs (?q) :certified (and (Conf ?a ?q) (Kin ?a ?b ?p ?q)))
  (:stream test-cfree
    :inputs (?b1 ?p1 ?b2 ?p2) :domain (and (Pose ?b1 ?p1) (Pose ?b2 ?p2)) :certified (CFree ?b1 ?p1 ?b2 ?p2))FUNCTION)
"""


def packing(
    blocks: int,
    region: Point,
    robots: dict[str, tuple[float, float]] | None = None,
    costs: bool = False,
    reached: float = 1.0,
) -> Problem:
    """Unit squares from a row on the ground into a region of some width and height, by arms of some reach in x.

    `reached`: the share of new poses for which there is a configuration. The region's lower left corner is the origin;
    the row begins two units to the right of it. Where arms do not reach both ends, blocks are handed over on a shelf in
    between.
    """
    width, height = region
    regions = {"goal": (0.0, 0.0, width, height), "shelf": (width + 0.5, 4.0, 3.0, 1.0)}
    arms = robots or {"arm": (-math.inf, math.inf)}
    starts = [(width + 2.0 + 1.5 * i, 0.0) for i in range(blocks)]

    def sample_pose(context: Any, block: str, name: str) -> Iterator[Point]:
        x, y, w, h = regions[name]
        while True:
            yield x + (w - 1.0) * context.rng.random(), y + (h - 1.0) * context.rng.random()

    def inverse_kinematics(context: Any, arm: str, block: str, pose: Point) -> Iterator[tuple[str, Point]]:
        low, high = arms[arm]
        if low <= pose[0] <= high and (pose in starts or context.rng.random() < reached):
            yield arm, (pose[0] + 0.5, pose[1] + 1.0)

    samplers: dict[str, Any] = {
        "sample-pose": sample_pose,
        "inverse-kinematics": inverse_kinematics,
        "test-cfree": lambda context, b1, p, b2, q: abs(p[0] - q[0]) >= 1.0 or abs(p[1] - q[1]) >= 1.0,
    }
    init: list[Any] = [("Region", name) for name in regions]
    for arm in arms:
        home = (arm, (width + 2.0, 9.0))
        init += [("Robot", arm), ("HandEmpty", arm), ("Conf", arm, home), ("AtConf", arm, home)]
    for i, pose in enumerate(starts):
        init += [("Block", f"b{i}"), ("Pose", f"b{i}", pose), ("AtPose", f"b{i}", pose)]
    function = ""
    if costs:
        samplers["distance"] = lambda context, a, b: math.dist(a[1], b[1])
        function = "\n  (:function (Distance ?q1 ?q2) (and))"
    text = PACKING.replace("MOVECOST", "(increase (total-cost) (Distance ?q1 ?q2))" if costs else "")
    text = text.replace("HANDCOST", "(increase (total-cost) 1)" if costs else "")
    if not costs:
        text = text.replace("(:functions (total-cost) (Distance ?q1 ?q2))", "")
    return Problem(
        domain=text,
        streams=PACKING_STREAMS.replace("FUNCTION", function),
        samplers=samplers,
        init=init,
        goal=("and", *(("In", f"b{i}", "goal") for i in range(blocks))),
    )


ROADMAP = """
(define (domain roadmap)
  (:requirements :strips)
  (:predicates (Vertex ?v) (Near ?v ?w) (Edge ?v ?w) (At ?v) (Goal ?v) (There))
  (:functions (total-cost) (Length ?v ?w))
  (:action go
    :parameters (?v ?w)
    :precondition (and (Edge ?v ?w) (At ?v))
    :effect (and (At ?w) (not (At ?v)) (increase (total-cost) (Length ?v ?w))))
  (:derived (There) (exists (?v) (and (Goal ?v) (At ?v)))))
"""

ROADMAP_STREAMS = """
(define (stream roadmap)
  (:stream sample-vertex :outputs (?v) :certified (Vertex ?v))
  (:stream test-edge :inputs (?v ?w) :domain (and (Vertex ?v) (Vertex ?w)) :certified (Edge ?v ?w))
  (:function (Length ?v ?w) (Edge ?v ?w)))
"""


def roadmap(vertices: int) -> Problem:
    """A probabilistic roadmap in the unit square, round a wall in the middle that leaves a passage at the top."""

    def clear(context: Any, a: Point, b: Point) -> bool:
        if a == b or math.dist(a, b) > 0.45:
            return False
        if (a[0] - 0.5) * (b[0] - 0.5) > 0:
            return True
        share = (0.5 - a[0]) / (b[0] - a[0]) if a[0] != b[0] else 0.0
        return a[1] + share * (b[1] - a[1]) > 0.7

    def sample_vertex(context: Any) -> Iterator[Point]:
        for _ in range(vertices):
            yield context.rng.random(), context.rng.random()

    start, goal = (0.1, 0.1), (0.9, 0.1)
    return Problem(
        domain=ROADMAP,
        streams=ROADMAP_STREAMS,
        samplers={
            "sample-vertex": sample_vertex,
            "test-edge": clear,
            "length": lambda context, a, b: math.dist(a, b),
        },
        init=[("Vertex", start), ("Vertex", goal), ("At", start), ("Goal", goal)],
        goal=("There",),
    )


PUSHES = """
(define (domain pushes)
  (:requirements :strips)
  (:predicates (Pose ?p) (Push ?p ?u ?p2) (At ?p) (Target ?p) (Done))
  (:action push
    :parameters (?p ?u ?p2)
    :precondition (and (Push ?p ?u ?p2) (At ?p))
    :effect (and (At ?p2) (not (At ?p))))
  (:derived (Done) (exists (?p) (and (Target ?p) (At ?p)))))
"""

PUSHES_STREAMS = """
(define (stream pushes)
  (:stream plan-push :inputs (?p) :domain (Pose ?p) :outputs (?u ?p2) :certified (and (Pose ?p2) (Push ?p ?u ?p2))))
"""


def pushes(distance: int) -> Problem:
    """A disc on a lattice is pushed in four directions; that it is far enough is a fact that no stream promises."""

    def plan_push(context: Any, pose: tuple[int, int]) -> Iterator[Certified]:
        for step in ((1, 0), (0, 1), (-1, 0), (0, -1)):
            after = (pose[0] + step[0], pose[1] + step[1])
            yield Certified((step, after), (("Target", after),) if after[0] >= distance else ())

    return Problem(
        domain=PUSHES,
        streams=PUSHES_STREAMS,
        samplers={"plan-push": plan_push},
        init=[("Pose", (0, 0)), ("At", (0, 0))],
        goal=("Done",),
    )


COOKING = """
(define (domain cooking)
  (:requirements :strips)
  (:predicates (Food ?f) (Stove ?s) (Recipe ?f ?d) (Dish ?d) (On ?f ?s) (Raw ?f) (Cooked ?f) (Busy ?s) (Served ?f)
               (Clean ?f))
  (:action wash :parameters (?f) :precondition (and (Food ?f) (Raw ?f)) :effect (Clean ?f))
  (:action put
    :parameters (?f ?s) :precondition (and (Food ?f) (Stove ?s) (Clean ?f) (not (Busy ?s)))
    :effect (and (On ?f ?s) (Busy ?s)))
  (:action cook :parameters (?f ?s) :precondition (On ?f ?s) :effect (and (Cooked ?f) (not (Raw ?f))))
  (:action serve
    :parameters (?f ?s ?d) :precondition (and (On ?f ?s) (Cooked ?f) (Recipe ?f ?d) (Dish ?d))
    :effect (and (Served ?f) (not (On ?f ?s)) (not (Busy ?s)))))
"""

COOKING_STREAMS = """
(define (stream cooking)
  (:stream plate :inputs (?f) :domain (and (Food ?f) (Cooked ?f)) :outputs (?d) :certified (Recipe ?f ?d))
  (:stream test-dish :inputs (?f ?d) :domain (Recipe ?f ?d) :certified (Dish ?d)))
"""


def cooking(foods: int) -> Problem:
    """Food is washed, cooked on the one stove, and plated, which a stream can do while it is cooked."""

    def plate(context: Any, food: str) -> Iterator[str]:
        for i in range(10):
            yield f"{food}-{i}"

    names = [f"f{i}" for i in range(foods)]
    return Problem(
        domain=COOKING,
        streams=COOKING_STREAMS,
        samplers={"plate": plate, "test-dish": lambda context, food, dish: dish.endswith("2")},
        init=[("Stove", "stove"), *(("Food", f) for f in names), *(("Raw", f) for f in names)],
        goal=("and", *(("Served", f) for f in names)),
    )


SEARCHING = """
(define (domain searching)
  (:requirements :strips)
  (:predicates (Belief ?b) (Looked ?b ?l ?b2) (Sure ?b ?l) (Now ?b) (Place ?l) (Found ?l))
  (:functions (total-cost) (Effort ?l))
  (:action look
    :parameters (?b ?l ?b2)
    :precondition (and (Looked ?b ?l ?b2) (Now ?b))
    :effect (and (Now ?b2) (not (Now ?b)) (increase (total-cost) (Effort ?l))))
  (:action take
    :parameters (?b ?l) :precondition (and (Sure ?b ?l) (Now ?b))
    :effect (and (Found ?l) (increase (total-cost) 1))))
"""

SEARCHING_STREAMS = """
(define (stream searching)
  (:stream update :inputs (?b ?l) :domain (and (Belief ?b) (Place ?l)) :outputs (?b2)
    :certified (and (Belief ?b2) (Looked ?b ?l ?b2)))
  (:stream test-sure :inputs (?b ?l) :domain (and (Belief ?b) (Place ?l)) :certified (Sure ?b ?l))
  (:function (Effort ?l) (Place ?l)))
"""


def searching(places: int) -> Problem:
    """Looks at places, each right with 0.8, until a belief of 0.95 is reached that the thing is at the last place."""

    def update(context: Any, belief: tuple[float, ...], place: int) -> Iterator[tuple[float, ...]]:
        weights = [p * (0.8 if i == place else 0.2) for i, p in enumerate(belief)]
        yield tuple(round(weight / sum(weights), 4) for weight in weights)

    start = tuple([round(1 / places, 4)] * places)
    return Problem(
        domain=SEARCHING,
        streams=SEARCHING_STREAMS,
        samplers={
            "update": update,
            "test-sure": lambda context, belief, place: belief[place] >= 0.95,
            "effort": lambda context, place: 1.0 + 0.1 * place,
        },
        init=[("Belief", start), ("Now", start), *(("Place", i) for i in range(places))],
        goal=("Found", places - 1),
    )


FILLING = """
(define (domain filling)
  (:requirements :strips :action-costs)
  (:predicates (Can ?c) (Ladle ?l) (Amount ?a) (Stock ?s) (Pour ?l ?a1 ?a2 ?s1 ?s2) (Enough ?a) (InJug ?a) (InCan ?c ?s)
               (Filled))
  (:functions (Work ?l))
  (:action pour
    :parameters (?c ?l ?a1 ?a2 ?s1 ?s2)
    :precondition (and (Can ?c) (Pour ?l ?a1 ?a2 ?s1 ?s2) (InJug ?a1) (InCan ?c ?s1))
    :effect (and (InJug ?a2) (InCan ?c ?s2) (not (InJug ?a1)) (not (InCan ?c ?s1)) (increase (total-cost) (Work ?l))))
  (:action close :parameters (?a) :precondition (and (Enough ?a) (InJug ?a)) :effect (Filled)))
"""

FILLING_STREAMS = """
(define (stream filling)
  (:stream sample-ladle :outputs (?l) :certified (Ladle ?l))
  (:stream pour :inputs (?l ?a1 ?s1) :domain (and (Ladle ?l) (Amount ?a1) (Stock ?s1)) :outputs (?a2 ?s2)
    :certified (and (Amount ?a2) (Stock ?s2) (Pour ?l ?a1 ?a2 ?s1 ?s2)))
  (:stream test-enough :inputs (?a) :domain (Amount ?a) :certified (Enough ?a))
  (:function (Work ?l) (Ladle ?l)))
"""


def filling(litres: float, cans: int = 2, stock: float = 30.0) -> Problem:
    """Ladles of any size pour from cans into a jug: what streams give multiplies with each that follows another."""

    def ladle(context: Any) -> Iterator[float]:
        while True:
            yield round(float(context.rng.uniform(1.0, stock)), 2)

    def pour(context: Any, ladle: float, jug: float, left: float) -> Iterator[tuple[float, float]]:
        if ladle <= left:
            yield round(jug + ladle, 2), round(left - ladle, 2)

    names = [f"can{i}" for i in range(cans)]
    return Problem(
        domain=FILLING,
        streams=FILLING_STREAMS,
        samplers={
            "sample-ladle": ladle,
            "pour": pour,
            "test-enough": lambda context, jug: jug >= litres,
            "work": lambda context, ladle: ladle,
        },
        init=[
            ("Amount", 2.0),
            ("InJug", 2.0),
            ("Stock", stock),
            *(("Can", name) for name in names),
            *(("InCan", name, stock) for name in names),
        ],
        goal=("Filled",),
    )


TEAMS = """
(define (domain teams)
  (:requirements :strips :equality)
  (:predicates (Robot ?r) (Spot ?q) (Way ?q1 ?t ?q2) (Apart ?q ?q2) (At ?r ?q) (Task ?x) (Reach ?x ?q) (Did ?x)
               (Crowded ?r ?q))
  (:action drive
    :parameters (?r ?q1 ?t ?q2)
    :precondition (and (Robot ?r) (Way ?q1 ?t ?q2) (At ?r ?q1) (not (Crowded ?r ?q2)))
    :effect (and (At ?r ?q2) (not (At ?r ?q1))))
  (:action do :parameters (?r ?x ?q) :precondition (and (Robot ?r) (Reach ?x ?q) (At ?r ?q)) :effect (Did ?x))
  (:derived (Crowded ?r ?q)
    (exists (?r2 ?q2) (and (Robot ?r) (At ?r2 ?q2) (not (= ?r ?r2)) (Spot ?q) (not (Apart ?q ?q2))))))
"""

TEAMS_STREAMS = """
(define (stream teams)
  (:stream sample-spot :inputs (?x) :domain (Task ?x) :outputs (?q) :certified (and (Spot ?q) (Reach ?x ?q)))
  (:stream plan-way :inputs (?q1 ?q2) :domain (and (Spot ?q1) (Spot ?q2)) :outputs (?t) :certified (Way ?q1 ?t ?q2))
  (:stream test-apart :inputs (?q ?q2) :domain (and (Spot ?q) (Spot ?q2)) :certified (Apart ?q ?q2)))
"""


def teams(tasks: int, robots: int) -> Problem:
    """Several rovers do tasks at points close together; where one stands, no other can be."""
    points = {f"x{i}": (0.4 * i, 0.0) for i in range(tasks)}

    def sample_spot(context: Any, task: str) -> Iterator[Point]:
        x, y = points[task]
        while True:
            angle = 2 * math.pi * context.rng.random()
            yield x + 0.5 * math.cos(angle), y + 0.5 * math.sin(angle)

    homes = {f"rover{i}": (2.0 * i, -3.0) for i in range(robots)}
    assert all(math.dist(a, b) > 1.0 for a, b in combinations(homes.values(), 2))
    init: list[Any] = [("Task", task) for task in points]
    for robot, home in homes.items():
        init += [("Robot", robot), ("Spot", home), ("At", robot, home)]
    goal = [("Did", task) for task in points] + [("At", robot, home) for robot, home in homes.items()]
    return Problem(
        domain=TEAMS,
        streams=TEAMS_STREAMS,
        samplers={
            "sample-spot": sample_spot,
            "plan-way": lambda context, a, b: iter([(a, b)]),
            "test-apart": lambda context, a, b: math.dist(a, b) >= 0.6,
        },
        init=init,
        goal=("and", *goal),
    )
