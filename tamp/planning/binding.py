"""Binding a skeleton: choose real values for its placeholders by conflict-directed backjumping.

A check that fails names the values that made it fail; the search for values goes back to the last choice of one of
them, past all choices that could not have helped (Prosser, "Hybrid algorithms for the constraint satisfaction
problem", 1993). Values come from generators, so a choice is given up after a number of values that grows from one
attempt to the next.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from tamp.planning.connectors import Connector, Connectors
from tamp.planning.constraints import Matcher
from tamp.planning.evaluate import Evaluator, State, Violation
from tamp.planning.instances import Instance, Knowledge, ground
from tamp.planning.normal import ActionSchema, Condition
from tamp.planning.objects import Fact
from tamp.planning.sampling import Sampling
from tamp.planning.schema import External
from tamp.planning.skeleton import Apply, Check, Choose, Connect, Item, Rewind, Skeleton


@dataclass(frozen=True)
class Budget:
    """How much one attempt may spend: counts, so that the outcome does not depend on the machine's load.

    Attributes:
        values: values tried for one choice before it is given up.
        draws: calls of streams with outputs in the whole attempt, on top of four for each item of the skeleton.
        patience: draws in a row that may bring nothing before a choice is given up.
        jumps: failed checks in the whole attempt.
    """

    values: int = 6
    draws: int = 60
    patience: int = 6
    jumps: int = 1000

    def grown(self, attempts: int) -> Budget:
        """The budget after some failed attempts: each doubles it, up to a bound."""
        factor = 2 ** min(attempts, 6)
        return Budget(self.values * factor, self.draws * factor, self.patience * factor, self.jumps * factor)


@dataclass(frozen=True)
class BoundStep:
    """An action with real objects for all variables of its condition."""

    schema: ActionSchema
    binding: dict[str, int]

    @property
    def args(self) -> tuple[int, ...]:
        """Handles of the action's own parameters."""
        return tuple(self.binding[t] if isinstance(t, str) else t for t in self.schema.parameters)


@dataclass
class Attempt:
    """What came of binding a skeleton.

    Attributes:
        steps: the bound actions, connectors included; None where it failed.
        blamed: real instances whose values all led to conflicts.
        motions: connector moves that failed: (where it should end, facts in the way).
        nogoods: streams with fluents that have nothing to give: (stream, inputs, facts in which that is so, whether
            the sampler named them).
        exhaustive: whether nothing was left untried, so that failure is final for the values there are.
    """

    steps: tuple[BoundStep, ...] | None = None
    blamed: dict[Instance, None] = field(default_factory=dict)
    motions: list[tuple[int, int, tuple[Fact, ...]]] = field(default_factory=list)
    nogoods: list[tuple[External, tuple[int, ...], tuple[Fact, ...], bool]] = field(default_factory=list)
    exhaustive: bool = True
    broke_at: str = ""
    reason: str = ""
    depth: int = -1


@dataclass
class _Frame:
    """The choice of one item: which instance, which of its results, and what made earlier values fail."""

    instance: Instance | None = None
    cursor: int = 0
    tried: int = 0
    conflict: set[int] = field(default_factory=set)
    outputs: tuple[int, ...] = ()
    moves: tuple[BoundStep, ...] = ()
    culprits: dict[Instance, None] = field(default_factory=dict)


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
        self.connectors = connectors
        self.forbidden = forbidden
        self.deadline = deadline

    def bind(self, skeleton: Skeleton, budget: Budget) -> Attempt:
        """Try to find values for everything that a skeleton leaves open."""
        return _Run(self, skeleton, budget).run()

    def progress(self, step: ActionSchema, binding: dict[str, int], state: State) -> State:
        """The state after an action."""
        added: dict[Fact, None] = {}
        deleted: set[Fact] = set()
        for effect in step.effects:
            bindings: Iterable[dict[str, int]] = (binding,)
            if effect.condition != Condition():
                bindings = [b for b, _ in self.evaluator.satisfy(effect.condition, binding, state)]
            for found in bindings:
                fact = ground(effect.atom, found)
                if effect.positive:
                    added[fact] = None
                else:
                    deleted.add(fact)
        kept = [fact for fact in state if fact not in deleted or fact in added]
        return State([*kept, *added])


class _Run:
    """One attempt."""

    def __init__(self, binder: Binder, skeleton: Skeleton, budget: Budget) -> None:
        self.binder = binder
        self.skeleton = skeleton
        self.budget = budget
        self.items = skeleton.items
        self.frames: dict[int, _Frame] = {}
        self.values: dict[int, int] = {}  # placeholder -> handle
        self.owners: dict[int, list[int]] = {}  # handle -> choices that took it
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
                self.attempt.exhaustive = False
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
            if isinstance(item, Choose | Check | Apply) and all(is_real(self.values.get(h, h)) for h in handles):
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

    def _release(self, position: int, frame: _Frame) -> None:
        item = self.items[position]
        if isinstance(item, Choose) and frame.outputs:
            for placeholder, handle in zip(item.template.placeholders, frame.outputs, strict=True):
                self.values.pop(placeholder, None)
                self.owners[handle].remove(position)
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
            violation = self.binder.evaluator.violation(self._real(item.fact), item.positive, state)
            if violation is not None:
                self._note(position, item.step, violation.reason)
                return self._blame(position, violation)
        if isinstance(item, Apply):
            step = BoundStep(self.skeleton.steps[item.step].schema, self._bound(self.skeleton.steps[item.step].binding))
            if self.binder.forbidden(step.schema.name, step.args):
                self._note(position, item.step, "the action is forbidden with these values")
                return self._blame(position, Violation(((step.schema.name, *step.args),), ""))
            state = self.binder.progress(step.schema, step.binding, state)
        if isinstance(item, Rewind):
            state = self.states[0]
        self.states[position + 1] = state
        return None

    def _choose(self, position: int, item: Choose, fresh: bool, state: State) -> set[int] | None:
        frame = self.frames.setdefault(position, _Frame())
        template = item.template
        inputs = tuple(self.values.get(h, h) for h in template.inputs)
        wanted = template.external.fluents
        fluents = tuple(f for f in state if f[0] in wanted) if wanted else ()
        instance = self.binder.knowledge.instance(template.external, inputs, fluents)
        if fresh:
            parents = {owner for h in inputs for owner in self.owners.get(h, ())}
            parents |= {owner for f in fluents for h in f[1:] for owner in self.owners.get(h, ())}
            frame.instance, frame.cursor, frame.tried, frame.conflict = instance, 0, 0, parents
            frame.culprits = {}
        for fact in instance.domain:
            if not self.binder.evaluator.given(fact):
                self._note(position, item.step, f"{self.binder.knowledge.objects.text(fact)} does not hold")
                frame.culprits[instance] = None
                return set(frame.conflict)
        outputs = self._next(frame, instance, item, state)
        if outputs is None:
            frame.culprits[instance] = None
            if fluents and instance.exhausted and not instance.results:
                causes = next((facts for _, facts in instance.reasons if facts), ())
                self.attempt.nogoods.append((template.external, inputs, causes or fluents, bool(causes)))
            reasons = max(instance.reasons.items(), key=lambda pair: pair[1], default=(("no further value", ()), 0))
            name = template.external.name
            self._note(position, item.step, f"{name}: {reasons[0][0]}")
            return set(frame.conflict)
        frame.outputs = outputs
        for placeholder, handle in zip(template.placeholders, outputs, strict=True):
            self.values[placeholder] = handle
            self.owners.setdefault(handle, []).append(position)
        self.states[position + 1] = state
        return None

    def _next(self, frame: _Frame, instance: Instance, item: Choose, state: State) -> tuple[int, ...] | None:
        """The next value of a choice: one that was sampled before, or a new one."""
        if frame.tried >= self.budget.values:
            self.attempt.exhaustive &= instance.exhausted and frame.cursor >= len(instance.results)
            return None
        misses = 0
        while frame.cursor >= len(instance.results):
            if instance.exhausted:
                return None
            if misses >= self.budget.patience or self._spent():
                self.attempt.exhaustive = False
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
                fact = self._real(effect.atom)
                if effect.adds and all(map(objects.is_real, fact[1:])):
                    yield fact
        yield from state

    def _connect(self, position: int, item: Connect, fresh: bool, state: State) -> set[int] | None:
        frame = self.frames.setdefault(position, _Frame())
        target = self._real(item.target)
        if target in state:
            if not fresh:
                return set(frame.conflict)
            frame.conflict = set()
            self.states[position + 1] = state
            return None
        if not fresh:
            return set(frame.conflict)
        blame: dict[Fact, None] = {}
        for connector in self.binder.connectors.connectors:
            for move in self._moves(connector, target, state, blame):
                frame.moves = (move,)
                frame.conflict = {o for h in move.binding.values() for o in self.owners.get(h, ())}
                self.states[position + 1] = self.binder.progress(move.schema, move.binding, state)
                return None
        self._note(position, item.step, self.attempt_reason)
        return self._blame(position, Violation((target, *blame), "", exact=bool(blame)))

    attempt_reason = "no action leads from one to the other"

    def _moves(self, connector: Connector, target: Fact, state: State, blame: dict[Fact, None]) -> Iterator[BoundStep]:
        """The connector's action from where the fluent is to `target`, once its streams have given what it needs."""
        binding = dict(zip(connector.after[1:], target[1:], strict=True))
        start: dict[str, int] = {t: h for t, h in binding.items() if isinstance(t, str)}
        given = self.binder.evaluator.given
        for found, support in list(self.binder.evaluator.satisfy(connector.fluents, start, state)):
            complete = self._sampled(connector, found, state, blame, target, support)
            if complete is not None and all(given(ground(p, complete)) for p in connector.static):
                yield BoundStep(connector.schema, complete)

    def _sampled(
        self,
        connector: Connector,
        binding: dict[str, int],
        state: State,
        blame: dict[Fact, None],
        target: Fact,
        support: tuple[Fact, ...],
    ) -> dict[str, int] | None:
        for external, pattern in connector.streams:
            certified = next(c for c in external.certified if c[0] == pattern[0])
            terms = dict(zip(certified[1:], pattern[1:], strict=True))
            inputs = tuple(binding[str(terms[v])] for v in external.inputs)
            fluents = tuple(f for f in state if f[0] in external.fluents)
            instance = self.binder.knowledge.instance(external, inputs, fluents)
            misses = 0
            if all(map(self.binder.evaluator.given, instance.domain)):
                while not instance.results and not instance.exhausted and misses < self.budget.patience:
                    misses += not self.binder.sampling.draw(instance, tuple(state))
                    if time.monotonic() > self.binder.deadline:
                        break
            if not instance.results:
                self.attempt.exhaustive &= instance.exhausted
                (reason, facts), _ = max(
                    instance.reasons.items(), key=lambda pair: pair[1], default=(("nothing found", ()), 0)
                )
                self.attempt_reason = f"{external.name}: {reason}"
                blame.update(dict.fromkeys((*support, *facts) if facts or not fluents else (*support, *fluents)))
                source = binding[str(connector.before[connector.position])]
                self.attempt.motions.append((source, target[connector.position], facts))
                return None
            outputs = dict(zip(external.outputs, instance.results[0], strict=True))
            for variable, term in terms.items():
                if variable in outputs and isinstance(term, str):
                    binding = {**binding, term: outputs[str(variable)]}
        return binding

    def _blame(self, position: int, violation: Violation) -> set[int]:
        if not violation.exact:
            return {i for i, frame in self.frames.items() if i < position and (frame.outputs or frame.moves)}
        handles = {h for fact in violation.facts for h in fact[1:]}
        return {owner for h in handles for owner in self.owners.get(h, ()) if owner < position}

    def _note(self, position: int, step: int, reason: str) -> None:
        """Remember where the attempt got furthest, for the report."""
        if self.surveying:
            return
        if position >= self.attempt.depth:
            steps = self.skeleton.steps
            self.attempt.depth = position
            self.attempt.broke_at = f"step {step + 1}, {steps[step].schema.name}" if step < len(steps) else "the goal"
            self.attempt.reason = reason

    def _real(self, fact: Fact) -> Fact:
        return (fact[0], *[self.values.get(h, h) for h in fact[1:]])

    def _bound(self, binding: dict[str, int]) -> dict[str, int]:
        return {name: self.values.get(h, h) for name, h in binding.items()}

    def _bound_steps(self) -> Iterator[BoundStep]:
        late = any(isinstance(item, Rewind) for item in self.items)
        for position, item in enumerate(self.items):
            if isinstance(item, Rewind):
                late = False
            if isinstance(item, Connect):
                yield from self.frames[position].moves
            if isinstance(item, Apply) and not late:
                step = self.skeleton.steps[item.step]
                yield BoundStep(step.schema, self._bound(step.binding))


__all__ = ["Attempt", "Binder", "BoundStep", "Budget", "Item"]
