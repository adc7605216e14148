"""Problems drawn at random: small ADL domains with every construct, and streams that fail as they like."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from tamp.planning import Problem

PREDICATES = {"p": 1, "q": 1, "r": 2, "s": 0}
"""What actions change; `d` and `e` are derived, `made` and `ok` are certified by streams."""


class Draw:
    """Draws PDDL text."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.names = 0

    def pick(self, *choices: Any) -> Any:
        return choices[int(self.rng.integers(len(choices)))]

    def chance(self, p: float) -> bool:
        return bool(self.rng.random() < p)

    def atom(self, variables: list[str], extra: dict[str, int] | None = None) -> str:
        table = PREDICATES | (extra or {})
        name = self.pick(*[n for n, arity in table.items() if arity == 0 or variables])
        args = [self.pick(*variables) for _ in range(table[name])]
        return f"({' '.join([name, *args])})"

    def formula(self, variables: list[str], extra: dict[str, int], depth: int = 2) -> str:
        kinds = ["atom"] * 3 + ["not"] * 2
        if depth:
            kinds += ["and", "or", "imply", "exists", "forall", *(["="] if len(variables) > 1 else [])]
        match self.pick(*kinds):
            case "atom":
                return self.atom(variables, extra)
            case "not":
                return f"(not {self.atom(variables, extra)})"
            case "=":
                return f"(= {variables[0]} {variables[1]})"
            case "imply":
                return (
                    f"(imply {self.formula(variables, extra, depth - 1)} {self.formula(variables, extra, depth - 1)})"
                )
            case ("exists" | "forall") as quantifier:
                self.names += 1
                new = f"?z{self.names}"
                return f"({quantifier} ({new}) {self.formula([*variables, new], extra, depth - 1)})"
            case operator:
                parts = [self.formula(variables, extra, depth - 1) for _ in range(2)]
                return f"({operator} {' '.join(parts)})"

    def effect(self, variables: list[str], extra: dict[str, int]) -> str:
        literal = self.atom(variables)
        literal = f"(not {literal})" if self.chance(0.4) else literal
        if self.chance(0.25):
            return f"(when {self.formula(variables, extra, 1)} {literal})"
        if self.chance(0.15):
            self.names += 1
            new = f"?z{self.names}"
            inner = [*variables, new]
            return f"(forall ({new}) (when {self.formula(inner, extra, 1)} {self.atom(inner)}))"
        return literal


def domain(draw: Draw, streams: bool) -> str:
    """Four actions and two derived predicates, the second of which may look at the first through a negation."""
    derived = {"d": 1, "e": 1}
    static = {"made": 2, "ok": 2} if streams else {}
    recursive = draw.pick("(d ?y)", "(q ?y)")
    axioms = [
        f"(:derived (d ?x) (or {draw.formula(['?x'], static, 1)} (exists (?y) (and (r ?x ?y) {recursive}))))",
        f"(:derived (e ?x) {draw.formula(['?x'], {'d': 1} | static)})",
    ]
    actions = []
    for i in range(4):
        variables = ["?a", "?b"][: int(draw.rng.integers(1, 3))]
        conditions = [draw.formula(variables, derived)]
        if streams and len(variables) == 2 and draw.chance(0.7):
            conditions.append(draw.pick("(made ?a ?b)", "(and (made ?a ?b) (ok ?a ?b))"))
        effects = [draw.effect(variables, derived) for _ in range(3)]
        actions.append(
            f"(:action a{i} :parameters ({' '.join(variables)}) :precondition (and {' '.join(conditions)})"
            f" :effect (and {' '.join(effects)}))"
        )
    table = PREDICATES | derived | {"made": 2, "ok": 2, "thing": 1}
    predicates = " ".join(f"({' '.join([name, *['?x', '?y'][:arity]])})" for name, arity in table.items())
    return f"(define (domain chance) (:requirements :adl) (:predicates {predicates}) {' '.join(axioms + actions)})"


STREAMS = """
(define (stream chance)
  (:stream make :inputs (?x) :domain (thing ?x) :outputs (?y) :certified (and (made ?x ?y) (product ?y)))
  (:stream test-ok :inputs (?x ?y) :domain (and (thing ?x) (product ?y)) :certified (ok ?x ?y)))
"""


def make(context: Any, thing: str) -> Iterator[str]:
    """As many products as the letters of the alphabet say, none of some things."""
    for i in range((ord(thing[-1]) + context.scene) % 3):
        yield f"{thing}-{i}"


def make_without_end(context: Any, thing: str) -> Iterator[str | None]:
    """The same products, after which it never says that there are no more."""
    yield from make(context, thing)
    if context.scene % 4 == 0:
        yield thing
    while True:
        yield None


def ok(context: Any, thing: str, product: str) -> bool:
    return product.startswith(thing) or (ord(thing[-1]) + len(product)) % 2 == 0


def problem(seed: int, streams: bool = False, endless: bool = False) -> Problem:
    """A problem that may or may not have a solution; with streams that do not depend on chance and may be endless."""
    draw = Draw(seed)
    text = domain(draw, streams)
    things = ["ta", "tb", "tc"]
    init: list[Any] = [("thing", thing) for thing in things]
    for _ in range(4):
        name = draw.pick("p", "q", "r")
        init.append((name, *(draw.pick(*things) for _ in range(PREDICATES[name]))))
    goal: list[Any] = ["and"]
    for _ in range(3):
        name = draw.pick("p", "q", "r", "d", "e")
        atom = (name, *(draw.pick(*things) for _ in range(2 if name == "r" else 1)))
        goal.append(("not", atom) if draw.chance(0.3) else atom)
    if draw.chance(0.3):
        goal.append((draw.pick("exists", "forall"), ("?x",), (draw.pick("p", "q", "e"), "?x")))
    extra: dict[str, Any] = {}
    if streams:
        samplers = {
            "make": make_without_end if endless else make,
            "test-ok": lambda context, thing, product: ok(context, thing, product),
        }
        extra = {"streams": STREAMS, "samplers": samplers, "scene": seed}
    return Problem(domain=text, init=init, goal=tuple(goal), **extra)
