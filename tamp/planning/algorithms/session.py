"""One run of the planner: initial facts, and what has been sampled so far."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import replace

from tamp.planning.algorithms.costs import Costs
from tamp.planning.algorithms.hidden_moves import constant, few_moves, may_be_filled_in, seen_by_search
from tamp.planning.algorithms.incumbent import Found
from tamp.planning.algorithms.initial_facts import Known, given_fact, initial_facts
from tamp.planning.algorithms.lifting import Lifter
from tamp.planning.algorithms.searches import Searches
from tamp.planning.binding.attempt import Attempt, Budget
from tamp.planning.binding.backjumping import Binder, progress
from tamp.planning.binding.learning import Lessons
from tamp.planning.binding.reopening import reopened
from tamp.planning.binding.skeleton import Skeleton, make_skeleton
from tamp.planning.constraints import Course, Forbidden
from tamp.planning.grounding.ground_task import TaskOperator
from tamp.planning.grounding.grounder import Grounder
from tamp.planning.grounding.infeasibility import Outlook
from tamp.planning.grounding.moves import MovePrices
from tamp.planning.grounding.operators import GroundOperator
from tamp.planning.grounding.task_builder import Scope, TaskBuilder
from tamp.planning.model.analysis.any_object import with_any_object
from tamp.planning.model.analysis.invariants import find_invariants, groups
from tamp.planning.model.fact_store import Knowledge
from tamp.planning.model.normal_form import Condition
from tamp.planning.model.objects import Fact, Objects
from tamp.planning.model.schema import Schema
from tamp.planning.model.state import State
from tamp.planning.options import Limits, Options, Restart
from tamp.planning.problem import Problem
from tamp.planning.sampling.evaluation import Evaluator
from tamp.planning.sampling.stream_calls import Sampling, Stopwatch
from tamp.planning.sampling.stream_rounds import Rounds
from tamp.planning.sampling.surprises import Surprises
from tamp.planning.search.best_first import Search
from tamp.planning.search.symbolic_search import SymbolicSearch

ALIKE = 4
"""How many attempts at skeletons with values for the same choices, maybe in another order, count as one at each."""


class Session:
    """The parts of a run, and the steps that the algorithms are made of.

    Attributes:
        eager: whether the search sees real values alone, so that all streams are called.
        searches: of this question, and how much of `work` they were.
        on_better: what is done about a plan that is better than the last one.
    """

    def __init__(self, problem: Problem, options: Options, search: Search, eager: bool, started: float) -> None:
        self.objects = Objects()
        stated = Schema(problem, self.objects, priced=not options.unit_costs)
        schema = with_any_object(stated, self.objects, options.constraints.bind)
        self.schema, self.connectors = seen_by_search(schema, self.objects, options)
        self._filled_in = may_be_filled_in(schema, self.objects, options)
        self.knowledge = Knowledge(self.schema, self.objects)
        self.sampling = Sampling(self.knowledge, options.seed, started + options.timeout)
        self.evaluator = Evaluator(self.knowledge, self.sampling)
        self.given_state: list[Fact] = []
        self._named: set[int] = set()
        self._search = search
        self.eager = eager
        self.on_better: Callable[[Session], None] = lambda session: None
        self._invariants = find_invariants(self.schema, self.connectors.fluent)
        self.grounder = Grounder(self.schema, self.knowledge, self.connectors, options)
        self._lifter = Lifter(self.knowledge, self.grounder)
        self._prepare(options, started)

    def _prepare(self, options: Options, started: float, frozen: frozenset[int] = frozenset()) -> None:
        """Make the parts that know the limits, the goal and the initial state of one question."""
        self.started = started
        self.options = options
        self.limits = Limits(options, started)
        self.stopwatch = Stopwatch(self.sampling)
        self.rounds = Rounds(
            self.knowledge, self.sampling, self.evaluator, self.limits, self.stopwatch, self.eager, options.lazy_tests
        )
        self.grounder.report_to(self.rounds.appear, self.limits.check)
        hidden = frozenset(c.schema.name for c in self.connectors.connectors)
        self.costs = Costs(self.knowledge, self.sampling, options.unit_costs, hidden)
        if options.max_cost < math.inf:
            self.costs.prefer_cheap(options.max_cost)
        forbidden = Forbidden(options.constraints, self.objects)
        course = Course(options.constraints, self.objects, self._filled_in)
        self.binder = Binder(
            self.knowledge, self.sampling, self.evaluator, self.connectors, forbidden, course, self.limits.deadline
        )
        self.lessons = Lessons(self.knowledge, self.grounder.clears)
        self.found = Found(options, self.costs, self.knowledge)
        self.surprises = Surprises(self.knowledge, self.sampling, self.evaluator, self.limits)
        self.outlook = Outlook(self.schema, self.knowledge, self.sampling, self.surprises, self.limits.check)
        self._skeletons: dict[tuple[tuple[int, ...], ...], Skeleton] = {}
        self._builder = TaskBuilder(
            self.knowledge,
            lambda atoms: groups(self._invariants, atoms, [*self.knowledge.state, *self.knowledge.optimistic_state()]),
            self.costs.of_operator,
            self.costs.of_assumed_test,
            MovePrices(self.connectors, self.costs.of_move, self.costs.of_move_between),
            course,
            forbidden,
            frozen,
        )
        self.symbolic = SymbolicSearch(
            self.schema, self.knowledge, self.evaluator, self.grounder, self._builder, self._search
        )
        self.searches = Searches(
            self.symbolic,
            self.knowledge,
            self.connectors,
            self.lessons,
            self.found,
            self.limits,
            self.stopwatch,
            self.eager,
        )

    def begin(self, known: Known | None = None) -> None:
        """Take in what the problem gives; with `known`, its state in place of the initial one, and its facts besides.

        Raises:
            Ended: at a limit.
        """
        with self.stopwatch.timed("grounding"):
            self.grounder.start()
            for fact in initial_facts(self.schema, self.objects, self.options.reuse):
                self.limits.check()
                if known is None or fact[0] not in self.schema.fluents:
                    self.knowledge.give(fact)
            for raw in (*known.facts, *known.state) if known is not None else ():
                self.knowledge.give(self.schema.inner((raw[0], *map(self.objects.intern, raw[1:]))))
            for raw in known.brought if known is not None else ():
                self.knowledge.brought[(raw[0], *map(self.objects.intern, raw[1:]))] = None
            for atom in self.schema.problem.initial_state.negated:
                self.knowledge.refute(given_fact(atom, self.objects))
        inner = self.schema.inner
        given = (inner(given_fact(atom, self.objects)) for atom in self.schema.problem.initial_state.facts)
        self.given_state = [fact for fact in given if fact[0] in self.schema.fluents]
        facts = (fact for fact in (*self.knowledge.real, *self.knowledge.state) if fact[0] != "object")
        self._named = {handle for fact in facts for handle in fact[1:]}
        self._named |= {self.objects.intern(c.value) for c in self.schema.domain.constants.values()}

    def freeze(self, frozen: frozenset[int]) -> None:
        """Let no action delete a fact that has one of these objects as its first argument."""
        if frozen:
            self._prepare(self.options, self.started, frozen)

    def answers(self, goal: Condition) -> bool:
        """Whether what is grounded fits another goal as well, so that it can be asked next."""
        private, hidden = self.connectors.private, self.connectors.fluent
        changing = self.schema.fluents | (self.grounder.derived - private)
        wanted, unwanted = ({str(p[0]) for p in patterns} for patterns in (goal.positive, goal.negative))
        if not self.connectors.spent.isdisjoint(wanted | unwanted):
            return False
        return wanted <= changing and unwanted <= self.schema.fluents - {hidden}

    def ask(self, goal: Condition, options: Options, started: float, frozen: frozenset[int]) -> None:
        """Turn to another goal, with what was learnt of streams; `begin` is not needed again.

        Args:
            goal: one that `answers` says yes to.
            options: with the limits of this question; nothing else may differ from the options of the session.
            started: when the question was asked, on the clock of tamp.clock.now() [s].
            frozen: objects of which no action may delete a fact that has them as its first argument.
        """
        self.schema.goal = goal
        rounds, lessons = self.rounds.count, self.lessons
        self.sampling.continue_until(started + options.timeout)
        self._prepare(options, started, frozen)
        self.rounds.count = rounds
        self.lessons.blames, self.lessons.proofs = lessons.blames, lessons.proofs
        self.lessons.guessed = lessons.guessed
        for pattern in goal.positive + goal.negative:
            for term in pattern[1:]:
                self.knowledge.give(("object", term))

    def move_to(self, state: Iterable[Fact]) -> None:
        """Let another state be the initial one."""
        self.knowledge.state = dict.fromkeys(state)
        self.knowledge.version += 1
        for fact in self.knowledge.state:
            for handle in fact[1:]:
                self.knowledge.show(handle)
            self.grounder.tell(fact)

    def final_state(self) -> tuple[Fact, ...]:
        """What holds after the best plan."""
        state = State(self.found.basis.state)
        for step in self.found.best or ():
            state = progress(self.evaluator, step.schema, step.binding, state)
        return tuple(state)

    def earlier_plan(self) -> Skeleton | None:
        """The remaining actions of an earlier plan as a skeleton; None where an action is not possible any more."""
        if self.options.reuse is None:
            return None
        hidden = {c.schema.name for c in self.connectors.connectors}
        known = {(op.schema.name, op.args): op for op in self.grounder.operators}
        actions = [a for a in self.options.reuse.actions if a.name not in hidden]
        steps = [known.get((a.name, tuple(map(self.objects.intern, a.args)))) for a in actions]
        found = [step for step in steps if step is not None]
        return self.skeleton(found) if len(found) == len(steps) else None

    @property
    def goal_names_unknown(self) -> bool:
        """Whether the goal wants something of an object that nothing given names and no stream has given."""
        wanted = {term for pattern in self.schema.goal.positive for term in pattern[1:] if isinstance(term, int)}
        return any(self.knowledge.source(handle) is None for handle in wanted - self._named)

    @property
    def goal_barred(self) -> bool:
        """Whether the goal wants a move that failed."""
        hidden = [pattern for pattern in self.schema.goal.positive if pattern[0] == self.connectors.fluent]
        return any(term in self.lessons.blames for pattern in hidden for term in pattern[1:])

    @property
    def optimizers(self) -> bool:
        """Whether optimizers give values."""
        return any(external.optimizer for external in self.schema.externals.values())

    @property
    def work(self) -> int:
        """How much was done, whatever the time it took: calls of streams, optimistic facts grounded, and searches."""
        return self.rounds.work + len(self.knowledge.templates) + self.searches.work

    def cheaper(self, enough: int, scope: Scope, below: int | None = None) -> tuple[Skeleton, int] | None:
        """The skeleton of what `Searches.cheaper` finds, and its cost there; None where it finds nothing.

        Raises:
            Ended: at a limit.
        """
        plan = self.searches.cheaper(enough, scope, below)
        return None if plan is None else (self.skeleton_of(plan), sum(step.cost for step in plan))

    def failed(self) -> list[Skeleton]:
        """The skeletons that could not be bound when they were tried last, though they may be possible."""
        self.knowledge.refresh()
        tried = (skeleton for skeleton, trial in self.lessons.tried.items() if trial.last.steps is None)
        return [skeleton for skeleton in tried if all(map(self._builder.is_possible, skeleton.steps))]

    def skeleton_of(self, plan: Iterable[TaskOperator]) -> Skeleton:
        """The skeleton of what a search found."""
        return self.skeleton(step.source for step in plan if step.source is not None)

    def skeleton(self, operators: Iterable[GroundOperator]) -> Skeleton:
        """The skeleton of a symbolic plan; the same object for the same schemas with the same objects.

        Operators that have only their actions' arguments in common rest on different facts, each to be tried.
        """
        steps = tuple(operators)
        key = tuple((id(step.schema), *step.binding.values()) for step in steps)
        if key not in self._skeletons:
            self._skeletons[key] = make_skeleton(steps, self.schema, self.knowledge, self.connectors)
        return self._skeletons[key]

    def lifted(self, skeleton: Skeleton) -> Skeleton:
        """A skeleton with sampled values left open again, as far as each comes from a stream of its own.

        What was drawn before competes there with fresh draws: the search would try the values in ever new combinations.
        """
        return self.skeleton(self._lifter.lift(skeleton.steps))

    def reopened(self, skeleton: Skeleton) -> tuple[Skeleton, dict[int, int]]:
        """A skeleton of the best plan with all values left open that streams gave, and what stands there in it."""
        steps = [s for s in self.found.best or () if not self.connectors.is_connector(s.schema.name)]
        goal = self.schema.goal
        kept = {t for p in (*goal.positive, *goal.negative) for t in p[1:] if isinstance(t, int)} | self._named
        return reopened(skeleton, steps, kept, self.schema, self.knowledge, self.connectors)

    def bind(self, skeleton: Skeleton, budget: Budget) -> bool:
        """Try to bind a skeleton, and learn from it where it fails; whether it gave an acceptable plan.

        Raises:
            Ended: where a plan as good as wanted is found, or at a limit.
        """
        cost = self.found.cost
        attempt = self.attempt(skeleton, budget)
        if self.found.cost < cost:
            self.on_better(self)
            self.found.check()
            if self.connectors.fluent and not self.moves_cost_alike():
                raise Restart(replace(self.options, connectors=False))
        puzzled = self.lessons.puzzling or (self._moves_can_be_asked_for and self.lessons.supposed > 0)
        if attempt.steps is None and puzzled and few_moves(self.connectors, self.grounder.operators):
            raise Restart(replace(self.options, connectors=False))
        return attempt.steps is not None

    @property
    def _moves_can_be_asked_for(self) -> bool:
        """Whether a search among real values would ask the tests that moves rest on, if it saw the moves.

        What such a test says no to is a guess otherwise, and one state after the other is tried.
        """
        streams = [external for c in self.connectors.connectors for external, _ in c.streams]
        return self.eager and any(external.is_state_test for external in streams)

    def moves_cost_alike(self) -> bool:
        """Whether the search knows what the moves cost that it leaves out."""
        return self.costs.unit or all(constant(c.schema.cost) for c in self.connectors.connectors)

    def attempt(self, skeleton: Skeleton, budget: Budget) -> Attempt:
        """Try to bind a skeleton, keep the plan where it is better, and learn from it where it fails.

        Raises:
            Ended: at a limit.
        """
        trial = self.lessons.trial(skeleton)
        with self.stopwatch.timed("binding"):
            alike = self.lessons.alike(skeleton)
            grown = budget.grown(max(trial.attempts, alike // ALIKE))
            attempt = self.binder.bind(skeleton, grown, turn=alike)
        self.lessons.count(skeleton)
        trial.last = attempt
        self.found.take(skeleton, attempt)
        self.grounder.be_shallow()
        with self.stopwatch.timed("grounding"):
            self.lessons.learn(attempt)
        self.limits.check()
        return attempt

    def check_surprises(self) -> None:
        """Begin again with every stream where one has certified more than it promises, and some were left out.

        So too where a fluent was told apart by what streams promise.

        Raises:
            Restart: then.
        """
        rest = self.schema.externals.keys() - self.grounder.joined - self.connectors.streams
        if self.sampling.wild and rest and not self.options.every_stream:
            tame = frozenset(self.sampling.tame - self.sampling.wild)
            raise Restart(replace(self.options, every_stream=True, tame=tame))
        if self.sampling.wild and self.schema.part is not None:
            raise Restart(replace(self.options, connectors=False))

    def check_prospects(self, seen: bool = False) -> None:
        """End the run where the goal is out of reach, unless the search has just seen a plan.

        Raises:
            Ended: "infeasible".
        """
        self.check_surprises()
        if self.found.best is None and not seen:
            with self.stopwatch.timed("grounding"):
                self.outlook.check()
