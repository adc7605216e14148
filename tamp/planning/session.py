"""One run of the planner: its parts put together, the clock, and what it has found."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

from tamp.planning.attempt import Budget
from tamp.planning.binding import Binder
from tamp.planning.builder import TaskBuilder
from tamp.planning.connectors import Connectors
from tamp.planning.constraints import Matcher, places
from tamp.planning.costs import Costs
from tamp.planning.evaluate import Evaluator
from tamp.planning.found import Found
from tamp.planning.given import given_fact, initial_facts
from tamp.planning.grounding import Grounder
from tamp.planning.invariants import find_invariants, groups
from tamp.planning.knowledge import Knowledge
from tamp.planning.lessons import Lessons
from tamp.planning.limits import Limits
from tamp.planning.objects import Objects
from tamp.planning.operators import GroundOperator
from tamp.planning.options import Options, Restart
from tamp.planning.outlook import Outlook
from tamp.planning.problem import Problem
from tamp.planning.rounds import Rounds
from tamp.planning.sampling import Sampling
from tamp.planning.schema import Schema
from tamp.planning.search import Search, SearchResult
from tamp.planning.skeleton import Skeleton, make_skeleton
from tamp.planning.stopwatch import Stopwatch
from tamp.planning.symbolic import SymbolicSearch

MOVES_IN_SEARCH = 4000
"""How many moves between values the search may see where leaving them out has failed."""


class Session:
    """The parts of a run, and the steps that the algorithms are made of."""

    def __init__(self, problem: Problem, options: Options, search: Search, eager: bool, started: float) -> None:
        self.started = started
        self.options = options
        self.limits = Limits(options, started)
        self.objects = Objects()
        self.schema = Schema(problem, self.objects)
        self.knowledge = Knowledge(self.schema, self.objects)
        self.sampling = Sampling(self.knowledge, options.seed, self.limits.deadline)
        self.stopwatch = Stopwatch(self.sampling)
        self.evaluator = Evaluator(self.knowledge, self.sampling)
        self.rounds = Rounds(
            self.knowledge, self.sampling, self.evaluator, self.limits, self.stopwatch, eager, options.lazy_tests
        )
        self.costs = Costs(self.knowledge, self.sampling, options.unit_costs)
        bounded = min(options.max_cost, options.success_cost) < math.inf
        if bounded:
            self.costs.prefer_cheap()
        forbids = {str(p[0]).lower() for p in options.constraints.forbidden}
        hide = options.connectors and (self.costs.unit or not bounded)
        self.connectors = Connectors(self.schema, hide)
        if any(c.schema.name in forbids for c in self.connectors.connectors):
            self.connectors = Connectors(self.schema, enabled=False)
        forbidden = Matcher(options.constraints.forbidden, self.objects)
        self.binder = Binder(
            self.knowledge, self.sampling, self.evaluator, self.connectors, forbidden, self.limits.deadline
        )
        self.lessons = Lessons(self.knowledge)
        self.found = Found(options, self.costs)
        self.outlook = Outlook(self.schema, self.knowledge, self.sampling)
        self._by_key: dict[tuple[tuple[str, tuple[int, ...]], ...], Skeleton] = {}
        invariants = find_invariants(self.schema, self.connectors.fluent)
        builder = TaskBuilder(
            self.knowledge,
            lambda atoms: groups(invariants, atoms, [*self.knowledge.state, *self.knowledge.hoped_state()]),
            self.costs.of_operator,
            self.connectors.fluent,
            places(options.constraints, self.objects, frozenset(c.schema.name for c in self.connectors.connectors)),
            forbidden,
        )
        with self.stopwatch.timed("grounding"):
            self.grounder = Grounder(self.schema, self.knowledge, self.connectors, options.lazy_tests)
        self.grounder.on_instance = self.rounds.appear
        self.grounder.tick = self.limits.check
        self.symbolic = SymbolicSearch(
            self.schema, self.knowledge, self.evaluator, self.connectors, self.grounder, builder, search
        )

    def begin(self) -> None:
        """Take in what the problem gives.

        Raises:
            Ended: at a limit.
        """
        with self.stopwatch.timed("grounding"):
            for fact in initial_facts(self.schema, self.objects, self.options.reuse):
                self.limits.check()
                self.knowledge.give(fact)
            for atom in self.schema.problem.initial_state.negated:
                self.knowledge.refute(given_fact(atom, self.objects))

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

    def search(self, novel: bool = False) -> SearchResult:
        """Search for a plan under the hopes of this moment; with `novel`, without what was blamed for a failure.

        Raises:
            Ended: at a limit.
        """
        self.limits.check()
        self.limits.iterations += 1
        with self.stopwatch.timed("grounding"):
            self.knowledge.refresh()
            task = self.symbolic.task(self.lessons.blames, novel)
        if not task.solvable:
            return SearchResult(None, proven=True)
        bound = self.found.bound()
        with self.stopwatch.timed("search"):
            result = self.symbolic.run(task, self.limits.left, bound, novel)
        self.lessons.proofs &= result.plan is not None or result.proven or result.timed_out or bound is not None
        self.limits.check()
        return result

    def skeleton(self, operators: Iterable[GroundOperator]) -> Skeleton:
        """The skeleton of a symbolic plan; the same object for the same plan."""
        made = make_skeleton(operators, self.schema, self.knowledge, self.connectors)
        return self._by_key.setdefault(made.key, made)

    def bind(self, skeleton: Skeleton, budget: Budget) -> bool:
        """Try to bind a skeleton, and learn from it where it fails; whether it gave an acceptable plan.

        Raises:
            Ended: where a plan as good as wanted is found, or at a limit.
        """
        trial = self.lessons.trial(skeleton)
        with self.stopwatch.timed("binding"):
            attempt = self.binder.bind(skeleton, budget.grown(trial.attempts))
        trial.attempts += 1
        trial.last = attempt
        self.found.take(attempt)
        with self.stopwatch.timed("grounding"):
            self.lessons.learn(attempt)
        self.limits.check()
        if attempt.steps is None and self.lessons.unexplained >= 3 and self.few_values():
            raise Restart(replace(self.options, connectors=False))
        return attempt.steps is not None

    def few_values(self) -> bool:
        """Whether the search could as well see the moves that were left out of it."""
        connectors = self.connectors.connectors
        wanted = {
            (op.schema.name, p[connectors[0].position])
            for op in self.grounder.operators
            for p in op.schema.condition.positive
            if p[0] == self.connectors.fluent
        }
        values = {op.binding.get(str(t), t) for op in self.grounder.operators for n, t in wanted if n == op.schema.name}
        return len(values) ** 2 * len(connectors) <= MOVES_IN_SEARCH

    def check_prospects(self) -> None:
        """End the run where the goal is out of reach.

        Raises:
            Ended: "infeasible".
        """
        if self.found.best is None:
            with self.stopwatch.timed("grounding"):
                self.outlook.check()
