"""Conflict-directed backjumping: values for a skeleton's parameters, in plan order, with culprits named."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from tamp.planning.binding.assignment import Begin, Walk
from tamp.planning.binding.attempt import Attempt, BoundStep, Budget, Frame, Nogood
from tamp.planning.binding.optimizing import Optimizers
from tamp.planning.binding.skeleton import Apply, Check, Choose, Connect, Rewind, Skeleton
from tamp.planning.binding.transit import Mover
from tamp.planning.binding.value_selection import Chooser
from tamp.planning.constraints import Course, Forbidden
from tamp.planning.model.analysis.transit_actions import Connectors
from tamp.planning.model.fact_store import Knowledge
from tamp.planning.model.normal_form import ActionSchema, Condition
from tamp.planning.model.objects import Fact
from tamp.planning.model.state import State, Violation
from tamp.planning.model.stream_instances import ground
from tamp.planning.sampling.evaluation import Evaluator
from tamp.planning.sampling.stream_calls import Sampling


def progress(evaluator: Evaluator, action: ActionSchema, binding: dict[str, int], state: State) -> State:
    """The state after an action with these values; what it adds wins over what it deletes."""
    added: dict[Fact, None] = {}
    deleted: set[Fact] = set()
    for effect in action.effects:
        bindings: Iterable[dict[str, int]] = (binding,)
        if effect.condition != Condition():
            bindings = [b for b, _ in evaluator.satisfy(effect.condition, binding, state)]
        for found in bindings:
            fact = ground(effect.atom, found)
            if effect.positive:
                added[fact] = None
            else:
                deleted.add(fact)
    kept = [fact for fact in state if fact not in deleted or fact in added]
    return State([*kept, *added])


class Binder:
    """Binds skeletons. Results stay with their instances, so that nothing is computed twice."""

    def __init__(
        self,
        knowledge: Knowledge,
        sampling: Sampling,
        evaluator: Evaluator,
        connectors: Connectors,
        forbidden: Forbidden,
        course: Course,
        deadline: float,
    ) -> None:
        self._knowledge = knowledge
        self._sampling = sampling
        self._evaluator = evaluator
        optimizers = Optimizers(knowledge, sampling, evaluator, progress)
        self._chooser = Chooser(knowledge, sampling, evaluator, optimizers)
        self._mover = Mover(knowledge, sampling, evaluator, connectors, deadline)
        self._forbidden = forbidden
        self._course = course
        self._deadline = deadline

    def bind(self, skeleton: Skeleton, budget: Budget, turn: int = 0, begin: Begin | None = None) -> Attempt:
        """Try to find values for all that a skeleton leaves open.

        Args:
            skeleton: what shall be bound.
            budget: what may be spent on it.
            turn: how often it, or its like, was tried.
            begin: which results of streams to try first.
        """
        walk = Walk(skeleton, budget, self._knowledge, self._sampling, self._deadline, turn, begin)
        position, fresh = 0, True
        while position < len(walk.items):
            if walk.spent():
                return walk.given_up()
            conflict = self._advance(walk, position, fresh)
            if conflict is None:
                position, fresh = position + 1, True
                continue
            if walk.surprised:  # the search has its turn: other values would but bring more of the same
                walk.show_values()
                return walk.given_up()
            walk.jumps += 1
            failed = walk.frames.get(position)
            culprits = dict(failed.culprits) if failed is not None else {}
            if not conflict:
                walk.attempt.blamed.update(culprits)
                self._survey(walk, position)
                return walk.attempt
            target = max(conflict)
            barren, barred = self._is_barren(failed), self._is_barred(walk, position)
            walk.undo(target, position)
            walk.frames[target].conflict |= conflict - {target}
            walk.frames[target].culprits.update(culprits)
            walk.frames[target].barren += barren
            walk.frames[target].barred += barred
            position, fresh = target, False
        walk.attempt.steps, walk.attempt.values = tuple(walk.bound_steps()), walk.values.all()
        return walk.attempt

    def _is_barren(self, failed: Frame | None) -> bool:
        """Whether a choice failed as its stream cannot go on from its inputs, though it may well from others."""
        if failed is None or failed.instance is None:
            return False
        return not failed.instance.results and failed.instance.record.promising

    def _is_barred(self, walk: Walk, position: int) -> bool:
        """Whether an item failed as a test is against a value, or against all that were made of one."""
        item, failed = walk.items[position], walk.frames.get(position)
        if failed is not None:
            return 0 < failed.tried == failed.barred
        if not isinstance(item, Check) or item.positive:
            return False
        return any(map(self._may_hold_of_others, walk.attempt.barred.get(walk.values.fact(item.fact), ())))

    def _may_hold_of_others(self, fact: Fact) -> bool:
        """Whether tests are against a fact that may well certify others of its kind."""
        knowledge = self._knowledge
        if fact not in knowledge.refuted:
            return False
        return any(knowledge.certifier(test, fact).record.promising for test in knowledge.schema.tests.get(fact[0], ()))

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
                walk.attempt.nogoods.extend(self._nogoods(walk.values.fact(item.fact), state) if item.positive else ())
                if not item.positive:
                    walk.attempt.barred[walk.values.fact(item.fact)] = violation.facts
                return walk.blame(position, violation)
        if isinstance(item, Apply):
            taken = walk.skeleton.steps[item.step]
            step = BoundStep(taken.schema, walk.values.binding(taken.binding))
            if self._forbidden(step.schema.name, step.args):
                walk.note(position, item.step, "the action is forbidden with these values")
                return walk.blame(position, Violation(((step.schema.name, *step.args),), ""))
            if not self._course.free and not self._follows(walk, item.step):
                walk.note(position, item.step, "the plan would not follow the given skeleton with these values")
                taken_so_far = walk.skeleton.steps[: item.step + 1]
                return walk.blame(position, Violation(tuple(walk.values.fact(("", *s.args)) for s in taken_so_far), ""))
            state = progress(self._evaluator, step.schema, step.binding, state)
        if isinstance(item, Rewind):
            state = walk.states[0]
        walk.states[position + 1] = state
        return None

    def _nogoods(self, fact: Fact, state: State) -> Iterator[Nogood]:
        """States in which tests with fluents do not certify a fact."""
        if fact[0] in self._knowledge.schema.state_tests:
            for test in self._evaluator.truth.answers(fact, state):
                causes = test.main_reason[1]
                facts = self._evaluator.explanations.why(test) or test.fluents
                yield Nogood(test.external, test.inputs, facts, bool(causes) and not test.gave_up, test.fluents)

    def _follows(self, walk: Walk, last: int) -> bool:
        """Whether the actions up to one of them follow the given skeleton with their values."""
        at = set(self._course.starts)
        for step in walk.skeleton.steps[: last + 1]:
            args = walk.values.fact(("", *step.args))[1:]
            at = {after for p in at for after in self._course.after(p, step.schema.name, args, optimistic=True)}
        return any(map(self._course.done, at)) if last + 1 == len(walk.skeleton.steps) else bool(at)

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
            walk.attempt.moved.append((self._mover.place(target), state))
            frame.conflict = walk.values.owners(found.binding.values())
            walk.states[position + 1] = progress(self._evaluator, found.schema, found.binding, state)
            return None
        wanted = set(map(walk.values.fact, walk.skeleton.positive(item.step)))
        walk.attempt.moves.extend(move.without(wanted) for move in found.failed)
        walk.note(position, item.step, found.reason)
        if not found.facts:
            return walk.blame(position, Violation((target,), "", exact=False))
        return walk.blame(position, self._evaluator.violated((target, *found.facts), ""))
