"""What of a schema is grounded: which axioms and streams matter to a plan, and how tests inside conditions are read."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property

from tamp.planning.model.analysis.transit_actions import Connectors
from tamp.planning.model.external import External
from tamp.planning.model.normal_form import AxiomSchema, Condition, EffectSchema
from tamp.planning.model.schema import FALSE_MARK, TRUE_MARK, Schema


@dataclass(frozen=True)
class Visible:
    """A schema as it is grounded.

    Attributes:
        lazy: whether tests are asked only where a plan rests on them, and assumed in its favour before.
        every_stream: whether also streams are called whose promises nothing needs, but for tests that are `tame`: that
            are known to certify no more than they promise.
    """

    schema: Schema
    connectors: Connectors
    lazy: bool
    every_stream: bool = False
    tame: frozenset[str] = frozenset()

    @cached_property
    def derived(self) -> frozenset[str]:
        """The derived predicates that are grounded: what is asked for, and what no further stream is called for."""
        asked = self.schema.asked_for
        streams = self._streams(asked)
        more = {d: asked | {d} | self.schema.below(d) for d in self.schema.derived - asked}
        return asked | {name for name, heads in more.items() if self._streams(heads) == streams}

    def axioms(self) -> list[tuple[AxiomSchema, Condition]]:
        """The axioms that are grounded, and what each one's condition is read as."""
        return self._axioms(self.derived)

    def _axioms(self, heads: Collection[str]) -> list[tuple[AxiomSchema, Condition]]:
        return [
            (axiom, self.doubting(axiom.condition) if self._is_doubted(axiom) else axiom.condition)
            for axiom in self.schema.axioms
            if axiom.head[0] not in self.connectors.private and axiom.head[0] in heads
        ]

    def _is_doubted(self, axiom: AxiomSchema) -> bool:
        return self.lazy and axiom.head[0] in self.schema.doubted

    def may_hurt(self, effect: EffectSchema) -> bool:
        """Whether what an effect does is not what is wanted: what a test may yet prevent is assumed not to happen."""
        return ((str(effect.atom[0]), True) in self.schema.wanted) != effect.positive

    def doubting(self, condition: Condition) -> Condition:
        """Tests inside a condition that the plan wants false: only what is known to hold, or known not to, counts.

        Those that are asked as soon as they can be are known, except that no state is known to ask some of them in.
        """
        tests = {*self.schema.state_tests, *(self.schema.tests if self.lazy else ())}
        positive = tuple((TRUE_MARK + str(p[0]), *p[1:]) if p[0] in tests else p for p in condition.positive)
        refuted = tuple((FALSE_MARK + str(p[0]), *p[1:]) for p in condition.negative if p[0] in tests)
        negative = tuple(p for p in condition.negative if p[0] not in tests)
        return Condition(positive + refuted, negative, (), condition.unequal)

    def streams(self) -> list[tuple[External, bool]]:
        """The streams that are not called on demand alone, and whether some condition may use what each promises."""
        return self._streams(self.derived)

    def _streams(self, heads: Collection[str]) -> list[tuple[External, bool]]:
        used, joined = self._used(heads), set[str]()
        externals = self.schema.externals.values()
        on_demand = self.connectors.streams
        while True:
            extra = {e.name for e in externals if e.info.eager or (self._for_surprises(e) and e.name not in on_demand)}
            more = [e for e in externals if e.name not in joined and (e.name in extra or used & _promised(e))]
            if not more:
                return [(e, bool(used & _promised(e))) for e in externals if e.name in joined]
            joined |= {e.name for e in more}
            used |= {str(p[0]) for e in more for p in e.domain + e.awaited}

    def _for_surprises(self, external: External) -> bool:
        """Whether a stream is called for what it may certify besides."""
        return self.every_stream and not (external.is_test and external.name in self.tame)

    def _used(self, heads: Collection[str]) -> set[str]:
        """Predicates that actions, axioms and the goal want true; and false ones, where tests are asked at once."""
        actions = [a for a in self.schema.actions if not self.connectors.is_connector(a.name)]
        conditions = [c for a in actions for c in (a.condition, *(e.condition for e in a.effects))]
        conditions += [condition for _, condition in self._axioms(heads)]
        conditions += [self.schema.goal]
        doubted = () if self.lazy else (str(p[0]) for c in conditions for p in c.negative if p[0] in self.schema.tests)
        return {str(p[0]) for c in conditions for p in c.positive}.union(doubted)


def _promised(external: External) -> set[str]:
    return {str(p[0]) for p in external.certified}
