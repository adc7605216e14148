"""Why a test that is told the state says no: as few facts as it still says no to, found by asking it (QuickXplain)."""

from __future__ import annotations

from tamp.errors import SamplerError
from tamp.planning.model.fact_store import Knowledge
from tamp.planning.model.objects import Fact
from tamp.planning.model.stream_instances import Instance, Record
from tamp.planning.sampling.stream_calls import Sampling

Facts = tuple[Fact, ...]


class Explanations:
    """Explains answers by what their samplers name, or by asking again with fewer facts (Junker, AAAI 2004).

    The latter is a guess: a test may say yes where more holds.
    """

    def __init__(self, knowledge: Knowledge, sampling: Sampling) -> None:
        self._knowledge = knowledge
        self._sampling = sampling
        self._found: dict[Instance, Facts] = {}

    def why(self, instance: Instance) -> Facts:
        """Facts to blame for what gave nothing; none where it would say no as well if none of them held."""
        named = instance.main_reason[1]
        if named or not instance.external.is_state_test or not instance.calls:
            return named
        if instance not in self._found:
            self._found[instance] = self._fewest(instance)
        return self._found[instance]

    def _fewest(self, instance: Instance) -> Facts:
        if not instance.fluents or self._says_no(instance, ()):
            return ()
        return self._relevant(instance, (), instance.fluents, changed=False)

    def _relevant(self, instance: Instance, kept: Facts, facts: Facts, changed: bool) -> Facts:
        """The fewest of some facts with which, beside those that are kept, a test says no; `changed`: if more are."""
        if changed and self._says_no(instance, kept):
            return ()
        if len(facts) == 1:
            return facts
        first, second = facts[: len(facts) // 2], facts[len(facts) // 2 :]
        needed = self._relevant(instance, kept + first, second, changed=True)
        return self._relevant(instance, kept + needed, first, changed=bool(needed)) + needed

    def _says_no(self, instance: Instance, facts: Facts) -> bool:
        """Whether a test says no where it is told these facts; that it cannot deal with them is no answer."""
        told = tuple(fact for fact in instance.fluents if fact in facts)
        other = self._knowledge.instance(instance.external, instance.inputs, told)
        if not other.calls:
            other.record = Record()  # what is asked in states that do not come about says nothing of others
            try:
                self._sampling.draw(other)
            except SamplerError:
                return False
        return not other.results
