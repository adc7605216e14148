"""What attempts to bind plans have taught: sampled values for the search to use, and what it had better avoid."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

from tamp.planning.binding.attempt import Attempt
from tamp.planning.binding.skeleton import Skeleton
from tamp.planning.grounding.blame import Blame
from tamp.planning.model.fact_store import Knowledge
from tamp.planning.model.objects import Fact
from tamp.planning.report import SkeletonReport

ACTIVATED = 6
"""How many results of a stream enter the search each time that it is blamed."""

PUZZLING, SUPPOSED = 3, 16
"""How many moves may fail for no known reason, and how many for a reason that is guessed count as one of them."""


@dataclass
class Trial:
    """How often a skeleton was tried, and what came of it last."""

    attempts: int = 0
    last: Attempt = field(default_factory=Attempt)


class Lessons:
    """Learns from attempts.

    Attributes:
        tried: the skeletons that were tried, in order.
        blames: value, or lineage of values -> why moves there failed.
        proofs: whether everything that bars a plan is certain, but for what is guessed.
        guessed: whether streams with fluents failed for no named reason: that any state with these fluents bars them,
            and others besides, is a guess.
        failed_moves: how many moves between actions failed.
        unexplained: how many of them for no known reason, or for one that nothing can clear away.
        supposed: how many for a reason that is guessed.
    """

    def __init__(self, knowledge: Knowledge, clears: Callable[[Fact], bool]) -> None:
        """`clears`: whether an action makes a fact false."""
        self.tried: dict[Skeleton, Trial] = {}
        self.blames: dict[int, Blame] = {}
        self.proofs = True
        self.guessed = False
        self.failed_moves = 0
        self.unexplained = 0
        self.supposed = 0
        self._alike: Counter[tuple[tuple[str | int, ...], ...]] = Counter()
        self._knowledge = knowledge
        self._clears = clears

    def trial(self, skeleton: Skeleton) -> Trial:
        """The one record of a skeleton."""
        return self.tried.setdefault(skeleton, Trial())

    def alike(self, skeleton: Skeleton) -> int:
        """How many attempts there were at skeletons of the same actions, but for their order and sampled values."""
        return self._alike[self._kind(skeleton)]

    def count(self, skeleton: Skeleton) -> None:
        """Count an attempt at a skeleton."""
        self.trial(skeleton).attempts += 1
        self._alike[self._kind(skeleton)] += 1

    def _kind(self, skeleton: Skeleton) -> tuple[tuple[str | int, ...], ...]:
        lineage = self._knowledge.lineage
        return tuple(sorted((step.schema.name, *map(lineage, step.args)) for step in skeleton.steps))

    def learn(self, attempt: Attempt) -> None:
        """Tell the search what a failed attempt has taught."""
        for instance in attempt.blamed:
            instance.failures += 1
            self._knowledge.activate(instance, ACTIVATED * instance.failures)
        for nogood in attempt.nogoods:
            template = self._knowledge.instance(nogood.external, nogood.inputs)
            facts = self._changing(nogood.facts)
            new = facts not in template.nogoods
            self._knowledge.version += new
            if new and not nogood.named:
                template.record.refuse(facts)
            template.nogoods[facts] = template.nogoods.get(facts, False) or nogood.named
            if not nogood.named:
                self.guessed = True
                told = self._changing(nogood.told)
                self._knowledge.version += told not in template.refusals
                template.refusals[told] = None
        for move in attempt.moves:
            self.failed_moves += 1
            known = bool(move.facts) and (not move.guessed or any(map(self._clears, move.facts)))
            self.unexplained += not known
            self.supposed += known and move.guessed
            for handle in {move.target, self._knowledge.lineage(move.target)}:
                blame = self.blames.setdefault(handle, Blame())
                blame.facts.update(move.facts)
                blame.failures += 1
        self._learn_kinds(attempt.barred)
        for target, state in attempt.moved:
            kind = self._knowledge.lineage(target)
            if kind in self.blames:
                self.blames[kind].harmless.update(state)

    def _learn_kinds(self, barred: Mapping[Fact, tuple[Fact, ...]]) -> None:
        """Blame the kinds of values that tests are against, where they were against all others of their kinds so far.

        Such values are barred by whatever is of the same kind as what barred these: new ones would be drawn in vain.

        Args:
            barred: derived facts that were not to hold, each with what made it hold.
        """
        lineage, fluents = self._knowledge.lineage, self._knowledge.schema.fluents
        kinds: dict[int, dict[Fact, None]] = {}
        for head, causes in barred.items():
            for test in filter(self._is_of_a_kind, causes):
                for handle in {h for h in head[1:] if h in test[1:] and lineage(h) < 0}:
                    others = set(test[1:]) - {handle}
                    near = (f for f in causes if f[0] in fluents and not others.isdisjoint(f[1:]))
                    alike = dict.fromkeys((f[0], *map(lineage, f[1:])) for f in near)
                    kinds.setdefault(lineage(handle), {}).update(alike)
        for kind, facts in kinds.items():
            blame = self.blames.setdefault(kind, Blame())
            blame.kinds.update(facts.keys())
            blame.failures += 1

    def _is_of_a_kind(self, fact: Fact) -> bool:
        """Whether tests have said of many values of the same kinds, and of all, what they say of these."""
        knowledge = self._knowledge
        tests = knowledge.schema.tests.get(fact[0], ())
        records = [knowledge.certifier(test, fact).record for test in tests]
        if fact in knowledge.refuted:
            return bool(records) and not any(record.promising for record in records)
        return any(record.unfailing for record in records)

    @property
    def puzzling(self) -> bool:
        """Whether moves fail so often, for no known reason above all, that they may not be possible without others."""
        return self.unexplained + self.supposed // SUPPOSED >= PUZZLING

    def _changing(self, facts: tuple[Fact, ...]) -> tuple[Fact, ...]:
        """The facts that actions may change."""
        return tuple(f for f in facts if f[0] not in self._knowledge.schema.shown)

    def reports(self) -> Iterator[SkeletonReport]:
        """What was tried, in order, and where each broke."""
        name = self._knowledge.objects.name
        for skeleton, trial in self.tried.items():
            actions = tuple(f"{step.schema.name}({', '.join(map(name, step.args))})" for step in skeleton.steps)
            if trial.last.steps is not None:
                yield SkeletonReport(actions, trial.attempts, True, "", "")
            else:
                yield SkeletonReport(actions, trial.attempts, False, trial.last.broke_at, trial.last.reason)
