"""From operators, axioms and the hopes of one moment to the ground task that is searched."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace

from tamp.planning.constraints import Matcher, Place
from tamp.planning.knowledge import Knowledge
from tamp.planning.numbering import Literals, Numbering
from tamp.planning.objects import Fact
from tamp.planning.operators import GroundAxiom, GroundOperator
from tamp.planning.reachability import reachable
from tamp.planning.task import GroundTask, TaskAxiom, TaskEffect, TaskOperator


@dataclass
class Blame:
    """A learnt reluctance: an operator that mentions `handle` is discouraged while one of `facts` holds."""

    handle: int
    facts: dict[Fact, None] = field(default_factory=dict)
    failures: int = 0

    @property
    def weight(self) -> int:
        """What it adds to the cost of an operator."""
        return 30 * self.failures


PLACE = "@place"
"""Predicate of atoms that say how much of a given skeleton is done."""


class TaskBuilder:
    """Builds ground tasks; knows what holds in the initial state and what shall hold in the end."""

    def __init__(
        self,
        knowledge: Knowledge,
        groups: Callable[[Iterable[Fact]], list[list[Fact]]],
        cost: Callable[[GroundOperator], int],
        hidden: str,
        places: tuple[Place, ...],
        forbidden: Matcher,
    ) -> None:
        self._knowledge = knowledge
        self._groups = groups
        self._cost = cost
        self._hidden = hidden
        self._places = places
        self._forbidden = forbidden

    def build(
        self,
        operators: Sequence[GroundOperator],
        axioms: Sequence[GroundAxiom],
        goal: tuple[tuple[Fact, ...], tuple[Fact, ...]],
        blames: dict[int, Blame],
        novel: bool = False,
    ) -> GroundTask:
        """The task of this moment; unreachable operators are left out, and with `novel` those blamed for a failure."""
        knowledge = self._knowledge
        given = [*knowledge.state, *knowledge.hoped_state()]
        state = dict.fromkeys(fact for fact in given if fact[0] != self._hidden)
        usable = [op for op in operators if self._exist(op.binding.values()) and self._holds(op.static, op.absent)]
        usable = [op for op in usable if not self._forbidden(op.schema.name, op.args)]
        if novel:
            usable = [op for op in usable if not any(instance.failures for instance in op.needs)]
        valid = [axiom for axiom in axioms if self._holds(axiom.static, axiom.absent)]
        reached, live, bodies = reachable(state, usable, valid, knowledge)
        number = Numbering(state, reached, bodies, knowledge)
        wanted = number.literals(*goal)
        if wanted is None or not all(f in reached for f in goal[0] if not number.true(f)):
            return GroundTask((), frozenset(), (), (), (), (), solvable=False)
        made = [t for op in live for t in self._operators(op, number, blames, novel)]
        made, wanted = self._in_places(made, wanted, number)
        defined = [
            TaskAxiom(number.of(head), *literals)
            for head in number.axiomatic()
            for body in bodies[head]
            if (literals := number.literals(*body)) is not None
        ]
        atoms = number.atoms()
        groups = tuple(tuple(number.of(f) for f in group) for group in self._groups(atoms))
        initial = frozenset(i for i, f in enumerate(atoms) if f in state or f == (PLACE, 0))
        return GroundTask(atoms, initial, *wanted, tuple(made), tuple(defined), groups)

    def _in_places(
        self, operators: list[TaskOperator], wanted: Literals, number: Numbering
    ) -> tuple[list[TaskOperator], Literals]:
        """Where a skeleton is given, operators that follow it: one for each place in it that they may take."""
        last = len(self._places) - 1
        if last == 0 and self._places[0].gap:
            return operators, wanted
        at = [number.of((PLACE, i)) for i in range(last + 1)]
        made: list[TaskOperator] = []
        for op in operators:
            for i, place in enumerate(self._places):
                here = replace(op, positive=(*op.positive, at[i]))
                if place.gap:
                    made.append(here)
                if place.matches is not None and place.matches(op.source.schema.name, op.source.args):
                    step = (TaskEffect(at[i], adds=False), TaskEffect(at[i + 1], adds=True))
                    made.append(replace(here, effects=(*op.effects, *step)))
        return made, ((*wanted[0], at[last]), wanted[1])

    def _holds(self, static: tuple[Fact, ...], absent: tuple[Fact, ...]) -> bool:
        knowledge = self._knowledge
        marked = ("~", "+")
        return all(f[0][0] in marked or f[0] == "=" or knowledge.usable(f) for f in static) and not any(
            f in knowledge.real for f in absent
        )

    def _exist(self, handles: Iterable[int]) -> bool:
        """Whether objects are real, or may still come from their streams."""
        origins = map(self._knowledge.objects.origin, handles)
        return all(origin is None or origin.alive for origin in origins)

    def _operators(
        self, op: GroundOperator, number: Numbering, blames: dict[int, Blame], novel: bool
    ) -> Iterable[TaskOperator]:
        barred = [number.nogood(facts) for instance in op.needs for facts in instance.nogoods]
        literals = number.literals(op.positive, (*op.negative, *barred))
        if literals is None:
            return
        effects = tuple(e for effect in op.effects if (e := number.effect(effect)) is not None)
        cost = self._cost(op)
        against = [blames[h] for h in dict.fromkeys(op.binding.values()) if h in blames]
        facts = dict.fromkeys(f for blame in against for f in blame.facts if f not in op.positive and number.known(f))
        if not all(blame.facts for blame in against):
            cost += max(blame.weight for blame in against)
        elif facts:
            clear = number.literals(op.positive, (*op.negative, *barred, *facts))
            if clear is not None:
                yield TaskOperator(op, *clear, effects, cost)
            if novel:
                return
            cost += max(blame.weight for blame in against)
        yield TaskOperator(op, *literals, effects, cost)
