"""A planning domain as data: types, predicates, functions, actions, axioms. All names are in lower case."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from tamp.frozen import FrozenDict
from tamp.language.formula import OBJECT, TRUE, Atom, Constant, Formula, Parameter, Term


@dataclass(frozen=True, slots=True)
class Signature:
    """The declaration of a predicate or of a function."""

    name: str
    parameters: tuple[Parameter, ...]

    @property
    def arity(self) -> int:
        """How many arguments it takes."""
        return len(self.parameters)


@dataclass(frozen=True, slots=True)
class FunctionTerm:
    """A function applied to terms; its value is a number."""

    function: str
    args: tuple[Term, ...]


@dataclass(frozen=True, slots=True)
class Effect:
    """For all objects of `parameters` for which `condition` holds before the action, `atom` becomes true or false.

    An atom that one action both adds and deletes is true afterwards.
    """

    atom: Atom
    positive: bool = True
    parameters: tuple[Parameter, ...] = ()
    condition: Formula = TRUE


@dataclass(frozen=True, slots=True)
class Action:
    """An action schema. It costs the sum of `cost`; None where it has no `(increase (total-cost) ...)`."""

    name: str
    parameters: tuple[Parameter, ...]
    precondition: Formula
    effects: tuple[Effect, ...]
    cost: tuple[float | FunctionTerm, ...] | None = None


@dataclass(frozen=True, slots=True)
class Axiom:
    """A derived predicate: `predicate(parameters)` holds where `condition` does, or that of another of its axioms."""

    predicate: str
    parameters: tuple[Parameter, ...]
    condition: Formula


@dataclass(frozen=True)
class Domain:
    """A PDDL domain.

    Types are also predicates of one argument: the fact `("block", b)` gives `b` the type `block` and all its
    supertypes; `("object", b)` holds for everything. No variable is bound twice along any path into a formula.

    Attributes:
        types: name -> its direct supertypes; `object` is always there and has none.
        constants: name -> the object it stands for; unless told otherwise that is the name.
        constant_types: name -> the types of that constant.
        predicates: name -> declaration; derived predicates and types are included.
        functions: name -> declaration, or how it is used where the file does not declare it; without `total-cost`.
        actions: name -> schema, in the order of the file.
        axioms: in the order of the file.
        uses_costs: whether the file mentions `total-cost`; otherwise each action costs 1.
    """

    name: str
    requirements: tuple[str, ...] = ()
    types: Mapping[str, tuple[str, ...]] = field(default_factory=lambda: {OBJECT: ()})
    constants: Mapping[str, Constant] = field(default_factory=dict)
    constant_types: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    predicates: Mapping[str, Signature] = field(default_factory=dict)
    functions: Mapping[str, Signature] = field(default_factory=dict)
    actions: Mapping[str, Action] = field(default_factory=dict)
    axioms: tuple[Axiom, ...] = ()
    uses_costs: bool = False

    def __post_init__(self) -> None:
        for name in ("types", "constants", "constant_types", "predicates", "functions", "actions"):
            object.__setattr__(self, name, FrozenDict(getattr(self, name)))

    def __hash__(self) -> int:
        """Equal domains have equal names."""
        return hash((self.name, tuple(self.predicates), tuple(self.actions)))

    @property
    def derived(self) -> frozenset[str]:
        """Names of the predicates that axioms define."""
        return frozenset(axiom.predicate for axiom in self.axioms)

    @property
    def fluents(self) -> frozenset[str]:
        """Names of the predicates that some action changes."""
        return frozenset(effect.atom.predicate for action in self.actions.values() for effect in action.effects)

    def supertypes(self, name: str) -> tuple[str, ...]:
        """All types above `name`, nearest first, without `name` itself."""
        found: dict[str, None] = {}
        queue = list(self.types[name])
        while queue:
            above = queue.pop(0)
            if above not in found:
                found[above] = None
                queue.extend(self.types[above])
        return tuple(found)

    def constant(self, value: Any) -> Constant:
        """The object that a Python value stands for; a text that spells a constant of the domain is that constant."""
        if isinstance(value, str) and value.lower() in self.constants:
            return self.constants[value.lower()]
        return Constant(value)
