"""Facts that are known: kept once, indexed by predicate and argument, each with the level at which it came."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from tamp.planning.model.external import External
from tamp.planning.model.objects import Fact, Objects
from tamp.planning.model.schema import FALSE_MARK, TRUE_MARK, Schema
from tamp.planning.model.stream_instances import Instance, Record, ground


class FactIndex:
    """Facts that can be looked up by any of their positions; indices are made when first asked for."""

    def __init__(self) -> None:
        self._facts: dict[str, dict[Fact, None]] = {}
        self._tables: dict[str, dict[tuple[int, ...], dict[tuple[int, ...], list[Fact]]]] = {}

    def __contains__(self, fact: Fact) -> bool:
        return fact in self._facts.get(fact[0], ())

    def __iter__(self) -> Iterator[Fact]:
        for facts in self._facts.values():
            yield from facts

    def add(self, fact: Fact) -> bool:
        """Add a fact; whether it is new."""
        facts = self._facts.setdefault(fact[0], {})
        if fact in facts:
            return False
        facts[fact] = None
        for positions, table in self._tables.get(fact[0], {}).items():
            table.setdefault(tuple([fact[p] for p in positions]), []).append(fact)
        return True

    def of(self, predicate: str) -> list[Fact]:
        """All facts of a predicate."""
        return list(self._facts.get(predicate, ()))

    def lookup(self, predicate: str, positions: tuple[int, ...], key: tuple[int, ...]) -> list[Fact]:
        """The facts of a predicate that have `key` at `positions`."""
        tables = self._tables.setdefault(predicate, {})
        if positions not in tables:
            tables[positions] = {}
            for fact in self._facts.get(predicate, ()):
                tables[positions].setdefault(tuple([fact[p] for p in positions]), []).append(fact)
        return tables[positions].get(key, [])


class Knowledge:
    """Certified facts, optimistic facts, and the instances behind them.

    Attributes:
        real: facts without fluents that hold: given, or certified by a call.
        state: the fluent facts of the initial state, in the order given.
        brought: those of them that streams have certified; each becomes true once, whatever actions do about it later.
        bringers: object that is no output of a stream -> the instance that first spoke of it, beyond its promise.
        producers: optimistic fact -> the instances that may certify it.
        templates: every instance that the optimistic level made, in an order in which supports come first.
    """

    def __init__(self, schema: Schema, objects: Objects) -> None:
        self.schema = schema
        self.objects = objects
        self.real = FactIndex()
        self.refuted: dict[Fact, str] = {}
        self.state: dict[Fact, None] = {}
        self.brought: dict[Fact, None] = {}
        self.bringers: dict[int, Instance] = {}
        self.producers: dict[Fact, list[Instance]] = {}
        self.templates: list[Instance] = []
        self.version = 0
        self._shown: dict[Fact, None] = {}
        self._unsupported = schema.derived | schema.fluents | {"object"}
        self._instances: dict[tuple[str, tuple[int, ...], frozenset[Fact] | None], Instance] = {}
        self._sources: dict[int, tuple[Instance, int]] = {}
        self._givers: dict[int, list[tuple[Instance, int]]] = {}
        self._given: set[int] = set()
        self._records: dict[tuple[str, tuple[int, ...]], Record] = {}
        self._lineages: dict[tuple[str, tuple[int, ...]], int] = {}
        self._lineage_of: dict[int, int] = {}
        self._tell: Callable[[Fact], None] = lambda fact: None
        self._take_back: Callable[[Fact], None] = lambda fact: None

    def on_fact(self, tell: Callable[[Fact], None], take_back: Callable[[Fact], None]) -> None:
        """Have the search told of every fact that it may use, and of those that it may not use after all."""
        self._tell = tell
        self._take_back = take_back

    def instance(
        self, external: External, inputs: tuple[int, ...], fluents: tuple[Fact, ...] | None = None
    ) -> Instance:
        """The one instance of a stream for these inputs.

        `fluents`: what a stream with fluents is told, in any order, which may be nothing; None for what stands for it
        in any state.
        """
        key = (external.name, inputs, frozenset(fluents) if external.fluents and fluents is not None else None)
        found = self._instances.get(key)
        if found is None:
            found = self._instances[key] = Instance(external, inputs, fluents or ())
            binding = found.binding()
            found.domain = tuple(ground(pattern, binding) for pattern in external.domain)
            kind = (external.name, tuple(map(self.lineage, inputs)))
            found.record = self._records.setdefault(kind, found.record)
        return found

    def lineage(self, handle: int) -> int:
        """What objects share that came, or may come, from one stream for inputs of the same lineage; below 0."""
        if handle not in self._lineage_of:
            self._lineage_of[handle] = handle  # a stream may give what it was called for
            source = self.source(handle) or self.objects.origin(handle)
            if source is not None:
                kind = (source.external.name, tuple(map(self.lineage, source.inputs)))
                self._lineage_of[handle] = self._lineages.setdefault(kind, -1 - len(self._lineages))
        return self._lineage_of[handle]

    def find(self, external: External, inputs: tuple[int, ...]) -> Instance | None:
        """The instance of a stream without fluents for these inputs, where there is one yet."""
        return self._instances.get((external.name, inputs, None))

    def certifier(self, test: External, fact: Fact) -> Instance:
        """The instance of a test that may certify a fact of a predicate that it certifies."""
        pattern = next(p for p in test.certified if p[0] == fact[0])
        values = dict(zip(pattern[1:], fact[1:], strict=True))
        return self.instance(test, tuple(values[v] for v in test.inputs))

    def instances(self) -> list[Instance]:
        """All instances, in the order in which they appeared."""
        return list(self._instances.values())

    def give(self, fact: Fact) -> None:
        """A fact of the problem."""
        if fact[0] != "object":
            self._given.update(fact[1:])
        if fact[0] in self.schema.fluents:
            self.state[fact] = None
        else:
            self.real.add(fact)
            if fact[0] in self.schema.shown:
                self._shown[fact] = None
        self._announce(fact)

    def told(self, external: External, state: Iterable[Fact]) -> tuple[Fact, ...]:
        """What a stream with fluents is told of a state: the facts of its predicates, first those that never change."""
        wanted = external.fluents
        return tuple(f for f in (*self._shown, *state) if f[0] in wanted) if wanted else ()

    def certify(self, fact: Fact, active: bool) -> None:
        """A call has certified a fact; the search hears of it only where it is active."""
        if fact[0] in self.schema.fluents:
            if fact not in self.brought:  # a stream may bring objects, and where they are at the start
                self.version += 1
                self.brought[fact] = None
                self.state[fact] = None
        elif self.real.add(fact):
            self.version += 1
        if active:
            self._announce(fact)

    def refute(self, fact: Fact, reason: str = "") -> None:
        """A call has shown that a fact does not hold, for a reason."""
        if fact not in self.refuted:
            self.version += 1
            self.refuted[fact] = reason
            self._tell((FALSE_MARK + fact[0], *fact[1:]))

    def assume(self, template: Instance) -> None:
        """Let the search assume that an instance will certify what it promises."""
        self.templates.append(template)
        outputs = template.external.outputs
        if outputs and not template.placeholders:
            key = f"{template.external.name}({','.join(map(self.objects.key, template.inputs))})"
            template.placeholders = tuple(self.objects.placeholder(f"{key}#{i}", template) for i in range(len(outputs)))
        for fact in template.certified(template.placeholders):
            self.producers.setdefault(fact, []).append(template)
            self._tell(fact)

    def retract(self, test: Instance) -> None:
        """Let nothing more rest on what an assumed test, which has said no, would have certified."""
        for fact in test.certified(()):
            if fact not in self.real and all(p.exhausted for p in self.producers.get(fact, ())):
                self._take_back(fact)

    def _announce(self, fact: Fact) -> None:
        self._tell(fact)
        if fact[0] in self.schema.tests:
            self._tell((TRUE_MARK + fact[0], *fact[1:]))

    def record(self, instance: Instance, outputs: tuple[int, ...]) -> bool:
        """A call has yielded outputs; whether they are new. What they certify holds; the search hears of it later."""
        if outputs in instance.results:
            return False
        for handle in outputs:
            if handle not in self._given:  # a stream may give what the problem has given already
                self._sources.setdefault(handle, (instance, len(instance.results)))
            self._givers.setdefault(handle, []).append((instance, len(instance.results)))
        instance.results.append(outputs)
        if instance.fluents:
            instance.record.acquit(instance.fluents)
        for fact in instance.certified(outputs) if not instance.external.is_state_test else ():
            self.certify(fact, active=False)
        return True

    def source(self, handle: int) -> Instance | None:
        """The stream instance that an object came from; None for an object of the problem."""
        found = self._sources.get(handle)
        return None if found is None else found[0]

    def givers(self, handle: int) -> list[tuple[Instance, int]]:
        """The stream instances that have yielded an object, each with the number of a result."""
        return self._givers.get(handle, [])

    def activate(self, instance: Instance, limit: int) -> None:
        """Let the search use the first `limit` results of an instance."""
        for number in range(min(limit, len(instance.results))):
            self._activate(instance, number)

    def is_shown(self, handle: int) -> bool:
        """Whether the search knows an object: one of the problem, or one that a stream gave and that was shown."""
        if handle not in self._sources:
            return True
        return any(number in instance.activated for instance, number in self._givers[handle])

    def show(self, handle: int) -> None:
        """Let the search know what is certified of a sampled object."""
        if handle in self._sources:
            self._activate(*self._sources[handle])

    def announce(self, test: Instance) -> None:
        """Let the search know what a test that holds certifies."""
        for outputs in test.results:
            for fact in test.certified(outputs):
                self._announce(fact)
        test.activated.update(range(len(test.results)))

    def _activate(self, instance: Instance, number: int) -> None:
        if number in instance.activated:
            return
        instance.activated.add(number)
        for handle in instance.inputs:  # what it was computed from must be known to the search as well
            if handle in self._sources:
                self._activate(*self._sources[handle])
        for fact in instance.certified(instance.results[number]):
            self._announce(fact)

    def refresh(self) -> None:
        """Work out which instances may still bring something the search does not know, and so may what they rest on."""
        for template in self.templates:
            template.alive = (
                template.unfinished
                and all(support.alive for support in template.supports)
                and all(fact[0] in self._unsupported or self.usable(fact) for fact in template.domain)
            )

    def usable(self, fact: Fact) -> bool:
        """Whether the search may rely on a fact that is no fluent."""
        if fact[0] == "object":
            origin = self.objects.origin(fact[1])
            return origin is None or bool(origin.alive)
        return fact in self.real or any(p.alive for p in self.producers.get(fact, ()))

    def possible(self, fact: Fact) -> bool:
        """Whether a fact that is no fluent may hold; so may one of a placeholder whose values are all known by now."""
        if fact[0] == "object":
            origin = self.objects.origin(fact[1])
            return origin is None or bool(origin.alive or origin.results)
        return fact in self.real or any(p.alive or p.results for p in self.producers.get(fact, ()))

    def optimistic_state(self) -> list[Fact]:
        """Fluent facts that streams may still add to the initial state."""
        return [f for f in self.producers if f[0] in self.schema.fluents and self.usable(f)]
