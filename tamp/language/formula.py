"""Terms and formulas: what conditions, goals and facts are made of. `imply` is read as `(or (not a) b)`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

OBJECT = "object"
"""The root of every type hierarchy; a parameter of this type is unrestricted."""


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable; `name` is in lower case and keeps its question mark, as in `?x`."""

    name: str

    def __str__(self) -> str:
        return self.name


class Constant:
    """An object of the problem: any Python value.

    Two constants are equal where their values are; values without a hash, such as numpy arrays, only where they are
    the same object.
    """

    __slots__ = ("_hash", "_identity", "value")

    value: Any
    _hash: int
    _identity: bool

    def __init__(self, value: Any) -> None:
        object.__setattr__(self, "value", value)
        try:
            digest, by_identity = hash(value), False
        except TypeError:
            digest, by_identity = id(value), True
        object.__setattr__(self, "_hash", digest)
        object.__setattr__(self, "_identity", by_identity)

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError("a Constant is immutable")

    @property
    def by_identity(self) -> bool:
        """Whether the value has no hash."""
        return self._identity

    def __hash__(self) -> int:
        return self._hash

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Constant):
            return NotImplemented
        if self.value is other.value:
            return True
        if self._identity or other._identity or self._hash != other._hash:
            return False
        return bool(self.value == other.value)

    def __repr__(self) -> str:
        return f"Constant({self.value!r})"

    def __str__(self) -> str:
        return str(self.value)


Term = Variable | Constant


@dataclass(frozen=True, slots=True)
class Parameter:
    """A typed variable of an action, quantifier or predicate. Several `types` mean any of them (`either`)."""

    variable: Variable
    types: tuple[str, ...] = (OBJECT,)


@dataclass(frozen=True, slots=True)
class Atom:
    """A predicate (in lower case) applied to terms."""

    predicate: str
    args: tuple[Term, ...]

    def __str__(self) -> str:
        return f"({' '.join((self.predicate, *map(str, self.args)))})"


@dataclass(frozen=True, slots=True)
class Equal:
    """Both terms are the same object."""

    left: Term
    right: Term


@dataclass(frozen=True, slots=True)
class Not:
    """The formula does not hold (closed world)."""

    formula: Formula


@dataclass(frozen=True, slots=True)
class And:
    """All parts hold; `And(())` is true."""

    parts: tuple[Formula, ...]


@dataclass(frozen=True, slots=True)
class Or:
    """Some part holds; `Or(())` is false."""

    parts: tuple[Formula, ...]


@dataclass(frozen=True, slots=True)
class Exists:
    """The body holds for some objects of the parameters' types."""

    parameters: tuple[Parameter, ...]
    body: Formula


@dataclass(frozen=True, slots=True)
class Forall:
    """The body holds for all objects of the parameters' types."""

    parameters: tuple[Parameter, ...]
    body: Formula


Formula = Atom | Equal | Not | And | Or | Exists | Forall

TRUE = And(())


def atoms(formula: Formula) -> Iterator[Atom]:
    """Every atom that occurs in a formula, from left to right."""
    if isinstance(formula, Atom):
        yield formula
    elif isinstance(formula, Not):
        yield from atoms(formula.formula)
    elif isinstance(formula, And | Or):
        for part in formula.parts:
            yield from atoms(part)
    elif isinstance(formula, Exists | Forall):
        yield from atoms(formula.body)


def polarities(formula: Formula, positive: bool = True) -> Iterator[tuple[Atom, bool]]:
    """Every atom, and whether it may be read as it grows: not under a negation, nor under forall (`not exists not`)."""
    if isinstance(formula, Atom):
        yield formula, positive
    elif isinstance(formula, Not):
        yield from polarities(formula.formula, not positive)
    elif isinstance(formula, And | Or):
        for part in formula.parts:
            yield from polarities(part, positive)
    elif isinstance(formula, Exists):
        yield from polarities(formula.body, positive)
    elif isinstance(formula, Forall):
        for atom in atoms(formula.body):
            yield atom, False


def type_conditions(parameters: tuple[Parameter, ...]) -> tuple[Formula, ...]:
    """What the parameters' types ask for, with each type as a predicate of one argument; `object` asks nothing."""
    conditions: list[Formula] = []
    for parameter in parameters:
        if OBJECT not in parameter.types:
            choices = tuple(Atom(name, (parameter.variable,)) for name in parameter.types)
            conditions.append(choices[0] if len(choices) == 1 else Or(choices))
    return tuple(conditions)
