"""An action's parts: attributes, precondition, conditional effects and cost."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass

from tamp.language.domain import Action, Effect, FunctionTerm, Signature
from tamp.language.formula import TRUE, And, Formula, Parameter, Variable
from tamp.language.read_formula import FormulaReader, Scope
from tamp.language.sexpr import Group, Node, Symbol, show, suggest


def read_attributes(
    reader: FormulaReader, group: Group, first: int, valid: Collection[str], what: str
) -> dict[str, Node]:
    """`:key value :key value ...` behind the first `first` items, each key at most once."""
    attributes: dict[str, Node] = {}
    items = group.items[first:]
    for index in range(0, len(items), 2):
        key = reader.symbol(items[index], f"an attribute of {what} such as {next(iter(valid))}")
        if key.text not in valid:
            raise reader.source.error(
                key, f"unknown attribute {key.text!r} of {what}{suggest(key.text, valid, 'attributes')}"
            )
        if key.text in attributes:
            raise reader.source.error(key, f"{what} has {key.text!r} twice")
        if index + 1 == len(items):
            raise reader.source.error(key, f"expected a value behind {key.text!r}")
        attributes[key.text] = items[index + 1]
    return attributes


@dataclass(frozen=True)
class ActionReader:
    """Reads actions; functions that are used without a declaration are added to `functions`."""

    formulas: FormulaReader
    functions: dict[str, Signature]
    derived: frozenset[str]

    def action(self, group: Group) -> tuple[Symbol, Action]:
        """(:action NAME :parameters (...) :precondition ... :effect ...), and where its name stands."""
        reader = self.formulas
        if len(group.items) < 2:
            raise reader.source.error(group, "expected (:action NAME ...)")
        symbol = reader.symbol(group.items[1], "the name of an action")
        valid = (":parameters", ":precondition", ":effect")
        if symbol.text.startswith((":", "?")):
            raise reader.source.error(symbol, f"expected the name of an action, found {symbol.text!r}")
        given = read_attributes(reader, group, 2, valid, f"action {symbol.text!r}")
        parameters, scope = reader.parameters(given[":parameters"]) if ":parameters" in given else ((), {})
        precondition = reader.formula(given[":precondition"], scope) if ":precondition" in given else TRUE
        effects: list[Effect] = []
        cost: list[float | FunctionTerm] = []
        if ":effect" in given:
            self._effect(given[":effect"], scope, (), TRUE, effects, cost)
        return symbol, Action(symbol.text, parameters, precondition, tuple(effects), tuple(cost) if cost else None)

    def _effect(
        self,
        node: Node,
        scope: Scope,
        parameters: tuple[Parameter, ...],
        condition: Formula,
        effects: list[Effect],
        cost: list[float | FunctionTerm],
    ) -> None:
        """Flatten an effect: `parameters` and `condition` are those of the foralls and whens around it."""
        reader = self.formulas
        group = reader.group(node, "an effect such as (and ...)")
        if not group.items:
            return
        head = reader.symbol(group.items[0], "a predicate or one of and, not, when, forall, increase")
        match head.text:
            case "and":
                for part in group.items[1:]:
                    self._effect(part, scope, parameters, condition, effects, cost)
            case "forall":
                reader.count(group, 2, "(forall (?variable ...) EFFECT)")
                new, inner = reader.parameters(group.items[1], scope)
                self._effect(group.items[2], inner, parameters + new, condition, effects, cost)
            case "when":
                reader.count(group, 2, "(when CONDITION EFFECT)")
                new_condition = reader.formula(group.items[1], scope)
                both = new_condition if condition == TRUE else And((condition, new_condition))
                self._effect(group.items[2], scope, parameters, both, effects, cost)
            case "increase":
                if parameters or condition != TRUE:
                    raise reader.source.error(node, "the cost of an action cannot depend on 'when' or 'forall'")
                cost.extend(self._increase(group, scope))
            case "not":
                reader.count(group, 1, "(not FACT)")
                effects.append(self._literal(group.items[1], scope, parameters, condition, positive=False))
            case "decrease" | "assign" | "scale-up" | "scale-down":
                raise reader.source.error(node, f"{head.text!r} is not supported, only (increase (total-cost) ...)")
            case _:
                effects.append(self._literal(node, scope, parameters, condition, positive=True))

    def _literal(
        self, node: Node, scope: Scope, parameters: tuple[Parameter, ...], condition: Formula, positive: bool
    ) -> Effect:
        reader = self.formulas
        atom = reader.atom(node, scope)
        if atom.predicate in self.derived:
            raise reader.source.error(node, f"{atom.predicate!r} is derived; an action cannot change it")
        if atom.predicate in reader.types:
            raise reader.source.error(node, f"{atom.predicate!r} is a type; an action cannot change it")
        return Effect(atom, positive, parameters, condition)

    def _increase(self, group: Group, scope: Scope) -> tuple[float | FunctionTerm, ...]:
        """(increase (total-cost) EXPRESSION)."""
        reader = self.formulas
        reader.count(group, 2, "(increase (total-cost) COST)")
        match group.items[1]:
            case Group((Symbol("total-cost"),)) | Symbol("total-cost"):
                return self._cost(group.items[2], scope)
            case other:
                raise reader.source.error(other, f"only (total-cost) can be increased, found {show(other)}")

    def _cost(self, node: Node, scope: Scope) -> tuple[float | FunctionTerm, ...]:
        """A number, a function of terms, or (+ COST ...), as the terms of a sum."""
        reader = self.formulas
        if isinstance(node, Symbol):
            return (self._number(node),)
        head, args = reader.application(node, "a cost: a number or (FUNCTION ?x ...)")
        if head.text == "+":
            return tuple(term for part in args for term in self._cost(part, scope))
        if head.text in ("-", "*", "/"):
            raise reader.source.error(node, "a cost is a number, (FUNCTION ?x ...), or a sum of those by (+ ...)")
        terms = tuple(reader.term(arg, scope) for arg in args)
        unnamed = tuple(Parameter(Variable(f"?x{i}")) for i in range(len(terms)))
        declared = self.functions.setdefault(head.text, Signature(head.text, unnamed))
        reader.arity(head, len(terms), declared)
        return (FunctionTerm(head.text, terms),)

    def _number(self, symbol: Symbol) -> float:
        try:
            value = float(symbol.text)
        except ValueError:
            value = -1.0
        if not math.isfinite(value) or value < 0:
            raise self.formulas.source.error(symbol, f"expected a cost of 0 or more, found {symbol.text!r}")
        return value
