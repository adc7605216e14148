"""Ground operators and axioms, kept up to date as facts arrive, and the stream instances that facts give rise to."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

from tamp.planning.connectors import Connectors
from tamp.planning.instances import Instance, ground
from tamp.planning.join import Join, JoinRule
from tamp.planning.knowledge import Knowledge
from tamp.planning.normal_schemas import ActionSchema, AxiomSchema, Condition, EffectSchema
from tamp.planning.objects import Fact
from tamp.planning.operators import GroundAxiom, GroundEffect, GroundOperator
from tamp.planning.schema import FALSE_MARK, TRUE_MARK, External, Schema
from tamp.planning.visible import Visible


class Grounder:
    """Turns facts into operators, axioms and stream instances, each exactly once.

    Only what is reachable when nothing is ever deleted is grounded. Atoms that tests decide are assumed in the plan's
    favour: a negated test in an axiom becomes a condition that the test was refuted.
    """

    def __init__(self, schema: Schema, knowledge: Knowledge, connectors: Connectors, lazy: bool = True) -> None:
        self.schema = schema
        self.knowledge = knowledge
        self.connectors = connectors
        self.operators: list[GroundOperator] = []
        self.axioms: list[GroundAxiom] = []
        self.limit = 1
        self.on_instance: Callable[[Instance], None] = lambda instance: None
        self.tick: Callable[[], None] = lambda: None
        self._since_tick = 0
        self._visible = Visible(schema, connectors, lazy)
        self._pending: list[Instance] = []
        self._by_binding: dict[tuple[int, tuple[int, ...]], GroundOperator] = {}
        self._with_objects = False
        self.join = Join(self._rules())
        self._seen: set[int] = set()
        knowledge.on_fact(self.tell)
        self.join.start()

    def tell(self, fact: Fact) -> None:
        """Take a fact in, and the objects it speaks of."""
        if self._with_objects and fact[0][0] not in (FALSE_MARK, TRUE_MARK):
            for handle in fact[1:]:
                if handle not in self._seen:
                    self._seen.add(handle)
                    self.join.add(("object", handle))
        self.join.add(fact)

    def deepen(self) -> bool:
        """Allow one more stream in a row to be hoped for; whether that brought anything new."""
        if not self._pending:
            return False
        self.limit = min(instance.level for instance in self._pending)
        waiting, self._pending = self._pending, []
        for instance in waiting:
            self._admit(instance)
        return True

    def _rules(self) -> list[JoinRule]:
        rules = [rule for schema in self.schema.actions for rule in self._action_rules(schema)]
        rules += [self._axiom_rule(axiom, condition) for axiom, condition in self._visible.axioms()]
        rules += [self._stream_rule(external, hoped) for external, hoped in self._visible.streams()]
        self._with_objects = any(p[0] == "object" for rule in rules for p in rule.body)
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
            if not effect.positive:  # what a test may yet prevent is assumed not to happen
                effect = replace(effect, condition=self._visible.doubting(effect.condition))
            body = tuple(dict.fromkeys(condition.positive + effect.condition.positive))
            names = tuple(dict.fromkeys((*variables, *_variables(effect.condition))))
            unequal = condition.unequal + effect.condition.unequal
            yield JoinRule(names, body, unequal, self._effect_rule(index, schema, effect, names, len(variables)))

    def _effect_rule(
        self, index: int, schema: ActionSchema, effect: EffectSchema, names: tuple[str, ...], count: int
    ) -> Callable[[tuple[int, ...]], None]:
        def on_match(values: tuple[int, ...]) -> None:
            operator = self._operator(index, schema, values[:count])
            self._add_effect(operator, effect, dict(zip(names, values, strict=True)))

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
        self._by_binding[index, values] = operator
        self._since_tick += 1
        if self._since_tick >= 200:
            self._since_tick = 0
            self.tick()
        self.operators.append(operator)
        for effect in self.connectors.effects(schema):
            if _is_plain(effect):
                self._add_effect(operator, effect, binding)
        return operator

    def _add_effect(self, operator: GroundOperator, effect: EffectSchema, binding: dict[str, int]) -> None:
        _, absent, positive, negative = self._split(effect.condition, binding)
        if any(fact in self.knowledge.real for fact in absent):
            return
        atom = ground(effect.atom, binding)
        operator.effects.append(GroundEffect(atom, effect.positive, positive, negative))
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

    def _axiom_rule(self, axiom: AxiomSchema, condition: Condition) -> JoinRule:
        condition = self.connectors.without(condition)
        variables = _variables(condition)

        def on_match(values: tuple[int, ...]) -> None:
            binding = dict(zip(variables, values, strict=True))
            head = ground(axiom.head, binding)
            self.axioms.append(GroundAxiom(head, *self._split(condition, binding)))
            self.tell(head)

        return JoinRule(variables, condition.positive, condition.unequal, on_match)

    def _stream_rule(self, external: External, hoped: bool) -> JoinRule:
        called_only = external.is_test and not hoped
        is_real = self.knowledge.objects.is_real

        def on_match(values: tuple[int, ...]) -> None:
            if called_only and not all(map(is_real, values)):
                return
            instance = self.knowledge.instance(external, values)
            instance.supports = self._supports(values, instance.domain)
            instance.level = 1 + max((s.level for s in instance.supports), default=0)
            self._admit(instance)

        return JoinRule(external.inputs, external.domain, (), on_match)

    def _supports(self, handles: Iterable[int], facts: Iterable[Fact]) -> tuple[Instance, ...]:
        """The instances that placeholders and hoped-for facts come from."""
        origins = [self.knowledge.objects.origin(h) for h in handles if not self.knowledge.objects.is_real(h)]
        for fact in facts:
            if fact not in self.knowledge.real:
                producers = self.knowledge.producers.get(fact, ())
                origins.extend(p for p in producers[:1] if p not in origins)
        return tuple(dict.fromkeys(origins))

    def _admit(self, instance: Instance) -> None:
        if instance.level > self.limit:
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
