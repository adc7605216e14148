"""A guess at why there is no plan: conditions that no values fit, if each stream's values are no other stream's.

The relaxed problem is looked at with one object for all that an output of a stream may be, and one for all given
objects of which the same is said: it has few facts, however many values there are (Datalog). What is out of reach there
may be within reach where a value of one stream happens to be equal to another's, so that it proves nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

from tamp.planning.grounding.datalog import EVERY, Join, JoinRule
from tamp.planning.grounding.relaxed_rules import Rule, relaxed_rules
from tamp.planning.model.fact_store import Knowledge
from tamp.planning.model.objects import Fact, Pattern
from tamp.planning.model.schema import Schema

MOST_FACTS, MOST_STEPS = 5_000, 200_000
"""What may be looked at before nothing is guessed."""


class _TooMany(Exception):  # noqa: N818  control flow inside this module
    """There is more to look at than a guess is worth."""


class _Alike(Exception):  # noqa: N818  control flow inside this module
    """Values of different streams are equal indeed, so that kinds tell nothing."""


def unfit_conditions(schema: Schema, knowledge: Knowledge) -> str:
    """A sentence about conditions that no values fit; empty where there are none, or nothing can be told."""
    try:
        return _Kinds(schema, knowledge).unfit()
    except (_TooMany, _Alike):
        return ""


class _Kinds:
    """The relaxed problem of kinds in place of objects."""

    def __init__(self, schema: Schema, knowledge: Knowledge) -> None:
        self._knowledge = knowledge
        self._numbers: dict[object, int] = {}
        self._kind_of: dict[int, int] = {}
        self._facts: dict[str, dict[Fact, None]] = {}
        self._externals = tuple(schema.externals.values())
        self._count = self._steps = 0
        given = [f for f in (*knowledge.real, *knowledge.state) if f[0] != "object"]
        self._find_kinds(given)
        self._rules = [self._with_kinds(rule) for rule in relaxed_rules(schema)]
        self._goal = [self._put(p) for p in schema.goal.positive if p[0] not in ("=", "object")]
        self._fired: set[Rule] = set()
        self._reach(given)

    def unfit(self) -> str:
        """The first conditions on the way to the goal that nothing fits, as few of them as do not fit together."""
        wanted = [p for p in self._goal if not self._fits([p])]
        seen = {str(p[0]) for p in wanted}
        for goal in wanted:  # grows while it is walked through
            for rule in self._rules:
                if rule.head[0] != goal[0] or rule in self._fired:
                    continue
                alone = [p for p in rule.body if not self._fits([p])]
                if not alone:
                    return self._told(rule)
                fresh = [p for p in alone if str(p[0]) not in seen]
                wanted += fresh
                seen |= {str(p[0]) for p in fresh}
        return ""

    def _told(self, rule: Rule) -> str:
        core = [p for p in rule.body if p[0] != "object"]
        for pattern in tuple(core):
            rest = [p for p in core if p is not pattern]
            core = core if self._fits(rest) else rest
        if any(str(p[0]).startswith("@") for p in core) or rule.name.startswith("@"):
            return ""
        facts = " and ".join(f"({' '.join(map(str, p))})" for p in self._named(core))
        return (
            f"Unless values of different streams are equal, nothing fits {facts} of {rule.name}: "
            "look at what streams certify of these, and in which order."
        )

    def _named(self, patterns: list[Pattern]) -> Iterator[tuple[object, ...]]:
        names = {kind: self._knowledge.objects.name(handle) for handle, kind in reversed(self._kind_of.items())}
        for pattern in patterns:
            yield pattern[0], *(t if isinstance(t, str) else names.get(t, "...") for t in pattern[1:])

    def _find_kinds(self, given: list[Fact]) -> None:
        """One kind for given objects of which the same is said in the same places, one for each output of a stream."""
        said: dict[int, set[tuple[str, int]]] = {}
        made: dict[int, set[tuple[str, int]]] = {}
        for instance in self._knowledge.instances():
            for outputs in instance.results:
                for place, handle in enumerate(outputs):
                    made.setdefault(handle, set()).add((instance.external.name, place))
        for fact in given:
            for place, handle in enumerate(fact[1:]):
                said.setdefault(handle, set()).add((str(fact[0]), place))
        for handle, streams in made.items():
            if len(streams) > 1 or self._knowledge.source(handle) is None:
                raise _Alike
            self._kind_of[handle] = self._number(*streams)
        for handle, places in said.items():
            self._kind_of.setdefault(handle, self._number(frozenset(places)))

    def _number(self, kind: object) -> int:
        return self._numbers.setdefault(kind, len(self._numbers))

    def _put(self, pattern: Pattern) -> Pattern:
        terms = (t if isinstance(t, str) else self._kind_of.setdefault(t, self._number(t)) for t in pattern[1:])
        return (pattern[0], *terms)

    def _with_kinds(self, rule: Rule) -> Rule:
        return Rule(rule.name, self._put(rule.head), tuple(map(self._put, rule.body)))

    def _reach(self, given: list[Fact]) -> None:
        """All that can be reached from what is given, which includes what streams have given."""
        join = Join([self._join_rule(rule, lambda head: self._add(join, head)) for rule in self._rules])
        join.tick = self._tick
        join.start()
        for fact in given:
            self._add(join, (fact[0], *(self._kind_of[h] for h in fact[1:])))

    def _join_rule(self, rule: Rule, add: Callable[[Fact], None]) -> JoinRule:
        variables = tuple(dict.fromkeys(t for p in rule.body for t in p[1:] if isinstance(t, str)))

        def on_match(values: tuple[int, ...]) -> None:
            self._fired.add(rule)
            binding = dict(zip(variables, values, strict=True))
            head = (binding[t] if t in binding else self._output(rule, t) for t in rule.head[1:])
            add((rule.head[0], *head))

        return JoinRule(variables, rule.body, (), on_match)

    def _output(self, rule: Rule, term: str | int) -> int:
        """The kind of what no condition binds: an output of the stream of that name."""
        if isinstance(term, int):
            return term
        outputs = next((e.outputs for e in self._externals if e.name == rule.name), ())
        return self._number((rule.name, outputs.index(term))) if term in outputs else self._number(term)

    def _add(self, join: Join, fact: Fact) -> None:
        facts = self._facts.setdefault(str(fact[0]), {})
        if fact not in facts:
            facts[fact] = None
            self._count += 1
            if self._count > MOST_FACTS:
                raise _TooMany
            join.add(fact)
            for kind in fact[1:]:
                self._add(join, ("object", kind))

    def _tick(self) -> None:
        self._steps += EVERY
        if self._steps > MOST_STEPS:
            raise _TooMany

    def _fits(self, patterns: Sequence[Pattern], binding: Mapping[str, int] | None = None) -> bool:
        """Whether there are facts that all patterns fit, with one kind for each variable."""
        if not patterns:
            return True
        known = binding or {}
        for fact in self._facts.get(str(patterns[0][0]), ()):
            self._steps += 1
            if self._steps > MOST_STEPS:
                raise _TooMany
            found = dict(known)
            fitting = zip(patterns[0][1:], fact[1:], strict=True)
            fits = all((found.setdefault(t, kind) if isinstance(t, str) else t) == kind for t, kind in fitting)
            if fits and self._fits(patterns[1:], found):
                return True
        return False
