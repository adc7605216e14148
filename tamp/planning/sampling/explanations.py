"""Why a stream that is told the state gives nothing: as few facts as it still gives nothing for (QuickXplain)."""

from __future__ import annotations

from tamp.errors import SamplerError
from tamp.planning.model.fact_store import Knowledge
from tamp.planning.model.objects import Fact
from tamp.planning.model.stream_instances import Instance, Record
from tamp.planning.sampling.stream_calls import Sampling

Facts = tuple[Fact, ...]


class Explanations:
    """Explains answers by what their samplers name, or by asking again with fewer facts (Junker, AAAI 2004).

    The latter is a guess: a stream may give something where more holds.
    """

    def __init__(self, knowledge: Knowledge, sampling: Sampling) -> None:
        self._knowledge = knowledge
        self._sampling = sampling
        self._found: dict[Instance, Facts] = {}

    def why(self, instance: Instance) -> Facts:
        """Facts to blame for what gave nothing; none where it would say no as well if none of them held."""
        named = instance.main_reason[1]
        if named or not instance.fluents or not instance.calls or not _barren(instance):
            return named
        if instance.reasons and not instance.external.is_test:
            return ()  # what bars it is known, and is none of these facts; it may be dear to ask again
        if instance not in self._found:
            self._found[instance] = self._fewest(instance)
        return self._found[instance]

    def _fewest(self, instance: Instance) -> Facts:
        if not instance.fluents or self._says_no(instance, ()):
            return ()
        return self._relevant(instance, (), instance.fluents, changed=False)

    def _relevant(self, instance: Instance, kept: Facts, facts: Facts, changed: bool) -> Facts:
        """The fewest of some facts with which, beside those that are kept, it says no; `changed`: if more are."""
        if changed and self._says_no(instance, kept):
            return ()
        if len(facts) == 1:
            return facts
        first, second = facts[: len(facts) // 2], facts[len(facts) // 2 :]
        needed = self._relevant(instance, kept + first, second, changed=True)
        return self._relevant(instance, kept + needed, first, changed=bool(needed)) + needed

    def _says_no(self, instance: Instance, facts: Facts) -> bool:
        """Whether a stream gives nothing where it is told these facts; that it cannot deal with them is no answer."""
        told = tuple(fact for fact in instance.fluents if fact in facts)
        other = self._knowledge.instance(instance.external, instance.inputs, told)
        if not other.calls:
            other.record = Record()  # what is asked in states that do not come about says nothing of others
            try:
                for _ in range(instance.calls):  # as often as it took to end where it was told all
                    if not other.results and not other.exhausted:
                        self._sampling.draw(other)
            except SamplerError:
                return False
        return _barren(other)


def _barren(instance: Instance) -> bool:
    """Whether a stream has said no, or has ended without giving anything: where it has not, other calls may."""
    return not instance.results and (instance.external.is_test or instance.exhausted)
