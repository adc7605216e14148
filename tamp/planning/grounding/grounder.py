"""Grounding: instances of actions, axioms and streams whose static conditions hold, as far as they are visible."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import replace

from tamp.planning.grounding.datalog import Join, JoinRule
from tamp.planning.grounding.operators import GroundAxiom, GroundEffect, GroundOperator
from tamp.planning.grounding.visible import Visible
from tamp.planning.model.analysis.transit_actions import Connectors
from tamp.planning.model.external import External
from tamp.planning.model.fact_store import Knowledge
from tamp.planning.model.normal_form import ActionSchema, AxiomSchema, Condition, EffectSchema
from tamp.planning.model.objects import Fact
from tamp.planning.model.schema import FALSE_MARK, TRUE_MARK, Schema
from tamp.planning.model.stream_instances import Instance, ground
from tamp.planning.model.turns import Turns
from tamp.planning.options import Options

MANY_ASSUMED = 1000
"""How many stream instances may be assumed before new values bring short chains of them only."""

OPERATORS_EACH = 4
"""How many operators, or conditional effects, that assume anything count as much as a stream instance."""

SHARE = 500
"""How many instances of streams whose inputs are real may come up before they are all drawn from in turn, at least."""

GROWTH = 4
"""A round may bring one more for so many of them that there are."""

PATIENCE = 16_000
"""How many optimistic facts one more stream in a row may bring at most before sampling has another turn."""


class Grounder:
    """Turns facts into operators, axioms and stream instances, each exactly once.

    Only what is reachable when nothing is ever deleted is grounded. Atoms that tests decide are assumed in the plan's
    favour: a negated test in an axiom becomes a condition that the test was refuted.

    Attributes:
        derived: the derived predicates whose axioms it makes.
        joined: the streams whose instances it makes.
        limit: how many streams in a row may be assumed.
    """

    def __init__(self, schema: Schema, knowledge: Knowledge, connectors: Connectors, options: Options) -> None:
        self.schema = schema
        self.knowledge = knowledge
        self.connectors = connectors
        self.operators: list[GroundOperator] = []
        self.axioms: list[GroundAxiom] = []
        self.limit = 1
        self._room: float = MANY_ASSUMED
        self.on_instance: Callable[[Instance], None] = lambda instance: None
        self._visible = Visible(schema, connectors, options.lazy_tests, options.every_stream, options.tame)
        self._pending: list[Instance] = []
        self._by_binding: dict[tuple[int, tuple[int, ...]], GroundOperator] = {}
        self._waiting: list[Fact] = []
        self._sated = False
        self._optimistic = 0
        self.derived = self._visible.derived
        streams = self._visible.streams()
        self.joined = frozenset(external.name for external, _ in streams)
        chained = [self._stream_rule(external, assumed) for external, assumed in streams if not external.is_test]
        rules = self._rules()
        rules += [self._stream_rule(external, assumed) for external, assumed in streams if external.is_test]
        self._with_objects = any(p[0] == "object" for rule in (*rules, *chained) for p in rule.body)
        self._join, self._real, self._chains = Join(rules), Join(chained), Join(chained)
        self._chains.paused = lambda: self._assumed > self._room
        self._real.paused = lambda: len(self._admitted) > self._most_admitted
        self._admitted: set[Instance] = set()
        self._most_admitted = SHARE
        self._seen: set[int] = set()
        self._turns = Turns(knowledge)
        knowledge.on_fact(self.tell, self._remove)

    def report_to(self, on_instance: Callable[[Instance], None], tick: Callable[[], None]) -> None:
        """`on_instance` is told of stream instances from now on, and `tick` called now and then."""
        self.on_instance = on_instance
        self._join.tick = self._real.tick = self._chains.tick = tick

    def start(self) -> None:
        """Make what needs no facts."""
        self._join.start()
        self._chains.start()

    @property
    def broken(self) -> bool:
        """Whether something was ended in the middle, so that not all is grounded that should be."""
        return self._join.broken or self._real.broken or self._chains.broken

    def tell(self, fact: Fact) -> None:
        """Take a fact in, and the objects it speaks of."""
        if self._with_objects and fact[0][0] not in (FALSE_MARK, TRUE_MARK):
            for handle in fact[1:]:
                if handle not in self._seen:
                    self._seen.add(handle)
                    self._add(("object", handle))
        self._add(fact)

    def _add(self, fact: Fact) -> None:
        """Let actions, axioms and tests see a fact at once, and streams with outputs as soon as they may follow it.

        Those whose inputs are all real see it at once as well.
        """
        self._join.add(fact)
        level = self._level(fact)
        turn = self._turns.of_fact(fact) if self._turns.needed else 0
        if not level:
            self._real.add(fact, turn)
        if 0 < level >= self.limit:
            self._waiting.append(fact)
        else:
            self._chains.add(fact, turn)

    def _remove(self, fact: Fact) -> None:
        """Ground nothing more with an optimistic fact that was refuted."""
        self._join.remove(fact)
        self._chains.remove(fact)

    def _level(self, fact: Fact) -> int:
        """How many streams in a row a fact rests on that were not called yet."""
        knowledge = self.knowledge
        origins = [knowledge.objects.origin(handle) for handle in fact[1:]]
        if fact not in knowledge.real:
            origins += knowledge.producers.get(fact, ())[:1]
        return max((origin.level for origin in origins if origin is not None), default=0)

    @property
    def _assumed(self) -> int:
        """How much is assumed: stream instances, and some operators and their conditional effects for each."""
        return len(self.knowledge.templates) + self._optimistic // OPERATORS_EACH

    @property
    def crowded(self) -> bool:
        """Whether very many are assumed, with those that wait."""
        return self._assumed + len(self._pending) > MANY_ASSUMED

    def be_shallow(self, sober: bool = False, drawing: bool = False) -> None:
        """Where many are assumed, let each new value be followed by one stream only, until the next `deepen`.

        It would else bring instances whose number grows with the power of the depth; `sober`: by none at all, where
        those that wait are counted as well.

        `drawing`: streams are drawn from next, so that as many may come up as in `deepen`.
        """
        self._most_admitted = len(self._admitted) + (self._share if drawing else SHARE)
        self._real.run()
        if sober and self.crowded:
            self.limit = 0
        elif self._assumed > MANY_ASSUMED:
            self.limit = min(self.limit, 1)

    def deepen(self, most: float = math.inf, patient: bool = False) -> bool:
        """Allow more streams in a row to be assumed; whether that brought anything new.

        Args:
            most: streams in a row that may be assumed at most.
            patient: bring about as many as there are at once; where they are many, nothing before sampling has
                had a turn.
        """
        unfinished = self._real.unfinished
        self._most_admitted = len(self._admitted) + self._share
        self._real.run()
        self.knowledge.refresh()
        self._pending = [i for i in self._pending if all(map(self._is_alive, i.inputs))]
        self._waiting = [f for f in self._waiting if all(map(self._is_alive, f[1:]))]
        levels = [*(i.level for i in self._pending), *(1 + self._level(f) for f in self._waiting)]
        level = max(1, self.limit) if self._chains.unfinished else min(levels, default=math.inf)
        sated, self._sated = self._sated and patient, False
        if level > most or level == math.inf or sated:
            return unfinished
        self.limit = int(level)
        assumed = self._assumed
        self._room = assumed + min(max(assumed, MANY_ASSUMED), PATIENCE) if patient else math.inf
        pending, self._pending = self._pending, []
        facts, self._waiting = self._waiting, []
        self._chains.run()
        for instance in pending:
            self._admit(instance)
        for fact in facts:
            if self._level(fact) < self.limit:
                self._chains.add(fact)
            else:
                self._waiting.append(fact)
        self._sated = self.crowded
        self._room = max(MANY_ASSUMED, self._assumed)
        return True

    @property
    def _share(self) -> int:
        """How many instances may come up before a round: by a constant number, many would take as many rounds."""
        return max(SHARE, len(self._admitted) // GROWTH)

    def _is_alive(self, handle: int) -> bool:
        """Whether an object is real, or may still come from its stream."""
        origin = self.knowledge.objects.origin(handle)
        return origin is None or bool(origin.alive)

    def _rules(self) -> list[JoinRule]:
        rules = [rule for schema in self.schema.actions for rule in self._action_rules(schema)]
        for axiom, condition in self._visible.axioms():
            rules += self._axiom_rules(axiom, condition)
        return rules

    def _action_rules(self, schema: ActionSchema) -> Iterable[JoinRule]:
        if self.connectors.is_connector(schema.name):
            return
        condition = self.connectors.without(schema.condition)
        variables = _variables(condition)
        index = self.schema.actions.index(schema)

        def on_match(values: tuple[int, ...]) -> None:
            self._operator(index, schema, values)

        yield JoinRule(variables, condition.positive, condition.unequal, on_match)
        for effect in self.connectors.effects(schema):
            if _is_plain(effect):
                continue
            if self._visible.may_hurt(effect):
                effect = replace(effect, condition=self._visible.doubting(effect.condition))
            wanted = tuple(p for p in effect.condition.positive if p[0] != "=")
            body = tuple(dict.fromkeys(condition.positive + wanted))
            names = tuple(dict.fromkeys((*variables, *_variables(effect.condition))))
            unequal = condition.unequal + effect.condition.unequal
            yield JoinRule(names, body, unequal, self._effect_rule(index, schema, effect, names, len(variables)))

    def _effect_rule(
        self, index: int, schema: ActionSchema, effect: EffectSchema, names: tuple[str, ...], count: int
    ) -> Callable[[tuple[int, ...]], None]:
        equal = [p for p in effect.condition.positive if p[0] == "="]  # of parameters, which are bound

        def on_match(values: tuple[int, ...]) -> None:
            binding = dict(zip(names, values, strict=True))
            if all(a == b for _, a, b in (ground(pair, binding) for pair in equal)):
                operator = self._operator(index, schema, values[:count])
                self._optimistic += bool(operator.needs)
                self._add_effect(operator, effect, binding)

        return on_match

    def _operator(self, index: int, schema: ActionSchema, values: tuple[int, ...]) -> GroundOperator:
        found = self._by_binding.get((index, values))
        if found is not None:
            return found
        condition = self.connectors.without(schema.condition)
        binding = dict(zip(_variables(condition), values, strict=True))
        static, absent, positive, negative = self._split(condition, binding)
        operator = GroundOperator(schema, binding, static, absent, positive, negative)
        operator.needs = self._needs(operator)
        self._optimistic += bool(operator.needs)
        self._by_binding[index, values] = operator
        self.operators.append(operator)
        for effect in self.connectors.effects(schema):
            if _is_plain(effect):
                self._add_effect(operator, effect, binding)
        return operator

    def clears(self, fact: Fact) -> bool:
        """Whether an operator makes a fact false."""
        return any(not e.adds and e.atom == fact for op in self.operators for e in op.effects)

    def renamed(self, operator: GroundOperator, names: dict[int, int]) -> GroundOperator | None:
        """The operator with other objects; None where it is not grounded."""
        index = self.schema.actions.index(operator.schema)
        return self._by_binding.get((index, tuple(names.get(h, h) for h in operator.binding.values())))

    def _add_effect(self, operator: GroundOperator, effect: EffectSchema, binding: dict[str, int]) -> None:
        static, absent, positive, negative = self._split(effect.condition, binding)
        atom = ground(effect.atom, binding)
        operator.effects.append(GroundEffect(atom, effect.positive, positive, negative, static, absent))
        if effect.positive:
            self.tell(atom)

    def _split(
        self, condition: Condition, binding: dict[str, int]
    ) -> tuple[tuple[Fact, ...], tuple[Fact, ...], tuple[Fact, ...], tuple[Fact, ...]]:
        """Static and absent facts, positive and negative atoms of a condition."""
        changing = self.schema.fluents | self.schema.derived
        static: list[Fact] = []
        absent: list[Fact] = []
        positive: list[Fact] = []
        negative: list[Fact] = []
        for pattern in condition.positive:
            (positive if pattern[0] in changing else static).append(ground(pattern, binding))
        for pattern in condition.negative:
            (negative if pattern[0] in changing else absent).append(ground(pattern, binding))
        return tuple(static), tuple(absent), tuple(positive), tuple(negative)

    def _axiom_rules(self, axiom: AxiomSchema, condition: Condition) -> Iterable[JoinRule]:
        """One rule, or one for each condition that asks for the head, of no more objects than it asks for."""
        condition = self.connectors.without(condition)
        variables = _variables(condition)
        bounds = self.schema.bounds(axiom)
        known: set[tuple[int, ...]] = set()

        def on_match(values: tuple[int, ...]) -> None:
            values = values[: len(variables)]
            if bounds:  # several objects that are asked for may have them in common
                if values in known:
                    return
                known.add(values)
            binding = dict(zip(variables, values, strict=True))
            head = ground(axiom.head, binding)
            self.axioms.append(GroundAxiom(head, *self._split(condition, binding)))
            self.tell(head)

        for bound in bounds or ((),):
            own = [p for p in condition.positive if not bound or p[0] != "object" or p[1] not in axiom.head[1:]]
            body = tuple(dict.fromkeys((*own, *bound)))
            names = tuple(dict.fromkeys((*variables, *(t for p in bound for t in p[1:] if isinstance(t, str)))))
            yield JoinRule(names, body, condition.unequal, on_match)

    def _stream_rule(self, external: External, assumed: bool) -> JoinRule:
        called_only = external.is_test and not assumed
        is_real = self.knowledge.objects.is_real

        def on_match(values: tuple[int, ...]) -> None:
            if called_only and not all(map(is_real, values)):
                return
            instance = self.knowledge.instance(external, values)
            if instance in self._admitted:
                return
            self._admitted.add(instance)
            instance.supports = self._supports(values, instance.domain)
            instance.level = 1 + max((s.level for s in instance.supports), default=0)
            self._admit(instance)

        return JoinRule(external.inputs, external.domain + external.awaited, (), on_match)

    def _supports(self, handles: Iterable[int], facts: Iterable[Fact]) -> tuple[Instance, ...]:
        """The instances that placeholders and optimistic facts come from."""
        origins = [self.knowledge.objects.origin(h) for h in handles if not self.knowledge.objects.is_real(h)]
        for fact in facts:
            if fact not in self.knowledge.real:
                producers = self.knowledge.producers.get(fact, ())
                origins.extend(p for p in producers[:1] if p not in origins)
        return tuple(dict.fromkeys(origins))

    def _admit(self, instance: Instance) -> None:
        assumed = self._assumed
        crowded = assumed > self._room and (instance.level > 1 or assumed > self._room + 4 * MANY_ASSUMED)
        deep = instance.level > self.limit or crowded
        if deep and not (instance.external.is_test and self.limit == 0 and instance.level == 1):
            self._pending.append(instance)
            return
        self.on_instance(instance)

    def _needs(self, operator: GroundOperator) -> tuple[Instance, ...]:
        found: dict[Instance, None] = {}

        def visit(instance: Instance) -> None:
            if instance not in found:
                for support in instance.supports:
                    visit(support)
                found[instance] = None

        for instance in self._supports(operator.binding.values(), operator.static):
            visit(instance)
        return tuple(found)


def _is_plain(effect: EffectSchema) -> bool:
    """Whether an effect has no condition that facts must match."""
    return not effect.condition.positive and not effect.condition.unequal and not effect.condition.negative


def _variables(condition: Condition) -> tuple[str, ...]:
    """The variables of a condition's positive patterns, in order."""
    return tuple(dict.fromkeys(t for p in condition.positive for t in p[1:] if isinstance(t, str)))
