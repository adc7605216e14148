"""A PDDL domain file -> Domain. Follows PDDL 2.1 level 1 with ADL, derived predicates and action costs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tamp.errors import DomainError
from tamp.language.domain import Action, Axiom, Domain, Signature
from tamp.language.formula import OBJECT, Constant, Parameter, Variable
from tamp.language.read_action import ActionReader
from tamp.language.read_formula import FormulaReader
from tamp.language.sexpr import Group, Source, Symbol, load, read, show, suggest

REQUIREMENTS = (
    ":strips", ":typing", ":negation", ":negative-preconditions", ":disjunctive-preconditions", ":equality",
    ":existential-preconditions", ":universal-preconditions", ":quantified-preconditions", ":conditional-effects",
    ":adl", ":derived-predicates", ":domain-axioms", ":action-costs", ":fluents", ":numeric-fluents",
)  # fmt: skip


def parse_domain(text_or_path: str | Path, constants: Mapping[str, Any] | None = None) -> Domain:
    """Read a PDDL domain.

    Args:
        text_or_path: PDDL text, or the file it lies in.
        constants: the objects that constants of the domain stand for, where that is not their name.

    Raises:
        DomainError: with file, line and column of what cannot be read.
    """
    source = load(text_or_path, "domain")
    whole = read(source)
    name, sections = read_define(source, whole, "domain")
    reader = _DomainReader(source, {name.lower(): value for name, value in (constants or {}).items()})
    # Declarations first, wherever they stand in the file.
    for wanted in (":requirements", ":types", ":constants", ":predicates", ":functions", ":derived", ":action"):
        for head, group in sections:
            if head.text == wanted:
                reader.section(head.text)(group)
    for head, _ in sections:
        if head.text not in reader.sections:
            raise source.error(head, _unknown_section(head.text, reader.sections))
    for unknown in sorted(reader.values.keys() - reader.constants.keys()):
        hint = suggest(unknown, reader.constants, "constants of the domain")
        raise DomainError(f"{source.name}: a value is given for the undeclared constant {unknown!r}{hint}")
    return reader.domain(name)


def read_define(source: Source, whole: Group, kind: str) -> tuple[str, list[tuple[Symbol, Group]]]:
    """`(define (KIND NAME) (:section ...) ...)` as the name and the sections with their first words."""
    items = whole.items
    if len(items) < 2 or not isinstance(items[0], Symbol) or items[0].text != "define":
        raise source.error(whole, f"expected (define ({kind} NAME) ...), found {show(whole)}")
    header = items[1]
    match header:
        case Group((Symbol(word), Symbol(name))) if word == kind:
            pass
        case _:
            raise source.error(header, f"expected ({kind} NAME), found {show(header)}")
    sections: list[tuple[Symbol, Group]] = []
    for item in items[2:]:
        if not isinstance(item, Group) or not item.items or not isinstance(item.items[0], Symbol):
            raise source.error(
                item, f"expected a section such as (:{'action' if kind == 'domain' else kind} ...), found {show(item)}"
            )
        sections.append((item.items[0], item))
    return name, sections


def _unknown_section(name: str, valid: dict[str, Callable[[Group], None]]) -> str:
    if name == ":durative-action":
        return "durative actions are not supported; write an (:action ...) with a cost instead"
    return f"unknown section {name!r}{suggest(name, valid, 'sections')}"


@dataclass
class _DomainReader:
    """What has been declared so far."""

    source: Source
    values: Mapping[str, Any]
    requirements: list[str] = field(default_factory=list)
    types: dict[str, tuple[str, ...]] = field(default_factory=lambda: {OBJECT: ()})
    constants: dict[str, Constant] = field(default_factory=dict)
    constant_types: dict[str, tuple[str, ...]] = field(default_factory=dict)
    predicates: dict[str, Signature] = field(default_factory=dict)
    functions: dict[str, Signature] = field(default_factory=dict)
    actions: dict[str, Action] = field(default_factory=dict)
    axioms: list[Axiom] = field(default_factory=list)
    uses_costs: bool = False

    def __post_init__(self) -> None:
        self._declare_type(OBJECT)

    @property
    def sections(self) -> dict[str, Callable[[Group], None]]:
        """Section -> what reads it."""
        return {
            ":requirements": self.read_requirements,
            ":types": self.read_types,
            ":constants": self.read_constants,
            ":predicates": self.read_predicates,
            ":functions": self.read_functions,
            ":derived": self.read_axiom,
            ":action": self.read_action,
        }

    def section(self, name: str) -> Callable[[Group], None]:
        """What reads the section of that name."""
        return self.sections[name]

    @property
    def formulas(self) -> FormulaReader:
        """A reader of formulas over what is declared."""
        return FormulaReader(self.source, self.types, self.constants, self.predicates)

    def domain(self, name: str) -> Domain:
        """Everything that was read."""
        return Domain(
            name=name,
            requirements=tuple(self.requirements),
            types=self.types,
            constants=self.constants,
            constant_types=self.constant_types,
            predicates=self.predicates,
            functions=self.functions,
            actions=self.actions,
            axioms=tuple(self.axioms),
            uses_costs=self.uses_costs,
        )

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
            if symbol.text.startswith(("?", ":")):
                raise self.source.error(symbol, f"expected the name of a type, found {symbol.text!r}")
            if self.types.get(symbol.text) and above:
                raise self.source.error(symbol, f"type {symbol.text!r} is declared twice")
            for name in (symbol.text, *(parent.text for parent in above)):
                self._declare_type(name)
            if symbol.text != OBJECT:
                self.types[symbol.text] = tuple(parent.text for parent in above)
        for symbol, _ in entries:
            self._refuse_cycle(symbol)
        for name in self.types:
            if name != OBJECT and not self.types[name]:
                self.types[name] = (OBJECT,)

    def _declare_type(self, name: str) -> None:
        self.types.setdefault(name, ())
        self.predicates[name] = Signature(name, (Parameter(Variable("?x")),))

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
            if symbol.text.startswith(("?", ":")):
                raise self.source.error(symbol, f"expected the name of a constant, found {symbol.text!r}")
            if symbol.text in self.constants:
                raise self.source.error(symbol, f"constant {symbol.text!r} is declared twice")
            self.constants[symbol.text] = Constant(self.values.get(symbol.text, symbol.text))
            self.constant_types[symbol.text] = self.formulas.check_types(types)

    def read_predicates(self, group: Group) -> None:
        """(:predicates (On ?a ?b) ...)."""
        for item in group.items[1:]:
            symbol, signature = self._signature(item, "(PREDICATE ?x ...)")
            self._declare(self.predicates, symbol, signature, "predicate")

    def read_functions(self, group: Group) -> None:
        """(:functions (total-cost) (distance ?a ?b) - number ...)."""
        items = list(group.items[1:])
        for index, item in enumerate(items):
            if isinstance(item, Symbol):
                # What remains is the optional result type: `- number` behind one or several functions.
                if item.text == "-" and index and index + 1 < len(items) and isinstance(items[index - 1], Group):
                    continue
                if item.text == "number" and index and _is_dash(items[index - 1]):
                    continue
                raise self.source.error(item, f"expected (FUNCTION ?x ...) or '- number', found {show(item)}")
            symbol, signature = self._signature(item, "(FUNCTION ?x ...)")
            if symbol.text == "total-cost":
                self.uses_costs = True
            else:
                self._declare(self.functions, symbol, signature, "function")

    def _signature(self, node: object, expected: str) -> tuple[Symbol, Signature]:
        reader = self.formulas
        symbol, _ = reader.application(node, expected)  # type: ignore[arg-type]
        assert isinstance(node, Group)
        parameters, _ = reader.parameters(Group(node.items[1:], node.position))
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

    def read_axiom(self, group: Group) -> None:
        """(:derived (P ?x) CONDITION)."""
        reader = self.formulas
        reader.count(group, 2, "(:derived (PREDICATE ?x ...) CONDITION)")
        symbol, _ = reader.application(group.items[1], "(PREDICATE ?x ...)")
        head = reader.group(group.items[1], "(PREDICATE ?x ...)")
        declared = self.predicates.get(symbol.text)
        if declared is None or symbol.text in self.types:
            hint = suggest(symbol.text, self.predicates.keys() - self.types.keys(), "predicates")
            raise self.source.error(symbol, f"undeclared predicate {symbol.text!r}{hint}")
        parameters, scope = reader.parameters(Group(head.items[1:], head.position))
        reader.arity(symbol, len(parameters), declared)
        self.axioms.append(Axiom(symbol.text, parameters, reader.formula(group.items[2], scope)))

    def read_action(self, group: Group) -> None:
        """(:action NAME :parameters (...) :precondition ... :effect ...)."""
        derived = frozenset(axiom.predicate for axiom in self.axioms)
        reader = ActionReader(self.formulas, self.functions, derived)
        symbol, action = reader.action(group)
        if action.name in self.actions:
            raise self.source.error(symbol, f"action {action.name!r} is defined twice")
        self.actions[action.name] = action
        self.uses_costs = self.uses_costs or action.cost is not None


def _is_dash(node: object) -> bool:
    return isinstance(node, Symbol) and node.text == "-"
