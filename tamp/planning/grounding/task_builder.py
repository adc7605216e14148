"""From a normalized problem and its facts to a ground problem: relevance, reachability, numbering."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from tamp.planning.constraints import Course, Forbidden
from tamp.planning.grounding.atom_table import Body, Literals, Numbering
from tamp.planning.grounding.blame import Blame, Reluctance
from tamp.planning.grounding.ground_task import GroundTask, TaskAxiom, TaskEffect, TaskOperator
from tamp.planning.grounding.moves import MovePrices, Moves
from tamp.planning.grounding.operators import GroundAxiom, GroundEffect, GroundOperator
from tamp.planning.model.fact_store import Knowledge
from tamp.planning.model.objects import Fact
from tamp.planning.model.stream_instances import Instance


class _Relaxation:
    """Delete relaxation, by counters of the preconditions that are not reached yet (Dowling and Gallier 1984).

    Attributes:
        reached: the atoms reached by now.
        live: the operators and axioms whose preconditions are all reached.
    """

    def __init__(self, atoms: Iterable[Fact]) -> None:
        self.reached = set[Fact]()
        self.live: list[GroundOperator | GroundAxiom] = []
        self._queue: list[Fact] = []
        self._things: list[GroundOperator | GroundAxiom | GroundEffect] = []
        self._missing: list[int] = []
        self._waiting: dict[Fact, list[int]] = {}
        for atom in atoms:
            self._reach(atom)

    def add(self, thing: GroundOperator | GroundAxiom | GroundEffect, needed: Iterable[Fact]) -> None:
        """Have an operator, an axiom or an effect fire once all atoms that it needs are reached."""
        index, needed = len(self._things), dict.fromkeys(needed)
        self._things.append(thing)
        self._missing.append(len(needed))
        for fact in needed:
            self._waiting.setdefault(fact, []).append(index)

    def run(self) -> None:
        """Reach all that can be reached; `live` is in the order in which things were added."""
        fired = [index for index, count in enumerate(self._missing) if not count]
        for index in fired:
            self._fire(index)
        while self._queue:
            for index in self._waiting.get(self._queue.pop(), ()):
                self._missing[index] -= 1
                if self._missing[index] == 0:
                    fired.append(index)
                    self._fire(index)
        things = (self._things[index] for index in sorted(fired))
        self.live = [thing for thing in things if not isinstance(thing, GroundEffect)]

    def _reach(self, fact: Fact) -> None:
        if fact not in self.reached:
            self.reached.add(fact)
            self._queue.append(fact)

    def _fire(self, index: int) -> None:
        thing = self._things[index]
        if isinstance(thing, GroundAxiom):
            self._reach(thing.head)
        elif isinstance(thing, GroundEffect):
            self._reach(thing.atom)


def reachable(
    state: Iterable[Fact], operators: list[GroundOperator], axioms: list[GroundAxiom], knowledge: Knowledge
) -> tuple[set[Fact], list[GroundOperator], dict[Fact, list[Body]]]:
    """What can be reached when deletes are ignored.

    Args:
        state: the atoms that hold at first.
        operators: all that there are.
        axioms: all that there are.
        knowledge: static facts hold as far as it has them usable.

    Returns:
        The atoms, the operators in the order given, and for each head of axioms the bodies that are reached.
    """
    static = {f for axiom in axioms for f in axiom.positive if knowledge.usable(f)}
    static |= {f for op in operators for f in op.positive if knowledge.usable(f)}
    relaxed = _Relaxation((*state, *static))
    for op in operators:
        relaxed.add(op, op.positive)
        for effect in op.effects:
            if effect.adds:
                relaxed.add(effect, op.positive + effect.positive)
    for axiom in axioms:
        relaxed.add(axiom, axiom.positive)
    relaxed.run()
    bodies: dict[Fact, list[Body]] = {}
    for thing in relaxed.live:
        if isinstance(thing, GroundAxiom):
            bodies.setdefault(thing.head, []).append((thing.positive, thing.negative))
    return relaxed.reached, [thing for thing in relaxed.live if isinstance(thing, GroundOperator)], bodies


OPTIMISTIC = "@optimistic"
"""Predicate of atoms that say that the price of assuming a test was paid."""

PLACE = "@place"
"""Predicate of atoms that say how much of a given skeleton is done."""


@dataclass(frozen=True)
class Scope:
    """What a search may look at; everything by default.

    Attributes:
        novel: without streams whose values all failed, and as `unbarred`.
        unbarred: values to which moves failed only where what was in the way is gone.
        arriving: so much at the goal alone.
        sure: without optimistic facts, among real values alone.
        moves: with what the moves cost that are left to binding.
        pairs: these at what each costs between two values.
        exact: a stream with fluents that failed for no named reason is barred only where it is told the same.
        asking: nothing is barred that tests with fluents have said no to: whoever searches asks them.
        among: the only operators; None for all.
    """

    novel: bool = False
    unbarred: bool = False
    arriving: bool = False
    sure: bool = False
    moves: bool = True
    pairs: bool = False
    exact: bool = False
    asking: bool = False
    among: frozenset[GroundOperator] | None = None

    @property
    def clear(self) -> bool:
        """Whether what is in the way of a move must be gone, before an operator as at the goal."""
        return self.novel or self.unbarred


EVERYTHING = Scope()


class TaskBuilder:
    """Builds ground tasks; knows what holds in the initial state and what shall hold in the end."""

    def __init__(
        self,
        knowledge: Knowledge,
        groups: Callable[[Iterable[Fact]], list[list[Fact]]],
        cost: Callable[[GroundOperator], int],
        reluctance: Callable[[Instance], int],
        moves: MovePrices,
        course: Course,
        forbidden: Forbidden,
        frozen: frozenset[int] = frozenset(),
    ) -> None:
        self._knowledge = knowledge
        self._groups = groups
        self._cost = cost
        self._reluctance = reluctance
        self._moves = moves
        self._course = course
        self._forbidden = forbidden
        self._frozen = frozen

    def build(
        self,
        operators: Sequence[GroundOperator],
        axioms: Sequence[GroundAxiom],
        goal: tuple[tuple[Fact, ...], tuple[Fact, ...]],
        blames: dict[int, Blame],
        scope: Scope = EVERYTHING,
    ) -> GroundTask:
        """The task of this moment, as far as a search may look; unreachable operators are left out."""
        knowledge, hidden = self._knowledge, self._moves.fluent
        self._note_certain(operators, axioms)
        given = [*knowledge.state, *(() if scope.sure else knowledge.optimistic_state())]
        state = dict.fromkeys(fact for fact in given if fact[0] != hidden)
        usable = self._usable(operators, scope)
        assumed: dict[Fact, Instance] = {}
        valid = self._valid(axioms, scope)
        # Where there may well be no plan, as in a novel search, each price would double what must be searched.
        valid = self._surest(valid) if scope.novel else [a if a.certain else self._priced(a, assumed) for a in valid]
        reached, live, bodies = reachable({**state, **dict.fromkeys(assumed)}, usable, valid, knowledge)
        moving = self._moves.over(live, given, goal[0], scope.pairs) if scope.moves else Moves()
        reached.update(fact for group in moving.groups for fact in group)
        number = Numbering(state, reached, bodies, knowledge)
        ends = tuple(fact for fact in goal[0] if fact[0] != hidden or moving.fluent)
        last = Reluctance([h for f in goal[0] if f[0] == hidden for h in f[1:]], blames, knowledge)
        barring = last.barring(goal[0], number) if scope.clear or scope.arriving else ()
        wanted = number.literals(ends, (*goal[1], *barring))
        follows = any(
            set(bodies[f]) <= set(bodies.get(g, ()))
            for f in ends
            if f in bodies and not number.true(f)
            for g in goal[1]
        )
        if wanted is None or follows or not all(f in reached for f in ends if not number.true(f)):
            return GroundTask((), frozenset(), (), (), (), (), solvable=False)
        made = [t for op in live for t in self._operators(op, number, blames, moving, scope)]
        made, wanted = self._on_course(made, wanted, number)
        made += moving.operators(number.of)
        made += [
            TaskOperator(None, (), (), (TaskEffect(number.of(fact), adds=True),), self._reluctance(test))
            for fact, test in assumed.items()
        ]
        defined = [
            TaskAxiom(number.of(head), *literals)
            for head in number.axiomatic()
            for body in bodies[head]
            if (literals := number.literals(*body)) is not None
        ]
        atoms = number.atoms()
        groups = tuple(tuple(number.of(f) for f in group) for group in (*self._groups(atoms), *moving.groups))
        begun: set[Fact] = {(PLACE, start.number) for start in self._course.starts}
        begun |= {(PLACE, "done") for start in self._course.starts if self._course.done(start)}
        initial = frozenset(i for i, f in enumerate(atoms) if f in state or f in begun or f in moving.initial)
        return GroundTask(atoms, initial, *wanted, tuple(made), tuple(defined), groups)

    def _usable(self, operators: Iterable[GroundOperator], scope: Scope) -> list[GroundOperator]:
        """The operators that a search may use, with those of their effects that may take place."""
        if scope.among is not None:
            operators = [op for op in operators if op in scope.among]
        if scope.sure:
            operators = [op for op in operators if op.certain or self._is_sure(op.static, op.binding.values())]
        usable = [op for op in operators if op.certain or self._is_usable(op)]
        usable = [self._in_effect(op) for op in usable if not self._forbidden(op.schema.name, op.args)]
        if self._frozen:
            usable = [op for op in usable if not any(self._thaws(effect) for effect in op.effects)]
        if scope.novel:
            usable = [op for op in usable if not any(instance.failures for instance in op.needs)]
        return usable

    def _valid(self, axioms: Iterable[GroundAxiom], scope: Scope) -> list[GroundAxiom]:
        """The axioms whose static facts may hold, or in a sure search are known to."""
        if scope.sure:
            axioms = [axiom for axiom in axioms if axiom.certain or self._is_sure(axiom.static, axiom.head[1:])]
        return [axiom for axiom in axioms if axiom.certain or self._holds(axiom.static, axiom.absent)]

    def _priced(self, axiom: GroundAxiom, assumed: dict[Fact, Instance]) -> GroundAxiom:
        """An axiom that wants the price paid of each test that it assumes: axioms themselves cost nothing.

        What is for nothing needs no operator: a search would look at each set of such tests.
        """
        found = {(OPTIMISTIC, *fact): test for fact, test in self._assumed_tests(axiom) if self._reluctance(test)}
        assumed.update(found)
        return replace(axiom, positive=(*axiom.positive, *found)) if found else axiom

    def _assumed_tests(self, axiom: GroundAxiom) -> Iterator[tuple[Fact, Instance]]:
        """The facts of an axiom that only tests may certify yet, each with such a test."""
        for fact in axiom.static:
            if fact[0] in self._knowledge.schema.askable and fact not in self._knowledge.real:
                promised = [p for p in self._knowledge.producers.get(fact, ()) if p.alive]
                if promised and all(p.external.is_test for p in promised):
                    yield fact, promised[0]

    def _note_certain(self, operators: Iterable[GroundOperator], axioms: Iterable[GroundAxiom]) -> None:
        """Note what will be usable whatever streams may give: it need not be looked at again in every search."""
        real, is_real = self._knowledge.real, self._knowledge.objects.is_real
        for op in operators:
            if not op.certain and not op.absent and all(map(is_real, op.binding.values())):
                op.certain = all(fact in real for fact in op.static)
        for axiom in axioms:
            if not axiom.certain and not axiom.absent and all(map(is_real, axiom.head[1:])):
                axiom.certain = all(fact in real for fact in axiom.static)

    def _is_usable(self, op: GroundOperator) -> bool:
        """Whether what an operator rests on may hold, as far as it is known."""
        return self._exist(op.binding.values()) and self._holds(op.static, op.absent)

    def _is_sure(self, static: tuple[Fact, ...], handles: Iterable[int]) -> bool:
        """Whether static facts are known to hold, of real objects alone."""
        knowledge = self._knowledge
        if not all(map(knowledge.objects.is_real, handles)):
            return False
        return all(fact in knowledge.real or not self._is_optimistic(fact) for fact in static)

    def _is_optimistic(self, fact: Fact) -> bool:
        """Whether streams promise a fact; or, of an object, whether it is one that they promise.

        What a test says of a state is asked in each that a plan leads to: of real objects there is no more to know.
        """
        promised = fact in self._knowledge.producers and fact[0] not in self._knowledge.schema.state_tests
        return promised or not all(map(self._knowledge.objects.is_real, fact[1:]))

    def _surest(self, axioms: list[GroundAxiom]) -> list[GroundAxiom]:
        """Axioms without those that assume a test where there are others with the same head."""
        doubtful = [not axiom.certain and any(True for _ in self._assumed_tests(axiom)) for axiom in axioms]
        sure = {axiom.head for axiom, doubt in zip(axioms, doubtful, strict=True) if not doubt}
        return [a for a, doubt in zip(axioms, doubtful, strict=True) if not doubt or a.head not in sure]

    def _on_course(
        self, operators: list[TaskOperator], wanted: Literals, number: Numbering
    ) -> tuple[list[TaskOperator], Literals]:
        """Where skeletons are given, operators that follow one: one for each progress from which they may be taken.

        All of them are open at the start; the first operator closes those that it does not follow.
        """
        if self._course.free:
            return operators, wanted
        at = {start: number.of((PLACE, start.number)) for start in self._course.starts}
        done = number.of((PLACE, "done"))
        begun = {*at.values(), done} if any(map(self._course.done, at)) else set(at.values())
        made: list[TaskOperator] = []
        queue = list(at)
        for before in queue:  # grows while it is walked through
            for op in operators:
                here = replace(op, positive=(*op.positive, at[before]))
                source = op.source
                assert source is not None
                for after in self._course.after(before, source.schema.name, source.args, optimistic=True):
                    if after not in at:
                        at[after] = number.of((PLACE, len(at)))
                        queue.append(after)
                    now = {at[after], done} if self._course.done(after) else {at[after]}
                    past = begun if before in self._course.starts else {at[before]}
                    step = [TaskEffect(atom, adds=False) for atom in sorted(past - now)]
                    step += [TaskEffect(atom, adds=True) for atom in sorted(now - {at[before]})]
                    made.append(replace(here, effects=(*op.effects, *step)))
        return made, ((*wanted[0], done), wanted[1])

    def is_possible(self, op: GroundOperator) -> bool:
        """Whether all that an operator rests on may hold, of what streams have given or may give, and never changes."""
        return self._holds(op.static, op.absent, self._knowledge.possible)

    def _thaws(self, effect: GroundEffect) -> bool:
        """Whether an effect deletes what holds of a frozen object."""
        return not effect.adds and len(effect.atom) > 1 and effect.atom[1] in self._frozen

    def _in_effect(self, op: GroundOperator) -> GroundOperator:
        """An operator without the effects whose conditions are known never to hold."""
        effects = [e for e in op.effects if not (e.static or e.absent) or self._holds(e.static, e.absent)]
        return op if len(effects) == len(op.effects) else replace(op, effects=effects)

    def _holds(
        self, static: tuple[Fact, ...], absent: tuple[Fact, ...], may: Callable[[Fact], bool] | None = None
    ) -> bool:
        knowledge = self._knowledge
        may = may or knowledge.usable
        marked = ("~", "+")
        return all(f[0][0] in marked or f[0] == "=" or may(f) for f in static) and not any(
            f in knowledge.real for f in absent
        )

    def _exist(self, handles: Iterable[int]) -> bool:
        """Whether objects are real, or may still come from their streams."""
        origins = map(self._knowledge.objects.origin, handles)
        return all(origin is None or origin.alive for origin in origins)

    def _operators(
        self, op: GroundOperator, number: Numbering, blames: dict[int, Blame], moves: Moves, scope: Scope
    ) -> Iterable[TaskOperator]:
        needs = (i for i in op.needs if not (scope.asking and i.external.is_state_test))
        barred = [head for instance in needs for head in _nogoods(instance, number, scope.exact)]
        positive = (*op.positive, *moves.wanted(op))
        literals = number.literals(positive, (*op.negative, *barred))
        if literals is None:
            return
        effects = tuple(e for effect in op.effects if (e := number.effect(effect)) is not None)
        effects += moves.changed(op, number.of)
        cost = self._cost(op)
        reluctance = Reluctance(op.binding.values(), blames, self._knowledge)
        facts = reluctance.barring(op.positive, number)
        if reluctance.vague:
            cost += reluctance.weight
        elif facts or reluctance.spoilt(op.positive):
            clear = number.literals(positive, (*op.negative, *barred, *facts))
            if clear is not None and not reluctance.spoilt(op.positive):
                yield TaskOperator(op, *clear, effects, cost)
            if scope.clear:
                return
            cost += reluctance.weight
        yield TaskOperator(op, *literals, effects, cost)


def _nogoods(instance: Instance, number: Numbering, exact: bool) -> Iterator[Fact]:
    """Atoms that hold where a stream with fluents is known to have nothing to give, or guessed, unless `exact`.

    What most inputs of a kind failed for is guessed to be in the way of them all, also of those that are assumed.
    """
    for facts, named in instance.nogoods.items():
        if named or not exact:
            yield number.nogood(facts)
    for facts in instance.record.suspects if not exact else ():
        if facts not in instance.nogoods:
            yield number.nogood(facts)
    for told in instance.refusals if exact else ():
        yield number.nogood(told, instance.external.fluents)
