"""Choosing a value for a placeholder: one that was sampled before, or a new one from its stream."""

from __future__ import annotations

from collections.abc import Iterator

from tamp.planning.binding.assignment import Walk
from tamp.planning.binding.attempt import Frame, Nogood
from tamp.planning.binding.optimizing import Optimizers
from tamp.planning.binding.skeleton import Choose
from tamp.planning.model.fact_store import Knowledge
from tamp.planning.model.objects import Fact
from tamp.planning.model.state import State
from tamp.planning.model.stream_instances import Instance
from tamp.planning.sampling.evaluation import Evaluator
from tamp.planning.sampling.stream_calls import Sampling

STEP = 6
"""By how many values later each further attempt begins among those that are known."""

SELDOM = 1 / 3
"""The share of calls that succeed below which a call counts for less of what an attempt may spend."""


def turned(number: int, known: int, turn: int) -> int:
    """Which value comes as the given one in an attempt: the `known` ones from elsewhere in each `turn`, then new ones.

    Attempts that began at the same values would stay among the same few combinations of them.
    """
    return (number + turn * STEP) % known if number < known else number


class Chooser:
    """Makes the choices of a walk."""

    def __init__(self, knowledge: Knowledge, sampling: Sampling, evaluator: Evaluator, optimizers: Optimizers) -> None:
        self._knowledge = knowledge
        self._sampling = sampling
        self._evaluator = evaluator
        self._optimizers = optimizers

    def choose(self, walk: Walk, position: int, item: Choose, fresh: bool) -> set[int] | None:
        """Choose the next value; None where there is one, otherwise the choices to blame."""
        state = walk.states[position]
        frame = walk.frames.setdefault(position, Frame())
        template = item.template
        inputs = tuple(map(walk.values.value, template.inputs))
        fluents = self._knowledge.told(template.external, state)
        instance = self._knowledge.instance(template.external, inputs, fluents)
        if fresh:
            parents = walk.values.owners((*inputs, *(h for f in fluents for h in f[1:])))
            frame.instance, frame.conflict = instance, parents
            frame.tried = frame.barren = frame.barred = 0
            frame.parents = len(parents)
            frame.cursor = walk.begin.get((template, inputs), 0)
            frame.culprits = {}
            frame.visits += 1
            frame.vain, frame.ended = frame.vain + 1 if frame.ended else 0, False
            frame.known = len(instance.results)
        for fact in instance.domain:
            if not self._evaluator.given(fact):
                walk.note(position, item.step, f"{self._knowledge.objects.text(fact)} does not hold")
                frame.culprits[instance] = None
                return set(frame.conflict)
        outputs = self._optimised(walk, position, fresh, instance)
        if outputs is None:
            outputs = self._next(walk, frame, instance, item, state)
        if outputs is None:
            frame.culprits[instance] = None
            frame.ended = True
            reason, causes = instance.main_reason
            if fluents and instance.exhausted and not instance.results:
                named = bool(causes) and not instance.gave_up
                facts = self._evaluator.explanations.why(instance) or fluents
                walk.attempt.nogoods.append(Nogood(template.external, inputs, facts, named, fluents))
            walk.note(position, item.step, f"{template.external.name}: {reason}")
            return set(frame.conflict)
        frame.outputs = outputs
        walk.values.take(position, template.placeholders, outputs)
        walk.states[position + 1] = state
        return None

    def _optimised(self, walk: Walk, position: int, fresh: bool, instance: Instance) -> tuple[int, ...] | None:
        """What an optimizer has found for a choice together with others; None where it is to be drawn by itself."""
        if not instance.external.optimizer:
            return None
        if position in walk.following:
            outputs = walk.following[position] if fresh else None
        else:
            outputs = self._optimizers.propose(walk, position)
        return outputs if outputs in instance.results else None

    def _next(self, walk: Walk, frame: Frame, instance: Instance, item: Choose, state: State) -> tuple[int, ...] | None:
        """The next value of a choice: one that was sampled before, or a new one.

        What was sampled before suited other circumstances: each visit may try one more value than the last. A value
        from which a stream cannot go on, such as a pose that the arm does not reach, says little of the others: there
        may be one more for it. So may there for one that a test is against, where no other choice is to blame: without
        another value all would be searched anew. A miss says little where a stream seldom gives anything. In a walk
        that is narrow by now values made of other choices' values are half as many after each visit in vain: where
        those others are to blame, such as a bad place, more of these, such as ways to reach it, are no help.
        """
        budget = walk.budget
        more = min(frame.barren + (0 if frame.conflict else frame.barred), budget.barren)
        most = min(budget.values + frame.visits - 1, 4 * budget.values)
        if walk.narrow and frame.parents:
            most = max(1, most >> frame.vain)
        if frame.tried >= most + more:
            return None
        misses, spared = 0, walk.spared
        # As told before: each miss would excuse the next, without end where there is nothing.
        worth = min(1.0, self._sampling.counted(instance.external.name).odds / SELDOM)
        while frame.cursor >= len(instance.results):
            if instance.exhausted or misses * worth >= budget.patience or walk.spent():
                walk.spared = spared  # what was waited for in vain counts in full
                return None
            bound = tuple(self._around(walk, item.step, state))
            if not self._sampling.draw(instance, bound):
                misses += 1
                walk.spared += 0.0 if instance.exhausted else 1.0 - worth
        frame.tried += 1
        frame.cursor += 1
        return instance.results[turned(frame.cursor - 1, frame.known, walk.turn)]

    def _around(self, walk: Walk, step: int, state: State) -> Iterator[Fact]:
        """Settled facts for a sampler to respect: what later steps will make true, then what is true now."""
        objects = self._knowledge.objects
        for later in reversed(walk.skeleton.steps[step:]):
            for effect in later.effects:
                fact = walk.values.fact(effect.atom)
                if effect.adds and all(map(objects.is_real, fact[1:])):
                    yield fact
        # A choice that is put off leaves placeholders in the state for a while.
        yield from (fact for fact in state if all(map(objects.is_real, fact[1:])))
