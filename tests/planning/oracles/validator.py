"""Simulates a plan from the definition of PDDL and says which step cannot be taken, and why."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

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
    FunctionStream,
    FunctionTerm,
    Not,
    Or,
    Parameter,
    PredicateStream,
    Rule,
    Stream,
    StreamFile,
    Variable,
    atoms,
    parse_domain,
    parse_goal,
    parse_init,
)
from tests.planning.oracles.semantics import Bindings, Relation, State, relation_of

Values = dict[FunctionTerm, float]


class InvalidPlanError(AssertionError):
    """A step that cannot be taken, or a goal that is not reached."""


def validate(
    domain: Domain | str | Path,
    facts: Iterable[Any],
    plan: Iterable[tuple[str, tuple[Any, ...]]],
    goal: Any,
    streams: StreamFile | None = None,
    samplers: Mapping[str, Callable[..., Any]] | None = None,
    observe: Callable[[str, tuple[Any, ...], Relation], None] | None = None,
    given: Iterable[Any] = (),
) -> float:
    """Carry out a plan.

    Args:
        domain: the domain, or its text or file.
        facts: all initial and certified facts and function values, as tuples.
        plan: names and arguments of the actions.
        goal: the goal, as nested tuples.
        streams: what the samplers belong to.
        samplers: tests, predicates and functions are asked again: facts of tests must be true, and facts of
            :predicate externals and values of functions come from here.
        observe: called before each action with its name, arguments and the facts that hold.
        given: those of the facts that hold from the start, whatever the domains of streams say.

    Returns:
        The plan's cost.

    Raises:
        InvalidPlanError: with the step and the condition that is not met.
    """
    domain = domain if isinstance(domain, Domain) else parse_domain(domain)
    if streams is not None:
        names = guarded(domain, streams)
        facts = [(FUTURE + fact[0].lower(), *fact[1:]) if fact[0].lower() in names else fact for fact in facts]
        facts += [fact for fact in given if fact[0].lower() in names]
        domain, streams, _ = guard(domain, streams)
        domain = replace(domain, axioms=(*domain.axioms, *(a for rule in streams.rules for a in axioms_of(rule))))
    steps = [(name.lower(), tuple(domain.constant(arg) for arg in args)) for name, args in plan]
    formula, initial = parse_goal(goal, domain, streams), parse_init(facts, domain, streams)
    relation = relation_of(initial.facts)
    add_types(domain, relation)
    values: Values = dict(initial.values)
    if streams is not None:
        ask_again(domain, relation, values, streams, samplers or {})
    objects = known_objects(domain, relation, formula, steps)
    cost = 0.0
    for number, (name, args) in enumerate(steps, start=1):
        label = f"step {number}, ({name} {' '.join(map(str, args))})"
        if name not in domain.actions:
            raise InvalidPlanError(f"{label}: there is no such action")
        action = domain.actions[name]
        if len(args) != len(action.parameters):
            raise InvalidPlanError(f"{label}: takes {len(action.parameters)} arguments")
        state = State(domain, objects, told(domain, relation, streams, samplers or {}, objects)).derive()
        env = {parameter.variable: arg for parameter, arg in zip(action.parameters, args, strict=True)}
        for parameter, arg in zip(action.parameters, args, strict=True):
            if not state.has_types(parameter, arg):
                raise InvalidPlanError(f"{label}: {arg} is no {' or '.join(parameter.types)}")
        explain(state, action.precondition, env, label)
        if observe:
            observe(name, tuple(arg.value for arg in args), state.facts)
        cost += action_cost(domain, action.cost, env, values, label)
        relation = successor(state, relation, action.effects, env)
    relation = told(domain, relation, streams, samplers or {}, objects)
    explain(State(domain, objects, relation).derive(), formula, {}, "the goal")
    return cost


FUTURE = "future-"
"""Prefix of what a stream certifies under conditions that actions change."""


def guarded(domain: Domain, streams: StreamFile) -> set[str]:
    """Predicates certified by streams whose domain names a fact that actions change, or another guarded predicate."""
    found: set[str] = set()
    while True:
        changing = domain.fluents | found
        more = {
            atom.predicate
            for source in (*streams.streams, *streams.predicates)
            if any(fact.predicate in changing for fact in source.domain)
            for atom in getattr(source, "certified", None) or (Atom(source.name, source.inputs),)
        }
        if more <= found:
            return found
        found |= more


def guard(domain: Domain, streams: StreamFile) -> tuple[Domain, StreamFile, set[str]]:
    """The same problem with guarded predicates derived: a fact that was certified holds where the domain does.

    Also the predicates that actions change and streams wait for. Predicates given by a function are not supported.
    """
    names = guarded(domain, streams)
    if not names:
        return domain, streams, set()

    def later(atom: Atom) -> Atom:
        return Atom(FUTURE + atom.predicate, atom.args) if atom.predicate in names else atom

    changed, axioms = [], []
    for source in streams.streams:
        certified = tuple(map(later, source.certified))
        changed.append(replace(source, domain=tuple(map(later, source.domain)), certified=certified))
        for atom in source.certified:
            if atom.predicate in names:
                parameters = tuple(Parameter(Variable(f"?arg{i}")) for i in range(len(atom.args)))
                same = [Equal(p.variable, arg) for p, arg in zip(parameters, atom.args, strict=True)]
                promised = [a for a in certified if a.predicate.startswith(FUTURE)]
                own = (*source.inputs, *source.outputs)
                axioms.append(
                    Axiom(
                        atom.predicate,
                        parameters,
                        Exists(tuple(map(Parameter, own)), And((*source.domain, *promised, *same))),
                    )
                )
    waits = {a.predicate for s in streams.streams for a in s.domain if a.predicate in domain.fluents}
    return replace(domain, axioms=(*domain.axioms, *axioms)), replace(streams, streams=tuple(changed)), waits


def axioms_of(rule: Rule) -> Iterator[Axiom]:
    """A rule of a stream file derives each fact that it certifies wherever its domain holds."""
    for atom in rule.certified:
        parameters = tuple(Parameter(Variable(f"?arg{i}")) for i in range(len(atom.args)))
        same = tuple(Equal(p.variable, arg) for p, arg in zip(parameters, atom.args, strict=True))
        body = Exists(tuple(map(Parameter, rule.inputs)), And((*rule.domain, *same)))
        yield Axiom(atom.predicate, parameters, body)


def ask_again(
    domain: Domain,
    relation: Relation,
    values: Values,
    streams: StreamFile,
    samplers: Mapping[str, Callable[..., Any]],
) -> None:
    """Ask all tests, predicates and functions about everything in the facts, and correct or refuse the facts."""
    objects = known_objects(domain, relation, And(()), [])
    state = State(domain, objects, relation)
    asked = [s for s in streams.streams if s.is_test and not s.fluents and s.name in samplers]
    for external in (*streams.predicates, *streams.functions, *asked):
        sampler = samplers.get(external.name)
        if sampler is None:
            continue
        for found in list(state.solutions(list(external.domain), [Parameter(v) for v in external.inputs], {})):
            args = tuple(found[variable] for variable in external.inputs)
            answer = sampler(SimpleNamespace(fluents=(), sees_fluents=False), *(arg.value for arg in args))
            if isinstance(external, FunctionStream):
                values[FunctionTerm(external.name, args)] = float(answer)
            elif isinstance(external, PredicateStream):
                known = relation.setdefault(external.name, set())
                known.add(args) if answer else known.discard(args)
            elif not answer or getattr(answer, "outputs", ()) is None:
                refuse_claims(external, state, found, relation)


def told(
    domain: Domain,
    relation: Relation,
    streams: StreamFile | None,
    samplers: Mapping[str, Callable[..., Any]],
    objects: tuple[Constant, ...],
) -> Relation:
    """The facts with what tests certify that are told those of a state."""
    tests = [s for s in streams.streams if s.is_test and s.fluents and s.name in samplers] if streams else []
    result = {name: set(args) for name, args in relation.items()}
    state = State(domain, objects, relation)
    for test in tests:
        seen = [(name, args) for name in test.fluents for args in sorted(relation.get(name, ()), key=str)]
        facts = tuple((name, *(arg.value for arg in args)) for name, args in seen)
        for found in list(state.solutions(list(test.domain), [Parameter(v) for v in test.inputs], {})):
            context = SimpleNamespace(fluents=facts, sees_fluents=True, fail=lambda *args, **keywords: None)
            if samplers[test.name](context, *(found[v].value for v in test.inputs)):
                for atom in test.certified:
                    result.setdefault(atom.predicate, set()).add(tuple(state.value(arg, found) for arg in atom.args))
    return result


def refuse_claims(test: Stream, state: State, found: Bindings, relation: Relation) -> None:
    """A test that says no certifies nothing."""
    for atom in test.certified:
        if tuple(state.value(arg, found) for arg in atom.args) in relation.get(atom.predicate, ()):
            raise InvalidPlanError(f"{show(atom, found)} is claimed, but {test.name} says no")


def known_objects(domain: Domain, relation: Relation, goal: Formula, steps: list[Any]) -> tuple[Constant, ...]:
    """Everything that is mentioned anywhere, in a fixed order."""
    found: dict[Constant, None] = dict.fromkeys(domain.constants.values())
    for name in sorted(relation):
        for args in relation[name]:
            found.update(dict.fromkeys(args))
    for atom in atoms(goal):
        found.update(dict.fromkeys(arg for arg in atom.args if isinstance(arg, Constant)))
    for _, args in steps:
        found.update(dict.fromkeys(args))
    return tuple(found)


def add_types(domain: Domain, relation: Relation) -> None:
    """Give constants their types, and everything the supertypes of its types."""
    for name, types in domain.constant_types.items():
        if len(types) == 1:
            relation.setdefault(types[0], set()).add((domain.constants[name],))
    for name in domain.types:
        for above in domain.supertypes(name):
            if above != OBJECT:
                relation.setdefault(above, set()).update(relation.get(name, ()))


def explain(state: State, formula: Formula, env: Bindings, label: str) -> None:
    """Raise with the first conjunct that does not hold."""
    if isinstance(formula, And):
        for part in formula.parts:
            explain(state, part, env, label)
    elif not state.holds(formula, env):
        raise InvalidPlanError(f"{label}: not met: {show(formula, env)}")


def successor(state: State, relation: Relation, effects: tuple[Any, ...], env: Bindings) -> Relation:
    """The facts after an action: all conditions are read before it, and what is added wins over what is deleted."""
    added: list[tuple[str, tuple[Constant, ...]]] = []
    deleted: list[tuple[str, tuple[Constant, ...]]] = []
    for effect in effects:
        for found in state.solutions([effect.condition], list(effect.parameters), env):
            args = tuple(state.value(arg, found) for arg in effect.atom.args)
            (added if effect.positive else deleted).append((effect.atom.predicate, args))
    result = {name: set(args) for name, args in relation.items()}
    for name, args in deleted:
        result.get(name, set()).discard(args)
    for name, args in added:
        result.setdefault(name, set()).add(args)
    return result


def action_cost(
    domain: Domain,
    cost: tuple[float | FunctionTerm, ...] | None,
    env: Bindings,
    values: Values,
    label: str,
) -> float:
    """The sum of an action's costs; 1 in a domain without costs."""
    if not domain.uses_costs:
        return 1.0
    total = 0.0
    for term in cost or ():
        if not isinstance(term, FunctionTerm):
            total += term
            continue
        args = tuple(env[arg] if isinstance(arg, Variable) else arg for arg in term.args)
        if FunctionTerm(term.function, args) in values:
            total += values[FunctionTerm(term.function, args)]
        else:
            raise InvalidPlanError(f"{label}: ({term.function} {' '.join(map(str, args))}) has no value")
    return total


def show(formula: Formula, env: Bindings) -> str:
    """A formula in PDDL, with the values of its bound variables."""

    def terms(*args: Any) -> str:
        return " ".join(str(env.get(arg, arg)) for arg in args)

    match formula:
        case Atom(predicate, args):
            return f"({predicate} {terms(*args)})" if args else f"({predicate})"
        case Equal(left, right):
            return f"(= {terms(left, right)})"
        case Not(inner):
            return f"(not {show(inner, env)})"
        case And(parts) | Or(parts):
            return f"({type(formula).__name__.lower()} {' '.join(show(part, env) for part in parts)})"
        case Exists(parameters, body) | Forall(parameters, body):
            variables = " ".join(p.variable.name for p in parameters)
            return f"({type(formula).__name__.lower()} ({variables}) {show(body, env)})"
