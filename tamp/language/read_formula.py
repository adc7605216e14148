"""Nodes -> terms, typed variables, formulas, checked against what is declared. For domains, streams and goals."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass

from tamp.errors import DomainWarning
from tamp.language.domain import Signature
from tamp.language.formula import (
    OBJECT,
    TRUE,
    And,
    Atom,
    Constant,
    Equal,
    Exists,
    Forall,
    Formula,
    Not,
    Or,
    Parameter,
    Term,
    Variable,
)
from tamp.language.sexpr import Group, Leaf, Node, Source, Symbol, show, suggest

Scope = Mapping[str, Variable]
"""The variables in scope: their name in the text -> the variable."""

EQUALITY = ("=", "identical")
"""PDDLStream knows `identical` as another name of `=`."""

OPERATORS = ("and", "or", "not", "imply", "exists", "forall", "when", *EQUALITY)


@dataclass(frozen=True)
class Unbound:
    """What a variable stands for that nothing binds: an object like no other, by the variable's name."""

    name: str

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True)
class FormulaReader:
    """Reads formulas that may use the given names; the mappings may still grow while a file is read.

    Attributes:
        source: where errors point to.
        types: known types.
        constants: known constants and the objects they stand for; None allows any.
        predicates: known predicates.
        open_world: whether an unknown predicate declares itself where it is first used.
        lenient: whether an unbound variable is let pass with a warning, as a name of something that no fact names.
    """

    source: Source
    types: Mapping[str, tuple[str, ...]]
    constants: Mapping[str, Constant] | None
    predicates: dict[str, Signature]
    open_world: bool = False
    lenient: bool = False

    def formula(self, node: Node, scope: Scope) -> Formula:
        """Any formula; `()` is true."""
        if not isinstance(node, Group):
            raise self.source.error(node, f"expected a formula such as (and ...), found {show(node)}")
        if not node.items:
            return TRUE
        head = self.symbol(node.items[0], "a predicate or one of and, or, not, imply, exists, forall, =").text
        parts = node.items[1:]
        if head in ("and", "or"):
            formulas = tuple(self.formula(part, scope) for part in parts)
            return And(formulas) if head == "and" else Or(formulas)
        if head == "not":
            self.count(node, 1, "(not FORMULA)")
            return Not(self.formula(parts[0], scope))
        if head == "imply":
            self.count(node, 2, "(imply FORMULA FORMULA)")
            return Or((Not(self.formula(parts[0], scope)), self.formula(parts[1], scope)))
        if head in ("exists", "forall"):
            self.count(node, 2, f"({head} (?variable ...) FORMULA)")
            parameters, inner = self.parameters(parts[0], scope)
            body = self.formula(parts[1], inner)
            return Exists(parameters, body) if head == "exists" else Forall(parameters, body)
        if head in EQUALITY:
            self.count(node, 2, f"({head} TERM TERM)")
            return Equal(self.term(parts[0], scope), self.term(parts[1], scope))
        return self.atom(node, scope)

    def atom(self, node: Node, scope: Scope) -> Atom:
        """A predicate applied to terms."""
        head, args = self.application(node, "a fact such as (predicate ?x)")
        if head.text in OPERATORS:
            raise self.source.error(node, f"expected a fact such as (predicate ?x), found {show(node)}")
        declared = self.predicates.get(head.text)
        if declared is None and not self.open_world:
            hint = suggest(head.text, self.predicates.keys() - self.types.keys(), "predicates")
            raise self.source.error(head, f"undeclared predicate {head.text!r}{hint}")
        if declared is None:
            parameters = tuple(Parameter(Variable(f"?x{i}")) for i in range(len(args)))
            declared = self.predicates[head.text] = Signature(head.text, parameters)
        self.arity(head, len(args), declared)
        return Atom(head.text, tuple(self.term(arg, scope) for arg in args))

    def arity(self, head: Symbol, found: int, declared: Signature) -> None:
        """Refuse a predicate or function with the wrong number of arguments."""
        if found != declared.arity:
            plural = "" if declared.arity == 1 else "s"
            raise self.source.error(head, f"{head.text!r} takes {declared.arity} argument{plural}, found {found}")

    def term(self, node: Node, scope: Scope) -> Term:
        """A variable in scope, a constant, or a Python value of a goal."""
        if isinstance(node, Leaf):
            return Constant(node.value)
        name = self.symbol(node, "a variable or a constant").text
        if name.startswith("?"):
            return scope[name] if name in scope else self._unbound(node, name, scope)
        if name.startswith(":") or name == "-":
            raise self.source.error(node, f"expected a variable or a constant, found {name!r}")
        if self.constants is None:
            return Constant(name)
        if name not in self.constants:
            raise self.source.error(node, f"undeclared constant {name!r}{suggest(name, self.constants, 'constants')}")
        return self.constants[name]

    def _unbound(self, node: Node, name: str, scope: Scope) -> Constant:
        """Refuse a variable that nothing binds, or warn of it: PDDLStream's rules then never apply."""
        message = f"unbound variable {name!r}{suggest(name, scope, 'variables in scope')}"
        if not self.lenient:
            raise self.source.error(node, message)
        warnings.warn(str(self.source.error(node, f"{message}: no fact names it")), DomainWarning, stacklevel=2)
        return Constant(Unbound(name))

    def parameters(self, node: Node, scope: Scope | None = None) -> tuple[tuple[Parameter, ...], Scope]:
        """A typed list of variables, and `scope` with them in it; a name taken there gets a new variable."""
        inner = dict(scope or {})
        taken = {variable.name for variable in inner.values()}
        parameters: dict[str, Parameter] = {}
        for symbol, types in self.typed_list(node):
            if not symbol.text.startswith("?") or symbol.text == "?":
                raise self.source.error(symbol, f"expected a variable such as ?x, found {symbol.text!r}")
            if symbol.text in parameters:
                raise self.source.error(symbol, f"variable {symbol.text!r} is named twice")
            name = symbol.text
            while name in taken:
                name += "'"
            taken.add(name)
            inner[symbol.text] = Variable(name)
            parameters[symbol.text] = Parameter(inner[symbol.text], self.check_types(types))
        return tuple(parameters.values()), inner

    def check_types(self, types: tuple[Symbol, ...]) -> tuple[str, ...]:
        """Names of declared types; none means `object`."""
        for symbol in types:
            if symbol.text not in self.types:
                hint = suggest(symbol.text, self.types, "types")
                raise self.source.error(symbol, f"undeclared type {symbol.text!r}{hint}")
        return tuple(symbol.text for symbol in types) or (OBJECT,)

    def typed_list(self, node: Node, start: int = 0) -> list[tuple[Symbol, tuple[Symbol, ...]]]:
        """`a b - t c` as [(a, (t,)), (b, (t,)), (c, ())]; `start` items at the front are skipped."""
        items = self.group(node, "a list in brackets").items[start:]
        result: list[tuple[Symbol, tuple[Symbol, ...]]] = []
        waiting: list[Symbol] = []
        index = 0
        while index < len(items):
            symbol = self.symbol(items[index], "a name")
            index += 1
            if symbol.text != "-":
                waiting.append(symbol)
                continue
            if not waiting or index == len(items):
                raise self.source.error(symbol, "expected names before '-' and a type behind it")
            types = self._types(items[index])
            index += 1
            result += [(name, types) for name in waiting]
            waiting = []
        return result + [(name, ()) for name in waiting]

    def _types(self, node: Node) -> tuple[Symbol, ...]:
        if isinstance(node, Group):
            head, types = self.application(node, "(either TYPE ...)")
            if head.text != "either" or not types:
                raise self.source.error(node, f"expected a type or (either TYPE ...), found {show(node)}")
            return tuple(self.symbol(item, "a type") for item in types)
        return (self.symbol(node, "a type"),)

    def application(self, node: Node, expected: str) -> tuple[Symbol, tuple[Node, ...]]:
        """A group that begins with a word: the word and the rest."""
        group = self.group(node, expected)
        if not group.items:
            raise self.source.error(node, f"expected {expected}, found '()'")
        return self.symbol(group.items[0], expected), group.items[1:]

    def group(self, node: Node, expected: str) -> Group:
        """Refuse what is not a group."""
        if not isinstance(node, Group):
            raise self.source.error(node, f"expected {expected}, found {show(node)}")
        return node

    def symbol(self, node: Node, expected: str) -> Symbol:
        """Refuse what is not a word."""
        if not isinstance(node, Symbol):
            raise self.source.error(node, f"expected {expected}, found {show(node)}")
        return node

    def count(self, node: Group, expected: int, form: str) -> None:
        """Refuse an operator with the wrong number of operands."""
        if len(node.items) - 1 != expected:
            raise self.source.error(node, f"expected {form}, found {len(node.items) - 1} operands")
