"""A problem in PDDLStream's form about where things may be: guesses as values, moves that fail, looks that err."""

from __future__ import annotations

from typing import Any

from tamp.planning import Problem
from tamp.planning.pddlstream import from_fn, from_stream_map, from_test

HIDDEN = """
(define (domain hidden)
  (:requirements :strips)
  (:predicates (Spot ?s) (Guess ?x ?g) (Likely ?x ?g) (Shifted ?x ?g1 ?s1 ?s2 ?g2) (Peeked ?x ?g1 ?s ?seen ?g2)
               (SureOf ?x ?g ?s) (Full ?s ?x ?g) (IsAt ?x ?s) (Risky ?s))
  (:functions (Effort ?x ?g ?s ?seen))
  (:action shift
    :parameters (?x ?g1 ?s1 ?s2 ?g2)
    :precondition (and (Shifted ?x ?g1 ?s1 ?s2 ?g2) (Likely ?x ?g1) (not (Risky ?s2)))
    :effect (and (Likely ?x ?g2) (not (Likely ?x ?g1)) (increase (total-cost) 1)))
  (:action peek
    :parameters (?x ?g1 ?s ?seen ?g2)
    :precondition (and (Peeked ?x ?g1 ?s ?seen ?g2) (Likely ?x ?g1))
    :effect (and (Likely ?x ?g2) (not (Likely ?x ?g1)) (increase (total-cost) (Effort ?x ?g1 ?s ?seen))))
  (:derived (IsAt ?x ?s) (exists (?g) (and (SureOf ?x ?g ?s) (Likely ?x ?g))))
  (:derived (Risky ?s) (exists (?x ?g) (and (Spot ?s) (Full ?s ?x ?g) (Likely ?x ?g)))))
"""

HIDDEN_STREAMS = """
(define (stream hidden)
  (:function (Effort ?x ?g ?s ?seen) (and (Guess ?x ?g) (Spot ?s) (Answer ?seen)))
  (:predicate (Full ?s ?x ?g) (and (Spot ?s) (Guess ?x ?g)))
  (:stream test-sure :inputs (?x ?g ?s) :domain (and (Guess ?x ?g) (Wanted ?x ?s)) :certified (SureOf ?x ?g ?s))
  (:stream after-shift
    :inputs (?x ?g1 ?s1 ?s2) :domain (and (Guess ?x ?g1) (Spot ?s1) (Spot ?s2)) :outputs (?g2)
    :certified (and (Guess ?x ?g2) (Shifted ?x ?g1 ?s1 ?s2 ?g2)))
  (:stream after-peek
    :inputs (?x ?g1 ?s ?seen) :domain (and (Guess ?x ?g1) (Spot ?s) (Answer ?seen)) :outputs (?g2)
    :certified (and (Guess ?x ?g2) (Peeked ?x ?g1 ?s ?seen ?g2))))
"""

MOVED, SEEN, SURE, RISK = 0.8, 0.9, 0.95, 0.25
"""How likely a shift succeeds and a look is right, when one is sure of a place, and when it may be occupied."""


def hidden(wanted: int = 2, spots: int = 3) -> Problem:
    """One thing is to be at a spot where another most likely is; a guess says how likely a thing is at each spot.

    To shift a thing from a spot to itself gives the same guess again.
    """

    def about(spot: int, share: float) -> tuple[float, ...]:
        return tuple(share * (i == spot) + (1.0 - share) / spots for i in range(spots))

    def after_shift(thing: str, guess: tuple[float, ...], start: int, end: int) -> tuple[tuple[float, ...]]:
        moved = MOVED * guess[start] if start != end else 0.0
        return (tuple(p + moved * ((i == end) - (i == start)) for i, p in enumerate(guess)),)

    def weights(guess: tuple[float, ...], spot: int, seen: bool) -> list[float]:
        return [p * (SEEN if (i == spot) == seen else 1.0 - SEEN) for i, p in enumerate(guess)]

    def after_peek(thing: str, guess: tuple[float, ...], spot: int, seen: bool) -> tuple[tuple[float, ...]]:
        found = weights(guess, spot, seen)
        return (tuple(w / sum(found) for w in found),)

    stream_map = {
        "test-sure": from_test(lambda thing, guess, spot: guess[spot] >= SURE),
        "after-shift": from_fn(after_shift),
        "after-peek": from_fn(after_peek),
        "full": lambda spot, thing, guess: guess[spot] > RISK,
        "effort": lambda thing, guess, spot, seen: 1.0 / sum(weights(guess, spot, seen)),
    }
    init: list[Any] = [
        *(("Spot", i) for i in range(spots)),
        ("Answer", True),
        ("Answer", False),
        ("Wanted", "a", wanted),
    ]
    for thing, guess in (("a", about(1, 0.6)), ("b", about(2, 0.9))):
        init += [("Guess", thing, guess), ("Likely", thing, guess)]
    return Problem(HIDDEN, HIDDEN_STREAMS, from_stream_map(stream_map), init, ("IsAt", "a", wanted))
