"""Normal form: actions and axioms whose conditions are conjunctions of literals.

Disjunctions split an action, existential quantifiers add variables to it, and a universal quantifier becomes the
negation of a new derived predicate (Helmert, "Concise finite-domain representations for PDDL planning tasks", 2009).
"""

from __future__ import annotations

from collections.abc import Iterator
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
from tamp.planning.normal_schemas import ActionSchema, AxiomSchema, Condition, EffectSchema, NormalDomain
from tamp.planning.objects import Objects, Pattern
from tamp.planning.substitution import free_variables, put, put_condition, rename, rename_atom, resolve

GOAL = "@goal"


def normalise(domain: Domain, goal: Formula, objects: Objects) -> NormalDomain:
    """Bring a domain and a goal into normal form."""
    normal = _Normaliser(objects)
    actions = [schema for action in domain.actions.values() for schema in normal.action(action)]
    for axiom in domain.axioms:
        normal.axiom(axiom.predicate, axiom.parameters, axiom.condition)
    choices = [normal.closed(choice, ()) for choice in normal.conditions(goal)]
    if len(choices) == 1 and not any(True for _ in choices[0][0].variables()):
        goal_condition = choices[0][0]
    else:
        goal_condition = Condition(positive=((GOAL,),))
        normal.axioms.extend(AxiomSchema((GOAL,), condition) for condition, _ in choices)
    derived = frozenset(str(axiom.head[0]) for axiom in normal.axioms) | ({GOAL} if not choices else frozenset())
    return NormalDomain(tuple(actions), tuple(normal.axioms), goal_condition, domain.fluents, derived)


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
        names = tuple(p.variable.name for p in inner)
        for choice in self.conditions(formula):
            condition, more = self.closed(put_condition(choice, sigma), names, outer=parameters)
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
