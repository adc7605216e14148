"""What kind of predicate is which, and the problem in normal form: what every part of the planner looks up."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cached_property

from tamp.language import FunctionStream, PredicateStream, Rule, Stream
from tamp.planning.model.awaited import await_domains
from tamp.planning.model.external import External
from tamp.planning.model.momentary import ask_for_any
from tamp.planning.model.normal_form import ActionSchema, AxiomSchema, Condition, NormalDomain, normalise
from tamp.planning.model.objects import Fact, Objects, Part, Pattern
from tamp.planning.problem import Problem, StreamInfo

FALSE_MARK = "~"
"""Prefix of the pseudo-predicate of atoms that a test has refuted."""
TRUE_MARK = "+"
"""Prefix of the pseudo-predicate of atoms that a test has confirmed, where nothing may be assumed."""


VALUED_MARK = "@valued "
"""Prefix of the pseudo-predicate of arguments for which the initial state gives a function's value."""


def valued(function: str) -> str:
    """The pseudo-predicate of a function's given values."""
    return VALUED_MARK + function


class Schema:
    """A problem's domain, goal and streams in normal form, with its constants as handles.

    Attributes:
        externals: streams, tests and predicates by name, in the order of the file.
        functions: function streams by name.
        tests: predicate -> the tests that decide it; only predicates that nothing else certifies.
        askable: predicate -> the tests that may certify it, whatever else does.
        state_tests: predicate -> the tests with fluents that decide it in each state anew.
        shown: what streams with fluents are told though no action changes it.
        guarded: what streams certify for as long as their domain holds, which actions change.
        part: the part of a fluent that has a name of its own inside the planner; None where there is none.
    """

    def __init__(self, problem: Problem, objects: Objects, priced: bool = True) -> None:
        """`priced`: whether costs count, so that an action without one is not possible."""
        domain, streams = problem.parsed_domain, problem.parsed_streams
        self.problem = problem
        self.objects = objects
        for constant in domain.constants.values():
            objects.intern(constant.value)
        normal = normalise(domain, problem.goal_formula, objects)
        rules = tuple(axiom for rule in streams.rules for axiom in self._rule(rule))
        self.domain = domain
        self.functions: dict[str, FunctionStream] = {f.name: f for f in streams.functions}
        self.actions = normal.actions
        if priced:
            self.actions = tuple(a for action in normal.actions for a in self._where_cost_is_defined(action))
        self.axioms: tuple[AxiomSchema, ...] = normal.axioms + rules
        self.goal = normal.goal
        self.fluents = normal.fluents
        self.derived = normal.derived | {str(axiom.head[0]) for axiom in rules}
        declared: tuple[Stream | PredicateStream, ...] = (*streams.streams, *streams.predicates)
        changing = frozenset(name for name in self.fluents | self.derived if self.influences(name) & self.fluents)
        externals = {stream.name: self._external(stream) for stream in declared}
        given = {atom.predicate for atom in problem.initial_state.facts}
        externals, self.axioms = ask_for_any(externals, self.axioms, self._asked_besides(externals), given)
        self.externals, axioms = await_domains(externals, changing, self.fluents, domain.types)
        self.axioms += axioms
        told = frozenset(name for external in self.externals.values() for name in external.fluents)
        self.shown = told - self.fluents - self.derived
        self.guarded = frozenset(str(axiom.head[0]) for axiom in axioms)
        self.derived |= self.guarded
        self.part: Part | None = None
        self.tests = self._tests()
        self.askable = self._askable()
        self.state_tests = self._certifiers(lambda external: external.is_state_test)
        self.normal: NormalDomain = normal

    def with_actions(self, actions: tuple[ActionSchema, ...]) -> Schema:
        """The same with other actions."""
        made = copy.copy(self)
        for name in ("wanted", "asked_for", "conditional", "doubted", "ambivalent", "recursive", "undecided"):
            made.__dict__.pop(name, None)
        made.actions = actions
        return made

    def with_part(
        self, part: Part, actions: tuple[ActionSchema, ...], axioms: tuple[AxiomSchema, ...], goal: Condition
    ) -> Schema:
        """The same with a part of a fluent under its own name, as these actions, axioms and goal have it."""
        made = self.with_actions(actions)
        made.part, made.axioms, made.goal = part, axioms, goal
        made.fluents = self.fluents | {part.name}
        made.externals = {
            name: replace(e, fluents=(*e.fluents, part.name)) if part.fluent in e.fluents else e
            for name, e in self.externals.items()
        }
        made.tests, made.askable = made._tests(), made._askable()
        made.state_tests = made._certifiers(lambda external: external.is_state_test)
        return made

    def inner(self, fact: Fact) -> Fact:
        """A fact by the name that it has inside the planner."""
        return fact if self.part is None else self.part.inner(fact)

    def bounds(self, axiom: AxiomSchema) -> tuple[tuple[Pattern, ...], ...]:
        """Where any object fits a variable of an axiom's head: what those who ask for the head know of such objects.

        One conjunction for each condition that asks, with the axiom's own names for the variables of its head. None
        where some condition asks for any object: then all objects must be looked at.
        """
        loose = [p[1] for p in axiom.condition.positive if p[0] == "object" and p[1] in axiom.head[1:]]
        if not loose:
            return ()
        found = [self._bound(axiom, pattern, static, loose) for pattern, static in self._askers(str(axiom.head[0]))]
        return () if () in found else tuple(dict.fromkeys(found))

    def _askers(self, name: str) -> Iterator[tuple[Pattern, list[Pattern]]]:
        """Each literal of a derived predicate in a condition, with what the condition says that no action changes."""
        changing = self.fluents | self.derived | {"object", "="}
        conditions = self._conditions()
        conditions += [a.condition & e.condition for a in self.actions for e in a.effects]
        for condition in conditions:
            static = [p for p in condition.positive if p[0] not in changing]
            yield from ((p, static) for p in condition.positive + condition.negative if p[0] == name)

    def _bound(
        self, axiom: AxiomSchema, asked: Pattern, static: list[Pattern], loose: list[str | int]
    ) -> tuple[Pattern, ...]:
        """The fewest static literals of a condition that mention all loose variables; none where they do not."""
        names = {term: own for term, own in zip(asked[1:], axiom.head[1:], strict=True) if own in loose}
        if len(names) < len(loose) or not all(isinstance(term, str) for term in names):
            return ()
        chosen: list[Pattern] = []
        rest = set(names)
        while rest:
            best = max(static, key=lambda p: len(rest.intersection(p[1:])), default=())
            if rest.isdisjoint(best[1:]):
                return ()
            chosen.append(best)
            rest.difference_update(best[1:])
        return tuple((p[0], *(names.get(t, f"{t}.asked") if isinstance(t, str) else t for t in p[1:])) for p in chosen)

    def _pattern(self, atom: object) -> Pattern:
        from tamp.language import Atom, Variable

        assert isinstance(atom, Atom)
        return (
            atom.predicate,
            *(t.name if isinstance(t, Variable) else self.objects.intern(t.value) for t in atom.args),
        )

    def _rule(self, rule: Rule) -> tuple[AxiomSchema, ...]:
        condition = Condition(positive=tuple(map(self._pattern, rule.domain)))
        return tuple(AxiomSchema(self._pattern(atom), condition) for atom in rule.certified)

    def _where_cost_is_defined(self, action: ActionSchema) -> list[ActionSchema]:
        """An action that also wants a value of each function in its cost, as in Fast Downward's translator.

        The initial state gives it, or a function's sampler does for inputs in its domain: two actions where both may.
        """
        given = {term.function for term in self.problem.initial_state.values}
        choices: list[tuple[Pattern, ...]] = [action.condition.positive]
        for term in action.cost or ():
            if isinstance(term, tuple):
                function = self.functions.get(str(term[0]))
                ways = [] if function is None else [self._domain(function, term)]
                ways += [((valued(str(term[0])), *term[1:]),)] if function is None or function.name in given else []
                choices = [(*chosen, *way) for chosen in choices for way in ways]
        conditions = [replace(action.condition, positive=tuple(dict.fromkeys(positive))) for positive in choices]
        return [replace(action, condition=condition) for condition in dict.fromkeys(conditions)]

    def _domain(self, function: FunctionStream, term: Pattern) -> tuple[Pattern, ...]:
        """What a function's domain says of the inputs in a term."""
        terms = dict(zip((v.name for v in function.inputs), term[1:], strict=True))
        patterns = map(self._pattern, function.domain)
        return tuple((p[0], *(terms.get(str(t), t) if isinstance(t, str) else t for t in p[1:])) for p in patterns)

    def _external(self, stream: Stream | PredicateStream) -> External:
        inputs = tuple(v.name for v in stream.inputs)
        domain = tuple(map(self._pattern, stream.domain))
        covered = {t for pattern in domain for t in pattern[1:]}
        domain += tuple(("object", v) for v in inputs if v not in covered)
        info = self.problem.info.get(stream.name, StreamInfo())
        if isinstance(stream, PredicateStream):
            return External(stream.name, inputs, domain, (), ((stream.name, *inputs),), (), info, is_predicate=True)
        outputs = tuple(v.name for v in stream.outputs)
        certified = tuple(map(self._pattern, stream.certified))
        return External(
            stream.name, inputs, domain, outputs, certified, stream.fluents, info, optimizer=stream.optimizer
        )

    def _asked_besides(self, externals: dict[str, External]) -> frozenset[str]:
        """The predicates that actions, the goal, streams and functions ask for."""
        conditions = [action.condition for action in self.actions] + [self.goal]
        conditions += [effect.condition for action in self.actions for effect in action.effects]
        found = {str(p[0]) for c in conditions for p in c.positive + c.negative}
        found |= {str(p[0]) for external in externals.values() for p in external.domain}
        return frozenset(found | {atom.predicate for f in self.functions.values() for atom in f.domain})

    def _tests(self) -> dict[str, tuple[External, ...]]:
        generated = {str(p[0]) for e in self.externals.values() if not e.is_test for p in e.certified}
        return {name: tests for name, tests in self._askable().items() if name not in generated}

    def _askable(self) -> dict[str, tuple[External, ...]]:
        return self._certifiers(lambda external: external.is_test and not external.is_state_test)

    def _certifiers(self, of_kind: Callable[[External], bool]) -> dict[str, tuple[External, ...]]:
        """Predicate -> the streams of a kind that certify it."""
        found: dict[str, tuple[External, ...]] = {}
        for external in filter(of_kind, self.externals.values()):
            for pattern in external.certified:
                found[str(pattern[0])] = (*found.get(str(pattern[0]), ()), external)
        return found

    @cached_property
    def undecided(self) -> bool:
        """Whether tests with fluents decide more than preconditions: the search cannot learn what they forbid there."""
        elsewhere = [axiom.condition for axiom in self.axioms] + [self.goal]
        elsewhere += [effect.condition for action in self.actions for effect in action.effects]
        patterns = [p for c in elsewhere for p in c.positive + c.negative]
        patterns += [p for action in self.actions for p in action.condition.negative]
        return any(p[0] in self.state_tests for p in patterns)

    @cached_property
    def wanted(self) -> frozenset[tuple[str, bool]]:
        """What preconditions and the goal want true, and what false, themselves or through axioms and effects."""
        sources = [action.condition for action in self.actions] + [self.goal]
        queue = [literal for condition in sources for literal in _literals(condition, True)]
        found = set(queue)
        for name, sign in queue:  # grows while it is walked through
            inside = [(a.condition, sign) for a in self.axioms if a.head[0] == name]
            effects = (e for action in self.actions for e in action.effects if e.atom[0] == name)
            inside += [(e.condition, sign == e.positive) for e in effects]
            more = [literal for condition, good in inside for literal in _literals(condition, good)]
            queue += dict.fromkeys(literal for literal in more if literal not in found)
            found.update(more)
        return frozenset(found)

    @cached_property
    def asked_for(self) -> frozenset[str]:
        """Derived predicates that an action, the goal, a stream or a function asks for, themselves or by axioms."""
        conditions = [*(a.condition for a in self.actions), *(e.condition for a in self.actions for e in a.effects)]
        names = {str(p[0]) for c in (*conditions, self.goal) for p in c.positive + c.negative}
        for external in self.externals.values():
            names |= {str(p[0]) for p in external.domain + external.awaited} | set(external.fluents)
        names |= {atom.predicate for function in self.functions.values() for atom in function.domain}
        return frozenset(names.union(*map(self.below, names)) & self.derived)

    @cached_property
    def conditional(self) -> frozenset[str]:
        """Predicates that effects make true under conditions."""
        effects = (e for action in self.actions for e in action.effects if e.positive and e.condition != Condition())
        return frozenset(str(effect.atom[0]) for effect in effects)

    @cached_property
    def doubted(self) -> frozenset[str]:
        """Derived predicates that are wanted false: nothing is assumed in their favour."""
        return frozenset(name for name, sign in self.wanted if not sign and name in self.derived)

    @cached_property
    def ambivalent(self) -> bool:
        """Whether what is assumed of tests may also hurt: the search can then miss plans until tests are asked.

        So it is where they decide what is wanted both true and false, by conditional effects or axioms.
        """
        both = {name for name, sign in self.wanted if sign and (name, False) in self.wanted}
        return any(not self.influences(name).isdisjoint(self.tests) for name in both - self.tests.keys())

    @cached_property
    def recursive(self) -> frozenset[str]:
        """Derived predicates that depend on themselves."""
        return frozenset(name for name in self.derived if name in self.below(name))

    def below(self, name: str) -> set[str]:
        """The derived predicates that one depends on."""
        found: set[str] = set()
        queue = [name]
        while queue:
            current = queue.pop()
            for condition in (axiom.condition for axiom in self.axioms if axiom.head[0] == current):
                more = {str(p[0]) for p in condition.positive + condition.negative if p[0] in self.derived} - found
                found |= more
                queue.extend(sorted(more))
        return found

    def influences(self, name: str) -> frozenset[str]:
        """The predicates that the truth of one may depend on, through axioms and conditional effects; itself too."""
        found: set[str] = set()
        queue = [name]
        while queue:
            current = queue.pop()
            if current not in found:
                found.add(current)
                inside = [a.condition for a in self.axioms if a.head[0] == current]
                inside += [e.condition for a in self.actions for e in a.effects if e.atom[0] == current]
                queue += [str(p[0]) for c in inside for p in c.positive + c.negative]
        return frozenset(found)

    def _conditions(self) -> list[Condition]:
        found = [action.condition for action in self.actions] + [axiom.condition for axiom in self.axioms]
        found += [effect.condition for action in self.actions for effect in action.effects]
        return [*found, self.goal]


def _literals(condition: Condition, wanted: bool) -> Iterator[tuple[str, bool]]:
    """The predicates of a condition, each with the truth that is wanted of it where the condition is wanted, or not."""
    yield from ((str(p[0]), wanted) for p in condition.positive)
    yield from ((str(p[0]), not wanted) for p in condition.negative)
