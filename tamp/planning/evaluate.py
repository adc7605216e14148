"""What holds in a state: conditions evaluated on real values, with tests asked only when the answer depends on them."""

from __future__ import annotations

from collections.abc import Iterator

from tamp.planning.fact_index import FactIndex
from tamp.planning.instances import Instance, ground
from tamp.planning.join import Pattern
from tamp.planning.knowledge import Knowledge
from tamp.planning.normal_schemas import AxiomSchema, Condition
from tamp.planning.objects import Fact
from tamp.planning.sampling import Sampling
from tamp.planning.schema import External
from tamp.planning.state import State, Support, Violation

Pairs = tuple[tuple[str | int, str | int], ...]


Order = tuple[tuple[Pattern, Pairs], ...]
"""The patterns of a condition in the order of evaluation, after an empty first one."""


class Evaluator:
    """Evaluates literals over states; calls tests through `sampling` where nothing is known yet."""

    def __init__(self, knowledge: Knowledge, sampling: Sampling) -> None:
        self._knowledge = knowledge
        self._sampling = sampling
        self._schema = knowledge.schema
        self._axioms: dict[str, list[AxiomSchema]] = {}
        for axiom in self._schema.axioms:
            self._axioms.setdefault(str(axiom.head[0]), []).append(axiom)
        self._orders: dict[tuple[int, frozenset[str]], tuple[Condition, Order]] = {}

    def truth(self, fact: Fact) -> bool:
        """Whether a fact without fluents holds; asks the tests that decide it."""
        if fact in self._knowledge.real:
            return True
        if fact in self._knowledge.refuted:
            return False
        if fact[0] == "object":
            return True
        if fact[0] == "=":
            return bool(fact[1] == fact[2])
        tests = self._schema.askable.get(fact[0])
        if tests is None or not all(self._knowledge.objects.is_real(h) for h in fact[1:]):
            return False
        reason = ""
        for test in tests:
            for pattern in test.certified:
                if pattern[0] == fact[0]:
                    instance = self._ask(test, dict(zip(pattern[1:], fact[1:], strict=True)))
                    if instance is not None and instance.results:
                        return True
                    reason = next((r for r, _ in instance.reasons), reason) if instance is not None else reason
        if fact[0] in self._schema.tests:  # otherwise another stream may certify it yet
            self._knowledge.refute(fact, reason)
        return False

    def _ask(self, test: External, terms: dict[str | int, int]) -> Instance | None:
        """The instance of a test that decides a fact, after its call; None where it does not apply."""
        if any(isinstance(t, int) and t != h for t, h in terms.items()) or not all(v in terms for v in test.inputs):
            return None
        instance = self._knowledge.instance(test, tuple(terms[v] for v in test.inputs))
        if not instance.calls:
            if not all(self.given(f) for f in instance.domain):
                return None
            self._sampling.draw(instance)
            self._knowledge.announce(instance)
            self._knowledge.version += not instance.results
        return instance

    def given(self, fact: Fact) -> bool:
        """Whether a domain fact holds: certified, derived without fluents, or a fluent that held at the start."""
        if fact[0] in self._schema.derived:
            return fact in self._knowledge.real or self.support(fact, State(self._knowledge.state)) is not None
        return fact in self._knowledge.state or self.truth(fact)

    def support(self, fact: Fact, state: State) -> Support | None:
        """Facts that make a ground atom true in a state, or None where it is false."""
        return next(self._atom(fact, {}, state), (None, None))[1]

    def violation(self, fact: Fact, positive: bool, state: State) -> Violation | None:
        """Why a ground literal does not hold in a state, or None where it does.

        All causes are looked for: a plan that fails teaches the search most when it learns them at once.
        """
        if positive:
            if self.support(fact, state) is not None:
                return None
            exact = fact[0] in self._schema.tests
            return Violation((fact,), f"{self._knowledge.objects.text(fact)} does not hold", exact)
        causes: dict[Fact, None] = {}
        for _, support in self._atom(fact, {}, state):
            causes.update(dict.fromkeys(support))
        if not causes and self.support(fact, state) is None:
            return None
        return Violation((fact, *causes), self._reason(fact, tuple(causes)))

    def _reason(self, fact: Fact, causes: Support) -> str:
        text = self._knowledge.objects.text
        reasons = dict.fromkeys(r for c in causes if (r := self._knowledge.refuted.get(c)))
        if reasons:
            return f"{text(fact)}: {', '.join(list(reasons)[:3])}"
        named = [c for c in causes if c[0] not in self._schema.tests] or list(causes)
        return f"{text(fact)} because of {', '.join(map(text, named[:3]))}"

    def _atom(
        self, pattern: Pattern, binding: dict[str, int], state: State
    ) -> Iterator[tuple[dict[str, int], Support]]:
        """Every binding that makes an atom true, with its support."""
        name = str(pattern[0])
        terms = [binding.get(t, t) if isinstance(t, str) else t for t in pattern[1:]]
        bound = all(isinstance(t, int) for t in terms)
        if name in self._axioms:
            yield from self._derived(name, terms, binding, state)
        if name in self._schema.fluents:
            yield from self._matches(state.index, name, terms, binding)
        elif name == "object" and not bound:
            for handle in self._knowledge.objects.real():
                yield {**binding, str(terms[0]): handle}, ()
        elif bound:
            fact: Fact = (name, *terms)
            if self.truth(fact):
                yield binding, (fact,)
        else:
            yield from self._matches(self._knowledge.real, name, terms, binding)

    def _matches(
        self, index: FactIndex, name: str, terms: list[int | str], binding: dict[str, int]
    ) -> Iterator[tuple[dict[str, int], Support]]:
        positions = tuple(i for i, t in enumerate(terms, start=1) if isinstance(t, int))
        for fact in list(index.lookup(name, positions, tuple(t for t in terms if isinstance(t, int)))):
            extended = dict(binding)
            if all(extended.setdefault(t, h) == h for t, h in zip(terms, fact[1:], strict=True) if isinstance(t, str)):
                yield extended, (fact,)

    def _derived(
        self, name: str, terms: list[int | str], binding: dict[str, int], state: State
    ) -> Iterator[tuple[dict[str, int], Support]]:
        if name in self._schema.recursive:
            yield from self._matches(self._extension(name, state), name, terms, binding)
            return
        for axiom in self._axioms[name]:
            inner: dict[str, int] = {}
            fits = True
            for parameter, term in zip(axiom.head[1:], terms, strict=True):
                if isinstance(term, int):
                    fits &= (
                        parameter == term if isinstance(parameter, int) else inner.setdefault(parameter, term) == term
                    )
            if not fits:
                continue
            for found, support in self.satisfy(axiom.condition, inner, state):
                extended = dict(binding)
                head = ground(axiom.head, found)
                if all(
                    extended.setdefault(t, h) == h for t, h in zip(terms, head[1:], strict=True) if isinstance(t, str)
                ):
                    yield extended, support

    def _extension(self, name: str, state: State) -> FactIndex:
        """All facts of a recursive predicate, with those it depends on mutually, by iterating to the fixpoint."""
        if name not in state.extensions:
            together = self._mutual(name)
            table = FactIndex()
            for member in together:
                state.extensions[member] = table
            changed = True
            while changed:
                changed = False
                for member in together:
                    for axiom in self._axioms[member]:
                        heads = [ground(axiom.head, b) for b, _ in self.satisfy(axiom.condition, {}, state)]
                        changed |= sum(table.add(head) for head in heads) > 0
        return state.extensions[name]

    def _mutual(self, name: str) -> list[str]:
        """The predicates that a recursive one depends on and that depend on it, itself included."""
        below = self._schema.below
        return sorted(n for n in self._schema.recursive if n == name or (n in below(name) and name in below(n)))

    def satisfy(
        self, condition: Condition, binding: dict[str, int], state: State
    ) -> Iterator[tuple[dict[str, int], Support]]:
        """Every binding of a condition's variables that makes it true, with the facts that it rests on."""
        key = (id(condition), frozenset(binding))
        if key not in self._orders:
            self._orders[key] = (condition, self._order(condition, set(binding)))  # keeps the condition, and so its id
        order = self._orders[key][1]
        if _differ(order[0][1], binding):
            yield from self._satisfy(1, order, condition, binding, state, ())

    def _satisfy(
        self, depth: int, order: Order, condition: Condition, binding: dict[str, int], state: State, support: Support
    ) -> Iterator[tuple[dict[str, int], Support]]:
        if depth == len(order):
            yield from self._negatives(condition, binding, state, support)
            return
        pattern, pairs = order[depth]
        for extended, facts in self._atom(pattern, binding, state):
            if _differ(pairs, extended):
                yield from self._satisfy(depth + 1, order, condition, extended, state, support + facts)

    def _order(self, condition: Condition, bound: set[str]) -> Order:
        """In which order to look literals up, each with the inequalities that can be decided after it."""
        rest, pairs = list(condition.positive), list(condition.unequal)
        order: list[tuple[Pattern, Pairs]] = []
        pattern: Pattern = ()
        while True:
            ready = tuple(pair for pair in pairs if all(isinstance(t, int) or t in bound for t in pair))
            pairs = [pair for pair in pairs if pair not in ready]
            order.append((pattern, ready))
            if not rest:
                return tuple(order)
            pattern = min(rest, key=lambda p: self._rank(p, bound))
            rest = [p for p in rest if p is not pattern]
            bound |= {t for t in pattern[1:] if isinstance(t, str)}

    def _negatives(
        self, condition: Condition, binding: dict[str, int], state: State, support: Support
    ) -> Iterator[tuple[dict[str, int], Support]]:
        absent: list[Fact] = []
        for pattern in sorted(condition.negative, key=lambda p: p[0] in self._schema.tests):
            fact = ground(pattern, binding)
            if fact[0] in self._schema.tests and not all(map(self._knowledge.objects.is_real, fact[1:])):
                return  # not bound yet: assumed in the plan's favour
            if self.support(fact, state) is not None:
                return
            absent.append(fact)
        yield binding, (*support, *absent)

    def _rank(self, pattern: Pattern, binding: set[str]) -> tuple[int, int]:
        """Cheap and selective literals first, tests last."""
        unbound = sum(isinstance(t, str) and t not in binding for t in pattern[1:])
        if pattern[0] in self._schema.tests:
            return (9 if not unbound else 10), unbound
        if not unbound and pattern[0] not in self._schema.derived:
            return 0, 0
        kind = 1 if pattern[0] in self._schema.fluents else 2 if pattern[0] not in self._schema.derived else 3
        return 1 + (pattern[0] == "object") * 7, unbound * 10 + kind


def _differ(pairs: Pairs, binding: dict[str, int]) -> bool:
    return all((binding[a] if isinstance(a, str) else a) != (binding[b] if isinstance(b, str) else b) for a, b in pairs)
