"""The ground planning task of one moment: what operators and axioms amount to when the hopes of that moment hold."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace

from tamp.planning.constraints import Matcher, Place
from tamp.planning.grounding import GroundAxiom, GroundEffect, GroundOperator
from tamp.planning.instances import Knowledge
from tamp.planning.objects import Fact


@dataclass(frozen=True, slots=True)
class TaskEffect:
    """Atom `atom` becomes true or false where all of `positive` and none of `negative` hold."""

    atom: int
    adds: bool
    positive: tuple[int, ...] = ()
    negative: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class TaskOperator:
    """An operator over atom numbers. `cost` is what the search minimises: the action's cost and its reluctance."""

    source: GroundOperator
    positive: tuple[int, ...]
    negative: tuple[int, ...]
    effects: tuple[TaskEffect, ...]
    cost: int


@dataclass(frozen=True, slots=True)
class TaskAxiom:
    """Atom `head` holds where all of `positive` and none of `negative` hold."""

    head: int
    positive: tuple[int, ...]
    negative: tuple[int, ...]


@dataclass(frozen=True)
class GroundTask:
    """A STRIPS task with axioms. Atoms are numbered; `goal` is None where it is out of reach even without deletes.

    Attributes:
        groups: sets of atoms of which at most one is true at a time.
    """

    atoms: tuple[Fact, ...]
    initial: frozenset[int]
    goal_positive: tuple[int, ...]
    goal_negative: tuple[int, ...]
    operators: tuple[TaskOperator, ...]
    axioms: tuple[TaskAxiom, ...]
    groups: tuple[tuple[int, ...], ...] = ()
    solvable: bool = True


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


NOGOOD = "@nogood"
"""Predicate of derived atoms that say that a set of facts holds in which a stream is known to fail."""

BROKEN = "@broken"
"""Predicate of derived atoms that say that a conjunction does not hold."""

PLACE = "@place"
"""Predicate of atoms that say how much of a given skeleton is done."""

Literals = tuple[tuple[int, ...], tuple[int, ...]]
Body = tuple[tuple[Fact, ...], tuple[Fact, ...]]


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
        usable = [op for op in operators if self._holds(op.static, op.absent)]
        usable = [op for op in usable if not self._forbidden(op.schema.name, op.args)]
        if novel:
            usable = [op for op in usable if not any(instance.failures for instance in op.needs)]
        valid = [axiom for axiom in axioms if self._holds(axiom.static, axiom.absent)]
        reached, live, bodies = _reachable(state, usable, valid, knowledge)
        number = _Numbering(state, reached, bodies, knowledge)
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
        self, operators: list[TaskOperator], wanted: Literals, number: _Numbering
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
        return all(f[0][0] in marked or f[0] in ("object", "=") or knowledge.usable(f) for f in static) and not any(
            f in knowledge.real for f in absent
        )

    def _operators(
        self, op: GroundOperator, number: _Numbering, blames: dict[int, Blame], novel: bool
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


def _reachable(
    state: dict[Fact, None], operators: list[GroundOperator], axioms: list[GroundAxiom], knowledge: Knowledge
) -> tuple[set[Fact], list[GroundOperator], dict[Fact, list[Body]]]:
    """Atoms, operators and axiom bodies that can be reached when deletes are ignored."""
    waiting: dict[Fact, list[tuple[object, int]]] = {}
    missing: list[int] = []
    things: list[tuple[str, object]] = []
    queue: list[Fact] = list(state)
    reached = set(state)
    live: list[int] = []
    static_true = {f for a in axioms for f in a.positive if knowledge.usable(f)}
    static_true |= {f for op in operators for f in op.positive if knowledge.usable(f)}

    def reach(fact: Fact) -> None:
        if fact not in reached:
            reached.add(fact)
            queue.append(fact)

    def fire(index: int) -> None:
        kind, thing = things[index]
        if kind == "operator":
            live.append(index)
        elif kind == "axiom":
            live.append(index)
            reach(thing.head)  # type: ignore[attr-defined]
        else:
            reach(thing.atom)  # type: ignore[attr-defined]

    ready: list[int] = []

    def watch(kind: str, thing: object, needed: tuple[Fact, ...]) -> None:
        index = len(things)
        things.append((kind, thing))
        needed = tuple(dict.fromkeys(needed))
        missing.append(len(needed))
        for fact in needed:
            waiting.setdefault(fact, []).append((thing, index))
        if not needed:
            ready.append(index)

    for fact in static_true:
        reach(fact)
    for op in operators:
        watch("operator", op, op.positive)
        for effect in op.effects:
            if effect.adds:
                watch("effect", effect, op.positive + effect.positive)
    for axiom in axioms:
        watch("axiom", axiom, axiom.positive)
    for index in ready:
        fire(index)
    while queue:
        for _, index in waiting.get(queue.pop(), ()):
            missing[index] -= 1
            if missing[index] == 0:
                fire(index)
    live.sort()
    bodies: dict[Fact, list[Body]] = {}
    for index in live:
        thing = things[index][1]
        if isinstance(thing, GroundAxiom):
            bodies.setdefault(thing.head, []).append((thing.positive, thing.negative))
    return reached, [thing for i in live if isinstance(thing := things[i][1], GroundOperator)], bodies


class _Numbering:
    """Numbers atoms as they are used, and puts simple derived atoms in their definitions' place."""

    def __init__(
        self, state: dict[Fact, None], reached: set[Fact], bodies: dict[Fact, list[Body]], knowledge: Knowledge
    ) -> None:
        self._state = state
        self._reached = reached
        self._bodies = bodies
        self._knowledge = knowledge
        self._derived = knowledge.schema.derived | {NOGOOD, BROKEN}
        self._recursive = knowledge.schema.recursive
        self._numbers: dict[Fact, int] = {}
        self._axiomatic: dict[Fact, None] = {}

    def true(self, fact: Fact) -> bool:
        """Whether a derived atom holds whatever happens."""
        if fact[0] not in self._derived:
            return False
        free = (not p and self._reached.isdisjoint(n) for p, n in self._bodies.get(fact, ()))
        return self._knowledge.usable(fact) or any(free)

    def nogood(self, facts: tuple[Fact, ...]) -> Fact:
        """A derived atom that holds where all of some facts do."""
        head = (NOGOOD, *facts)
        self._reached.add(head)
        self._bodies[head] = [(facts, ())] if all(f in self._reached for f in facts) else []
        return head

    def known(self, fact: Fact) -> bool:
        """Whether an atom is within reach."""
        return fact in self._reached

    def of(self, fact: Fact) -> int:
        return self._numbers.setdefault(fact, len(self._numbers))

    def atoms(self) -> tuple[Fact, ...]:
        return tuple(self._numbers)

    def axiomatic(self) -> list[Fact]:
        """Derived atoms that need axioms, those that their bodies mention included."""
        done: dict[Fact, None] = {}
        while len(done) < len(self._axiomatic):
            for head in list(self._axiomatic):
                if head not in done:
                    done[head] = None
                    for body in self._bodies[head]:
                        self.literals(*body)
        return list(done)

    def literals(
        self, positive: Iterable[Fact], negative: Iterable[Fact]
    ) -> tuple[tuple[int, ...], tuple[int, ...]] | None:
        """Atom numbers of a conjunction; None where it can never hold."""
        plus: dict[int, None] = {}
        minus: dict[int, None] = {}
        if not all(self._positive(f, plus, minus) for f in positive):
            return None
        if not all(self._negative(f, plus, minus) for f in negative):
            return None
        return None if plus.keys() & minus.keys() else (tuple(plus), tuple(minus))

    def _positive(self, fact: Fact, plus: dict[int, None], minus: dict[int, None]) -> bool:
        if fact not in self._reached:
            return False
        if fact[0] in self._derived:
            if self.true(fact):
                return True
            bodies = self._bodies.get(fact, [])
            if len(bodies) == 1 and all(f[0] not in self._derived for part in bodies[0] for f in part):
                return all(self._positive(f, plus, minus) for f in bodies[0][0]) and all(
                    self._negative(f, plus, minus) for f in bodies[0][1]
                )
            self._axiomatic[fact] = None
        plus[self.of(fact)] = None
        return True

    def _negative(self, fact: Fact, plus: dict[int, None], minus: dict[int, None]) -> bool:
        if fact not in self._reached:
            return True
        if fact[0] in self._derived:
            if self.true(fact):
                return False
            if fact[0] not in self._recursive:
                return all(self._broken(body, plus, minus) for body in self._bodies.get(fact, ()))
            self._axiomatic[fact] = None
        minus[self.of(fact)] = None
        return True

    def _broken(self, body: Body, plus: dict[int, None], minus: dict[int, None]) -> bool:
        """Demand that a conjunction does not hold: one literal is negated, of several any is, by a new derived atom.

        Heuristics see through such positive axioms, but not through the negation of a derived atom.
        """
        positive, negative = body
        if len(positive) + len(negative) == 1:
            return all(self._negative(f, plus, minus) for f in positive) and all(
                self._positive(f, plus, minus) for f in negative
            )
        head = (BROKEN, body)
        if head not in self._bodies:
            self._bodies[head] = [((), (f,)) for f in positive] + [((f,), ()) for f in negative]
            if any(f in self._reached for f in negative) or positive:
                self._reached.add(head)
        return self._positive(head, plus, minus)

    def effect(self, effect: GroundEffect) -> TaskEffect | None:
        if effect.atom not in self._reached:
            return None
        literals = self.literals(effect.positive, effect.negative)
        return None if literals is None else TaskEffect(self.of(effect.atom), effect.adds, *literals)


def axiom_layers(axioms: Iterable[TaskAxiom]) -> dict[int, int]:
    """Head -> stratum: above what its bodies negate, not below what they use.

    Raises:
        ValueError: where a derived atom depends on its own negation.
    """
    axioms = list(axioms)
    layer = {axiom.head: 0 for axiom in axioms}
    for _ in range(len(layer) + 1):
        changed = False
        for axiom in axioms:
            least = max(
                [layer[a] for a in axiom.positive if a in layer] + [layer[a] + 1 for a in axiom.negative if a in layer],
                default=0,
            )
            if least > layer[axiom.head]:
                layer[axiom.head] = least
                changed = True
        if not changed:
            return layer
    raise ValueError("a derived predicate depends on its own negation")
