"""Recursive derived predicates: what can be reached through open doors, and what stands above what."""

from itertools import pairwise
from typing import Any

from tamp.planning import Problem

ROOMS = """
(define (domain rooms)
  (:requirements :adl :derived-predicates)
  (:predicates (Door ?d ?a ?b) (Key ?k ?d) (At ?a) (Open ?d) (Lies ?k ?a) (Has ?k) (Reachable ?a) (Visited ?a))
  (:action fetch
    :parameters (?k ?a)
    :precondition (and (Lies ?k ?a) (Reachable ?a))
    :effect (and (Has ?k) (not (Lies ?k ?a))))
  (:action unlock
    :parameters (?k ?d ?a ?b)
    :precondition (and (Has ?k) (Key ?k ?d) (Door ?d ?a ?b) (Reachable ?a) (not (Open ?d)))
    :effect (Open ?d))
  (:action go
    :parameters (?a ?b)
    :precondition (and (At ?a) (Reachable ?b))
    :effect (and (At ?b) (not (At ?a)) (Visited ?b)))
  (:derived (Reachable ?b)
    (or (At ?b) (exists (?a ?d) (and (Door ?d ?a ?b) (Open ?d) (Reachable ?a))))))
"""


def rooms(n: int) -> Problem:
    """n locked rooms in a row; the key of each door lies in the room before it, that of the first in the hall."""
    init: list[Any] = [("At", 0)]
    for i in range(n):
        init += [("Door", f"door{i}", i, i + 1), ("Door", f"door{i}", i + 1, i)]
        init += [("Key", f"key{i}", f"door{i}"), ("Lies", f"key{i}", i)]
    return Problem(domain=ROOMS, init=init, goal=("and", ("Visited", n), ("Reachable", 0)))


TOWERS = """
(define (domain towers)
  (:requirements :adl :derived-predicates :conditional-effects)
  (:predicates (Block ?b) (On ?a ?b) (Above ?a ?b) (Table ?t) (Free ?b) (Painted ?b) (Wet ?b))
  (:action put
    :parameters (?a ?from ?to)
    :precondition (and (Block ?a) (On ?a ?from) (Free ?a) (Free ?to) (not (= ?a ?to)) (not (= ?from ?to)))
    :effect (and (On ?a ?to) (not (On ?a ?from))))
  (:action spray
    :parameters (?b)
    :precondition (and (Block ?b) (not (Wet ?b)))
    :effect (and (Painted ?b) (Wet ?b)
                 (forall (?c) (when (and (Block ?c) (Above ?c ?b)) (Painted ?c)))))
  (:derived (Free ?x) (or (Table ?x) (and (Block ?x) (forall (?y) (not (On ?y ?x))))))
  (:derived (Above ?a ?b) (or (On ?a ?b) (exists (?c) (and (On ?a ?c) (Above ?c ?b))))))
"""


def painted_tower(n: int) -> Problem:
    """A tower of n blocks; the lowest must come to the top, and paint, which rises, must reach all blocks."""
    blocks = [f"b{i}" for i in range(n)]
    init: list[Any] = [("Table", "table"), ("On", blocks[0], "table")]
    init += [("Block", block) for block in blocks]
    init += [("On", above, below) for below, above in pairwise(blocks)]
    painted = ("forall", ("?b",), ("imply", ("Block", "?b"), ("Painted", "?b")))
    return Problem(domain=TOWERS, init=init, goal=("and", ("Above", blocks[0], blocks[-1]), painted))
