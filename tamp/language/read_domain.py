"""A PDDL domain file -> Domain. Follows PDDL 2.1 level 1 with ADL, derived predicates and action costs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

from tamp.errors import DomainError
from tamp.language.domain import Action, Axiom, Domain
from tamp.language.formula import Exists, polarities
from tamp.language.read_action import ActionReader, read_attributes
from tamp.language.read_declarations import Declarations
from tamp.language.sexpr import PDDL, Group, Node, Source, Symbol, Text, load, read, show, suggest

# Declarations come first, wherever they stand in the file; axioms before actions, which may not change what is derived.
SECTIONS = (":requirements", ":types", ":constants", ":predicates", ":functions", ":derived", ":axiom", ":action")


def parse_domain(text_or_path: PDDL | Domain, constants: Mapping[str, Any] | None = None) -> Domain:
    """Read a PDDL domain.

    Args:
        text_or_path: PDDL text, the file it lies in, or several of either: sections of the others join the first.
            A domain is returned as it is.
        constants: the objects that constants of the domain stand for, where that is not their name.

    Raises:
        DomainError: with file, line and column of what cannot be read.
    """
    if isinstance(text_or_path, Domain):
        return text_or_path
    source = load(text_or_path, "domain")
    return _parsed(source, {key.lower(): value for key, value in constants.items()}) if constants else _known(source)


@lru_cache(maxsize=16)
def _known(source: Text) -> Domain:
    """The same for a text without constants that stand for objects: read once, as it stays what it is."""
    return _parsed(source, {})


def _parsed(source: Text, constants: Mapping[str, Any]) -> Domain:
    name, sections = read_define(source, read(source), "domain")
    for head, _ in sections:
        if head.text == ":durative-action":
            message = "durative actions are not supported; write an (:action ...) with a cost instead"
            raise source.error(head, message)
        if head.text not in SECTIONS:
            raise source.error(head, f"unknown section {head.text!r}{suggest(head.text, SECTIONS, 'sections')}")
    reader = _DomainReader(source, Declarations(source, constants))
    for wanted in SECTIONS:
        for head, group in sections:
            if head.text == wanted:
                reader.section(head.text, group)
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
            example = {"domain": ":action", "problem": ":init"}.get(kind, ":stream")
            raise source.error(item, f"expected a section such as ({example} ...), found {show(item)}")
        sections.append((item.items[0], item))
    return name, sections


@dataclass
class _DomainReader:
    """Reads axioms and actions over what is declared."""

    source: Source
    declared: Declarations
    actions: dict[str, Action] = field(default_factory=dict)
    axioms: list[tuple[Symbol, Axiom]] = field(default_factory=list)

    def section(self, name: str, group: Group) -> None:
        """One bracket of the file."""
        match name:
            case ":requirements":
                self.declared.read_requirements(group)
            case ":types":
                self.declared.read_types(group)
            case ":constants":
                self.declared.read_constants(group)
            case ":predicates":
                self.declared.read_predicates(group)
            case ":functions":
                self.declared.read_functions(group)
            case ":derived":
                self._axiom(group)
            case ":axiom":
                self._implied(group)
            case ":action":
                self._action(group)

    def domain(self, name: str) -> Domain:
        """Everything that was read."""
        declared = self.declared
        for unknown in sorted(declared.values.keys() - declared.constants.keys()):
            hint = suggest(unknown, declared.constants, "constants of the domain")
            raise DomainError(f"domain {name}: a value is given for the undeclared constant {unknown!r}{hint}")
        self._refuse_negative_cycles()
        return Domain(
            name=name,
            requirements=tuple(declared.requirements),
            types=declared.types,
            constants=declared.constants,
            constant_types=declared.constant_types,
            predicates=declared.predicates,
            functions=declared.functions,
            actions=self.actions,
            axioms=tuple(axiom for _, axiom in self.axioms),
            uses_costs=declared.costs or any(action.cost is not None for action in self.actions.values()),
        )

    def _axiom(self, group: Group) -> None:
        """(:derived (P ?x) CONDITION)."""
        reader = self.declared.formulas
        reader.count(group, 2, "(:derived (PREDICATE ?x ...) CONDITION)")
        symbol, rest = self._head(group.items[1])
        parameters, scope = reader.parameters(Group(rest, group.items[1].position))
        reader.arity(symbol, len(parameters), self.declared.predicates[symbol.text])
        condition = replace(reader, lenient=True).formula(group.items[2], scope)
        self.axioms.append((symbol, Axiom(symbol.text, parameters, condition)))

    def _implied(self, group: Group) -> None:
        """(:axiom :vars (?x ...) :context CONDITION :implies (P ?x ...)), as in PDDL 1.2."""
        reader = self.declared.formulas
        valid = (":vars", ":parameters", ":context", ":implies")
        given = read_attributes(reader, group, 1, valid, "an axiom")
        if not {":context", ":implies"} <= given.keys():
            raise self.source.error(group, "expected (:axiom :vars (?x ...) :context CONDITION :implies (P ?x ...))")
        symbol, rest = self._head(given[":implies"])
        listed = given.get(":vars") or given.get(":parameters") or Group(rest, symbol.position)
        parameters, scope = reader.parameters(listed)
        typed = {parameter.variable.name: parameter for parameter in parameters}
        heads, _ = reader.parameters(Group(rest, symbol.position))
        reader.arity(symbol, len(heads), self.declared.predicates[symbol.text])
        for node, head in zip(rest, heads, strict=True):
            if head.variable.name not in typed:
                raise self.source.error(node, f"unbound variable {head.variable.name!r}")
        condition = replace(reader, lenient=True).formula(given[":context"], scope)
        inner = tuple(parameter for parameter in parameters if parameter.variable not in {h.variable for h in heads})
        condition = Exists(inner, condition) if inner else condition
        self.axioms.append((symbol, Axiom(symbol.text, tuple(typed[h.variable.name] for h in heads), condition)))

    def _head(self, node: Node) -> tuple[Symbol, tuple[Node, ...]]:
        """The predicate that an axiom derives, and its arguments."""
        reader, declared = self.declared.formulas, self.declared
        symbol, rest = reader.application(node, "(PREDICATE ?x ...)")
        if symbol.text not in declared.predicates or symbol.text in declared.types:
            hint = suggest(symbol.text, declared.predicates.keys() - declared.types.keys(), "predicates")
            raise self.source.error(symbol, f"undeclared predicate {symbol.text!r}{hint}")
        return symbol, rest

    def _refuse_negative_cycles(self) -> None:
        """Axioms must be stratified: count the negations below each predicate; a cycle counts without end."""
        level = {axiom.predicate: 0 for _, axiom in self.axioms}
        changed = True
        while changed:
            changed = False
            for symbol, axiom in self.axioms:
                for atom, positive in polarities(axiom.condition):
                    needed = level.get(atom.predicate, -1) + (not positive)
                    if needed > len(level):
                        message = f"derived predicate {axiom.predicate!r} depends on its own negation"
                        raise self.source.error(symbol, message)
                    if atom.predicate in level and needed > level[axiom.predicate]:
                        level[axiom.predicate] = needed
                        changed = True

    def _action(self, group: Group) -> None:
        """(:action NAME :parameters (...) :precondition ... :effect ...)."""
        derived = frozenset(axiom.predicate for _, axiom in self.axioms)
        reader = ActionReader(self.declared.formulas, self.declared.functions, derived)
        symbol, action = reader.action(group)
        if action.name in self.actions:
            raise self.source.error(symbol, f"action {action.name!r} is defined twice")
        self.actions[action.name] = action
