"""What the search sees of a domain: which axioms, how they read while tests are open, and which streams."""

from __future__ import annotations

from dataclasses import dataclass

from tamp.planning.connectors import Connectors
from tamp.planning.normal_schemas import AxiomSchema, Condition
from tamp.planning.schema import FALSE_MARK, TRUE_MARK, External, Schema


@dataclass(frozen=True)
class Visible:
    """A schema as it is grounded.

    Attributes:
        lazy: whether tests are asked only where a plan rests on them, and assumed in its favour before.
    """

    schema: Schema
    connectors: Connectors
    lazy: bool

    def axioms(self) -> list[tuple[AxiomSchema, Condition]]:
        """The axioms that something other than a connector asks for, and what each one's condition is read as."""
        return [
            (axiom, self.doubting(axiom.condition) if self._is_doubted(axiom) else axiom.condition)
            for axiom in self.schema.axioms
            if axiom.head[0] not in self.connectors.private
        ]

    def _is_doubted(self, axiom: AxiomSchema) -> bool:
        return self.lazy and axiom.head[0] in self.schema.doubted

    def doubting(self, condition: Condition) -> Condition:
        """Tests inside a condition that the plan wants false: only what is known to hold, or known not to, counts."""
        tests = self.schema.tests
        positive = tuple((TRUE_MARK + str(p[0]), *p[1:]) if p[0] in tests else p for p in condition.positive)
        refuted = tuple((FALSE_MARK + str(p[0]), *p[1:]) for p in condition.negative if p[0] in tests)
        negative = tuple(p for p in condition.negative if p[0] not in tests)
        return Condition(positive + refuted, negative, (), condition.unequal)

    def streams(self) -> list[tuple[External, bool]]:
        """The streams that are not called on demand alone, and whether some condition may use what each promises."""
        used, joined = self._used(), set[str]()
        externals = self.schema.externals.values()
        while True:
            more = [e for e in externals if e.name not in joined and (e.info.eager or used & _promised(e))]
            if not more:
                return [(e, bool(used & _promised(e))) for e in externals if e.name in joined]
            joined |= {e.name for e in more}
            used |= {str(p[0]) for e in more for p in e.domain}

    def _used(self) -> set[str]:
        """Predicates that actions, axioms and the goal want true."""
        actions = [a for a in self.schema.actions if not self.connectors.is_connector(a.name)]
        conditions = [c for a in actions for c in (a.condition, *(e.condition for e in a.effects))]
        conditions += [condition for _, condition in self.axioms()]
        return {str(p[0]) for c in (*conditions, self.schema.goal) for p in c.positive}


def _promised(external: External) -> set[str]:
    return {str(p[0]) for p in external.certified}
