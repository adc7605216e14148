"""Binding a skeleton: choose real values for its placeholders by conflict-directed backjumping.

A check that fails names the values that made it fail; the search for values goes back to the last choice of one of
them, past all choices that could not have helped (Prosser, "Hybrid algorithms for the constraint satisfaction
problem", 1993). Values come from generators, so a choice is given up after a number of values that grows from one
attempt to the next.
"""

from __future__ import annotations

import time
from collections.abc import Iterator

from tamp.planning.assignment import Assignment
from tamp.planning.attempt import Attempt, BoundStep, Budget, Frame, Nogood
from tamp.planning.connectors import Connectors
from tamp.planning.constraints import Matcher
from tamp.planning.evaluate import Evaluator
from tamp.planning.instances import Instance
from tamp.planning.knowledge import Knowledge
from tamp.planning.moves import Mover
from tamp.planning.objects import Fact
from tamp.planning.progress import progress
from tamp.planning.sampling import Sampling
from tamp.planning.skeleton import Apply, Check, Choose, Connect, Rewind, Skeleton
from tamp.planning.state import State, Violation


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
        self.knowledge = knowledge
        self.sampling = sampling
        self.evaluator = evaluator
        self.mover = Mover(knowledge, sampling, evaluator, connectors, deadline)
        self.forbidden = forbidden
        self.deadline = deadline

    def bind(self, skeleton: Skeleton, budget: Budget) -> Attempt:
        """Try to find values for everything that a skeleton leaves open."""
        return _Run(self, skeleton, budget).run()


class _Run:
    """One attempt."""

    def __init__(self, binder: Binder, skeleton: Skeleton, budget: Budget) -> None:
        self.binder = binder
        self.skeleton = skeleton
        self.budget = budget
        self.items = skeleton.items
        self.frames: dict[int, Frame] = {}
        self.values = Assignment()
        self.states: dict[int, State] = {}  # item -> state that holds when it is reached
        self.attempt = Attempt()
        self.first_draw = binder.sampling.draws
        self.jumps = 0
        self.surveying = False

    def run(self) -> Attempt:
        self.states[0] = State(self.binder.knowledge.state)
        position, fresh = 0, True
        while position < len(self.items):
            if self._spent():
                for frame in self.frames.values():
                    self.attempt.blamed.update(frame.culprits)
                return self.attempt
            conflict = self._advance(position, fresh)
            if conflict is None:
                position, fresh = position + 1, True
                continue
            self.jumps += 1
            failed = self.frames.get(position)
            culprits = dict(failed.culprits) if failed is not None else {}
            if not conflict:
                self.attempt.blamed.update(culprits)
                self._survey(position)
                return self.attempt
            target = max(conflict)
            self._undo(target, position)
            self.frames[target].conflict |= conflict - {target}
            self.frames[target].culprits.update(culprits)
            position, fresh = target, False
        self.attempt.steps = tuple(self._bound_steps())
        return self.attempt

    def _survey(self, position: int) -> None:
        """Walk through the rest of the plan past every failure, so that all its conflicts are known at once."""
        self.surveying = True
        is_real = self.binder.knowledge.objects.is_real
        state = self.states[position]
        for i in range(position + 1, len(self.items)):
            item = self.items[i]
            if isinstance(item, Rewind) or self._spent():
                return
            self.states[i] = state
            handles = item.template.inputs if isinstance(item, Choose) else ()
            handles = item.fact[1:] if isinstance(item, Check) else handles
            if isinstance(item, Choose | Check | Apply) and all(is_real(self.values.value(h)) for h in handles):
                self._advance(i, fresh=True)
            state = self.states.get(i + 1, state) if isinstance(item, Apply) else state

    def _spent(self) -> bool:
        over = (
            self.binder.sampling.draws - self.first_draw > self.budget.draws + 4 * len(self.items)
            or self.jumps > self.budget.jumps
        )
        return over or time.monotonic() > self.binder.deadline

    def _undo(self, target: int, position: int) -> None:
        """Forget the choices after `target`, and the value of `target` itself."""
        for i in range(target, position + 1):
            frame = self.frames.get(i)
            if frame is None:
                continue
            self._release(i, frame)
            if i > target:
                frame.instance = None

    def _release(self, position: int, frame: Frame) -> None:
        item = self.items[position]
        if isinstance(item, Choose) and frame.outputs:
            self.values.release(position, item.template.placeholders, frame.outputs)
        frame.outputs = ()
        frame.moves = ()

    def _advance(self, position: int, fresh: bool) -> set[int] | None:
        """Do an item; None where it succeeded, otherwise the choices to blame."""
        item = self.items[position]
        state = self.states[position]
        if isinstance(item, Choose):
            return self._choose(position, item, fresh, state)
        if isinstance(item, Connect):
            return self._connect(position, item, fresh, state)
        if isinstance(item, Check):
            violation = self.binder.evaluator.violation(self.values.fact(item.fact), item.positive, state)
            if violation is not None:
                self._note(position, item.step, violation.reason)
                return self._blame(position, violation)
        if isinstance(item, Apply):
            step = BoundStep(
                self.skeleton.steps[item.step].schema, self.values.binding(self.skeleton.steps[item.step].binding)
            )
            if self.binder.forbidden(step.schema.name, step.args):
                self._note(position, item.step, "the action is forbidden with these values")
                return self._blame(position, Violation(((step.schema.name, *step.args),), ""))
            state = progress(self.binder.evaluator, step.schema, step.binding, state)
        if isinstance(item, Rewind):
            state = self.states[0]
        self.states[position + 1] = state
        return None

    def _choose(self, position: int, item: Choose, fresh: bool, state: State) -> set[int] | None:
        frame = self.frames.setdefault(position, Frame())
        template = item.template
        inputs = tuple(map(self.values.value, template.inputs))
        wanted = template.external.fluents
        fluents = tuple(f for f in state if f[0] in wanted) if wanted else ()
        instance = self.binder.knowledge.instance(template.external, inputs, fluents)
        if fresh:
            parents = self.values.owners((*inputs, *(h for f in fluents for h in f[1:])))
            frame.instance, frame.cursor, frame.tried, frame.conflict = instance, 0, 0, parents
            frame.culprits = {}
            frame.visits += 1
        for fact in instance.domain:
            if not self.binder.evaluator.given(fact):
                self._note(position, item.step, f"{self.binder.knowledge.objects.text(fact)} does not hold")
                frame.culprits[instance] = None
                return set(frame.conflict)
        outputs = self._next(frame, instance, item, state)
        if outputs is None:
            frame.culprits[instance] = None
            reason, causes = instance.main_reason
            if fluents and instance.exhausted and not instance.results:
                self.attempt.nogoods.append(Nogood(template.external, inputs, causes or fluents, bool(causes)))
            self._note(position, item.step, f"{template.external.name}: {reason}")
            return set(frame.conflict)
        frame.outputs = outputs
        self.values.take(position, template.placeholders, outputs)
        self.states[position + 1] = state
        return None

    def _next(self, frame: Frame, instance: Instance, item: Choose, state: State) -> tuple[int, ...] | None:
        """The next value of a choice: one that was sampled before, or a new one.

        What was sampled before suited other circumstances: each visit may try one more value than the last.
        """
        if frame.tried >= min(self.budget.values + frame.visits - 1, 4 * self.budget.values):
            return None
        misses = 0
        while frame.cursor >= len(instance.results):
            if instance.exhausted:
                return None
            if misses >= self.budget.patience or self._spent():
                return None
            bound = tuple(self._around(item.step, state))
            misses += not self.binder.sampling.draw(instance, bound)
        frame.tried += 1
        frame.cursor += 1
        return instance.results[frame.cursor - 1]

    def _around(self, step: int, state: State) -> Iterator[Fact]:
        """Settled facts for a sampler to respect: what later steps will make true, then what is true now."""
        objects = self.binder.knowledge.objects
        for later in reversed(self.skeleton.steps[step:]):
            for effect in later.effects:
                fact = self.values.fact(effect.atom)
                if effect.adds and all(map(objects.is_real, fact[1:])):
                    yield fact
        # A choice that is put off leaves placeholders in the state for a while.
        yield from (fact for fact in state if all(map(objects.is_real, fact[1:])))

    def _connect(self, position: int, item: Connect, fresh: bool, state: State) -> set[int] | None:
        frame = self.frames.setdefault(position, Frame())
        if not fresh:
            return set(frame.conflict)
        target = self.values.fact(item.target)
        frame.conflict = set()
        self.states[position + 1] = state
        if target in state:
            return None
        found = self.binder.mover.move(target, state, self.budget.patience)
        if isinstance(found, BoundStep):
            frame.moves = (found,)
            frame.conflict = self.values.owners(found.binding.values())
            self.states[position + 1] = progress(self.binder.evaluator, found.schema, found.binding, state)
            return None
        self.attempt.moves.extend(found.failed)
        self._note(position, item.step, found.reason)
        return self._blame(position, Violation((target, *found.facts), "", exact=bool(found.facts)))

    def _blame(self, position: int, violation: Violation) -> set[int]:
        if not violation.exact:
            return {i for i in self._movers(violation.facts[0]) if i < position}
        owners = self.values.owners({h for fact in violation.facts for h in fact[1:]})
        return {owner for owner in owners if owner < position}

    def _movers(self, fact: Fact) -> set[int]:
        """The choices that might make a fact come true: of its own objects, or of what steps do about its like."""
        names = self.binder.knowledge.schema.influences(str(fact[0]))
        atoms = [effect.atom for step in self.skeleton.steps for effect in step.effects if effect.atom[0] in names]
        handles = {self.values.value(h) for atom in (fact, *atoms) for h in atom[1:]}
        moved = {i for i, frame in self.frames.items() if frame.moves}
        return moved | self.values.owners(handles)

    def _note(self, position: int, step: int, reason: str) -> None:
        """Remember where the attempt got furthest, for the report."""
        if self.surveying:
            return
        if position >= self.attempt.depth:
            steps = self.skeleton.steps
            self.attempt.depth = position
            self.attempt.broke_at = f"step {step + 1}, {steps[step].schema.name}" if step < len(steps) else "the goal"
            self.attempt.reason = reason

    def _bound_steps(self) -> Iterator[BoundStep]:
        late = any(isinstance(item, Rewind) for item in self.items)
        for position, item in enumerate(self.items):
            if isinstance(item, Rewind):
                late = False
            if isinstance(item, Connect):
                yield from self.frames[position].moves
            if isinstance(item, Apply) and not late:
                step = self.skeleton.steps[item.step]
                yield BoundStep(step.schema, self.values.binding(step.binding))
