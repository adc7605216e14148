"""Streams that are told the state: whether a room can be entered depends on how many boxes stand in it."""

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

from tamp.planning import Problem

DOMAIN = """
(define (domain corridor)
  (:requirements :strips)
  (:predicates (Room ?r) (Box ?b) (Path ?r1 ?t ?r2) (In ?b ?r) (At ?r) (Carrying ?b) (HandEmpty))
  (:action go
    :parameters (?r1 ?t ?r2)
    :precondition (and (Path ?r1 ?t ?r2) (At ?r1))
    :effect (and (At ?r2) (not (At ?r1))))
  (:action lift
    :parameters (?b ?r)
    :precondition (and (Box ?b) (In ?b ?r) (At ?r) (HandEmpty))
    :effect (and (Carrying ?b) (not (In ?b ?r)) (not (HandEmpty))))
  (:action drop
    :parameters (?b ?r)
    :precondition (and (Room ?r) (Carrying ?b) (At ?r))
    :effect (and (In ?b ?r) (HandEmpty) (not (Carrying ?b)))))
"""

STREAMS = """
(define (stream corridor)
  (:stream plan-path
    :inputs (?r1 ?r2)
    :domain (and (Room ?r1) (Room ?r2))
    :fluents (In)
    :outputs (?t)
    :certified (Path ?r1 ?t ?r2)))
"""


def passable(start: int, end: int, boxes: dict[str, int], capacity: dict[int, int]) -> bool:
    """Rooms are neighbours, and the room entered holds fewer boxes than its capacity."""
    return abs(start - end) == 1 and sum(room == end for room in boxes.values()) < capacity.get(end, 99)


def plan_path(context: Any, start: int, end: int) -> Iterator[tuple[int, ...]]:
    boxes = {fact[1]: fact[2] for fact in context.fluents if fact[0].lower() == "in"}
    if passable(start, end, boxes, context.scene):
        yield (start, end, len(boxes))


def check(name: str, args: tuple[Any, ...], facts: dict[str, Any], capacity: dict[int, int]) -> None:
    """Each path that is taken is passable with the boxes where they are."""
    if name == "go":
        boxes = {box.value: room.value for box, room in facts.get("in", ())}
        assert passable(args[0], args[2], boxes, capacity), f"{args} cannot be passed with boxes at {boxes}"


def corridor(boxes: int) -> Problem:
    """Rooms 0 to 3 in a row, boxes in room 1; the first goes to room 2 and all others, then the robot, to room 3.

    Room 2 cannot be entered once a box stands in it: the first box must be moved last.
    """
    init: list[Any] = [("Room", room) for room in range(4)]
    init += [("At", 0), ("HandEmpty",)]
    for i in range(boxes):
        init += [("Box", f"box{i}"), ("In", f"box{i}", 1)]
    goal = ("and", ("At", 3), *(("In", f"box{i}", 3 if i else 2) for i in range(boxes)))
    return Problem(
        domain=DOMAIN, streams=STREAMS, samplers={"plan-path": plan_path}, init=init, goal=goal, scene={2: 1}
    )


def blocked(boxes: int = 2) -> Problem:
    """The robot starts in room 2 among boxes, and two of them bar it: the first must go to room 1, the robot to 3."""
    init: list[Any] = [("Room", room) for room in range(4)]
    init += [("At", 2), ("HandEmpty",)]
    for i in range(boxes):
        init += [("Box", f"box{i}"), ("In", f"box{i}", 2)]
    goal = ("and", ("In", "box0", 1), ("At", 3))
    return Problem(
        domain=DOMAIN, streams=STREAMS, samplers={"plan-path": plan_path}, init=init, goal=goal, scene={2: 2}
    )


TOLD = """
(define (stream corridor)
  (:stream test-passable
    :inputs (?r1 ?r2)
    :domain (and (Room ?r1) (Room ?r2))
    :fluents (In)
    :certified (Passable ?r1 ?r2)))
"""


def told_corridor(boxes: int) -> Problem:
    """As `corridor`, where a test is told the state in place of a stream with outputs."""
    domain = DOMAIN.replace("(Path ?r1 ?t ?r2)", "(Passable ?r1 ?r2)").replace("(?r1 ?t ?r2)", "(?r1 ?r2)")
    plain = corridor(boxes)

    def test(context: Any, start: int, end: int) -> bool:
        return passable(start, end, {fact[1]: fact[2] for fact in context.fluents}, plain.scene)

    return Problem(domain, TOLD, {"test-passable": test}, plain.init, plain.goal, plain.scene)


KITCHEN = """
(define (domain kitchen)
  (:requirements :strips)
  (:predicates (Food ?f) (Washable ?f) (Wet ?b) (Clean ?f) (Cooked ?f))
  (:action wash :parameters (?f) :precondition (Washable ?f) :effect (Clean ?f))
  (:action cook :parameters (?f) :precondition (and (Food ?f) (Clean ?f)) :effect (and (Cooked ?f) (not (Clean ?f)))))
"""

KITCHEN_STREAMS = """
(define (stream kitchen)
  (:stream test-washable :inputs (?f) :domain (Food ?f) :fluents (Cooked Wet) :certified (Washable ?f)))
"""


def washing(foods: int, clean: bool = False) -> Problem:
    """Nothing can be washed once anything is cooked: all are washed first; `clean`: the first also at the end.

    The test is told what is wet as well, which never changes.
    """

    def washable(context: Any, food: str) -> bool:
        assert ("wet", "sponge") in context.fluents
        return not any(fact[0] == "cooked" for fact in context.fluents)

    names = [f"food{i}" for i in range(foods)]
    goal = [("Cooked", name) for name in names] + [("Clean", names[0])] * clean
    init = [("Wet", "sponge"), *(("Food", name) for name in names)]
    return Problem(KITCHEN, KITCHEN_STREAMS, {"test-washable": washable}, init, ("and", *goal))


YARD = """
(define (domain yard)
  (:requirements :strips)
  (:predicates (Crate ?c) (Spot ?c ?x) (Above ?x ?q) (In ?x ?z) (Quiet ?q1 ?q2) (Over ?q) (Stands ?c ?x) (Lifted ?c)
               (Free) (Ready) (Stored ?c ?z))
  (:action drive
    :parameters (?q1 ?q2)
    :precondition (and (Quiet ?q1 ?q2) (Over ?q1) (Ready))
    :effect (and (Over ?q2) (not (Over ?q1)) (not (Ready))))
  (:action lift
    :parameters (?c ?x ?q)
    :precondition (and (Spot ?c ?x) (Above ?x ?q) (Over ?q) (Stands ?c ?x) (Free))
    :effect (and (Lifted ?c) (Ready) (not (Stands ?c ?x)) (not (Free))))
  (:action lower
    :parameters (?c ?x ?q)
    :precondition (and (Spot ?c ?x) (Above ?x ?q) (Over ?q) (Lifted ?c))
    :effect (and (Stands ?c ?x) (Free) (Ready) (not (Lifted ?c))))
  (:derived (Stored ?c ?z) (exists (?x) (and (Spot ?c ?x) (In ?x ?z) (Stands ?c ?x)))))
"""

YARD_STREAMS = """
(define (stream yard)
  (:stream sample-spot
    :inputs (?c ?z) :domain (May ?c ?z) :outputs (?x) :certified (and (Spot ?c ?x) (In ?x ?z)))
  (:stream find-above
    :inputs (?c ?x) :domain (Spot ?c ?x) :outputs (?q) :certified (and (Place ?q) (Above ?x ?q)))
  (:stream test-quiet
    :inputs (?q1 ?q2) :domain (and (Place ?q1) (Place ?q2)) :fluents (Stands) :certified (Quiet ?q1 ?q2)))
"""

ZONES = {"yard": (-9.0, 9.0), "bay": (6.0, 9.0)}


def yard(starts: tuple[float, ...] = (0.0, 7.5)) -> Problem:
    """A crane drives no more once two crates stand closer than 2 m; all are to be in the bay in the end."""

    def sample_spot(context: Any, crate: str, zone: str) -> Iterator[float]:
        while True:
            yield context.rng.uniform(*ZONES[zone])

    def find_above(context: Any, crate: str, spot: float) -> Iterator[tuple[str, float]]:
        yield "above", spot

    def test_quiet(context: Any, start: Any, end: Any) -> bool:
        spots = sorted(fact[2] for fact in context.fluents)
        return all(b - a > 2.0 for a, b in pairwise(spots))

    init: list[Any] = [("Place", "home"), ("Over", "home"), ("Free",), ("Ready",)]
    for i, start in enumerate(starts):
        crate = f"crate {i}"
        init += [("Crate", crate), ("Spot", crate, start), ("Stands", crate, start), ("May", crate, "yard")]
        init += [("May", crate, "bay"), *(("In", start, z) for z, (a, b) in ZONES.items() if a <= start <= b)]
    goal = ("and", ("Over", "home"), *(("Stored", f"crate {i}", "bay") for i in range(len(starts))))
    samplers = {"sample-spot": sample_spot, "find-above": find_above, "test-quiet": test_quiet}
    return Problem(YARD, YARD_STREAMS, samplers, init, goal)
