"""What attempts to bind plans have taught: sampled values for the search to use, and what it had better avoid."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from tamp.planning.binding.attempt import Attempt
from tamp.planning.binding.skeleton import Skeleton
from tamp.planning.grounding.task_builder import Blame
from tamp.planning.model.fact_store import Knowledge
from tamp.planning.report import SkeletonReport

ACTIVATED = 6
"""How many results of a stream enter the search each time that it is blamed."""


@dataclass
class Trial:
    """How often a skeleton was tried, and what came of it last."""

    attempts: int = 0
    last: Attempt = field(default_factory=Attempt)


class Lessons:
    """Learns from attempts.

    Attributes:
        tried: the skeletons that were tried, in order.
        blames: value -> why moves to it failed.
        proofs: whether everything that bars a plan is certain, but for what is guessed.
        guessed: whether streams with fluents failed for no named reason: that any state with these fluents bars them,
            and others besides, is a guess.
        failed_moves: how many moves between actions failed.
        unexplained: how many of them for no named reason.
    """

    def __init__(self, knowledge: Knowledge) -> None:
        self.tried: dict[Skeleton, Trial] = {}
        self.blames: dict[int, Blame] = {}
        self.proofs = True
        self.guessed = False
        self.failed_moves = 0
        self.unexplained = 0
        self._knowledge = knowledge

    def trial(self, skeleton: Skeleton) -> Trial:
        """The one record of a skeleton."""
        return self.tried.setdefault(skeleton, Trial())

    def learn(self, attempt: Attempt) -> None:
        """Tell the search what a failed attempt has taught."""
        for instance in attempt.blamed:
            instance.failures += 1
            self._knowledge.activate(instance, ACTIVATED * instance.failures)
        for nogood in attempt.nogoods:
            template = self._knowledge.instance(nogood.external, nogood.inputs)
            facts = tuple(f for f in nogood.facts if f[0] not in self._knowledge.schema.shown)
            self.guessed |= not nogood.named
            self._knowledge.version += facts not in template.nogoods
            template.nogoods[facts] = template.nogoods.get(facts, False) or nogood.named
        for move in attempt.moves:
            self.failed_moves += 1
            self.unexplained += not move.facts
            blame = self.blames.setdefault(move.target, Blame(move.target))
            blame.facts.update(dict.fromkeys(move.facts))
            blame.failures += 1

    def reports(self) -> Iterator[SkeletonReport]:
        """What was tried, in order, and where each broke."""
        name = self._knowledge.objects.name
        for skeleton, trial in self.tried.items():
            actions = tuple(f"{step.schema.name}({', '.join(map(name, step.args))})" for step in skeleton.steps)
            if trial.last.steps is not None:
                yield SkeletonReport(actions, trial.attempts, True, "", "")
            else:
                yield SkeletonReport(actions, trial.attempts, False, trial.last.broke_at, trial.last.reason)
