"""Small problems that can be solved only by reading streams exactly: tests in effects, further facts, awaited facts."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from tamp.planning import Certified, Problem

LAMPS = """
(define (domain lamps)
  (:predicates (lamp ?x) (good ?x) (lit ?x) (smoke ?x) (tried ?x) (d ?x) (seen ?x))
  (:action switch :parameters (?x) :precondition (lamp ?x)
    :effect (and (tried ?x) (when {condition} ({effect} ?x))))
  (:action see :parameters (?x) :precondition (and (tried ?x) {wanted}) :effect (seen ?x)))
"""

TEST = "(define (stream lamps) (:stream test-good :inputs (?x) :domain (lamp ?x) :certified (good ?x)))"


def lamps(condition: str, effect: str, wanted: str, goods: str) -> Problem:
    """Some lamp can be seen; what switching it does depends on a test."""
    return Problem(
        domain=LAMPS.format(condition=condition, effect=effect, wanted=wanted),
        streams=TEST,
        samplers={"test-good": lambda context, lamp: lamp in goods},
        init=[("lamp", lamp) for lamp in "abc"],
        goal=("exists", ("?x",), ("seen", "?x")),
    )


EFFECTS = {
    "a good one lights": lambda: lamps("(good ?x)", "lit", "(lit ?x)", "c"),
    "a bad one lights": lambda: lamps("(not (good ?x))", "lit", "(lit ?x)", "ab"),
    "a good one smokes": lambda: lamps("(good ?x)", "smoke", "(not (smoke ?x))", "ab"),
    "a bad one smokes": lambda: lamps("(not (good ?x))", "smoke", "(not (smoke ?x))", "c"),
    "all bad, none smokes": lambda: lamps("(good ?x)", "smoke", "(not (smoke ?x))", ""),
    "all good, none smokes": lambda: lamps("(not (good ?x))", "smoke", "(not (smoke ?x))", "abc"),
}

WILD = """
(define (domain wild)
  (:predicates (thing ?x) (made ?x ?y) (bonus ?x) (golden ?y) (have ?y))
  (:action take :parameters (?y) :precondition ({wanted} ?y) :effect (have ?y)))
"""

WILD_STREAMS = """
(define (stream wild)
  (:stream make :inputs (?x) :domain (thing ?x) :outputs (?y) :certified (made ?x ?y))
  (:stream gild :inputs (?x) :domain (bonus ?x) :outputs (?y) :certified (golden ?y)))
"""


def wild(wanted: str, fails: bool = False) -> Problem:
    """What makes things also certifies a bonus, which alone can be taken, or feeds the stream that gilds."""

    def make(context: Any, thing: str) -> Iterator[Certified]:
        yield Certified(None, (("bonus", thing),)) if fails else Certified("new", (("bonus", "new"),))

    def gild(context: Any, thing: str) -> Iterator[str]:
        yield f"gold-{thing}"

    return Problem(
        domain=WILD.format(wanted=wanted),
        streams=WILD_STREAMS,
        samplers={"make": make, "gild": gild},
        init=[("thing", "t")],
        goal=("exists", ("?y",), ("have", "?y")),
    )


TRANSIT = """
(define (domain transit)
  (:predicates (place ?x) (spot ?q) (near ?x ?q) (at ?q) (way ?q1 ?t ?q2) (visited ?x))
  (:action go :parameters (?q1 ?t ?q2) :precondition (and (spot ?q1) (spot ?q2) (way ?q1 ?t ?q2) (at ?q1))
    :effect (and (at ?q2) (not (at ?q1))))
  (:action visit :parameters (?x ?q) :precondition (and (near ?x ?q) (at ?q)) :effect (visited ?x)))
"""

TRANSIT_STREAMS = """
(define (stream transit)
  (:stream find-spot :inputs (?x) :domain (place ?x) :outputs (?q) :certified (and (spot ?q)))
  (:stream find-way :inputs (?q1 ?q2) :domain (and (spot ?q1) (spot ?q2)) :outputs (?t) :certified (way ?q1 ?t ?q2)))
"""


def transit() -> Problem:
    """To be at a spot of which only a stream knows that it is one."""
    return Problem(
        domain=TRANSIT,
        streams=TRANSIT_STREAMS,
        samplers={
            "find-spot": lambda context, place: iter((1.0, 2.0, 3.0)),
            "find-way": lambda context, a, b: iter([(a, b)]),
        },
        init=[("place", "x"), ("spot", 0.0), ("at", 0.0)],
        goal=("at", 3.0),
    )


EXOGENOUS = """
(define (domain exogenous)
  (:predicates (pot ?x) (hot ?x) (meal ?x ?y) (dish ?y) (eaten) (tidy))
  (:action heat :parameters (?x) :precondition (pot ?x) :effect (and (hot ?x) (not (tidy))))
  (:action cool :parameters (?x) :precondition (hot ?x) :effect (and (tidy) (not (hot ?x))))
  (:action eat :parameters (?x ?y) :precondition (and (meal ?x ?y) (dish ?y) {more}) :effect (eaten)))
"""

EXOGENOUS_STREAMS = """
(define (stream exogenous)
  (:stream cook :inputs (?x) :domain (and (pot ?x) (hot ?x)) :outputs (?y) :certified (meal ?x ?y))
  (:stream serve :inputs (?x ?y) :domain (meal ?x ?y) :certified (dish ?y)))
"""


def exogenous(more: str = "") -> Problem:
    """A meal is there while the pot is hot, which an action makes it."""

    def cook(context: Any, pot: str) -> Iterator[str]:
        yield f"soup-of-{pot}"

    return Problem(
        domain=EXOGENOUS.format(more=more),
        streams=EXOGENOUS_STREAMS,
        samplers={"cook": cook, "serve": lambda context, pot, meal: True},
        init=[("pot", "p"), ("tidy",)],
        goal=("and", ("eaten",), ("tidy",)),
    )


INPUTLESS = """
(define (domain inputless)
  (:predicates (free ?x) (had ?x))
  (:action have :parameters (?x) :precondition (free ?x) :effect (had ?x)))
"""


def inputless() -> Problem:
    """A stream without inputs is all there is."""
    return Problem(
        domain=INPUTLESS,
        streams="(define (stream inputless) (:stream spring :outputs (?x) :certified (free ?x)))",
        samplers={"spring": lambda context: iter(["water", "wine"])},
        goal=("had", "wine"),
    )


PRICED = """
(define (domain priced)
  (:predicates (good ?x) (known ?x) (had ?x) (marked ?x))
  (:functions (total-cost) (price ?x))
  (:action buy :parameters (?x) :precondition (good ?x) :effect (and (had ?x) (increase (total-cost) (price ?x))))
  (:action ask :parameters (?x) :precondition (good ?x) :effect (and (marked ?x) (increase (total-cost) 1))))
"""


def priced() -> Problem:
    """A price is defined for what is known, and only that can be bought."""

    def price(context: Any, good: str) -> float:
        assert good == "bread", "asked for a price outside the function's domain"
        return 2.0

    return Problem(
        domain=PRICED,
        streams="(define (stream priced) (:function (price ?x) (known ?x)))",
        samplers={"price": price},
        init=[("good", "bread"), ("good", "air"), ("known", "bread")],
        goal=("exists", ("?x",), ("had", "?x")),
    )


SUBTLE = {
    **EFFECTS,
    "wild": lambda: wild("bonus"),
    "wild feeds": lambda: wild("golden"),
    "wild and empty": lambda: wild("golden", fails=True),
    "transit": transit,
    "exogenous": exogenous,
    "inputless": inputless,
    "priced": priced,
}
