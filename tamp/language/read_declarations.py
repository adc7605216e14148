"""What a domain declares before it uses it: requirements, types, constants, predicates and functions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from tamp.language.domain import Signature
from tamp.language.formula import OBJECT, Constant, Parameter, Variable
from tamp.language.read_formula import FormulaReader
from tamp.language.sexpr import Group, Node, Source, Symbol, show, suggest

REQUIREMENTS = (
    ":strips", ":typing", ":negation", ":negative-preconditions", ":disjunctive-preconditions", ":equality",
    ":existential-preconditions", ":universal-preconditions", ":quantified-preconditions", ":conditional-effects",
    ":adl", ":derived-predicates", ":domain-axioms", ":action-costs", ":fluents", ":numeric-fluents",
)  # fmt: skip


@dataclass
class Declarations:
    """What has been declared so far.

    Attributes:
        source: the file that is read.
        values: objects that constants stand for, where that is not their name.
        costs: whether `total-cost` was declared.
        formulas: a reader of formulas over all these names, as they are declared.
    """

    source: Source
    values: Mapping[str, Any]
    requirements: list[str] = field(default_factory=list)
    types: dict[str, tuple[str, ...]] = field(default_factory=lambda: {OBJECT: ()})
    constants: dict[str, Constant] = field(default_factory=dict)
    constant_types: dict[str, tuple[str, ...]] = field(default_factory=dict)
    predicates: dict[str, Signature] = field(default_factory=lambda: {OBJECT: _type_predicate(OBJECT)})
    functions: dict[str, Signature] = field(default_factory=dict)
    costs: bool = False
    formulas: FormulaReader = field(init=False)

    def __post_init__(self) -> None:
        self.formulas = FormulaReader(self.source, self.types, self.constants, self.predicates)

    def read_requirements(self, group: Group) -> None:
        """(:requirements :adl ...). All that is supported is always allowed; what is not is refused."""
        for item in group.items[1:]:
            word = self.formulas.symbol(item, "a requirement such as :adl")
            if word.text not in REQUIREMENTS:
                hint = suggest(word.text, REQUIREMENTS, "supported requirements")
                raise self.source.error(word, f"unsupported requirement {word.text!r}{hint}")
            self.requirements.append(word.text)

    def read_types(self, group: Group) -> None:
        """(:types block - movable ...). A supertype need not be declared by itself."""
        entries = self.formulas.typed_list(group, start=1)
        for symbol, above in entries:
            self._refuse_mark(symbol, "type")
            if self.types.get(symbol.text) and above:
                raise self.source.error(symbol, f"type {symbol.text!r} is declared twice")
            for name in (symbol.text, *(parent.text for parent in above)):
                self.types.setdefault(name, ())
                self.predicates[name] = _type_predicate(name)
            if symbol.text != OBJECT and above:
                self.types[symbol.text] = tuple(parent.text for parent in above)
        for symbol, _ in entries:
            self._refuse_cycle(symbol)
        for name, parents in self.types.items():
            if name != OBJECT and not parents:
                self.types[name] = (OBJECT,)

    def _refuse_cycle(self, symbol: Symbol) -> None:
        seen, waiting = set[str](), list(self.types[symbol.text])
        while waiting:
            name = waiting.pop()
            if name == symbol.text:
                raise self.source.error(symbol, f"type {name!r} is its own supertype")
            if name not in seen:
                seen.add(name)
                waiting.extend(self.types[name])

    def read_constants(self, group: Group) -> None:
        """(:constants sink stove - region ...)."""
        for symbol, types in self.formulas.typed_list(group, start=1):
            self._refuse_mark(symbol, "constant")
            if symbol.text in self.constants:
                raise self.source.error(symbol, f"constant {symbol.text!r} is declared twice")
            self.constants[symbol.text] = Constant(self.values.get(symbol.text, symbol.text))
            self.constant_types[symbol.text] = self.formulas.check_types(types)

    def _refuse_mark(self, symbol: Symbol, what: str) -> None:
        if symbol.text.startswith(("?", ":")):
            raise self.source.error(symbol, f"expected the name of a {what}, found {symbol.text!r}")

    def read_predicates(self, group: Group) -> None:
        """(:predicates (On ?a ?b) ...)."""
        for item in group.items[1:]:
            symbol, signature = self._signature(item, "(PREDICATE ?x ...)")
            self._declare(self.predicates, symbol, signature, "predicate")

    def read_functions(self, group: Group) -> None:
        """(:functions (total-cost) (distance ?a ?b) - number ...)."""
        items = group.items[1:]
        previous: Node | None = None
        for item in items:
            match previous, item:
                case (Group(), Symbol("-")) | (Symbol("-"), Symbol("number")):
                    pass  # the result type, behind one or several functions
                case (_, Symbol()) | (Symbol("-"), _):
                    raise self.source.error(item, f"expected (FUNCTION ?x ...) or '- number', found {show(item)}")
                case _:
                    symbol, signature = self._signature(item, "(FUNCTION ?x ...)")
                    if symbol.text == "total-cost":
                        self.costs = True
                    else:
                        self._declare(self.functions, symbol, signature, "function")
            previous = item

    def _signature(self, node: Node, expected: str) -> tuple[Symbol, Signature]:
        symbol, rest = self.formulas.application(node, expected)
        parameters, _ = self.formulas.parameters(Group(rest, node.position))
        return symbol, Signature(symbol.text, parameters)

    def _declare(self, table: dict[str, Signature], symbol: Symbol, new: Signature, what: str) -> None:
        """A second declaration is harmless, and common in PDDLStream's files, where it agrees with the first."""
        if symbol.text in self.types:
            raise self.source.error(symbol, f"{symbol.text!r} is a type and cannot be declared as a {what}")
        old = table.setdefault(symbol.text, new)
        if old.arity != new.arity:
            raise self.source.error(
                symbol, f"{what} {symbol.text!r} is declared twice, with {old.arity} and {new.arity} arguments"
            )


def _type_predicate(name: str) -> Signature:
    return Signature(name, (Parameter(Variable("?x")),))
