"""Goals with exists and forall, facts as lists, types, and conditional effects."""

from collections.abc import Iterator
from typing import Any

from tamp.planning import Problem

DOMAIN = """
(define (domain trays)
  (:requirements :adl :typing)
  (:types item tray - object  cup plate - item  slot)
  (:constants Shelf - tray)
  (:predicates (Fits ?i - item ?s - slot) (Of ?s - slot ?t - tray) (In ?i - item ?s - slot) (Loose ?i - item)
               (Dirty ?x) (Full ?s - slot) (Ready ?t - tray))
  (:action put
    :parameters (?i - item ?s - slot)
    :precondition (and (Fits ?i ?s) (Loose ?i) (not (Full ?s)) (not (Dirty ?i)))
    :effect (and (In ?i ?s) (Full ?s) (not (Loose ?i))))
  (:action rinse
    :parameters (?t - tray)
    :precondition (exists (?i - item) (Dirty ?i))
    :effect (and (not (Dirty ?t)) (forall (?c - cup) (when (Loose ?c) (not (Dirty ?c))))))
  (:action wipe :parameters (?p - plate) :precondition (Loose ?p) :effect (not (Dirty ?p)))
  (:derived (Ready ?t - tray)
    (and (not (Dirty ?t))
         (exists (?s - slot ?c - cup) (and (Of ?s ?t) (In ?c ?s)))
         (forall (?i - item ?s - slot) (imply (and (In ?i ?s) (Of ?s ?t)) (not (Dirty ?i)))))))
"""

STREAMS = """
(define (stream trays)
  (:stream sample-slot
    :inputs (?i - item ?t - tray)
    :outputs (?s - slot)
    :certified (and (Fits ?i ?s) (Of ?s ?t))))
"""


def sample_slot(context: Any, item: str, tray: str) -> Iterator[tuple[str, str, int]]:
    for number in range(2):
        yield (item, tray, number)


def trays(n: int) -> Problem:
    """n cups and n plates, all dirty: none may stay loose, some plate lies on the shelf, and every tray is ready."""
    init: list[Any] = [["tray", "left"], ["Dirty", "left"]]
    for i in range(n):
        init += [["cup", f"cup{i}"], ["plate", f"plate{i}"]]
        init += [["Loose", f"{kind}{i}"] for kind in ("cup", "plate")]
        init += [["Dirty", f"{kind}{i}"] for kind in ("cup", "plate")]
    goal = [
        "and",
        ["forall", ["?i - item"], ["not", ["Loose", "?i"]]],
        ["exists", ["?p - plate", "?s - slot"], ["and", ["In", "?p", "?s"], ["Of", "?s", "shelf"]]],
        ["exists", ["?t - tray"], ["Ready", "?t"]],
        ["imply", ["exists", ["?c"], ["and", ["cup", "?c"], ["Dirty", "?c"]]], ["Ready", "Shelf"]],
    ]
    return Problem(domain=DOMAIN, streams=STREAMS, samplers={"sample-slot": sample_slot}, init=init, goal=goal)
