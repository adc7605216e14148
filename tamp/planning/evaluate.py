"""What holds in a state: conditions evaluated on real values, with tests asked only when the answer depends on them."""

from __future__ import annotations

from collections.abc import Iterator

from tamp.planning.fact_index import FactIndex
from tamp.planning.instances import ground
from tamp.planning.knowledge import Knowledge
from tamp.planning.lookups import Lookup, Lookups, differ, order
from tamp.planning.normal_schemas import AxiomSchema, Condition
from tamp.planning.objects import Fact, Pattern
from tamp.planning.sampling import Sampling
from tamp.planning.state import State, Support, Violation
from tamp.planning.truth import Truth


class Evaluator:
    """Evaluates literals over states; calls tests through `sampling` where nothing is known yet."""

    def __init__(self, knowledge: Knowledge, sampling: Sampling) -> None:
        self._knowledge = knowledge
        self._schema = knowledge.schema
        self._axioms: dict[str, list[AxiomSchema]] = {}
        for axiom in self._schema.axioms:
            self._axioms.setdefault(str(axiom.head[0]), []).append(axiom)
        self._orders: dict[tuple[int, frozenset[str]], Lookups] = {}
        self.truth = Truth(knowledge, sampling, self.given)

    def given(self, fact: Fact) -> bool:
        """Whether a domain fact holds: certified, derived without fluents, or a fluent that held at the start."""
        if fact[0] in self._schema.derived:
            return fact in self._knowledge.real or self.support(fact, State(self._knowledge.state)) is not None
        return fact in self._knowledge.state or self.truth(fact)

    def support(self, fact: Fact, state: State) -> Support | None:
        """Facts that make a ground atom true in a state, or None where it is false."""
        if fact[0] in self._axioms:
            return next(self._atom(Lookup.of(fact, ()), {}, state), (None, None))[1]
        holds = fact in state if fact[0] in self._schema.fluents else self.truth(fact)
        return (fact,) if holds else None

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
        for _, support in self._atom(Lookup.of(fact, ()), {}, state):
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

    def _atom(self, lookup: Lookup, binding: dict[str, int], state: State) -> Iterator[tuple[dict[str, int], Support]]:
        """Every binding that makes an atom true, with its support."""
        name = str(lookup.pattern[0])
        if name in self._axioms:
            yield from self._derived(lookup, binding, state)
        if name in self._schema.fluents:
            yield from self._matches(state.index, lookup, binding)
        elif name == "object" and lookup.open:
            for handle in self._knowledge.objects.real():
                yield {**binding, lookup.open[0][1]: handle}, ()
        elif lookup.open:
            yield from self._matches(self._knowledge.real, lookup, binding)
        elif self.truth(fact := ground(lookup.pattern, binding)):
            yield binding, (fact,)

    def _matches(
        self, index: FactIndex, lookup: Lookup, binding: dict[str, int]
    ) -> Iterator[tuple[dict[str, int], Support]]:
        for fact in list(index.lookup(str(lookup.pattern[0]), lookup.known, lookup.key(binding))):
            extended = dict(binding)
            if all(extended.setdefault(variable, fact[i]) == fact[i] for i, variable in lookup.open):
                yield extended, (fact,)

    def _derived(
        self, lookup: Lookup, binding: dict[str, int], state: State
    ) -> Iterator[tuple[dict[str, int], Support]]:
        name = str(lookup.pattern[0])
        if name in self._schema.recursive:
            yield from self._matches(self._extension(name, state), lookup, binding)
            return
        for axiom in self._axioms[name]:
            inner = _unified(axiom.head, lookup, binding)
            if inner is None:
                continue
            for found, support in self.satisfy(axiom.condition, inner, state):
                extended = dict(binding)
                head = ground(axiom.head, found)
                if all(extended.setdefault(variable, head[i]) == head[i] for i, variable in lookup.open):
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
        if key not in self._orders:  # what is kept holds the condition, and so its id
            self._orders[key] = order(condition, binding, self._schema)
        lookups = self._orders[key]
        if differ(lookups.unequal, binding):
            yield from self._satisfy(0, lookups, binding, state, ())

    def _satisfy(
        self, depth: int, lookups: Lookups, binding: dict[str, int], state: State, support: Support
    ) -> Iterator[tuple[dict[str, int], Support]]:
        if depth == len(lookups.positive):
            absent = self._absent(lookups.negative, binding, state)
            if absent is not None:
                yield binding, support + absent
            return
        lookup = lookups.positive[depth]
        if not lookup.open and lookup.pattern[0] not in self._axioms:
            found = self.support(ground(lookup.pattern, binding), state)
            if found is not None:
                yield from self._satisfy(depth + 1, lookups, binding, state, support + found)
            return
        for extended, facts in self._atom(lookup, binding, state):
            if differ(lookup.unequal, extended):
                yield from self._satisfy(depth + 1, lookups, extended, state, support + facts)

    def _absent(self, negative: tuple[Pattern, ...], binding: dict[str, int], state: State) -> Support | None:
        """The facts of negative literals where none of them holds; tests of placeholders are taken to hold."""
        absent: list[Fact] = []
        for pattern in negative:
            fact = ground(pattern, binding)
            if fact in self._knowledge.real:
                return None
            if fact[0] in self._schema.tests and not all(map(self._knowledge.objects.is_real, fact[1:])):
                return None  # not bound yet: assumed in the plan's favour
            if self.support(fact, state) is not None:
                return None
            absent.append(fact)
        return tuple(absent)


def _unified(head: Pattern, lookup: Lookup, binding: dict[str, int]) -> dict[str, int] | None:
    """What an axiom's variables are where its head is the atom looked up; None where the two cannot be the same."""
    inner: dict[str, int] = {}
    for position, handle in zip(lookup.known, lookup.key(binding), strict=True):
        term = head[position]
        if (inner.setdefault(term, handle) if isinstance(term, str) else term) != handle:
            return None
    return inner
