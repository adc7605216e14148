"""Evaluating conditions: which facts hold in a state, with streams that serve as tests asked only where it matters."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass

from tamp.planning.model.external import External
from tamp.planning.model.fact_store import FactIndex, Knowledge
from tamp.planning.model.normal_form import AxiomSchema, Condition
from tamp.planning.model.objects import Fact, Pattern
from tamp.planning.model.schema import Schema
from tamp.planning.model.state import State, Support, Violation
from tamp.planning.model.stream_instances import Instance, ground
from tamp.planning.sampling.explanations import Explanations
from tamp.planning.sampling.stream_calls import Sampling


class Truth:
    """Whether facts hold that actions do not change: asks the tests that decide them.

    Attributes:
        promised: what is taken to hold for the moment.
    """

    def __init__(self, knowledge: Knowledge, sampling: Sampling, given: Callable[[Fact], bool]) -> None:
        """`given`: whether a domain fact of a test holds."""
        self._knowledge = knowledge
        self._sampling = sampling
        self._schema = knowledge.schema
        self._given = given
        self.promised: Collection[Fact] = ()

    def __call__(self, fact: Fact) -> bool:
        """Whether a fact holds; asks the tests that decide it."""
        if fact in self._knowledge.real or fact in self.promised:
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
        return self._decided(fact, tests)

    def in_state(self, fact: Fact, state: State) -> bool:
        """Whether a fact that tests with fluents decide holds in a state; assumed as long as a value is missing."""
        if fact in self._knowledge.real:
            return True
        is_real = self._knowledge.objects.is_real
        seen = {name for test in self._schema.state_tests[str(fact[0])] for name in test.fluents}
        if not all(is_real(h) for f in (fact, *state) if f is fact or f[0] in seen for h in f[1:]):
            return True
        return any(instance.results for instance in self.answers(fact, state))

    def answers(self, fact: Fact, state: State) -> Iterator[Instance]:
        """The tests with fluents that decide a fact, after their calls for a state."""
        for test in self._schema.state_tests[str(fact[0])]:
            yield from self._asked(fact, test, self._knowledge.told(test, state))

    def _decided(self, fact: Fact, tests: tuple[External, ...]) -> bool:
        reason = ""
        for instance in (instance for test in tests for instance in self._asked(fact, test)):
            if instance.results:
                return True
            reason = next((r for r, _ in instance.reasons), reason)
        if fact[0] in self._schema.tests:  # otherwise another stream may certify it yet
            self._knowledge.refute(fact, reason)
        return False

    def _asked(self, fact: Fact, test: External, fluents: tuple[Fact, ...] = ()) -> Iterator[Instance]:
        """The instances of a test that decide a fact, after their calls; none where it does not apply."""
        for pattern in (p for p in test.certified if p[0] == fact[0]):
            terms = dict(zip(pattern[1:], fact[1:], strict=True))
            if any(isinstance(t, int) and t != h for t, h in terms.items()) or not all(v in terms for v in test.inputs):
                continue
            instance = self._knowledge.instance(test, tuple(terms[v] for v in test.inputs), fluents)
            if not instance.calls:
                if not all(self._given(f) for f in instance.domain):
                    continue
                self._sampling.draw(instance)
                if not test.is_state_test:
                    self._knowledge.announce(instance)
                    self._knowledge.version += not instance.results
            yield instance


Pairs = tuple[tuple[str | int, str | int], ...]


@dataclass(frozen=True)
class Lookup:
    """One literal's turn.

    Attributes:
        pattern: the literal.
        known: positions of its terms that are bound by then.
        open: positions and variables of the others.
        unequal: the inequalities that can be decided after it.
    """

    pattern: Pattern
    known: tuple[int, ...]
    open: tuple[tuple[int, str], ...]
    unequal: Pairs = ()

    @classmethod
    def of(cls, pattern: Pattern, bound: Collection[str], unequal: Pairs = ()) -> Lookup:
        """The turn of a literal by which the variables `bound` have values."""
        terms = list(enumerate(pattern))[1:]
        free = tuple((i, t) for i, t in terms if isinstance(t, str) and t not in bound)
        return cls(pattern, tuple(i for i, t in terms if isinstance(t, int) or t in bound), free, unequal)

    def key(self, binding: dict[str, int]) -> tuple[int, ...]:
        """The handles at the known positions."""
        return tuple([binding[t] if isinstance(t := self.pattern[i], str) else t for i in self.known])


@dataclass(frozen=True)
class Lookups:
    """A condition in the order of evaluation.

    Attributes:
        condition: the condition.
        unequal: its inequalities that can be decided at once.
        positive: the turns of its positive literals.
        negative: its negative literals, tests last.
    """

    condition: Condition
    unequal: Pairs
    positive: tuple[Lookup, ...]
    negative: tuple[Pattern, ...]


def order(condition: Condition, bound: Collection[str], schema: Schema) -> Lookups:
    """A condition's lookups where the variables `bound` have values: cheap and selective ones first."""
    rest, pairs, known = list(condition.positive), list(condition.unequal), set(bound)

    def ready() -> Pairs:
        found = tuple(pair for pair in pairs if all(isinstance(t, int) or t in known for t in pair))
        pairs[:] = [pair for pair in pairs if pair not in found]
        return found

    first = ready()
    turns: list[Lookup] = []
    while rest:
        pattern = min(rest, key=lambda p: _rank(p, known, schema))
        rest = [p for p in rest if p is not pattern]
        before = frozenset(known)
        known |= {t for t in pattern[1:] if isinstance(t, str)}
        turns.append(Lookup.of(pattern, before, ready()))
    negative = sorted(condition.negative, key=lambda p: p[0] in schema.tests)
    return Lookups(condition, first, tuple(turns), tuple(negative))


def _rank(pattern: Pattern, bound: Collection[str], schema: Schema) -> tuple[int, int]:
    """Cheap and selective literals first, tests last."""
    unbound = sum(isinstance(t, str) and t not in bound for t in pattern[1:])
    if pattern[0] in schema.tests or pattern[0] in schema.state_tests:
        return (9 if not unbound else 10), unbound
    if not unbound and pattern[0] not in schema.derived:
        return 0, 0
    kind = 1 if pattern[0] in schema.fluents else 2 if pattern[0] not in schema.derived else 3
    return 1 + (pattern[0] == "object") * 7, unbound * 10 + kind


def differ(pairs: Pairs, binding: dict[str, int]) -> bool:
    """Whether the two sides of each inequality have different values."""
    return all((binding[a] if isinstance(a, str) else a) != (binding[b] if isinstance(b, str) else b) for a, b in pairs)


class Evaluator:
    """Evaluates literals over states; calls tests through `sampling` where nothing is known yet.

    Attributes:
        truth: of facts that actions do not change.
        explanations: of what tests told the state say no to.
    """

    def __init__(self, knowledge: Knowledge, sampling: Sampling) -> None:
        self._knowledge = knowledge
        self._schema = knowledge.schema
        self._axioms: dict[str, list[AxiomSchema]] = {}
        for axiom in self._schema.axioms:
            self._axioms.setdefault(str(axiom.head[0]), []).append(axiom)
        self._orders: dict[tuple[int, frozenset[str]], Lookups] = {}
        self._domains: dict[str, Condition] = {}
        self._assumed: dict[Fact, None] = {}
        self.truth = Truth(knowledge, sampling, self.given)
        self.explanations = Explanations(knowledge, sampling)

    def given(self, fact: Fact) -> bool:
        """Whether a domain fact holds: certified, derived without fluents, or what the state at the start decides."""
        if fact[0] in self._schema.derived | self._schema.state_tests.keys():
            return fact in self._knowledge.real or self.support(fact, State(self._knowledge.state)) is not None
        return fact in self._knowledge.state or self.truth(fact)

    def assumed(self, fact: Fact, positive: bool, state: State, promised: Collection[Fact]) -> tuple[Fact, ...]:
        """The facts that tests of placeholders have yet to certify for a ground literal to hold in a state.

        `promised`: what streams will have certified of placeholders by then.
        """
        if positive and fact[0] not in self._axioms:
            return (fact,)
        self._assumed.clear()
        self.truth.promised = promised
        try:
            self.violation(fact, positive, state)
        finally:
            self.truth.promised = ()
        return tuple(self._assumed)

    def support(self, fact: Fact, state: State) -> Support | None:
        """Facts that make a ground atom true in a state, or None where it is false."""
        if fact[0] in self._axioms:
            return next(self._atom(Lookup.of(fact, ()), {}, state), (None, None))[1]
        return (fact,) if self._holds(fact, state) else None

    def _holds(self, fact: Fact, state: State) -> bool:
        """Whether a ground atom that is not derived holds."""
        if fact[0] in self._schema.state_tests:
            return self.truth.in_state(fact, state)
        return fact in state if fact[0] in self._schema.fluents else self.truth(fact)

    def violation(self, fact: Fact, positive: bool, state: State) -> Violation | None:
        """Why a ground literal does not hold in a state, or None where it does.

        All causes are looked for: a plan that fails teaches the search most when it learns them at once.
        """
        if positive:
            if self.support(fact, state) is not None:
                return None
            if fact[0] in self._schema.state_tests:
                return self._untold(fact, state)
            exact = fact[0] in self._schema.tests
            return Violation((fact,), f"{self._knowledge.objects.text(fact)} does not hold", exact)
        causes: dict[Fact, None] = {}
        for _, support in self._atom(Lookup.of(fact, ()), {}, state):
            causes.update(dict.fromkeys(support))
        if not causes and self.support(fact, state) is None:
            return None
        return self.violated((fact, *causes), self._reason(fact, tuple(causes)))

    def violated(self, facts: Support, reason: str) -> Violation:
        """The violation for which facts are to blame that hold, or what decided the effects that made them true."""
        return Violation(facts, reason, exact=not any(f[0] in self._schema.conditional for f in facts))

    def _untold(self, fact: Fact, state: State) -> Violation:
        """Why tests with fluents say no in a state: because of what their samplers name, or all that they were told."""
        causes: dict[Fact, None] = {}
        reason = ""
        for instance in self.truth.answers(fact, state):
            reason, named = instance.main_reason
            causes.update(dict.fromkeys(named or instance.fluents))
        text = f"{self._knowledge.objects.text(fact)} does not hold in this state"
        return Violation((fact, *causes), f"{text}: {reason}" if reason else text)

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
            yield from self._told(lookup, binding, state)
        elif self._holds(fact := ground(lookup.pattern, binding), state):
            yield binding, (fact,)

    def _told(self, lookup: Lookup, binding: dict[str, int], state: State) -> Iterator[tuple[dict[str, int], Support]]:
        """The bindings for which tests with fluents say yes in a state: nothing that they certify can be looked up."""
        for test in self._schema.state_tests.get(str(lookup.pattern[0]), ()):
            domain = self._domains.setdefault(test.name, Condition(test.domain))
            for certified in (p for p in test.certified if p[0] == lookup.pattern[0]):
                inner = _unified(certified, lookup, binding)
                for found, _ in () if inner is None else self.satisfy(domain, inner, state):
                    fact, extended = ground(certified, found), dict(binding)
                    fits = all(extended.setdefault(variable, fact[i]) == fact[i] for i, variable in lookup.open)
                    if fits and fact not in self._knowledge.real and self._holds(fact, state):
                        yield extended, (fact,)

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
                self._assumed[fact] = None
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
