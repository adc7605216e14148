"""Gardeners on the two banks of a river, whose sampler looks for places on the other bank in vain, and without end."""

from collections.abc import Iterator
from typing import Any

from tamp.planning import Problem

GARDEN = """
(define (domain garden)
  (:predicates (Gardener ?g) (Plant ?p) (Well ?w) (Spot ?g ?q) (Reach ?g ?q ?x) (Path ?g ?q1 ?t ?q2)
               (At ?g ?q) (Full ?g) (Watered ?p))
  (:action walk
    :parameters (?g ?q1 ?t ?q2)
    :precondition (and (Path ?g ?q1 ?t ?q2) (At ?g ?q1))
    :effect (and (At ?g ?q2) (not (At ?g ?q1))))
  (:action fill
    :parameters (?g ?q ?w)
    :precondition (and (Well ?w) (Reach ?g ?q ?w) (At ?g ?q))
    :effect (Full ?g))
  (:action water
    :parameters (?g ?q ?p)
    :precondition (and (Plant ?p) (Reach ?g ?q ?p) (At ?g ?q) (Full ?g))
    :effect (and (Watered ?p) (not (Full ?g)))))
"""

GARDEN_STREAMS = """
(define (stream garden)
  (:stream find-spot
    :inputs (?g ?x) :domain (and (Gardener ?g) (Thing ?x)) :outputs (?q) :certified (and (Spot ?g ?q) (Reach ?g ?q ?x)))
  (:stream find-path
    :inputs (?g ?q1 ?q2)
    :domain (and (Spot ?g ?q1) (Spot ?g ?q2)) :outputs (?t) :certified (Path ?g ?q1 ?t ?q2)))
"""

BANKS = {"left": -1.0, "right": 1.0}


def garden(plants: int, luck: float = 1.0, idle: bool = False) -> Problem:
    """As many plants on each bank are watered, from one well there; a gardener is home in the end.

    Args:
        plants: their number on each bank.
        luck: the share of calls in which a spot on the right bank is found.
        idle: whether an action has a parameter of which it says nothing.
    """
    domain = GARDEN.replace("(?g ?q ?p)", "(?g ?q ?p ?any)") if idle else GARDEN
    things = {f"{bank} {what}": side for bank, side in BANKS.items() for what in ("well", *map(str, range(plants)))}

    def find_spot(context: Any, gardener: str, thing: str) -> Iterator[float | None]:
        side = things[thing]
        while True:
            found = BANKS[gardener] == side and context.rng.random() < luck
            yield side * context.rng.uniform(1.0, 9.0) if found else None

    init: list[Any] = []
    for gardener, home in BANKS.items():
        init += [("Gardener", gardener), ("Spot", gardener, home), ("At", gardener, home)]
    for thing in things:
        init += [("Thing", thing), ("Well" if "well" in thing else "Plant", thing)]
    goal = [("Watered", thing) for thing in things if "well" not in thing]
    return Problem(
        domain=domain,
        streams=GARDEN_STREAMS,
        samplers={"find-spot": find_spot, "find-path": lambda context, gardener, a, b: iter([(a, b)])},
        init=init,
        goal=("and", *goal, *[("At", gardener, home) for gardener, home in BANKS.items()]),
    )
