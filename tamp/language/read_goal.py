"""Goals and facts given as nested Python tuples -> formulas and atoms; objects are any Python values."""

from __future__ import annotations

import math
import numbers
import reprlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from tamp.errors import DomainError
from tamp.frozen import FrozenDict
from tamp.language.domain import Domain, FunctionTerm
from tamp.language.formula import TRUE, Atom, Formula
from tamp.language.read_formula import FormulaReader
from tamp.language.sexpr import MAX_DEPTH, Group, Leaf, Node, Symbol
from tamp.language.streams import StreamFile


@dataclass(frozen=True)
class InitialState:
    """What is given to hold at the start.

    Attributes:
        facts: what holds, each once, in the order given.
        negated: what was given as not holding; everything that is no fact does not hold either.
        values: functions and their values.
    """

    facts: tuple[Atom, ...]
    negated: tuple[Atom, ...] = ()
    values: Mapping[FunctionTerm, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", FrozenDict(self.values))


def parse_goal(goal: object, domain: Domain, streams: StreamFile | None = None) -> Formula:
    """Read a goal such as `("and", ("On", a, b), ("exists", ("?p",), ("AtPose", c, "?p")))`.

    Strings that begin with `?` are variables; all other arguments are objects. None is always true. Predicates are
    those of the domain, and those that only the stream file names.

    Raises:
        DomainError: with the part that cannot be read.
    """
    if goal is None:
        return TRUE
    tuples = _Tuples("goal", domain)
    return _reader(tuples, streams).formula(tuples.node(goal), {})


def parse_init(init: Iterable[object], domain: Domain, streams: StreamFile | None = None) -> InitialState:
    """Read facts such as `("On", a, b)`, function values `("=", ("Distance", a, b), 5)`, and `("not", fact)`.

    Predicates that neither the domain nor the stream file names are allowed.

    Raises:
        DomainError: with the fact that cannot be read.
    """
    if isinstance(init, str) or not isinstance(init, Iterable):
        raise DomainError(f"init: expected a list of facts such as ('On', a, b), found {reprlib.repr(init)}")
    tuples = _Tuples("init", domain)
    reader = _reader(tuples, streams, open_world=True)
    facts: dict[Atom, None] = {}
    negated: dict[Atom, None] = {}
    values: dict[FunctionTerm, float] = {}
    for fact in init:
        match fact:
            case ("=", [_, *_] | (_, *_) as term, value):
                values[_function(tuples, reader, term)] = _number(tuples, fact, value)
            case (str(word), inner) if word.lower() == "not" and isinstance(inner, tuple | list):
                negated[reader.atom(tuples.node(inner), {})] = None
            case _:
                facts[reader.atom(tuples.node(fact), {})] = None
    return InitialState(tuple(facts), tuple(negated), values)


def _reader(tuples: _Tuples, streams: StreamFile | None, open_world: bool = False) -> FormulaReader:
    predicates = {s.name: s for s in streams.signatures} if streams is not None else {}
    return FormulaReader(tuples, tuples.domain.types, None, {**predicates, **tuples.domain.predicates}, open_world)


def _function(tuples: _Tuples, reader: FormulaReader, term: object) -> FunctionTerm:
    head, args = reader.application(tuples.node(term), "a function such as ('Distance', a, b)")
    if head.text in tuples.domain.functions:
        reader.arity(head, len(args), tuples.domain.functions[head.text])
    return FunctionTerm(head.text, tuple(reader.term(arg, {}) for arg in args))


def _number(tuples: _Tuples, fact: object, value: object) -> float:
    if not isinstance(value, numbers.Real) or not math.isfinite(value) or value < 0:
        raise tuples.error(tuples.node(fact), f"expected a value of 0 or more, found {reprlib.repr(value)}")
    return float(value)


@dataclass(frozen=True)
class _Tuples:
    """Turns nested tuples into the nodes of a file; a node's position is where its tuple lies in `expressions`."""

    name: str
    domain: Domain
    expressions: list[object] = field(default_factory=list)

    def error(self, node: Node, message: str) -> DomainError:
        """The error to raise about a node, with the expression it belongs to."""
        return DomainError(f"{self.name}: in {reprlib.repr(self.expressions[node.position])}: {message}")

    def node(self, expression: object, depth: int = 0) -> Node:
        """A formula as nodes. Only operators nest; the arguments of a predicate are objects, tuples too."""
        position = len(self.expressions)
        self.expressions.append(expression)
        if depth > MAX_DEPTH:
            raise DomainError(f"{self.name}: nested deeper than {MAX_DEPTH} levels")
        if not isinstance(expression, tuple | list):
            hint = f"; a fact without arguments is ({expression!r},)" if isinstance(expression, str) else ""
            raise self.error(
                Leaf(expression, position),
                f"expected a tuple such as ('On', a, b), found {type(expression).__name__}{hint}",
            )
        if not expression:
            return Group((), position)
        if not isinstance(expression[0], str):
            raise self.error(Leaf(expression, position), "a tuple begins with the name of a predicate or operator")
        head, rest = expression[0].lower(), expression[1:]
        if head in ("and", "or", "not", "imply"):
            items = tuple(self.node(part, depth + 1) for part in rest)
        elif head in ("exists", "forall") and len(rest) == 2:
            items = (self._variables(rest[0], position), self.node(rest[1], depth + 1))
        else:
            items = tuple(self._term(value, position) for value in rest)
        return Group((Symbol(head, position), *items), position)

    def _variables(self, names: object, position: int) -> Node:
        if not isinstance(names, tuple | list) or not all(isinstance(name, str) for name in names):
            raise self.error(Leaf(names, position), f"expected variables such as ('?x', '?y'), found {names!r}")
        words = " ".join(names).lower().split()
        return Group(tuple(Symbol(word, position) for word in words), position)

    def _term(self, value: object, position: int) -> Node:
        if isinstance(value, str) and value.startswith("?"):
            return Symbol(value.lower(), position)
        return Leaf(self.domain.constant(value).value, position)
