"""A second opinion: sample every stream a few times, then search breadth first by the validator's semantics.

Slow and without cleverness on purpose. It says which small problems can be solved, without any code of the planner.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np

from tamp.language import And, Constant, Parameter, Variable
from tests.planning.semantics import Relation, State, relation_of
from tests.planning.validator import add_types, ask_again, known_objects, successor

Plan = tuple[tuple[str, tuple[Any, ...]], ...]


def sample(problem: Any, rounds: int, calls: int) -> tuple[Relation, bool]:
    """Facts after calling every stream `calls` times for all its inputs in each round, and whether all have ended.

    Streams with fluents are not supported.
    """
    domain, streams = problem.parsed_domain, problem.parsed_streams
    relation = relation_of(problem.initial_state.facts)
    running: dict[Any, Iterator[Any]] = {}
    done: set[Any] = set()
    before = -1
    for _ in range(rounds):
        add_types(domain, relation)
        state = State(domain, known_objects(domain, relation, And(()), []), {k: set(v) for k, v in relation.items()})
        for source in (*streams.rules, *streams.streams):
            for found in list(state.solutions(list(source.domain), [Parameter(v) for v in source.inputs], {})):
                key = (id(source), tuple(found[v] for v in source.inputs))
                if key not in running:
                    running[key] = call(problem, source, key[1], seed=len(running))
                for _ in range(calls):
                    outputs = next(running[key], "ended")
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
    """The outputs of a stream or rule, as tuples of objects; None where its sampler has nothing yet."""
    if not hasattr(source, "name"):
        yield ()
        return
    assert not source.fluents
    context = SimpleNamespace(scene=problem.scene, rng=np.random.default_rng(seed), fluents=(), bound=())
    result = problem.samplers[source.name](context, *(arg.value for arg in args))
    if source.is_test:
        if result:
            yield ()
        return
    for output in result:
        values = (output,) if len(source.outputs) == 1 else output
        yield None if output is None else tuple(map(problem.parsed_domain.constant, values))


def search(problem: Any, rounds: int = 4, calls: int = 2, limit: int = 3000) -> tuple[Plan | None, bool]:
    """A shortest plan over the sampled facts, or None; and whether that is final: streams and states exhausted."""
    domain, goal = problem.parsed_domain, problem.goal_formula
    relation, exhausted = sample(problem, rounds, calls)
    add_types(domain, relation)
    ask_again(domain, relation, {}, problem.parsed_streams, problem.samplers)
    objects = known_objects(domain, relation, goal, [])
    names = sorted(domain.fluents)
    seen: set[Any] = set()
    queue: deque[tuple[Relation, Plan]] = deque([(relation, ())])
    while queue and len(seen) < limit:
        relation, plan = queue.popleft()
        state = State(domain, objects, relation).derive()
        if state.holds(goal, {}):
            return plan, True
        for action in domain.actions.values():
            for found in list(state.solutions([action.precondition], list(action.parameters), {})):
                after = successor(state, relation, action.effects, found)
                key = frozenset((name, args) for name in names for args in after.get(name, ()))
                if key not in seen:
                    seen.add(key)
                    step = (action.name, tuple(found[p.variable].value for p in action.parameters))
                    queue.append((after, (*plan, step)))
    return None, exhausted and not queue
