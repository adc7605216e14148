"""Calling streams for themselves, apart from any plan: when they appear, and all of them in turn, round by round."""

from __future__ import annotations

import math
from collections.abc import Iterable

from tamp.planning.model.fact_store import Knowledge
from tamp.planning.model.stream_instances import Instance
from tamp.planning.model.turns import Turns
from tamp.planning.options import Limits
from tamp.planning.sampling.evaluation import Evaluator
from tamp.planning.sampling.rare_tests import RareTests
from tamp.planning.sampling.stream_calls import Sampling, Stopwatch

FACTS_A_CALL = 5
"""How many facts beyond what streams promise are as much work as a call: each brings operators and more to assume."""

SHOWN = 3
"""How many values of a stream that plans have drawn the search sees before any round."""


class Rounds:
    """Calls streams whose inputs are real, and shows the search what they give.

    Attributes:
        count: how often all streams were drawn from.
    """

    def __init__(
        self,
        knowledge: Knowledge,
        sampling: Sampling,
        evaluator: Evaluator,
        limits: Limits,
        stopwatch: Stopwatch,
        eager: bool,
        lazy_tests: bool,
    ) -> None:
        """`eager`: let the search see real values alone; `lazy_tests`: ask tests only when a plan rests on them."""
        self.count = 0
        self._knowledge = knowledge
        self._sampling = sampling
        self._evaluator = evaluator
        self._limits = limits
        self._stopwatch = stopwatch
        self._eager = eager
        self._lazy_tests = lazy_tests
        self._asking = False
        self._turns = Turns(knowledge)
        self._rare = RareTests(self._ask)

    @property
    def work(self) -> int:
        """How much was done: calls of streams, and what wild ones brought."""
        return self._sampling.calls + self._sampling.news // FACTS_A_CALL

    def appear(self, instance: Instance) -> None:
        """A stream instance whose domain facts are there: call it, or assume it."""
        knowledge = self._knowledge
        eager = (self._eager and not instance.external.fluents) or instance.external.info.eager
        brings = instance.external.name in self._sampling.wild  # and that may have no end
        eager |= instance.external.is_test and not brings and (self._asking or not self._lazy_tests)
        eager &= not instance.external.fluents  # there is no state to ask for
        callable_now = self._is_real(instance) and all(
            f in knowledge.real or f in knowledge.state or f[0] == "object" for f in instance.domain
        )
        plain = callable_now and instance.external.is_test and not brings
        if plain and eager:
            self._ask(instance)
        elif plain and not self._eager and not instance.external.fluents and self._rare.take(instance):
            pass
        elif eager and self._eager:  # also tests that bring more, lest what they bring have no end
            knowledge.templates.append(instance)
        else:
            if eager and callable_now:
                self._sampling.draw(instance)
                knowledge.activate(instance, 1)
            knowledge.assume(instance)

    def expand(self, tests: bool = False) -> bool:
        """Draw once more from every stream that has more to give, and show it to the search; whether any had.

        Of what plans have drawn before, the search sees one more value of each stream in every round: what it must look
        at grows with the square of that number, or worse.

        Where wild streams were called, a round ends as soon as it is as much work as all calls before it: what one call
        brings may be the inputs of a thousand. Kinds of instances are drawn from in turn then.

        Args:
            tests: ask the tests of the new values as well, before anything is assumed of them.

        Raises:
            Ended: at a limit.
        """
        self.count += 1
        self._asking = tests
        try:
            known = self._knowledge.instances()
            if self._turns.needed:
                any_left = self._draw(self._turns.in_turn(filter(self._is_real, known)), 2 * self.work)
            else:
                any_left = self._draw(known)
            if tests:
                self._draw(i for i in self._knowledge.instances()[len(known) :] if i.external.is_test)
        finally:
            self._asking = False
        return any_left

    def ask_first(self, instances: Iterable[Instance], most: int) -> None:
        """Draw from each of these that has given nothing, and show the first of its values, up to `most` calls in all.

        Raises:
            Ended: at a limit.
        """
        for instance in instances:
            if self._sampling.calls >= most:
                return
            if instance.fluents or instance.external.fluents or not all(map(self._evaluator.given, instance.domain)):
                continue
            self._limits.check()
            if not instance.results and not instance.exhausted:
                self._sampling.draw(instance, brief=True)
            self._refute(instance)
            with self._stopwatch.timed("grounding"):
                self._knowledge.activate(instance, 1)

    def ask_alike(self, since: int, most: int) -> None:
        """Ask tests that have said no of other values that came from the same streams, one value at a time.

        What one value fails for, its like may fail for as well, and a search costs more than many calls.

        Args:
            since: how many facts were refuted before.
            most: calls at most.
        """
        last = self._sampling.calls + most
        for fact in list(self._knowledge.refuted)[since:]:
            for position, handle in enumerate(fact[1:], start=1):
                source = self._knowledge.source(handle)
                if source is None or fact[0] not in self._knowledge.schema.tests:
                    continue
                place = next(i for i, outputs in enumerate(zip(*source.results, strict=True)) if handle in outputs)
                for number in sorted(source.activated):
                    if self._sampling.calls >= last:
                        return
                    self._limits.check()
                    self._evaluator.given((*fact[:position], source.results[number][place], *fact[position + 1 :]))

    def _draw(self, instances: Iterable[Instance], most: float = math.inf) -> bool:
        """Draw from each of these, until there is as much work done as `most`; whether any had more."""
        any_left = False
        for instance in instances:
            if self.work >= most:
                break
            if instance.fluents or instance.external.fluents or not instance.unfinished:
                continue
            if not self._is_real(instance) or not all(map(self._evaluator.given, instance.domain)):
                continue
            any_left = True
            if not all(map(self._knowledge.is_shown, instance.inputs)):
                continue  # it would bring them along
            self._limits.check()
            if not instance.exhausted:
                self._sampling.draw(instance, brief=True)
            self._refute(instance)
            with self._stopwatch.timed("grounding"):
                self._knowledge.activate(instance, SHOWN + self.count)
        return any_left

    def _ask(self, test: Instance) -> bool:
        """Ask a test, and let the search know what it said; whether it holds."""
        self._limits.check()
        self._sampling.draw(test)
        self._knowledge.announce(test)
        self._refute(test)
        if not test.results:
            self._knowledge.retract(test)
        return bool(test.results)

    def _is_real(self, instance: Instance) -> bool:
        return all(map(self._knowledge.objects.is_real, instance.inputs))

    def _refute(self, instance: Instance) -> None:
        """Let the search know of a test that has said no."""
        if instance.external.is_test and not instance.results:
            for fact in instance.certified(()):
                if fact not in self._knowledge.real:
                    self._knowledge.refute(fact)
