"""A second opinion: sample every stream a few times, then search breadth first by the validator's semantics.

Slow and without cleverness on purpose. It says which small problems can be solved, without any code of the planner.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np

from tamp.language import And, Constant, FunctionTerm, Parameter, Variable
from tests.planning.oracles.semantics import Relation, State, relation_of
from tests.planning.oracles.validator import add_types, ask_again, guard, known_objects, successor, told

Plan = tuple[tuple[str, tuple[Any, ...]], ...]


def sample(problem: Any, rounds: int, calls: int, brought: Relation | None = None) -> tuple[Relation, bool]:
    """Facts after calling every stream `calls` times for all its inputs in each round, and whether all have ended.

    Of streams with fluents only tests are supported, which are asked in each state. `brought` are what actions may
    bring: they count for the domains of streams, whose outputs are then certified where they hold.
    """
    domain, streams, _ = guard(problem.parsed_domain, problem.parsed_streams)
    relation = relation_of(problem.initial_state.facts)
    running: dict[Any, Iterator[Any]] = {}
    done: set[Any] = set()
    before = -1
    for _ in range(rounds):
        add_types(domain, relation)
        seen = {k: set(v) for k, v in relation.items()}
        for name, args in (brought or {}).items():
            seen[name] = seen.get(name, set()) | args
        state = State(domain, known_objects(domain, relation, And(()), []), seen)
        for source in (*streams.rules, *(s for s in streams.streams if not (s.is_test and s.fluents))):
            for found in list(state.solutions(list(source.domain), [Parameter(v) for v in source.inputs], {})):
                key = (id(source), tuple(found[v] for v in source.inputs))
                if key not in running:
                    running[key] = call(problem, source, key[1], seed=len(running))
                for _ in range(calls):
                    outputs, facts = next(running[key], ("ended", ()))
                    for name, *args in facts:
                        relation.setdefault(name.lower(), set()).add(tuple(map(domain.constant, args)))
                    if outputs == "ended":
                        done.add(key)
                    elif outputs is not None:
                        env = found | dict(zip(getattr(source, "outputs", ()), outputs, strict=True))
                        for atom in source.certified:
                            args = tuple(env[arg] if isinstance(arg, Variable) else arg for arg in atom.args)
                            relation.setdefault(atom.predicate, set()).add(args)
        size = sum(map(len, relation.values()))
        if size == before and len(done) == len(running):
            return relation, True
        before = size
    return relation, False


def call(problem: Any, source: Any, args: tuple[Constant, ...], seed: int) -> Iterator[Any]:
    """The outputs of a stream or rule, as tuples of objects, None where its sampler has nothing yet; further facts."""
    if not hasattr(source, "name"):
        yield (), ()
        return
    assert not source.fluents
    context = SimpleNamespace(scene=problem.scene, rng=np.random.default_rng(seed), fluents=(), bound=())
    result = problem.samplers[source.name](context, *(arg.value for arg in args))
    if source.is_test:
        if result:
            yield getattr(result, "outputs", ()), getattr(result, "facts", ())
        return
    for output in result:
        outputs, facts = getattr(output, "outputs", output), getattr(output, "facts", ())
        values = (outputs,) if len(source.outputs) == 1 else outputs
        yield None if outputs is None else tuple(map(problem.parsed_domain.constant, values)), facts


def search(problem: Any, rounds: int = 4, calls: int = 2, limit: int = 3000) -> tuple[Plan | None, bool]:
    """A shortest plan over the sampled facts, or None; and whether that is final: streams and states exhausted.

    Where streams wait for what actions bring, both take turns until neither brings anything new.
    """
    brought: Relation = {}
    while True:
        plan, final, reached = _search(problem, *sample(problem, rounds, calls, brought), limit)
        if plan is not None or all(args <= brought.get(name, set()) for name, args in reached.items()):
            return plan, final
        brought = {name: brought.get(name, set()) | args for name, args in reached.items()}


def _search(problem: Any, relation: Relation, exhausted: bool, limit: int) -> tuple[Plan | None, bool, Relation]:
    """A shortest plan; whether the answer is final; and the facts that actions bring in any state that was seen."""
    domain, streams, waits = guard(problem.parsed_domain, problem.parsed_streams)
    goal = problem.goal_formula
    add_types(domain, relation)
    ask_again(domain, relation, {}, streams, problem.samplers)
    objects = known_objects(domain, relation, goal, [])
    names = sorted(domain.fluents)
    reached: Relation = {}
    seen: set[Any] = set()
    queue: deque[tuple[Relation, Plan]] = deque([(relation, ())])
    while queue and len(seen) < limit:
        relation, plan = queue.popleft()
        for name in waits:
            reached.setdefault(name, set()).update(relation.get(name, ()))
        seeing = told(domain, relation, streams, problem.samplers, objects)
        state = State(domain, objects, seeing).derive()
        if state.holds(goal, {}):
            return plan, True, {}
        for action in domain.actions.values():
            for found in list(state.solutions([action.precondition], list(action.parameters), {})):
                if not _has_cost(problem, state, action, found):
                    continue
                after = successor(state, relation, action.effects, found)
                key = frozenset((name, args) for name in names for args in after.get(name, ()))
                if key not in seen:
                    seen.add(key)
                    step = (action.name, tuple(found[p.variable].value for p in action.parameters))
                    queue.append((after, (*plan, step)))
    return None, exhausted and not queue, reached


def wander(problem: Any, steps: int, seed: int) -> tuple[Any, ...]:
    """A goal that can be reached: what differs after some random actions that each change something."""
    rng = np.random.default_rng(seed)
    given = problem.parsed_domain
    domain, streams, waits = guard(given, problem.parsed_streams)
    brought: Relation = {}
    relation, _ = sample(problem, 5, 3)
    start = {name: set(args) for name, args in relation.items()}
    for _ in range(steps):
        brought = {name: brought.get(name, set()) | relation.get(name, set()) for name in waits}
        more, _ = sample(problem, 5, 3, brought)
        add_types(domain, more)
        relation = {**more, **{name: relation.get(name, set()) for name in domain.fluents}}
        ask_again(domain, relation, {}, streams, problem.samplers)
        objects = known_objects(domain, relation, And(()), [])
        state = State(domain, objects, told(domain, relation, streams, problem.samplers, objects)).derive()
        after = [
            changed
            for action in domain.actions.values()
            for found in list(state.solutions([action.precondition], list(action.parameters), {}))
            if _has_cost(problem, state, action, found)
            and (changed := successor(state, relation, action.effects, found))
            and any(changed.get(name, set()) != relation.get(name, set()) for name in domain.fluents)
        ]
        if not after:
            break
        after.sort(key=lambda each: sorted((name, sorted(map(str, each.get(name, ())))) for name in domain.fluents))
        relation = after[int(rng.integers(len(after)))]
    goal: list[Any] = ["and"]
    for name in sorted(domain.fluents):
        added = sorted(relation.get(name, set()) - start.get(name, set()), key=str)[:2]
        removed = sorted(start.get(name, set()) - relation.get(name, set()), key=str)[:1]
        goal += [(name, *(arg.value for arg in args)) for args in added]
        goal += [("not", (name, *(arg.value for arg in args))) for args in removed]
    return tuple(goal)


def _has_cost(problem: Any, state: State, action: Any, env: Any) -> bool:
    """Whether every function that an action's cost names is defined for these values."""
    functions = {function.name: function for function in problem.parsed_streams.functions}
    for term in action.cost or ():
        if isinstance(term, FunctionTerm) and term.function in functions:
            function = functions[term.function]
            inner = {v: state.value(arg, env) for v, arg in zip(function.inputs, term.args, strict=True)}
            if not all(state.holds(atom, inner) for atom in function.domain):
                return False
    return True
