"""Problems drawn at random: small ADL domains with every construct, and streams that fail as they like."""

import re
from collections.abc import Collection, Iterator
from typing import Any

import numpy as np

from tamp.planning import Certified, Problem

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


LATE = ("late", "moody", "negated")
"""Streams that give nothing at first, tests that certify more, and what is asked for by its negation alone."""

CERTIFIED = {
    "wild": {"bonus": 1, "golden": 1},
    "transit": {"spot": 1},
    "exogenous": {"forged": 2},
    "inputless": {"free": 1},
    "told": {"told": 1},
    "moody": {"bonus": 1, "golden": 1},
    "negated": {"bad": 2},
}
"""Feature -> what its streams certify, and the number of arguments."""

FEATURES = ("effects", "wild", "transit", "exogenous", "inputless", "functions", "robots", "told", *LATE)


def domain(draw: Draw, streams: bool, features: Collection[str]) -> str:
    """Four actions and two derived predicates, the second of which may look at the first through a negation."""
    derived = {"d": 1, "e": 1}
    static = {"made": 2, "ok": 2} if streams else {}
    more = {
        name: arity for feature in FEATURES if feature in features for name, arity in CERTIFIED.get(feature, {}).items()
    }
    static |= {name: arity for name, arity in more.items() if name != "told"}
    asked = {"bad": "(not (bad {}))"}
    inside = derived | static if "effects" in features else derived
    recursive = draw.pick("(d ?y)", "(q ?y)")
    axioms = [
        f"(:derived (d ?x) (or {draw.formula(['?x'], static, 1)} (exists (?y) (and (r ?x ?y) {recursive}))))",
        f"(:derived (e ?x) {draw.formula(['?x'], {'d': 1} | static)})",
    ]
    actions = []
    for i in range(4):
        variables = ["?a", "?b"][: int(draw.rng.integers(1, 3))]
        conditions = [draw.formula(variables, inside)]
        if streams and len(variables) == 2 and draw.chance(0.7):
            conditions.append(draw.pick("(made ?a ?b)", "(and (made ?a ?b) (ok ?a ?b))"))
        for name, arity in more.items():
            if len(variables) >= arity and draw.chance(0.5):
                conditions.append(asked.get(name, f"({name} {{}})").format(" ".join(variables[:arity])))
        if "transit" in features and draw.chance(0.6):
            conditions.append(f"(at {draw.pick(*variables)})")
        effects = [draw.effect(variables, inside) for _ in range(3)]
        if "robots" in features and len(variables) == 2:
            conditions.append(draw.pick("(and (robot ?a) (stop ?a ?b) (in ?a ?b))", "(and (thing ?a) (in ?a ?b))"))
            effects.append(draw.pick("(forall (?r) (when (robot ?r) (ready ?r)))", "(p ?b)"))
        if "functions" in features and draw.chance(0.7):
            effects.append(f"(increase (total-cost) (price {variables[-1]}))")
        actions.append(
            f"(:action a{i} :parameters ({' '.join(variables)}) :precondition (and {' '.join(conditions)})"
            f" :effect (and {' '.join(effects)}))"
        )
    if "transit" in features:
        actions.append(GO)
    if "robots" in features:
        actions.append(DRIVE)
        axioms.append("(:derived (found ?x) (exists (?y) (and (thing ?x) (in ?x ?y) (p ?y))))")
    table = PREDICATES | derived | {"made": 2, "ok": 2, "thing": 1} | more | {"at": 1, "product": 1}
    table |= {"robot": 1, "stop": 2, "road": 3, "in": 2, "ready": 1, "found": 1} if "robots" in features else {}
    predicates = " ".join(f"({' '.join([name, *['?x', '?y', '?z'][:arity]])})" for name, arity in table.items())
    costs = "(:functions (total-cost) (price ?x))" if "functions" in features else ""
    return (
        f"(define (domain chance) (:requirements :adl) (:predicates {predicates}) {costs} {' '.join(axioms + actions)})"
    )


GO = """(:action go :parameters (?s1 ?s2) :precondition (and (spot ?s1) (spot ?s2) (at ?s1))
  :effect (and (at ?s2) (not (at ?s1))))"""


DRIVE = """(:action drive :parameters (?r ?s1 ?s2)
  :precondition (and (robot ?r) (road ?r ?s1 ?s2) (in ?r ?s1) (ready ?r))
  :effect (and (in ?r ?s2) (not (in ?r ?s1)) (not (ready ?r))))"""
"""Robots and things are in places by one predicate; each robot may go once until something makes it ready again."""


STREAMS = """
(define (stream chance)
  (:stream make :inputs (?x) :domain (thing ?x) :outputs (?y) :certified (and (made ?x ?y) (product ?y)))
  (:stream test-ok :inputs (?x ?y) :domain (and (thing ?x) (product ?y)) :certified (ok ?x ?y)))
"""


MORE_STREAMS = {
    "wild": "(:stream gild :inputs (?x) :domain (bonus ?x) :outputs (?y) :certified (golden ?y))",
    "transit": "(:stream find-spot :inputs (?x) :domain (thing ?x) :outputs (?y) :certified (spot ?y))",
    "exogenous": """(:stream forge :inputs (?x) :domain (q ?x) :outputs (?y) :certified (forged ?x ?y))
      (:stream test-forge :inputs (?x ?y) :domain (and (forged ?x ?y) (thing ?x)) :certified (product ?y))""",
    "moody": "(:stream gild :inputs (?x) :domain (bonus ?x) :outputs (?y) :certified (golden ?y))",
    "negated": "(:predicate (bad ?x ?y) (and (thing ?x) (product ?y)))",
    "inputless": "(:stream spring :outputs (?y) :certified (free ?y))",
    "functions": "(:function (price ?x) (thing ?x))",
    "told": "(:stream test-told :inputs (?x) :domain (thing ?x) :fluents (p q) :certified (told ?x))",
    "robots": """(:stream find-stop :inputs (?r ?x) :domain (and (robot ?r) (thing ?x)) :outputs (?y)
        :certified (stop ?r ?y))
      (:stream test-road :inputs (?r ?y ?z) :domain (and (robot ?r) (stop ?r ?y) (stop ?r ?z))
        :certified (road ?r ?y ?z))""",
}


def gild(context: Any, thing: str) -> Iterator[str]:
    if (ord(thing[-1]) + context.scene) % 2:
        yield f"gold-{thing}"


def find_spot(context: Any, thing: str) -> Iterator[str]:
    for i in range(1 + (ord(thing[-1]) + context.scene) % 2):
        yield f"spot-{thing}-{i}"


def find_stop(context: Any, robot: str, thing: str) -> Iterator[str]:
    if (ord(robot[-1]) + ord(thing[-1]) + context.scene) % 2:
        yield f"by-{thing}"


def forge(context: Any, thing: str) -> Iterator[str]:
    if len(thing) <= 4 and (ord(thing[-1]) + context.scene) % 3:
        yield f"{thing}-forged" if context.scene % 2 else "ta"


def spring(context: Any) -> Iterator[str]:
    yield from ("water", "tb")[: 1 + context.scene % 2]


def make_wild(context: Any, thing: str) -> Iterator[Certified]:
    """What `make` gives, and facts that it does not promise."""
    for i, product in enumerate(make(context, thing)):
        yield Certified(product, (("bonus", product if (i + context.scene) % 2 else thing),))
    if context.scene % 5 == 0:
        yield Certified(None, (("bonus", "tc"), ("free", thing)))
    if context.scene % 3 == 1:  # what actions change: it held from the start
        yield Certified(None, (("q", thing),))


def make(context: Any, thing: str) -> Iterator[str]:
    """As many products as the letters of the alphabet say, none of some things."""
    for i in range((ord(thing[-1]) + context.scene) % 3):
        yield f"{thing}-{i}"


def make_late(context: Any, thing: str) -> Iterator[Any]:
    """What `make` gives, with nothing before and between."""
    for product in make(context, thing):
        yield from [None] * (context.scene % 3)
        yield product


def make_wild_late(context: Any, thing: str) -> Iterator[Any]:
    """What `make_wild` gives, after nothing at all."""
    for given in make_wild(context, thing):
        yield from [None] * (1 + context.scene % 2)
        yield given


def ok_moody(seed: int, thing: str, product: str) -> bool | Certified:
    """What `ok` says, which certifies more: always where it holds, and of some things where it does not."""
    facts = (("bonus", product if seed % 2 else thing),)
    if ok(None, thing, product):
        return Certified((), facts)
    return Certified(None, facts) if product.endswith("1") and seed % 4 else False


def make_without_end(context: Any, thing: str) -> Iterator[str | None]:
    """The same products, after which it never says that there are no more."""
    yield from make(context, thing)
    if context.scene % 4 == 0:
        yield thing
    while True:
        yield None


def ok(context: Any, thing: str, product: str) -> bool:
    return product.startswith(thing) or (ord(thing[-1]) + len(product)) % 2 == 0


def problem(seed: int, streams: bool = False, endless: bool = False, features: Collection[str] = ()) -> Problem:
    """A problem that may or may not have a solution; with streams that do not depend on chance and may be endless."""
    draw = Draw(seed)
    text = domain(draw, streams, features)
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
    if "transit" in features:
        init += [("at", "home"), ("spot", "home")]
        if draw.chance(0.5):
            goal.append(("at", f"spot-{draw.pick(*things)}-0"))
    if "robots" in features:
        init += [("in", "ta", "by-tb"), ("in", "tb", "home"), ("in", "tc", "by-ta")]
        for robot in ("rx", "ry"):
            init += [("robot", robot), ("stop", robot, "home"), ("in", robot, "home"), ("ready", robot)]
        if draw.chance(0.5):
            goal.append(("in", "rx", f"by-{draw.pick(*things)}"))
    extra: dict[str, Any] = {}
    if streams:
        samplers = {
            "make": make_without_end if endless else make,
            "test-ok": lambda context, thing, product: ok(context, thing, product),
        }
        if "wild" in features:
            samplers["make"] = make_wild_late if "late" in features else make_wild
        elif "late" in features and not endless:
            samplers["make"] = make_late
        if "moody" in features:
            samplers["test-ok"] = lambda context, thing, product: ok_moody(seed, thing, product)
        known = {"gild": gild, "find-spot": find_spot, "forge": forge, "spring": spring}
        known |= {"find-stop": find_stop}
        known |= {"test-road": lambda context, robot, start, end: (len(start) + ord(end[-1]) + seed) % 3 > 0}
        known |= {"test-told": lambda context, thing: sum(f[1] != thing for f in context.fluents) <= seed % 3}
        known |= {"bad": lambda context, thing, product: (ord(thing[-1]) + len(product) + seed) % 3 == 0}
        known |= {"price": lambda context, thing: 1.0 + ["ta", "tb", "tc"].index(thing)}
        known |= {"test-forge": lambda context, thing, product: len(product) % 2 == 0}
        texts = [MORE_STREAMS[feature] for feature in FEATURES if feature in features and feature in MORE_STREAMS]
        texts = list(dict.fromkeys(texts))  # two features may have the same stream
        text_of_all = f"{STREAMS.rstrip()[:-1]} {' '.join(texts)})"
        samplers |= {name: sampler for name, sampler in known.items() if re.search(rf"\(?{name} ", text_of_all)}
        extra = {"streams": text_of_all, "samplers": samplers, "scene": seed}
    return Problem(domain=text, init=init, goal=tuple(goal), **extra)
