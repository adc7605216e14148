"""Conditions, effects and goals in a normal form: literals in conjunctions, disjunctions split, terms substituted."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace

from tamp.language import (
    Action,
    And,
    Atom,
    Domain,
    Effect,
    Equal,
    Exists,
    Forall,
    Formula,
    FunctionTerm,
    Not,
    Or,
    Parameter,
    Term,
    Variable,
    type_conditions,
)
from tamp.planning.model.objects import Objects, Pattern


@dataclass(frozen=True)
class Condition:
    """A conjunction of literals over variables, some of them existentially quantified."""

    positive: tuple[Pattern, ...] = ()
    negative: tuple[Pattern, ...] = ()
    equal: tuple[tuple[str | int, str | int], ...] = ()
    unequal: tuple[tuple[str | int, str | int], ...] = ()

    def __and__(self, other: Condition) -> Condition:
        return Condition(
            tuple(dict.fromkeys(self.positive + other.positive)),
            tuple(dict.fromkeys(self.negative + other.negative)),
            self.equal + other.equal,
            self.unequal + other.unequal,
        )

    def variables(self) -> Iterator[str]:
        """Every variable that occurs, in order, with repetitions."""
        for pattern in self.positive + self.negative:
            yield from (term for term in pattern[1:] if isinstance(term, str))
        for pair in self.unequal:
            yield from (term for term in pair if isinstance(term, str))


@dataclass(frozen=True)
class EffectSchema:
    """`atom` becomes true or false for all bindings of the variables that only occur here that satisfy `condition`."""

    atom: Pattern
    positive: bool
    condition: Condition = Condition()


@dataclass(frozen=True)
class ActionSchema:
    """An action in normal form. `parameters` are the terms of the action's own parameters, after equalities."""

    name: str
    parameters: tuple[str | int, ...]
    condition: Condition
    effects: tuple[EffectSchema, ...]
    cost: tuple[float | Pattern, ...] | None


@dataclass(frozen=True)
class AxiomSchema:
    """`head` holds where `condition` does."""

    head: Pattern
    condition: Condition


@dataclass(frozen=True)
class NormalDomain:
    """All schemas of a problem; the goal is a conjunction of literals without variables."""

    actions: tuple[ActionSchema, ...]
    axioms: tuple[AxiomSchema, ...]
    goal: Condition
    fluents: frozenset[str]
    derived: frozenset[str]


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


GOAL = "@goal"
"""Prefix of derived predicates that stand for parts of the goal that are more than literals."""


def normalise(domain: Domain, goal: Formula, objects: Objects) -> NormalDomain:
    """Bring a domain and a goal into normal form."""
    normal = _Normaliser(objects)
    actions = [schema for action in domain.actions.values() for schema in normal.action(action)]
    for axiom in domain.axioms:
        normal.axiom(axiom.predicate, axiom.parameters, axiom.condition)
    goal_condition, made = Condition(), list[str]()
    for part in _conjuncts(goal):
        choices = [normal.closed(choice, ()) for choice in normal.conditions(part)]
        if len(choices) == 1 and not any(True for _ in choices[0][0].variables()):
            goal_condition &= choices[0][0]
            continue
        made.append(f"{GOAL}-{len(made) + 1}")
        goal_condition &= Condition(positive=((made[-1],),))
        normal.axioms.extend(AxiomSchema((made[-1],), condition) for condition, _ in choices)
    derived = frozenset(str(axiom.head[0]) for axiom in normal.axioms) | frozenset(made)
    return NormalDomain(tuple(actions), tuple(normal.axioms), goal_condition, domain.fluents, derived)


def _conjuncts(formula: Formula) -> Iterator[Formula]:
    """The parts of a conjunction, or the formula itself: each can be looked after by itself."""
    if isinstance(formula, And):
        for part in formula.parts:
            yield from _conjuncts(part)
    else:
        yield formula


def literals_of(goal: Formula, objects: Objects) -> Condition | None:
    """A goal that is a conjunction of literals without variables; None where it is more than that."""
    positive: list[Pattern] = []
    negative: list[Pattern] = []
    queue = [goal]
    while queue:
        part = queue.pop(0)
        match part:
            case And(parts):
                queue = [*parts, *queue]
            case (Atom() as atom) | Not(Atom() as atom):
                if atom.predicate == "object" or any(isinstance(arg, Variable) for arg in atom.args):
                    return None
                found = positive if part is atom else negative
                found.append((atom.predicate, *(objects.intern(arg.value) for arg in atom.args)))  # type: ignore[union-attr]
            case _:
                return None
    return Condition(tuple(dict.fromkeys(positive)), tuple(dict.fromkeys(negative)))


@dataclass
class _Normaliser:
    objects: Objects
    axioms: list[AxiomSchema] = field(default_factory=list)
    fresh: int = 0

    def term(self, term: Term) -> str | int:
        return term.name if isinstance(term, Variable) else self.objects.intern(term.value)

    def pattern(self, atom: Atom) -> Pattern:
        return (atom.predicate, *map(self.term, atom.args))

    def action(self, action: Action) -> Iterator[ActionSchema]:
        types = type_conditions(action.parameters)
        parameters = tuple(p.variable.name for p in action.parameters)
        cost = None
        if action.cost is not None:
            cost = tuple(t if not isinstance(t, FunctionTerm) else self._function(t) for t in action.cost)
        for choice in self.conditions(And((*types, action.precondition))):
            condition, sigma = self.closed(choice, parameters)
            effects = tuple(e for effect in action.effects for e in self._effects(effect, parameters, sigma))
            patterns = None if cost is None else tuple(c if isinstance(c, float) else put(c, sigma) for c in cost)
            yield ActionSchema(action.name, tuple(sigma.get(p, p) for p in parameters), condition, effects, patterns)

    def _function(self, term: FunctionTerm) -> Pattern:
        return (term.function, *map(self.term, term.args))

    def _effects(
        self, effect: Effect, parameters: tuple[str, ...], sigma: dict[str, str | int]
    ) -> Iterator[EffectSchema]:
        renaming = {p.variable: Variable(self._name(p.variable.name)) for p in effect.parameters}
        inner = tuple(Parameter(renaming[p.variable], p.types) for p in effect.parameters)
        formula = And((*type_conditions(inner), rename(effect.condition, renaming)))
        atom = put(self.pattern(rename_atom(effect.atom, renaming)), sigma)
        # What neither the atom nor the condition names makes the same effect for each object.
        names = tuple(name for p in inner if (name := p.variable.name) in atom)
        # A parameter may go by the name of what the precondition says that it equals.
        outer = tuple(term for name in parameters if isinstance(term := sigma.get(name, name), str))
        for choice in self.conditions(formula):
            condition, more = self.closed(put_condition(choice, sigma), names, outer=outer)
            yield EffectSchema(put(atom, more), effect.positive, condition)

    def axiom(self, predicate: str, parameters: tuple[Parameter, ...], formula: Formula) -> None:
        names = tuple(p.variable.name for p in parameters)
        for choice in self.conditions(And((*type_conditions(parameters), formula))):
            condition, sigma = self.closed(choice, names)
            self.axioms.append(AxiomSchema((predicate, *(sigma.get(n, n) for n in names)), condition))

    def closed(
        self, condition: Condition, names: tuple[str, ...], outer: tuple[str, ...] = ()
    ) -> tuple[Condition, dict[str, str | int]]:
        """Put equalities in, and bind every variable that no positive literal binds to all objects."""
        sigma: dict[str, str | int] = {}
        equal = list(condition.equal)
        impossible = False
        while equal:
            a, b = (resolve(term, sigma) for term in equal.pop())
            if a == b:
                continue
            if isinstance(a, str) and a not in outer:
                sigma[a] = b
            elif isinstance(b, str) and b not in outer:
                sigma[b] = a
            elif isinstance(a, str) or isinstance(b, str):
                condition = replace(condition, positive=(*condition.positive, ("=", a, b)))
            else:
                impossible = True
        sigma = {name: resolve(name, sigma) for name in sigma}
        condition = put_condition(replace(condition, equal=()), sigma)
        if impossible or any(a == b for a, b in condition.unequal):
            condition = replace(condition, positive=(*condition.positive, ("@false",)))
        needed = [t for n in names if isinstance(t := sigma.get(n, n), str)] + list(condition.variables())
        covered = {t for p in condition.positive for t in p[1:] if isinstance(t, str)} | set(outer)
        loose = dict.fromkeys(t for t in needed if t not in covered)
        return replace(condition, positive=(*condition.positive, *(("object", t) for t in loose))), sigma

    def conditions(self, formula: Formula, holds: bool = True) -> list[Condition]:
        """The disjunctive normal form of a formula, or of its negation."""
        match formula:
            case Atom():
                pattern = self.pattern(formula)
                if pattern[0] == "object":
                    return [Condition()] if holds else []
                return [Condition(positive=(pattern,)) if holds else Condition(negative=(pattern,))]
            case Equal(left, right):
                pair = ((self.term(left), self.term(right)),)
                return [Condition(equal=pair) if holds else Condition(unequal=pair)]
            case Not(inner):
                return self.conditions(inner, not holds)
            case And(parts) | Or(parts) if isinstance(formula, And) == holds:
                product = [Condition()]
                for part in parts:
                    choices = self.conditions(part, holds)
                    product = [a & b for a in product for b in choices]
                return product
            case And(parts) | Or(parts):
                return [choice for part in parts for choice in self.conditions(part, holds)]
            case Exists(parameters, body) | Forall(parameters, body):
                if isinstance(formula, Exists) == holds:
                    return self._exists(parameters, body, holds)
                return [Condition(negative=(self._counterexample(parameters, body, not holds),))]
        raise AssertionError(f"no formula: {formula!r}")

    def _exists(self, parameters: tuple[Parameter, ...], body: Formula, holds: bool) -> list[Condition]:
        renaming = {p.variable: Variable(self._name(p.variable.name)) for p in parameters}
        inner = tuple(Parameter(renaming[p.variable], p.types) for p in parameters)
        types = self.conditions(And(type_conditions(inner)))
        choices = self.conditions(rename(body, renaming), holds)
        return [a & b for a in types for b in choices]

    def _counterexample(self, parameters: tuple[Parameter, ...], body: Formula, holds: bool) -> Pattern:
        """A new derived predicate of the free variables: some objects make the body (or its negation) true."""
        free = tuple(dict.fromkeys(v for v in free_variables(body) if v not in {p.variable for p in parameters}))
        self.fresh += 1
        name = f"@some-{self.fresh}"
        head: Pattern = (name, *(v.name for v in free))
        for choice in self._exists(parameters, body, holds):
            condition, sigma = self.closed(choice, tuple(v.name for v in free))
            self.axioms.append(AxiomSchema(put(head, sigma), condition))
        if not any(axiom.head[0] == name for axiom in self.axioms):
            self.axioms.append(AxiomSchema(head, self.closed(Condition(positive=(("@false",),)), head[1:])[0]))  # type: ignore[arg-type]
        return head

    def _name(self, base: str) -> str:
        self.fresh += 1
        return f"{base}.{self.fresh}"
