"""What a goal may need: literals and stream instances that regression from it leads to, whatever is grounded yet."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from tamp.planning.grounding.infeasibility import ANY
from tamp.planning.model.analysis.transit_actions import Connectors
from tamp.planning.model.external import External
from tamp.planning.model.fact_store import Knowledge
from tamp.planning.model.objects import Fact, Pattern
from tamp.planning.model.schema import Schema
from tamp.planning.model.stream_instances import Instance

GIVEN = -2
"""Stands for an object that something else gives which is needed with it: no stream need give it once more."""


@dataclass(frozen=True)
class _Way:
    """How a literal may come about: by an action, an axiom or a stream.

    Attributes:
        head: its atom; `sign` is whether it becomes true.
        needs: the literals that this wants, each with its sign.
        brings: all atoms that the action makes true.
        outputs: the objects that the stream gives.
    """

    head: Pattern
    sign: bool
    needs: tuple[tuple[Pattern, bool], ...]
    brings: tuple[Pattern, ...] = ()
    outputs: frozenset[str] = frozenset()


class Relevance:
    """Literals that some plan for a goal may need, of known objects or of any (regression without deletes).

    An action that needs what only comes after a fact is no way to that fact: whoever puts something down to have a free
    hand must have had one to take it up. It counts for what is held at first, or by actions that are needed anyway.
    """

    def __init__(self, schema: Schema, connectors: Connectors, knowledge: Knowledge) -> None:
        """`connectors`: moves that lead from anywhere to anywhere, so that only what is in their way matters."""
        self._knowledge = knowledge
        self._on_demand = connectors.streams
        self._ways: dict[tuple[str, bool], list[_Way]] = {}
        for way in _ways(schema, connectors):
            self._ways.setdefault((str(way.head[0]), way.sign), []).append(way)
        self._brought: dict[str, dict[Fact, None]] = {}
        self._wanted: dict[tuple[Fact, bool], None] = {}
        self._after: dict[tuple[Fact, Fact], bool] = {}
        self._known: dict[Instance, bool] = {}
        for fact in knowledge.state:
            self._brought.setdefault(str(fact[0]), {})[fact] = None
        for patterns, sign in ((schema.goal.positive, True), (schema.goal.negative, False)):
            self._wanted.update(((p, sign), None) for p in patterns)
        self._wanted.update(dict.fromkeys(_of_moves(schema, connectors)))
        size = (0, 0)
        while size < (size := (len(self._wanted), sum(map(len, self._brought.values())))):
            self._regress()
        self._literals: dict[str, dict[Fact, None]] = {}
        for fact, _ in self._wanted:
            self._literals.setdefault(str(fact[0]), {})[fact] = None

    def of(self, instance: Instance) -> bool:
        """Whether the goal may need what a stream certifies of its inputs, or to know that it does not.

        What it was given by other streams is needed as well then.
        """
        pending, opened = [instance], set[Instance]()  # streams may give what they were called for
        while pending:
            at = pending[-1]
            sources = [source for h in at.inputs if (source := self._knowledge.source(h)) is not None]
            waiting = [source for source in sources if source not in self._known and source not in opened]
            if at in self._known or not waiting:
                given = all(self._known.get(source, True) for source in sources)
                self._known[pending.pop()] = given and self._is_wanted(at)
            opened.add(at)
            pending += waiting
        return self._known[instance]

    def _is_wanted(self, instance: Instance) -> bool:
        external = instance.external
        if external.name in self._on_demand:
            return True
        binding = dict.fromkeys(external.outputs, ANY) | instance.binding()
        outputs = frozenset(external.outputs)
        return any(
            _bind(pattern, fact, binding, outputs) is not None
            for pattern in external.certified
            for fact in self._literals.get(str(pattern[0]), ())
        )

    def _regress(self) -> None:
        """Want what literals need that are wanted."""
        queue = list(self._wanted)
        for fact, sign in queue:  # grows while it is walked through
            for way, binding in self._steps(fact, sign):
                for brought in way.brings:
                    self._brought.setdefault(str(brought[0]), {})[_put(brought, binding)] = None
                for literal in _needed(way, binding):
                    known = literal[1] and literal[0] in self._knowledge.real
                    if literal not in self._wanted and not known:
                        self._wanted[literal] = None
                        queue.append(literal)

    def _steps(self, fact: Fact, sign: bool) -> Iterator[tuple[_Way, dict[str, int]]]:
        """The ways to a literal, with what they are about as far as the literal says so."""
        for way in self._ways.get((str(fact[0]), sign), ()):
            binding = _bind(way.head, fact, {}, way.outputs)
            if binding is None:
                continue
            late = [p for p, needed in way.needs if needed and sign and self._comes_after(_put(p, binding), fact)]
            if not late:
                yield way, binding
            for brought in tuple(self._brought.get(str(late[0][0]), ())) if late else ():
                found = _bind(late[0], brought, binding)
                if found is not None:
                    yield way, found

    def _comes_after(self, fact: Fact, first: Fact) -> bool:
        """Whether all that makes a fact true needs another one, which speaks of known objects."""
        if ANY in first or GIVEN in first:
            return False
        if (fact, first) not in self._after:
            ways = self._ways.get((str(fact[0]), True), ())
            found = [(way, b) for way in ways if (b := _bind(way.head, fact, {}, way.outputs)) is not None]
            needing = (any(needed and _put(p, b) == first for p, needed in way.needs) for way, b in found)
            self._after[fact, first] = bool(found) and all(needing)
        return self._after[fact, first]


def _put(pattern: Pattern, binding: dict[str, int]) -> Fact:
    """A pattern with its variables replaced, by any object where nothing is known of one."""
    return (pattern[0], *(binding.get(t, ANY) if isinstance(t, str) else t for t in pattern[1:]))


def _bind(
    pattern: Pattern, fact: Fact, binding: dict[str, int], outputs: frozenset[str] = frozenset()
) -> dict[str, int] | None:
    """The binding under which a pattern and a fact may be the same, with no output for what is given already."""
    found = dict(binding)
    for term, value in zip(pattern[1:], fact[1:], strict=True):
        before = found.get(term, ANY) if isinstance(term, str) else term
        if (before >= 0 and value >= 0 and before != value) or (value == GIVEN and term in outputs):
            return None
        if isinstance(term, str):
            found[term] = before if value == ANY else value if before == ANY else max(before, value)
    return found


def _needed(way: _Way, binding: dict[str, int]) -> Iterator[tuple[Fact, bool]]:
    """What a way needs. Of objects about which it says more elsewhere, together with known ones, those are given."""
    literals = [(pattern, _put(pattern, binding), sign) for pattern, sign in way.needs]
    given = {t for p, fact, sign in literals if sign and any(h >= 0 for h in fact[1:]) for t in p[1:]}
    for pattern, fact, sign in literals:
        if all(h == GIVEN or (h == ANY and t in given) for t, h in zip(pattern[1:], fact[1:], strict=True)):
            fact = (fact[0], *[GIVEN] * (len(fact) - 1))
        yield fact, sign


def _ways(schema: Schema, connectors: Connectors) -> Iterator[_Way]:
    for action in schema.actions:
        if connectors.is_connector(action.name):
            continue
        effects = tuple(connectors.effects(action))
        brings = tuple(e.atom for e in effects if e.positive)
        for effect in effects:
            condition = connectors.without(action.condition) & effect.condition
            yield _Way(effect.atom, effect.positive, _literals(condition.positive, condition.negative, True), brings)
    for axiom in schema.axioms:
        for sign in (True, False):
            yield _Way(axiom.head, sign, _literals(axiom.condition.positive, axiom.condition.negative, sign))
    for external in schema.externals.values():
        needs = _literals(external.domain + external.awaited, (), True) + _told(schema, external)
        for pattern in external.certified:
            yield from (_Way(pattern, sign, needs, outputs=frozenset(external.outputs)) for sign in (True, False))


def _of_moves(schema: Schema, connectors: Connectors) -> Iterator[tuple[Fact, bool]]:
    """What some moves need of the state that they are made in."""
    for connector in connectors.connectors:
        negative = (*connector.fluents.negative, *connector.negative)
        needs = _literals(connector.fluents.positive, negative, True)
        needs += tuple(literal for external, _ in connector.streams for literal in _told(schema, external))
        yield from ((_put(pattern, {}), sign) for pattern, sign in needs)


def _told(schema: Schema, external: External) -> tuple[tuple[Pattern, bool], ...]:
    """What a stream is told of the state may hold or not."""
    patterns = dict.fromkeys((e.atom[0], *[ANY] * (len(e.atom) - 1)) for a in schema.actions for e in a.effects)
    return tuple((p, sign) for p in patterns if p[0] in external.fluents for sign in (True, False))


def _literals(
    positive: tuple[Pattern, ...], negative: tuple[Pattern, ...], sign: bool
) -> tuple[tuple[Pattern, bool], ...]:
    """What is wanted of a condition that shall hold, or shall not."""
    found = [(p, sign) for p in positive] + [(p, not sign) for p in negative]
    return tuple((p, wanted) for p, wanted in found if p[0] not in ("=", "object"))
