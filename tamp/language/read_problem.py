"""A PDDL problem file -> initial state and goal as nested tuples of names, checked against its domain."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass, field
from typing import Any

from tamp.errors import DomainWarning
from tamp.language.domain import Domain
from tamp.language.formula import OBJECT, Constant
from tamp.language.read_domain import read_define
from tamp.language.read_formula import FormulaReader
from tamp.language.sexpr import PDDL, Group, Node, Source, Symbol, load, read, show, suggest

SECTIONS = (":domain", ":requirements", ":objects", ":init", ":goal", ":metric")


@dataclass(frozen=True)
class ProblemFile:
    """What a problem file says; objects are their names, in lower case.

    Attributes:
        init: facts such as `("on", "a", "b")`, types of objects among them, and values `("=", ("far", "a", "b"), 2.0)`.
        goal: a formula such as `("and", ("on", "a", "b"), ("clear", "a"))`.
    """

    init: tuple[Any, ...]
    goal: Any


def parse_problem(text_or_path: PDDL, domain: Domain) -> ProblemFile:
    """Read a PDDL problem.

    Args:
        text_or_path: PDDL text, or the file it lies in.
        domain: declares what may be said.

    Raises:
        DomainError: with file, line and column of what cannot be read, and where there is no goal.
    """
    source = load(text_or_path, "problem")
    whole = read(source)
    _, sections = read_define(source, whole, "problem")
    groups: dict[str, Group] = {}
    for head, group in sections:
        if head.text not in SECTIONS:
            raise source.error(head, f"unknown section {head.text!r}{suggest(head.text, SECTIONS, 'sections')}")
        if head.text in groups:
            raise source.error(head, f"section {head.text!r} is there twice")
        groups[head.text] = group
    if ":goal" not in groups:
        raise source.error(whole, "expected a (:goal FORMULA), found none")
    return _ProblemReader(source, domain).problem(groups)


@dataclass
class _ProblemReader:
    source: Source
    domain: Domain
    formulas: FormulaReader = field(init=False)

    def problem(self, groups: dict[str, Group]) -> ProblemFile:
        """Everything that the sections say."""
        nothing = Group((), groups[":goal"].position)
        types = self._objects(groups.get(":objects", nothing))
        constants = {**self.domain.constants, **{name: Constant(name) for name in types}}
        predicates = dict(self.domain.predicates)
        self.formulas = FormulaReader(self.source, self.domain.types, constants, predicates)
        self._check_domain(groups.get(":domain", nothing))
        self._check_metric(groups.get(":metric", nothing))
        facts = map(self._said, groups.get(":init", nothing).items[1:])
        init = (*((kind, name) for name, kind in types.items()), *facts)
        goal = groups[":goal"]
        self.formulas.count(goal, 1, "(:goal FORMULA)")
        self.formulas.formula(goal.items[1], {})
        return ProblemFile(init, _tuples(goal.items[1]))

    def _objects(self, group: Group) -> dict[str, str]:
        """The objects, each with its type."""
        reader = FormulaReader(self.source, self.domain.types, None, {})
        found: dict[str, str] = {}
        for symbol, types in reader.typed_list(group, start=1):
            if symbol.text in found:
                raise self.source.error(symbol, f"object {symbol.text!r} is named twice")
            if len(types) > 1:
                raise self.source.error(symbol, f"object {symbol.text!r} has several types; one is valid")
            (found[symbol.text],) = reader.check_types(types) or (OBJECT,)
        return found

    def _check_domain(self, group: Group) -> None:
        """Warn of a problem of another domain."""
        name = group.items[1] if len(group.items) == 2 else None
        if group.items and not (isinstance(name, Symbol) and name.text == self.domain.name):
            error = self.source.error(group, f"the domain is {self.domain.name!r}, not {show(name or group)}")
            warnings.warn(str(error), DomainWarning, stacklevel=2)

    def _check_metric(self, group: Group) -> None:
        """Refuse to make anything small but the cost of a plan."""
        if group.items and _tuples(group)[1:] != ("minimize", ("total-cost",)):
            raise self.source.error(group, f"expected (:metric minimize (total-cost)), found {show(group)}")

    def _said(self, node: Node) -> Any:
        """A fact, that one does not hold, or the value of a function."""
        head, rest = self.formulas.application(node, "a fact such as (predicate a)")
        if head.text == "not" and len(rest) == 1:
            return ("not", self._said(rest[0]))
        if head.text != "=":
            self.formulas.atom(node, {})
            return _tuples(node)
        form = "(= (FUNCTION a ...) NUMBER)"
        self.formulas.count(self.formulas.group(node, form), 2, form)
        function, args = self.formulas.application(rest[0], form)
        if function.text in self.domain.functions:
            self.formulas.arity(function, len(args), self.domain.functions[function.text])
        for arg in args:
            self.formulas.term(arg, {})
        return ("=", _tuples(rest[0]), self._number(rest[1]))

    def _number(self, node: Node) -> float:
        try:
            value = float(self.formulas.symbol(node, "a number").text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise self.source.error(node, f"expected a number, found {show(node)}")
        return value


def _tuples(node: Node) -> Any:
    """An expression as nested tuples of words."""
    if isinstance(node, Group):
        return tuple(map(_tuples, node.items))
    assert isinstance(node, Symbol)  # files hold nothing else
    return node.text
