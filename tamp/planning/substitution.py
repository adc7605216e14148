"""Terms put in the place of variables, in formulas and in normal form."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from tamp.language import (
    And,
    Atom,
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
from tamp.planning.normal_schemas import Condition
from tamp.planning.objects import Pattern


def resolve(term: str | int, sigma: dict[str, str | int]) -> str | int:
    """What a term finally stands for."""
    while isinstance(term, str) and term in sigma:
        term = sigma[term]
    return term


def put(pattern: Pattern, sigma: dict[str, str | int]) -> Pattern:
    """A pattern with variables replaced."""
    return (pattern[0], *(sigma.get(t, t) if isinstance(t, str) else t for t in pattern[1:]))


def put_condition(condition: Condition, sigma: dict[str, str | int]) -> Condition:
    """A condition with variables replaced."""

    def pairs(items: Iterable[tuple[str | int, str | int]]) -> tuple[tuple[str | int, str | int], ...]:
        return tuple((resolve(a, sigma), resolve(b, sigma)) for a, b in items)

    return Condition(
        tuple(put(p, sigma) for p in condition.positive),
        tuple(put(p, sigma) for p in condition.negative),
        pairs(condition.equal),
        pairs(condition.unequal),
    )


def rename_atom(atom: Atom, renaming: dict[Variable, Variable]) -> Atom:
    """An atom with variables renamed."""
    return Atom(atom.predicate, tuple(renaming.get(t, t) if isinstance(t, Variable) else t for t in atom.args))


def rename(formula: Formula, renaming: dict[Variable, Variable]) -> Formula:
    """A formula with its free variables renamed."""
    if not renaming:
        return formula

    def term(t: Term) -> Term:
        return renaming.get(t, t) if isinstance(t, Variable) else t

    match formula:
        case Atom():
            return rename_atom(formula, renaming)
        case Equal(left, right):
            return Equal(term(left), term(right))
        case Not(inner):
            return Not(rename(inner, renaming))
        case And(parts):
            return And(tuple(rename(part, renaming) for part in parts))
        case Or(parts):
            return Or(tuple(rename(part, renaming) for part in parts))
        case Exists(parameters, body):
            return Exists(parameters, rename(body, _without(renaming, parameters)))
        case Forall(parameters, body):
            return Forall(parameters, rename(body, _without(renaming, parameters)))
    raise AssertionError(f"no formula: {formula!r}")


def _without(renaming: dict[Variable, Variable], parameters: tuple[Parameter, ...]) -> dict[Variable, Variable]:
    hidden = {p.variable for p in parameters}
    return {old: new for old, new in renaming.items() if old not in hidden}


def free_variables(formula: Formula) -> Iterator[Variable]:
    """The free variables of a formula, with repetitions."""
    match formula:
        case Atom():
            yield from (t for t in formula.args if isinstance(t, Variable))
        case Equal(left, right):
            yield from (t for t in (left, right) if isinstance(t, Variable))
        case Not(inner):
            yield from free_variables(inner)
        case And(parts) | Or(parts):
            for part in parts:
                yield from free_variables(part)
        case Exists(parameters, body) | Forall(parameters, body):
            hidden = {p.variable for p in parameters}
            yield from (v for v in free_variables(body) if v not in hidden)
