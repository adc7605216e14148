"""Problems in PDDLStream's form, each with the cost of its cheapest plan, known by hand or by exhaustive search."""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Hashable, Iterable, Iterator
from itertools import count
from typing import Any

from tamp.planning import Problem
from tamp.planning.pddlstream import WildOutput, from_fn, from_gen_fn, from_stream_map, from_test

GUARDS = """
(define (domain guards)
  (:predicates (Cell ?c) (Guard ?g) (Post ?g ?p) (Place ?p) (On ?g ?p) (Watches ?p ?c) (Step ?a ?b) (At ?c) (Safe ?c)
               (Lured ?g ?p ?q))
  (:functions (Price ?g))
  (:action step
    :parameters (?a ?b)
    :precondition (and (Step ?a ?b) (At ?a) (Safe ?b))
    :effect (and (At ?b) (not (At ?a)) (increase (total-cost) 1)))
  (:action lure
    :parameters (?g ?p ?q)
    :precondition (and (Lured ?g ?p ?q) (On ?g ?p))
    :effect (and (On ?g ?q) (not (On ?g ?p)) (increase (total-cost) (Price ?g))))
  (:derived (Safe ?c) (and (Cell ?c) (forall (?g ?p) (imply (On ?g ?p) (not (Watches ?p ?c)))))))
"""

GUARDS_STREAMS = """
(define (stream guards)
  (:stream find-step :inputs (?a) :domain (Cell ?a) :outputs (?b) :certified (and (Cell ?b) (Step ?a ?b)))
  (:stream find-lure
    :inputs (?g ?p) :domain (Post ?g ?p) :outputs (?q) :certified (and (Post ?g ?q) (Place ?q) (Lured ?g ?p ?q)))
  (:predicate (Watches ?p ?c) (and (Place ?p) (Cell ?c)))
  (:function (Price ?g) (Guard ?g)))
"""


def guards(length: int, posts: tuple[tuple[int, int], ...]) -> tuple[Problem, float]:
    """Along a corridor of two lanes, past guards who watch the cell they stand in, and can be lured over."""

    def steps(cell: tuple[int, int]) -> Iterator[tuple[tuple[int, int]]]:
        for dx, dy in ((1, 0), (0, 1), (-1, 0), (0, -1)):
            if 0 <= cell[0] + dx < length and 0 <= cell[1] + dy < 2:
                yield ((cell[0] + dx, cell[1] + dy),)

    init: list[Any] = [("Cell", (0, 0)), ("At", (0, 0)), ("Cell", (length - 1, 0))]
    for i, post in enumerate(posts):
        init += [("Guard", i), ("Post", i, post), ("Place", post), ("On", i, post)]
    stream_map: dict[str, Any] = {
        "find-step": from_gen_fn(steps),
        "find-lure": from_fn(lambda guard, post: ((post[0], 1 - post[1]),)),
        "watches": from_test(lambda post, cell: post == cell),
        "price": lambda guard: 5.0,
    }

    def after(state: tuple[tuple[int, int], tuple[tuple[int, int], ...]]) -> Iterator[tuple[Hashable, float]]:
        at, on = state
        for (cell,) in steps(at):
            if cell not in on:
                yield (cell, on), 1.0
        for i, (x, y) in enumerate(on):
            yield (at, (*on[:i], (x, 1 - y), *on[i + 1 :])), 5.0

    best = cheapest(((0, 0), posts), after, lambda state: state[0] == (length - 1, 0))
    return Problem(GUARDS, GUARDS_STREAMS, from_stream_map(stream_map), init, ("At", (length - 1, 0))), best


DOORS = """
(define (domain doors)
  (:predicates (Room ?r) (Door ?d) (Leads ?d ?a ?b) (Key ?k) (Fits ?k ?d) (At ?r) (Lies ?k ?r) (Has ?k) (Open ?d))
  (:action walk
    :parameters (?d ?a ?b)
    :precondition (and (Leads ?d ?a ?b) (At ?a) (Open ?d))
    :effect (and (At ?b) (not (At ?a)) (increase (total-cost) 1)))
  (:action unlock
    :parameters (?d ?a ?b ?k)
    :precondition (and (Leads ?d ?a ?b) (At ?a) (Has ?k) (Fits ?k ?d))
    :effect (and (Open ?d) (increase (total-cost) 2)))
  (:action take
    :parameters (?k ?r)
    :precondition (and (Key ?k) (Lies ?k ?r) (At ?r))
    :effect (and (Has ?k) (not (Lies ?k ?r)) (increase (total-cost) 1))))
"""

DOORS_STREAMS = """
(define (stream doors)
  (:stream explore :inputs (?r) :domain (Room ?r) :certified (and))
  (:stream test-fits :inputs (?k ?d) :domain (and (Key ?k) (Door ?d)) :certified (Fits ?k ?d)))
"""


def doors(rooms: int) -> tuple[Problem, float]:
    """Rooms in a row, of which a wild stream tells what leads on; the key of a door lies a room before its own."""

    def explore(room: int) -> Iterator[Any]:
        door, on = f"door {room}", room + 1
        facts = [("Door", door), ("Leads", door, room, on), ("Leads", door, on, room), ("Room", on)]
        yield WildOutput([()], facts if on < rooms else [])

    init: list[Any] = [("Room", 0), ("At", 0)]
    for i in range(rooms - 1):
        init += [("Key", f"key {i}"), ("Lies", f"key {i}", max(0, i - 1))]
    stream_map: dict[str, Any] = {
        "explore": from_gen_fn(explore),
        "test-fits": from_test(lambda key, door: key[3:] == door[4:]),
    }
    return Problem(DOORS, DOORS_STREAMS, from_stream_map(stream_map), init, ("At", rooms - 1)), 4.0 * (rooms - 1)


MEETING = """
(define (domain meeting)
  (:predicates (Robot ?r) (Point ?p) (Way ?r ?a ?b) (At ?r ?p) (Met))
  (:functions (Far ?a ?b))
  (:action go
    :parameters (?r ?a ?b)
    :precondition (and (Way ?r ?a ?b) (At ?r ?a))
    :effect (and (At ?r ?b) (not (At ?r ?a)) (increase (total-cost) (Far ?a ?b))))
  (:derived (Met) (exists (?p) (and (Point ?p) (forall (?r) (imply (Robot ?r) (At ?r ?p)))))))
"""

MEETING_STREAMS = """
(define (stream meeting)
  (:stream find-point :outputs (?p) :certified (Point ?p))
  (:stream test-way
    :inputs (?r ?a ?b) :domain (and (Robot ?r) (Point ?a) (Point ?b)) :certified (Way ?r ?a ?b))
  (:function (Far ?a ?b) (and (Point ?a) (Point ?b))))
"""


def meeting(
    homes: tuple[float, ...], points: tuple[float, ...], at_home: tuple[int, ...] = ()
) -> tuple[Problem, float]:
    """Robots on a line meet at a point, of which a stream gives some; those `at_home` do not leave."""
    init: list[Any] = [f for i, x in enumerate(homes) for f in (("Robot", i), ("Point", x), ("At", i, x))]
    stream_map: dict[str, Any] = {
        "find-point": from_gen_fn(lambda: ((x,) for x in points)),
        "test-way": from_test(lambda robot, a, b: robot not in at_home),
        "far": lambda a, b: abs(a - b),
    }
    places = tuple(homes[i] for i in at_home) or homes + points
    best = min(sum(abs(home - place) for home in homes) for place in places)
    return Problem(MEETING, MEETING_STREAMS, from_stream_map(stream_map), init, ("Met",)), best


TRAY = """
(define (domain tray)
  (:predicates (Egg ?i) (Tray ?t) (Spot ?s) (On ?i ?t) (TrayAt ?t ?s) (At ?i ?s) (Leads ?a ?r ?b) (Road ?r)
               (Rough ?i ?r) (Wrapped ?i) (Broken ?i))
  (:functions (Time ?r))
  (:action load
    :parameters (?i ?t ?s)
    :precondition (and (Egg ?i) (At ?i ?s) (TrayAt ?t ?s))
    :effect (and (On ?i ?t) (not (At ?i ?s)) (increase (total-cost) 1)))
  (:action wrap :parameters (?i ?t) :precondition (On ?i ?t) :effect (and (Wrapped ?i) (increase (total-cost) 2)))
  (:action unload
    :parameters (?i ?t ?s)
    :precondition (and (On ?i ?t) (TrayAt ?t ?s))
    :effect (and (At ?i ?s) (not (On ?i ?t)) (not (Wrapped ?i)) (increase (total-cost) 1)))
  (:action carry
    :parameters (?t ?a ?r ?b)
    :precondition (and (Tray ?t) (Leads ?a ?r ?b) (TrayAt ?t ?a))
    :effect (and (TrayAt ?t ?b) (not (TrayAt ?t ?a)) (increase (total-cost) (Time ?r))
                 (forall (?i) (when (and (On ?i ?t) (Rough ?i ?r) (not (Wrapped ?i))) (Broken ?i))))))
"""

TRAY_STREAMS = """
(define (stream tray)
  (:stream find-road
    :inputs (?a ?b) :domain (and (Spot ?a) (Spot ?b)) :outputs (?r) :certified (and (Leads ?a ?r ?b) (Road ?r)))
  (:stream test-rough :inputs (?i ?r) :domain (and (Egg ?i) (Road ?r)) :certified (Rough ?i ?r))
  (:function (Time ?r) (Road ?r)))
"""


def tray(eggs: int) -> tuple[Problem, float]:
    """Eggs are carried along a rough road, wrapped, or along a long one: one is cheaper for few, one for many."""
    init: list[Any] = [("Tray", "tray"), ("TrayAt", "tray", "here"), ("Spot", "here"), ("Spot", "there")]
    goal: list[Any] = ["and"]
    for i in range(eggs):
        init += [("Egg", f"egg {i}"), ("At", f"egg {i}", "here")]
        goal += [("At", f"egg {i}", "there"), ("not", ("Broken", f"egg {i}"))]
    stream_map: dict[str, Any] = {
        "find-road": from_gen_fn(lambda a, b: (((kind, a, b),) for kind in ("rough", "long") if a != b)),
        "test-rough": from_test(lambda egg, road: road[0] == "rough"),
        "time": lambda road: 2.0 if road[0] == "rough" else 7.0,
    }
    problem = Problem(TRAY, TRAY_STREAMS, from_stream_map(stream_map), init, tuple(goal))
    return problem, 2.0 * eggs + min(2.0 + 2.0 * eggs, 7.0)


JUGS = """
(define (domain jugs)
  (:predicates (Jug ?j) (Volume ?l) (Level ?j ?l) (Full ?j ?l) (Empty ?l) (Poured ?i ?x ?j ?y ?x2 ?y2) (Wanted ?l)
               (Done))
  (:functions (Amount ?x ?x2))
  (:action fill
    :parameters (?j ?l ?c)
    :precondition (and (Jug ?j) (Level ?j ?l) (Full ?j ?c))
    :effect (and (Level ?j ?c) (not (Level ?j ?l)) (increase (total-cost) 3)))
  (:action spill
    :parameters (?j ?l ?c)
    :precondition (and (Jug ?j) (Level ?j ?l) (Empty ?c))
    :effect (and (Level ?j ?c) (not (Level ?j ?l)) (increase (total-cost) 1)))
  (:action pour
    :parameters (?i ?x ?j ?y ?x2 ?y2)
    :precondition (and (Poured ?i ?x ?j ?y ?x2 ?y2) (Level ?i ?x) (Level ?j ?y))
    :effect (and (Level ?i ?x2) (Level ?j ?y2) (not (Level ?i ?x)) (not (Level ?j ?y))
                 (increase (total-cost) (Amount ?x ?x2))))
  (:derived (Done) (exists (?j ?l) (and (Level ?j ?l) (Wanted ?l)))))
"""

JUGS_STREAMS = """
(define (stream jugs)
  (:stream pour
    :inputs (?i ?x ?j ?y) :domain (and (Jug ?i) (Jug ?j) (Volume ?x) (Volume ?y)) :outputs (?x2 ?y2)
    :certified (and (Volume ?x2) (Volume ?y2) (Poured ?i ?x ?j ?y ?x2 ?y2)))
  (:stream test-wanted :inputs (?l) :domain (Volume ?l) :certified (Wanted ?l))
  (:function (Amount ?x ?x2) (and (Volume ?x) (Volume ?x2))))
"""


def jugs(sizes: tuple[float, float], wanted: float) -> tuple[Problem, float]:
    """Two jugs, one of which shall hold an amount: levels are values that a stream gives of each other."""
    size = dict(zip(("first", "second"), sizes, strict=True))

    def pour(i: str, x: float, j: str, y: float) -> tuple[float, float] | None:
        amount = min(x, size[j] - y)
        return (x - amount, y + amount) if i != j and amount > 0.0 and x <= size[i] else None

    init: list[Any] = [("Volume", 0.0), ("Empty", 0.0)]
    for jug, most in size.items():
        init += [("Jug", jug), ("Level", jug, 0.0), ("Full", jug, most), ("Volume", most)]
    stream_map: dict[str, Any] = {
        "pour": from_fn(pour),
        "test-wanted": from_test(lambda level: level == wanted),
        "amount": lambda x, x2: abs(x - x2),
    }

    def after(levels: tuple[float, float]) -> Iterator[tuple[Hashable, float]]:
        a, b = levels
        yield from (((sizes[0], b), 3.0), ((a, sizes[1]), 3.0), ((0.0, b), 1.0), ((a, 0.0), 1.0))
        for amount in (min(a, sizes[1] - b), -min(b, sizes[0] - a)):
            if amount:
                yield (a - amount, b + amount), abs(amount)

    best = cheapest((0.0, 0.0), after, lambda levels: wanted in levels)
    return Problem(JUGS, JUGS_STREAMS, from_stream_map(stream_map), init, ("Done",)), best


def cheapest(first: Any, after: Callable[[Any], Iterable[tuple[Any, float]]], reached: Callable[[Any], bool]) -> float:
    """The least cost to a state (Dijkstra's algorithm); infinity where there is none."""
    order = count()
    costs, queue = {first: 0.0}, [(0.0, next(order), first)]
    while queue:
        cost, _, state = heapq.heappop(queue)
        if reached(state):
            return cost
        for other, price in after(state) if cost == costs[state] else ():
            if cost + price < costs.get(other, math.inf):
                costs[other] = cost + price
                heapq.heappush(queue, (cost + price, next(order), other))
    return math.inf
