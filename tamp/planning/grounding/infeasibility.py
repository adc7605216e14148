"""Relaxed reachability over all that streams might give: what can never come about, and the proof of it."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Container, Iterable, Iterator
from dataclasses import dataclass

from tamp.planning.grounding.relaxed_rules import Rule, call_rules, relaxed_rules
from tamp.planning.model.external import External
from tamp.planning.model.fact_store import Knowledge
from tamp.planning.model.objects import Fact, Pattern
from tamp.planning.model.schema import Schema
from tamp.planning.model.stream_instances import ground
from tamp.planning.options import Ended
from tamp.planning.sampling.stream_calls import Sampling
from tamp.planning.sampling.surprises import Surprises

ANY = -1
"""Some object, known or not."""

NEW = -2
"""Some object that is not known yet."""

CALLED = "a call"
"""What follows from the domains of streams, where it is asked whether they may be called."""

EVERY = 1_000
"""Facts looked at between two ticks."""

EFFORT, EFFORT_A_DRAW = 5_000, 50
"""Facts looked at before the question is left open: in any case, and for each time that a stream was called."""


@dataclass(frozen=True)
class _Promise:
    """A fact that may come to hold; where a stream may bring it, by the rule of that number and for those inputs."""

    fact: Fact
    rule: int = -1
    inputs: tuple[int, ...] = ()


class _Exhausted(Exception):  # noqa: N818  control flow inside this module
    """The effort is spent."""


def out_of_reach(
    schema: Schema,
    knowledge: Knowledge,
    effort: int = 100_000,
    tick: Callable[[], None] = lambda: None,
    proven: bool = True,
) -> Fact | None:
    """A part of the goal that no stream can bring within reach any more; None where all of it may be.

    The question is left open as well once `effort` facts were looked at; `tick` is called now and then, and may end it
    by an exception. Unless it shall be `proven`, streams that gave up count as those do that have nothing more.
    """
    goal = [p for p in schema.goal.positive if p[0] not in ("=", "object")]
    try:
        return next(iter(_Relaxation(relaxed_rules(schema), knowledge, goal, effort, tick, proven).lost()), None)
    except _Exhausted:
        return None


def may_be_called(
    schema: Schema, knowledge: Knowledge, streams: Container[str], effort: int, tick: Callable[[], None], proven: bool
) -> bool:
    """Whether some of these streams may yet be called: there may be inputs for which it has not ended.

    The arguments are those of `out_of_reach`. Where the effort is spent, it may.
    """
    called: Pattern = (CALLED,)
    rules = (*relaxed_rules(schema), *call_rules(schema, called, streams))
    try:
        return not _Relaxation(rules, knowledge, [called], effort, tick, proven).lost()
    except _Exhausted:
        return True


def never_given(schema: Schema, knowledge: Knowledge, lost: Fact) -> tuple[str, ...]:
    """Predicates without facts, and without anything that makes some, that a part of the goal would need; sorted.

    None where there may be facts like that part, about something else.
    """
    rules = list(_relevant(list(relaxed_rules(schema)), {str(lost[0])}))
    seen = _predicates(rules, knowledge)
    if lost[0] in seen:
        return ()
    needed = {str(pattern[0]) for rule in rules if rule.head[0] not in seen for pattern in rule.body}
    return tuple(sorted((needed or {str(lost[0])}) - seen - {str(rule.head[0]) for rule in rules}))


def never_undone(schema: Schema, knowledge: Knowledge) -> Fact | None:
    """What the goal wants false though it holds and no action makes it false; None where there is no such fact."""
    undone = {str(e.atom[0]) for action in schema.actions for e in action.effects if not e.positive}
    conditional = {str(p[0]) for e in schema.externals.values() if e.awaited for p in e.certified}
    standing = (p for p in schema.goal.negative if p[0] not in undone | conditional | schema.derived)
    return next((ground(p, {}) for p in standing if p in knowledge.real or p in knowledge.state), None)


def _fits(pattern: Pattern, promise: _Promise) -> bool:
    return all(b in (a, ANY) for a, b in zip(pattern[1:], promise.fact[1:], strict=True))


class _Relaxation:
    """The relaxed problem's facts, as far as the goal may depend on them (Datalog, evaluated fact by fact).

    What speaks of unknown objects has its turn first, the latest before the others: most goals are within reach by
    that, and there is no need to go on once all of the goal is.
    """

    def __init__(
        self,
        rules: Iterable[Rule],
        knowledge: Knowledge,
        goal: list[Pattern],
        effort: int,
        tick: Callable[[], None],
        proven: bool,
    ) -> None:
        self._knowledge = knowledge
        self._proven = proven
        self._goal = dict.fromkeys(goal)
        self._rules = list(_relevant(list(rules), {str(p[0]) for p in goal}))
        self._reached: dict[str, dict[_Promise, None]] = {}
        self._having: dict[tuple[str, int, int], list[_Promise]] = {}
        self._known: deque[_Promise] = deque()
        self._unknown: list[_Promise] = []
        self._left = effort
        self._tick = tick

    def lost(self) -> tuple[Pattern, ...]:
        """What is out of reach of the goal: what there can be no such fact of, or else these facts alone."""
        seen = _predicates(self._rules, self._knowledge)
        if never := tuple(pattern for pattern in self._goal if pattern[0] not in seen):
            return never
        objects = [*self._knowledge.objects.real(), ANY, NEW]
        for fact in (*self._knowledge.real, *self._knowledge.state, *(("object", handle) for handle in objects)):
            self._add(_Promise(fact))
        for number, rule in enumerate(self._rules):
            if not rule.body:
                self._conclude(number, {})
        while self._goal and (self._unknown or self._known):
            self._follow(self._unknown.pop() if self._unknown else self._known.popleft())
        return tuple(self._goal)

    def _follow(self, promise: _Promise) -> None:
        """Conclude what a fact brings with those that were reached before."""
        for number, rule in enumerate(self._rules):
            for i, pattern in enumerate(rule.body):
                if pattern[0] == promise.fact[0] and (binding := _bind(pattern, promise.fact, {})) is not None:
                    for found, used in self._matches(rule.body[:i] + rule.body[i + 1 :], binding):
                        if self._possible([(pattern, promise), *used], found):
                            self._conclude(number, found)
                        if not self._goal:
                            return

    def _add(self, promise: _Promise) -> None:
        known = self._reached.setdefault(str(promise.fact[0]), {})
        if promise not in known:
            known[promise] = None
            (self._unknown if min(promise.fact[1:], default=0) < 0 else self._known).append(promise)
            for position, handle in enumerate(promise.fact[1:], start=1):
                self._having.setdefault((str(promise.fact[0]), position, handle), []).append(promise)
            for pattern in [p for p in self._goal if p[0] == promise.fact[0] and _fits(p, promise)]:
                del self._goal[pattern]

    def _matches(
        self, body: tuple[Pattern, ...], binding: dict[str, int]
    ) -> Iterator[tuple[dict[str, int], list[tuple[Pattern, _Promise]]]]:
        """Every way to satisfy a body with what was reached so far, and the facts that do."""
        if not body:
            yield binding, []
            return
        candidates = [self._candidates(pattern, binding) for pattern in body]
        first = min(range(len(body)), key=lambda i: len(candidates[i]))
        for promise in candidates[first]:
            self._left -= 1
            if self._left < 0:
                raise _Exhausted
            if self._left % EVERY == 0:
                self._tick()
            found = _bind(body[first], promise.fact, binding)
            if found is not None:
                for complete, used in self._matches(body[:first] + body[first + 1 :], found):
                    yield complete, [(body[first], promise), *used]

    def _candidates(self, pattern: Pattern, binding: dict[str, int]) -> list[_Promise]:
        """What was reached so far that may match: the fewest that share an object, or leave it open."""
        name = str(pattern[0])
        found = list(self._reached.get(name, ()))
        for position, term in enumerate(pattern[1:], start=1):
            handle = binding.get(term, ANY) if isinstance(term, str) else term
            if handle != ANY:
                same = self._having.get((name, position, handle), [])
                unknown = self._having.get((name, position, ANY), [])
                if len(same) + len(unknown) < len(found):
                    found = same + unknown
        return found

    def _possible(self, used: list[tuple[Pattern, _Promise]], binding: dict[str, int]) -> bool:
        """Whether the facts may hold together: none is what a call would have had to give that gives nothing more."""
        for pattern, promise in used:
            rule = self._rules[promise.rule]
            if promise.rule >= 0 and rule.external is not None:
                values = [binding[t] if isinstance(t, str) else t for t in pattern[1:]]
                given = dict(zip(rule.head[1:], values, strict=True))
                inputs = [given.get(v, old) for v, old in zip(rule.external.inputs, promise.inputs, strict=True)]
                if self._ended(rule.external, tuple(inputs)):
                    return False
        return True

    def _ended(self, external: External, inputs: tuple[int, ...]) -> bool:
        if ANY in inputs or NEW in inputs or external.fluents:
            return False
        instance = self._knowledge.find(external, inputs)
        return instance is not None and instance.exhausted and not (self._proven and instance.gave_up)

    def _conclude(self, number: int, binding: dict[str, int]) -> None:
        rule = self._rules[number]

        unknown = NEW if rule.external is not None and rule.external.info.fresh else ANY

        def value(term: str | int) -> int:
            return binding.get(term, unknown) if isinstance(term, str) else term

        if any(value(a) == value(b) >= 0 for a, b in rule.unequal):
            return
        head = (rule.head[0], *map(value, rule.head[1:]))
        if rule.external is None:
            self._add(_Promise(head))
            return
        inputs = tuple(map(value, rule.external.inputs))
        if not self._ended(rule.external, inputs):
            self._add(_Promise(head, number, inputs))


def _bind(pattern: Pattern, fact: Fact, binding: dict[str, int]) -> dict[str, int] | None:
    """The binding under which a pattern and a fact may be the same; what one of them leaves open, the other settles."""
    found = dict(binding)
    for term, value in zip(pattern[1:], fact[1:], strict=True):
        before = found.get(term, ANY) if isinstance(term, str) else term
        if before != ANY and value not in (ANY, before):
            return None
        if isinstance(term, str):
            found[term] = value if before == ANY else before
    return found


def _relevant(rules: list[Rule], wanted: set[str]) -> Iterator[Rule]:
    """Rules that a fact of a wanted predicate may depend on."""
    before = -1
    while len(wanted) > before:
        before = len(wanted)
        wanted = wanted | {str(p[0]) for rule in rules if rule.head[0] in wanted for p in rule.body}
    return (rule for rule in rules if rule.head[0] in wanted)


def _predicates(rules: list[Rule], knowledge: Knowledge) -> set[str]:
    """The predicates of which there may be a fact some day, whatever it is about."""
    found, size = {"object", *(str(fact[0]) for fact in (*knowledge.real, *knowledge.state))}, -1
    while size < (size := len(found)):
        found |= {str(rule.head[0]) for rule in rules if all(pattern[0] in found for pattern in rule.body)}
    return found


class Outlook:
    """Looks into the prospects again whenever twice as much was sampled, so that it costs little beside sampling."""

    def __init__(
        self,
        schema: Schema,
        knowledge: Knowledge,
        sampling: Sampling,
        surprises: Surprises,
        tick: Callable[[], None],
    ) -> None:
        """`tick` is called now and then, and may end the work by an exception."""
        self._schema = schema
        self._tick = tick
        self._surprises = surprises
        self._knowledge = knowledge
        self._sampling = sampling
        self._next = 2 * sampling.draws  # nothing for a first question; a later one can wait as long again

    def check(self) -> None:
        """End the run where the goal is out of reach.

        Raises:
            Ended: "infeasible"; or "failed", where streams that gave up, and are never called again, could have
                brought it, and nothing else can.
        """
        goal = self._schema.goal
        if (both := next((ground(p, {}) for p in goal.positive if p in goal.negative), None)) is not None:
            raise Ended("infeasible", f"The goal wants {self._knowledge.objects.text(both)} both true and false.")
        if (standing := never_undone(self._schema, self._knowledge)) is not None:
            raise Ended("infeasible", f"{self._knowledge.objects.text(standing)} holds, and no action undoes it.")
        if self._sampling.draws < self._next or self._may_surprise():
            return
        self._next = 2 * self._sampling.draws
        effort = EFFORT + EFFORT_A_DRAW * self._sampling.draws
        lost = out_of_reach(self._schema, self._knowledge, effort, self._tick)
        if lost is not None and self._all_tame(effort):
            text = self._knowledge.objects.text(lost)
            missing = never_given(self._schema, self._knowledge, lost)
            because = f": nothing gives {' or '.join(missing)}" if missing else ""
            raise Ended("infeasible", f"{text} is out of reach, whatever streams may still give{because}.")
        gave_up = sorted({i.external.name for i in self._knowledge.instances() if i.exhausted and i.gave_up})
        if lost is not None or not gave_up:
            return
        lost = out_of_reach(self._schema, self._knowledge, effort, self._tick, proven=False)
        if lost is not None and self._all_tame(effort, proven=False):
            text, names = self._knowledge.objects.text(lost), ", ".join(gave_up)
            raise Ended("failed", f"{text} is out of reach of all that streams may still give; {names} gave up.")

    def _all_tame(self, effort: int, proven: bool = True) -> bool:
        """Whether streams certify no more than they promise: those that have not shown it may not be called any more.

        They are called before, twice, lest it take another look.
        """
        if self._surprises.look():
            self._surprises.look()
        unknown = self._schema.externals.keys() - self._sampling.tame
        return not self._sampling.wild and not may_be_called(
            self._schema, self._knowledge, unknown, effort, self._tick, proven
        )

    def _may_surprise(self) -> bool:
        """Whether a stream may yet certify more than it promises: one has, or some have not shown how they answer."""
        self._knowledge.refresh()
        return bool(self._sampling.wild) or any(
            not instance.exhausted
            and instance.alive
            and all(support.alive for support in instance.supports)
            and instance.external.outputs
            and not instance.external.fluents
            and instance.external.name not in self._sampling.tame
            for instance in self._knowledge.instances()
        )
