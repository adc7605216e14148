"""Binding a skeleton: choose real values for its placeholders by conflict-directed backjumping.

A check that fails names the values that made it fail; the search for values goes back to the last choice of one of
them, past all choices that could not have helped (Prosser, "Hybrid algorithms for the constraint satisfaction
problem", 1993). Values come from generators, so a choice is given up after a number of values that grows from one
attempt to the next.
"""

from __future__ import annotations

from tamp.planning.attempt import Attempt, BoundStep, Budget, Frame
from tamp.planning.choice import Chooser
from tamp.planning.connectors import Connectors
from tamp.planning.constraints import Matcher
from tamp.planning.evaluate import Evaluator
from tamp.planning.knowledge import Knowledge
from tamp.planning.moves import Mover
from tamp.planning.progress import progress
from tamp.planning.sampling import Sampling
from tamp.planning.skeleton import Apply, Check, Choose, Connect, Rewind, Skeleton
from tamp.planning.state import Violation
from tamp.planning.walk import Walk


class Binder:
    """Binds skeletons. Results stay with their instances, so that nothing is computed twice."""

    def __init__(
        self,
        knowledge: Knowledge,
        sampling: Sampling,
        evaluator: Evaluator,
        connectors: Connectors,
        forbidden: Matcher,
        deadline: float,
    ) -> None:
        self._knowledge = knowledge
        self._sampling = sampling
        self._evaluator = evaluator
        self._chooser = Chooser(knowledge, sampling, evaluator)
        self._mover = Mover(knowledge, sampling, evaluator, connectors, deadline)
        self._forbidden = forbidden
        self._deadline = deadline

    def bind(self, skeleton: Skeleton, budget: Budget) -> Attempt:
        """Try to find values for everything that a skeleton leaves open."""
        walk = Walk(skeleton, budget, self._knowledge, self._sampling, self._deadline)
        position, fresh = 0, True
        while position < len(walk.items):
            if walk.spent():
                for frame in walk.frames.values():
                    walk.attempt.blamed.update(frame.culprits)
                return walk.attempt
            conflict = self._advance(walk, position, fresh)
            if conflict is None:
                position, fresh = position + 1, True
                continue
            walk.jumps += 1
            failed = walk.frames.get(position)
            culprits = dict(failed.culprits) if failed is not None else {}
            if not conflict:
                walk.attempt.blamed.update(culprits)
                self._survey(walk, position)
                return walk.attempt
            target = max(conflict)
            walk.undo(target, position)
            walk.frames[target].conflict |= conflict - {target}
            walk.frames[target].culprits.update(culprits)
            position, fresh = target, False
        walk.attempt.steps = tuple(walk.bound_steps())
        return walk.attempt

    def _survey(self, walk: Walk, position: int) -> None:
        """Walk through the rest of the plan past every failure, so that all its conflicts are known at once."""
        walk.surveying = True
        is_real = self._knowledge.objects.is_real
        state = walk.states[position]
        for i in range(position + 1, len(walk.items)):
            item = walk.items[i]
            if isinstance(item, Rewind) or walk.spent():
                return
            walk.states[i] = state
            handles = item.template.inputs if isinstance(item, Choose) else ()
            handles = item.fact[1:] if isinstance(item, Check) else handles
            if isinstance(item, Choose | Check | Apply) and all(is_real(walk.values.value(h)) for h in handles):
                self._advance(walk, i, fresh=True)
            state = walk.states.get(i + 1, state) if isinstance(item, Apply) else state

    def _advance(self, walk: Walk, position: int, fresh: bool) -> set[int] | None:
        """Do an item; None where it succeeded, otherwise the choices to blame."""
        item = walk.items[position]
        state = walk.states[position]
        if isinstance(item, Choose):
            return self._chooser.choose(walk, position, item, fresh)
        if isinstance(item, Connect):
            return self._connect(walk, position, item, fresh)
        if isinstance(item, Check):
            violation = self._evaluator.violation(walk.values.fact(item.fact), item.positive, state)
            if violation is not None:
                walk.note(position, item.step, violation.reason)
                return walk.blame(position, violation)
        if isinstance(item, Apply):
            taken = walk.skeleton.steps[item.step]
            step = BoundStep(taken.schema, walk.values.binding(taken.binding))
            if self._forbidden(step.schema.name, step.args):
                walk.note(position, item.step, "the action is forbidden with these values")
                return walk.blame(position, Violation(((step.schema.name, *step.args),), ""))
            state = progress(self._evaluator, step.schema, step.binding, state)
        if isinstance(item, Rewind):
            state = walk.states[0]
        walk.states[position + 1] = state
        return None

    def _connect(self, walk: Walk, position: int, item: Connect, fresh: bool) -> set[int] | None:
        """Move to where the next action begins; there is one way only, so a second visit fails."""
        state = walk.states[position]
        frame = walk.frames.setdefault(position, Frame())
        if not fresh:
            return set(frame.conflict)
        target = walk.values.fact(item.target)
        frame.conflict = set()
        walk.states[position + 1] = state
        if target in state:
            return None
        found = self._mover.move(target, state, walk.budget.patience)
        if isinstance(found, BoundStep):
            frame.moves = (found,)
            frame.conflict = walk.values.owners(found.binding.values())
            walk.states[position + 1] = progress(self._evaluator, found.schema, found.binding, state)
            return None
        walk.attempt.moves.extend(found.failed)
        walk.note(position, item.step, found.reason)
        return walk.blame(position, Violation((target, *found.facts), "", exact=bool(found.facts)))
