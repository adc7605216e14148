"""A partial assignment of values to a skeleton's optimistic parameters, walked through state by state."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from tamp import clock
from tamp.planning.binding.attempt import Attempt, BoundStep, Budget, Frame
from tamp.planning.binding.skeleton import Apply, Choose, Connect, Rewind, Skeleton
from tamp.planning.model.fact_store import Knowledge
from tamp.planning.model.objects import Fact
from tamp.planning.model.state import State, Violation
from tamp.planning.model.stream_instances import Instance
from tamp.planning.sampling.stream_calls import Sampling

Begin = Mapping[tuple[Instance, tuple[int, ...]], int]
"""What a skeleton leaves open, and the inputs that were chosen for it -> the number of a stream's result."""


class Assignment:
    """Values of placeholders; a choice is known by its position among a skeleton's items."""

    def __init__(self) -> None:
        self._values: dict[int, int] = {}
        self._owners: dict[int, list[int]] = {}

    def take(self, position: int, placeholders: Iterable[int], handles: Iterable[int]) -> None:
        """A choice gives placeholders their values."""
        for placeholder, handle in zip(placeholders, handles, strict=True):
            self._values[placeholder] = handle
            self._owners.setdefault(handle, []).append(position)

    def release(self, position: int, placeholders: Iterable[int], handles: Iterable[int]) -> None:
        """A choice takes its values back."""
        for placeholder, handle in zip(placeholders, handles, strict=True):
            self._values.pop(placeholder, None)
            self._owners[handle].remove(position)

    def owners(self, handles: Iterable[int]) -> set[int]:
        """The choices that took any of these values."""
        return {owner for handle in handles for owner in self._owners.get(handle, ())}

    def value(self, handle: int) -> int:
        """What stands for a handle: the value of a placeholder that has one, otherwise itself."""
        return self._values.get(handle, handle)

    def all(self) -> dict[int, int]:
        """Placeholder -> its value."""
        return dict(self._values)

    def fact(self, fact: Fact) -> Fact:
        """A fact with values for its placeholders."""
        return (fact[0], *[self._values.get(h, h) for h in fact[1:]])

    def binding(self, binding: dict[str, int]) -> dict[str, int]:
        """A binding with values for its placeholders."""
        return {name: self._values.get(h, h) for name, h in binding.items()}


class Walk:
    """An attempt under way.

    Attributes:
        items: of the skeleton.
        frames: item -> the choice made there.
        values: placeholder -> what stands for it.
        states: item -> what holds when it is reached.
        attempt: what will be told of it.
        jumps: failed checks so far.
        spared: how many of its calls do not count, as their streams seldom give anything.
        turn: how many attempts at the same choices there were before.
        begin: which results are tried first, where those are not the first ones.
        following: choice -> what an optimizer has found for it together with an earlier choice.
        surveying: whether it has failed, and the rest is looked at for further conflicts only.
    """

    def __init__(
        self,
        skeleton: Skeleton,
        budget: Budget,
        knowledge: Knowledge,
        sampling: Sampling,
        deadline: float,
        turn: int = 0,
        begin: Begin | None = None,
    ) -> None:
        self.skeleton = skeleton
        self.budget = budget
        self.items = skeleton.items
        self.frames: dict[int, Frame] = {}
        self.values = Assignment()
        self.states: dict[int, State] = {0: State(knowledge.state)}
        self.attempt = Attempt()
        self.following: dict[int, tuple[int, ...]] = {}
        self.jumps = 0
        self.spared = 0.0
        self.turn = turn
        self.begin = begin or {}
        self.surveying = False
        self._knowledge = knowledge
        self._sampling = sampling
        self._deadline = deadline
        self._first_draw = sampling.draws
        self._old = sampling.news

    @property
    def surprised(self) -> bool:
        """Whether it has brought facts that the search did not know of when it found the skeleton."""
        return self._sampling.news > self._old

    def spent(self) -> bool:
        """Whether it may go on no longer."""
        return self._beyond(1.0) or clock.now() > self._deadline

    @property
    def narrow(self) -> bool:
        """Whether choices that follow from others are given ever fewer values: from half of what may be spent on."""
        return self._beyond(0.5)

    def _beyond(self, share: float) -> bool:
        """Whether more than a share of what it may spend was spent."""
        draws = self._sampling.draws - self._first_draw - self.spared
        return draws > share * (self.budget.draws + 4 * len(self.items)) or self.jumps > share * self.budget.jumps

    def show_values(self) -> None:
        """Let the search know the values that are chosen by now."""
        for frame in self.frames.values():
            for handle in frame.outputs:
                self._knowledge.show(handle)

    def given_up(self) -> Attempt:
        """The attempt, ended before all was tried: what failed so far is to blame."""
        for frame in self.frames.values():
            self.attempt.blamed.update(frame.culprits)
        return self.attempt

    def undo(self, target: int, position: int) -> None:
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

    def blame(self, position: int, violation: Violation) -> set[int]:
        """The earlier choices that may have caused a violation."""
        if not violation.exact:
            return {i for fact in violation.facts for i in self._movers(fact) if i < position}
        owners = self.values.owners({h for fact in violation.facts for h in fact[1:]})
        return {owner for owner in owners if owner < position}

    def _movers(self, fact: Fact) -> set[int]:
        """The choices that might make a fact come true: of its own objects, or of what steps do about its like."""
        names = self._knowledge.schema.influences(str(fact[0]))
        atoms = [effect.atom for step in self.skeleton.steps for effect in step.effects if effect.atom[0] in names]
        handles = {self.values.value(h) for atom in (fact, *atoms) for h in atom[1:]}
        moved = {i for i, frame in self.frames.items() if frame.moves}
        return moved | self.values.owners(handles)

    def note(self, position: int, step: int, reason: str) -> None:
        """Remember where the attempt got furthest, for the report."""
        if self.surveying:
            return
        if position >= self.attempt.depth:
            steps = self.skeleton.steps
            self.attempt.depth = position
            self.attempt.broke_at = f"step {step + 1}, {steps[step].schema.name}" if step < len(steps) else "the goal"
            self.attempt.reason = reason

    def bound_steps(self) -> Iterator[BoundStep]:
        """The actions of the whole skeleton with the values found, connectors included."""
        last_pass = max((i for i, item in enumerate(self.items) if isinstance(item, Rewind)), default=0)
        for position, item in enumerate(self.items):
            if isinstance(item, Connect):
                yield from self.frames[position].moves
            if isinstance(item, Apply) and position >= last_pass:
                step = self.skeleton.steps[item.step]
                yield BoundStep(step.schema, self.values.binding(step.binding))
