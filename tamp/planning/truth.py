"""Facts without fluents: what is certified, and what tests decide, which are asked when the answer is needed."""

from __future__ import annotations

from collections.abc import Callable

from tamp.planning.instances import Instance
from tamp.planning.knowledge import Knowledge
from tamp.planning.objects import Fact
from tamp.planning.sampling import Sampling
from tamp.planning.schema import External


class Truth:
    """Whether facts without fluents hold."""

    def __init__(self, knowledge: Knowledge, sampling: Sampling, given: Callable[[Fact], bool]) -> None:
        """`given`: whether a domain fact of a test holds."""
        self._knowledge = knowledge
        self._sampling = sampling
        self._schema = knowledge.schema
        self._given = given

    def __call__(self, fact: Fact) -> bool:
        """Whether a fact holds; asks the tests that decide it."""
        if fact in self._knowledge.real:
            return True
        if fact in self._knowledge.refuted:
            return False
        if fact[0] == "object":
            return True
        if fact[0] == "=":
            return bool(fact[1] == fact[2])
        tests = self._schema.askable.get(fact[0])
        if tests is None or not all(self._knowledge.objects.is_real(h) for h in fact[1:]):
            return False
        return self._decided(fact, tests)

    def _decided(self, fact: Fact, tests: tuple[External, ...]) -> bool:
        reason = ""
        for test in tests:
            for pattern in test.certified:
                if pattern[0] == fact[0]:
                    instance = self._ask(test, dict(zip(pattern[1:], fact[1:], strict=True)))
                    if instance is not None and instance.results:
                        return True
                    reason = next((r for r, _ in instance.reasons), reason) if instance is not None else reason
        if fact[0] in self._schema.tests:  # otherwise another stream may certify it yet
            self._knowledge.refute(fact, reason)
        return False

    def _ask(self, test: External, terms: dict[str | int, int]) -> Instance | None:
        """The instance of a test that decides a fact, after its call; None where it does not apply."""
        if any(isinstance(t, int) and t != h for t, h in terms.items()) or not all(v in terms for v in test.inputs):
            return None
        instance = self._knowledge.instance(test, tuple(terms[v] for v in test.inputs))
        if not instance.calls:
            if not all(self._given(f) for f in instance.domain):
                return None
            self._sampling.draw(instance)
            self._knowledge.announce(instance)
            self._knowledge.version += not instance.results
        return instance
