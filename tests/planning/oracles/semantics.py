"""What PDDL formulas mean in a state: joins over facts, quantifiers over all objects, axioms by fixpoint.

Written for plan validation alone and from the definition; it shares nothing with the planner's grounder.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import count

from tamp.language import (
    OBJECT,
    And,
    Atom,
    Axiom,
    Constant,
    Domain,
    Equal,
    Exists,
    Forall,
    Formula,
    Not,
    Or,
    Parameter,
    Term,
    Variable,
    atoms,
)

Bindings = dict[Variable, Constant]
Relation = dict[str, set[tuple[Constant, ...]]]


def strata(axioms: tuple[Axiom, ...]) -> list[list[Axiom]]:
    """Axioms in an order in which every negated derived predicate is complete before it is used."""
    level = {axiom.predicate: 0 for axiom in axioms}
    for _ in range(len(level) + 1):
        changed = False
        for axiom in axioms:
            for atom, positive in polarities(axiom.condition):
                if atom.predicate in level:
                    needed = level[atom.predicate] + (0 if positive else 1)
                    changed |= needed > level[axiom.predicate]
                    level[axiom.predicate] = max(level[axiom.predicate], needed)
        if not changed:
            return [[a for a in axioms if level[a.predicate] == n] for n in range(max(level.values(), default=-1) + 1)]
    raise AssertionError("the axioms cannot be stratified: a predicate depends on its own negation")


def polarities(formula: Formula, positive: bool = True) -> Iterator[tuple[Atom, bool]]:
    """The atoms of a formula and whether each stands under an even number of negations."""
    match formula:
        case Atom():
            yield formula, positive
        case Not(inner):
            yield from polarities(inner, not positive)
        case And(parts) | Or(parts):
            for part in parts:
                yield from polarities(part, positive)
        case Exists(_, body):
            yield from polarities(body, positive)
        case Forall(_, body):
            # Read as `not exists not`: the relation must be complete before it can be trusted.
            for atom in atoms(body):
                yield atom, False


@dataclass
class State:
    """Facts, and what follows from them.

    Attributes:
        domain: types and axioms.
        objects: everything that quantifiers range over.
        facts: predicate -> argument tuples that hold.
    """

    domain: Domain
    objects: tuple[Constant, ...]
    facts: Relation
    fresh: Iterator[int] = field(default_factory=count)

    def derive(self) -> State:
        """The same state with all derived facts."""
        relation: Relation = {name: set(args) for name, args in self.facts.items()}
        for axiom in self.domain.axioms:
            relation.setdefault(axiom.predicate, set())
        result = State(self.domain, self.objects, relation)
        for stratum in strata(self.domain.axioms):
            while True:
                new = {
                    (axiom.predicate, tuple(found[p.variable] for p in axiom.parameters))
                    for axiom in stratum
                    for found in result.solutions([axiom.condition], list(axiom.parameters), {})
                }
                if all(args in relation[name] for name, args in new):
                    break
                for name, args in new:
                    relation[name].add(args)
        return result

    def value(self, term: Term, env: Bindings) -> Constant:
        """The object a term stands for."""
        return env[term] if isinstance(term, Variable) else term

    def atom_holds(self, predicate: str, args: tuple[Constant, ...]) -> bool:
        """Whether a ground atom holds."""
        if predicate == OBJECT:
            return True
        return args in self.facts.get(predicate, ())

    def holds(self, formula: Formula, env: Bindings) -> bool:
        """Whether a formula holds; `env` binds all its free variables."""
        match formula:
            case Atom(predicate, args):
                return self.atom_holds(predicate, tuple(self.value(arg, env) for arg in args))
            case Equal(left, right):
                return self.value(left, env) == self.value(right, env)
            case Not(inner):
                return not self.holds(inner, env)
            case And(parts):
                return all(self.holds(part, env) for part in parts)
            case Or(parts):
                return any(self.holds(part, env) for part in parts)
            case Exists(parameters, body):
                return next(self.solutions([body], list(parameters), env), None) is not None
            case Forall(parameters, body):
                return next(self.solutions([Not(body)], list(parameters), env), None) is None

    def has_types(self, parameter: Parameter, value: Constant) -> bool:
        """Whether an object is of one of the parameter's types."""
        return any(name == OBJECT or (value,) in self.facts.get(name, ()) for name in parameter.types)

    def solutions(self, conjuncts: list[Formula], unbound: list[Parameter], env: Bindings) -> Iterator[Bindings]:
        """All extensions of `env` to the `unbound` parameters under which all `conjuncts` hold."""
        if not unbound:
            if all(self.holds(part, env) for part in conjuncts):
                yield env
            return
        open_variables = {parameter.variable: parameter for parameter in unbound}
        for index, part in enumerate(conjuncts):
            rest = conjuncts[:index] + conjuncts[index + 1 :]
            match part:
                case And(parts):
                    yield from self.solutions([*rest, *parts], unbound, env)
                    return
                case Not(Not(inner)):
                    yield from self.solutions([*rest, inner], unbound, env)
                    return
                case Not(Or(parts)):
                    yield from self.solutions([*rest, *(Not(p) for p in parts)], unbound, env)
                    return
                case Exists(parameters, body):
                    # Its variables join those to be bound, under names that no sibling has.
                    mine = {p.variable: Variable(f"{p.variable.name}#{next(self.fresh)}") for p in parameters}
                    renamed = [Parameter(mine[p.variable], p.types) for p in parameters]
                    seen = []
                    for found in self.solutions([*rest, rename(body, mine)], unbound + renamed, env):
                        kept = {k: v for k, v in found.items() if k not in mine.values()}
                        if kept not in seen:
                            seen.append(kept)
                            yield kept
                    return
        best = self._best_atom(conjuncts, open_variables)
        if best is not None:
            rest = [part for part in conjuncts if part is not best]
            for args in tuple(self.facts.get(best.predicate, ())):
                extended = self._unify(best.args, args, env, open_variables)
                if extended is not None:
                    yield from self.solutions(rest, [p for p in unbound if p.variable not in extended], extended)
            return
        parameter, *others = unbound
        for value in self.objects:
            if self.has_types(parameter, value):
                yield from self.solutions(conjuncts, others, {**env, parameter.variable: value})

    def _best_atom(self, conjuncts: list[Formula], open_variables: Mapping[Variable, Parameter]) -> Atom | None:
        candidates = [
            part
            for part in conjuncts
            if isinstance(part, Atom) and part.predicate != OBJECT and any(arg in open_variables for arg in part.args)
        ]
        # Few unbound variables first, then few facts.
        return min(
            candidates,
            key=lambda a: (len({x for x in a.args if x in open_variables}), len(self.facts.get(a.predicate, ()))),
            default=None,
        )

    def _unify(
        self,
        pattern: tuple[Term, ...],
        args: tuple[Constant, ...],
        env: Bindings,
        open_variables: Mapping[Variable, Parameter],
    ) -> Bindings | None:
        extended = dict(env)
        for term, value in zip(pattern, args, strict=True):
            known = extended.get(term) if isinstance(term, Variable) else term
            if known is None:
                if not self.has_types(open_variables[term], value):
                    return None
                extended[term] = value
            elif known != value:
                return None
        return extended


def rename(formula: Formula, names: Mapping[Variable, Variable]) -> Formula:
    """The formula with free variables renamed; no variable is bound twice on a path, so nothing is captured."""

    def term(t: Term) -> Term:
        return names.get(t, t) if isinstance(t, Variable) else t

    match formula:
        case Atom(predicate, args):
            return Atom(predicate, tuple(term(arg) for arg in args))
        case Equal(left, right):
            return Equal(term(left), term(right))
        case Not(inner):
            return Not(rename(inner, names))
        case And(parts):
            return And(tuple(rename(part, names) for part in parts))
        case Or(parts):
            return Or(tuple(rename(part, names) for part in parts))
        case Exists(parameters, body):
            return Exists(parameters, rename(body, names))
        case Forall(parameters, body):
            return Forall(parameters, rename(body, names))


def relation_of(facts: Iterable[Atom]) -> Relation:
    """Atoms as predicate -> argument tuples."""
    relation: Relation = {}
    for fact in facts:
        relation.setdefault(fact.predicate, set()).add(fact.args)
    return relation
