"""A skeleton: the actions of a symbolic plan, and in which order to choose its values and to check its conditions."""

from __future__ import annotations

from collections.abc import Container, Iterable
from dataclasses import dataclass, replace

from tamp.planning.grounding.operators import GroundOperator
from tamp.planning.model.analysis.transit_actions import Connectors
from tamp.planning.model.external import External
from tamp.planning.model.fact_store import Knowledge
from tamp.planning.model.objects import Fact
from tamp.planning.model.schema import Schema
from tamp.planning.model.stream_instances import Instance, ground


@dataclass(frozen=True)
class Choose:
    """Choose outputs of a stream instance, whose inputs may be placeholders that were chosen before."""

    template: Instance
    step: int


@dataclass(frozen=True)
class Check:
    """Check a literal in the state before `step`; placeholders in it were chosen before."""

    fact: Fact
    positive: bool
    step: int


@dataclass(frozen=True)
class Apply:
    """Go on to the state after `step`."""

    step: int


@dataclass(frozen=True)
class Connect:
    """Bring the connectors' fluent to what `step` wants; `target` is that fact."""

    target: Fact
    step: int


@dataclass(frozen=True)
class Rewind:
    """Begin again at the initial state, for the next pass."""


Item = Choose | Check | Apply | Connect | Rewind


@dataclass(frozen=True, eq=False)
class Skeleton:
    """A symbolic plan and the items that bind it."""

    steps: tuple[GroundOperator, ...]
    items: tuple[Item, ...]

    @property
    def leaves_open(self) -> bool:
        """Whether there is anything to choose, so that another attempt at it may come to something else."""
        return any(isinstance(item, Choose) for item in self.items)

    def positive(self, step: int) -> tuple[Fact, ...]:
        """What a step wants of the state; nothing is known of the goal, which comes after the last one."""
        return self.steps[step].positive if step < len(self.steps) else ()


def make_skeleton(
    steps: Iterable[GroundOperator], schema: Schema, knowledge: Knowledge, connectors: Connectors
) -> Skeleton:
    """Order a plan's choices and checks: in plan order, each check as soon as its objects are known, in three passes.

    What looks at whole states is asked once all else is chosen, and moves are made where nothing more can bar the plan.
    """
    steps = tuple(_one_choice_each(tuple(steps), knowledge))
    planner = _Planner(schema, knowledge, connectors, steps)
    return Skeleton(steps, tuple(planner.items()))


def _one_choice_each(steps: tuple[GroundOperator, ...], knowledge: Knowledge) -> Iterable[GroundOperator]:
    """Where several steps assume one stream with fluents, each chooses for itself: their states differ."""
    used: set[Instance] = set()
    for step in steps:
        new: dict[Instance, Instance] = {}
        for instance in step.needs:
            if instance in used and instance.external.fluents and instance.placeholders:
                fresh = replace(instance)
                keys = [knowledge.objects.key(h) for h in instance.placeholders]
                fresh.placeholders = tuple(knowledge.objects.placeholder(key, fresh) for key in keys)
                new[instance] = fresh
        used.update(step.needs)
        yield _with_fresh(step, new) if new else step


def _with_fresh(step: GroundOperator, fresh: dict[Instance, Instance]) -> GroundOperator:
    handles = {
        old: new
        for instance, other in fresh.items()
        for old, new in zip(instance.placeholders, other.placeholders, strict=True)
    }
    return replace(renamed(step, handles), needs=tuple(fresh.get(instance, instance) for instance in step.needs))


def renamed(step: GroundOperator, handles: dict[int, int]) -> GroundOperator:
    """A step with other objects in the place of some."""

    def fact(old: Fact) -> Fact:
        return (old[0], *[handles.get(h, h) for h in old[1:]])

    return replace(
        step,
        binding={name: handles.get(h, h) for name, h in step.binding.items()},
        positive=tuple(map(fact, step.positive)),
        negative=tuple(map(fact, step.negative)),
        effects=[replace(effect, atom=fact(effect.atom)) for effect in step.effects],
    )


# The passes through a plan.
AT_ONCE = 0
OF_STATES = 1  # what is told of the state, but of nothing that moves change
WITH_MOVES = 2  # all else that is deferred


class _Planner:
    def __init__(
        self, schema: Schema, knowledge: Knowledge, connectors: Connectors, steps: tuple[GroundOperator, ...]
    ) -> None:
        self.schema = schema
        self.knowledge = knowledge
        self.connectors = connectors
        self.steps = steps
        self.moved = {connectors.fluent, *connectors.spent} if connectors.fluent else set()
        self.needs = [self._with_optimistic_state(step) for step in steps]
        self.passes = dict.fromkeys(self._deferred(), OF_STATES)
        self._put_off()
        self.late = {h: self.passes[instance] for instance in self.passes for h in instance.placeholders}
        self.chosen: set[Instance] = set()
        self.known: set[int] = set()

    def _with_optimistic_state(self, step: GroundOperator) -> tuple[Instance, ...]:
        """A step's instances, and those that bring fluents that it wants from the start."""
        optimistic = [
            p
            for fact in step.positive
            if fact not in self.knowledge.state
            for p in self.knowledge.producers.get(fact, ())[:1]
        ]
        return tuple(dict.fromkeys((*step.needs, *(s for p in optimistic for s in (*p.supports, p)))))

    def _deferred(self) -> set[Instance]:
        """Instances whose choice can wait: they ask for it, and nothing that cannot wait rests on them."""
        every = [instance for needs in self.needs for instance in needs]
        late = {instance for instance in every if instance.external.deferred and not instance.external.is_test}
        while True:
            early = {s for instance in every if instance not in late for s in instance.supports if s in late}
            if not early:
                return late
            late -= early

    def _put_off(self) -> None:
        """Leave to the last pass what looks at anything that is known only there, and what is no question of states."""
        while True:
            last = {i for i, when in self.passes.items() if when == WITH_MOVES}
            late = {h for instance in last for h in instance.placeholders}
            put_off = [
                instance
                for instance in self.passes.keys() - last
                if last.intersection(instance.supports) or self._sees(instance.external, late)
            ]
            if not put_off:
                return
            self.passes.update(dict.fromkeys(put_off, WITH_MOVES))

    def _sees(self, external: External, late: Container[int]) -> bool:
        """Whether a stream is told of what moves change, or of objects that are chosen late; so is one without states.

        Without moves there is nothing to be asked before them.
        """
        if not external.fluents or not self.moved:
            return True
        if any(self.schema.influences(name) & self.moved for name in external.fluents):
            return True
        told = (e.atom for step in self.steps for e in step.effects if e.atom[0] in external.fluents)
        return any(h in late for atom in told for h in atom[1:])

    def items(self) -> Iterable[Item]:
        end = len(self.steps)
        literals = [(f, True) for f in self.schema.goal.positive] + [(f, False) for f in self.schema.goal.negative]
        goal: list[tuple[Fact, bool]] = [(ground(f, {}), positive) for f, positive in literals]
        for turn in (AT_ONCE, OF_STATES, WITH_MOVES):
            made: list[Item] = []
            for k, step in enumerate(self.steps):
                made += [*self._step(k, step, turn), Apply(k)]
            if turn == WITH_MOVES:
                made += [Connect(f, end) for f, positive in goal if positive and self._hidden(f)]
            made += [Check(f, p, end) for f, p in goal if not self._hidden(f) and self._pass_of(f) == turn]
            if turn == AT_ONCE:
                yield from made
            elif any(not isinstance(item, Apply) for item in made):
                yield Rewind()
                yield from made

    def _hidden(self, fact: Fact) -> bool:
        return bool(self.connectors.fluent) and fact[0] == self.connectors.fluent

    def _step(self, k: int, step: GroundOperator, turn: int) -> Iterable[Item]:
        waiting = list(self._literals(step))
        if turn == WITH_MOVES:
            yield from (Connect(f, k) for f, positive in waiting if positive and self._hidden(f))
        mine = [(f, p) for f, p in waiting if not self._hidden(f) and self._pass_of(f) == turn]
        needs = [i for i in self.needs[k] if i not in self.chosen and not i.external.is_test]
        groups: list[Instance | None] = [None, *(i for i in needs if self.passes.get(i, AT_ONCE) == turn)]
        for instance in groups:
            if instance is not None:
                self.chosen.add(instance)
                self.known |= set(instance.placeholders)
                yield Choose(instance, k)
            ready = [(f, p) for f, p in mine if all(self._is_known(h) for h in f[1:])]
            mine = [literal for literal in mine if literal not in ready]
            yield from (Check(f, p, k) for f, p in sorted(ready, key=self._difficulty))
        assert not mine, f"{step.schema.name}: no stream gives the objects of {mine}"

    def _pass_of(self, fact: Fact) -> int:
        """The first pass in which a literal can be checked: its objects, and the states it is about, are known."""
        latest = max((self.late.get(h, AT_ONCE) for h in fact[1:]), default=AT_ONCE)
        tests = self.schema.state_tests.get(str(fact[0]), ())
        last = {h for h, when in self.late.items() if when == WITH_MOVES} if tests else set()
        return max([latest, *(WITH_MOVES if self._sees(test, last) else OF_STATES for test in tests)])

    def _is_known(self, handle: int) -> bool:
        return handle in self.known or self.knowledge.objects.is_real(handle)

    def _difficulty(self, literal: tuple[Fact, bool]) -> int:
        name = literal[0][0]
        return 2 if name in self.schema.derived else 1 if name in self.schema.tests else 0

    def _literals(self, step: GroundOperator) -> Iterable[tuple[Fact, bool]]:
        """The literals of a step's whole condition that are not certain by themselves."""
        for pattern in step.schema.condition.positive:
            fact = ground(pattern, step.binding)
            if fact[0] in self.schema.fluents or fact not in self.knowledge.real:
                yield fact, True
        for pattern in step.schema.condition.negative:
            yield ground(pattern, step.binding), False
