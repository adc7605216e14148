"""A run that survives a question: what streams gave, what failed and what is grounded stay for the next one."""

from __future__ import annotations

import reprlib
from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

from tamp import clock
from tamp.clock import TimeUp
from tamp.errors import DomainError
from tamp.language import Constant, Formula, atoms
from tamp.planning.algorithms.adaptive import adaptive, binding, focused, incremental
from tamp.planning.algorithms.improvement import improve
from tamp.planning.algorithms.initial_facts import Known
from tamp.planning.algorithms.plan_graph import draw_plan
from tamp.planning.algorithms.session import Session
from tamp.planning.grounding.kinds import unfit_conditions
from tamp.planning.model.awaited import OWN_MARK
from tamp.planning.model.normal_form import Condition, literals_of
from tamp.planning.model.objects import Fact
from tamp.planning.model.schema import VALUED_MARK
from tamp.planning.model.stream_instances import ground
from tamp.planning.options import Ended, Options, Restart, Settings
from tamp.planning.problem import GroundAction, Problem, Solution
from tamp.planning.report import Report
from tamp.planning.search.best_first import BuiltinSearch, Search
from tamp.planning.search.fast_downward import FastDownward
from tamp.planning.slips import warn_of_slips

ALGORITHMS: dict[str, Callable[[Session], None]] = {
    "adaptive": adaptive,
    "binding": binding,
    "focused": focused,
    "incremental": incremental,
}


class PlanningRun:
    """Answers one question after another about a problem, each from the state that the plans committed so far lead to.

    A second question about a conjunction of facts costs its search and what is new to be sampled; one with quantifiers
    or disjunctions is grounded anew, with all facts that are known by then. So is the one after a question that had to
    be interrupted, with the facts that committed plans have left.
    """

    def __init__(self, problem: Problem, settings: Settings | None = None, until: float | None = None) -> None:
        """A run that has answered nothing yet.

        Args:
            problem: what the questions are about.
            settings: how each question is answered; its time limit is that of one question without a budget.
            until: when a sampler is interrupted that goes on, on the clock of tamp.clock.now() [s]; None for the limit
                of each question.

        Raises:
            DomainError: for an unknown algorithm or search, or constraints that do not fit the domain.
        """
        self.problem = problem
        self.settings = settings or Settings()
        if self.settings.algorithm not in tuple(ALGORITHMS):  # which may be unhashable
            names = ", ".join(ALGORITHMS)
            raise DomainError(f"unknown algorithm {self.settings.algorithm!r}; there are: {names}")
        self.settings.options.constraints.check(problem.parsed_domain)
        warn_of_slips(problem, priced=not self.settings.options.unit_costs)
        self._until = until
        self._search = searcher(self.settings.search)
        self._session: Session | None = None
        self._usable = False
        self._committed: list[_Present] = []
        self._reached: _Present | None = None

    def solve(self, goals: Any = None, frozen: Collection[Any] = (), budget: float | None = None) -> Solution:
        """Plan from the present state.

        Args:
            goals: what to reach, as nested tuples; None for the problem's goal.
            frozen: objects that stay as they are: no action may delete a fact whose first argument is one of them.
            budget: time limit of this question, on the clock of tamp.clock.now() [s].

        Raises:
            DomainError: where the goals cannot be read.
            SamplerError: where a sampler's output does not fit its stream.
        """
        started = clock.now()
        problem = self.problem if goals is None else replace(self.problem, goal=goals)
        options = self.settings.options
        options = options if budget is None else replace(options, timeout=budget)
        self._reached = None
        complete = True
        kept: Session | None = None  # with a plan, where the run began again to look for a cheaper one
        session = self._turn_to(problem.goal_formula, options, started, frozen)
        try:
            if session is None:
                session = self._begin(problem, options, started, frozen)
            while (restart := self._answer(session)) is not None:
                again = restart.options
                if session.found.best is not None:
                    kept = session
                    again = replace(again, max_cost=min(again.max_cost, session.found.cost))
                session = self._begin(problem, again, started, frozen)
            raise AssertionError("algorithms end by raising Ended or Restart")
        except _Begun as begun:
            session, status, message, complete = begun.session, begun.ended.status, begun.ended.message, False
            self._usable = False  # facts may be missing
        except Ended as ended:
            assert session is not None
            status, message = ended.status, ended.message
            self._usable &= not session.grounder.broken
        except KeyboardInterrupt:
            if session is None:
                raise
            status, message = "interrupted", "The run was interrupted."
            self._usable = False
        if session.found.best is None and kept is not None:
            message = "No better plan exists." if status == "infeasible" else message
            status = status if status == "interrupted" else "solved"
            self._session, self._usable = kept, False
            session = kept
        if session.found.best is None:
            message = " ".join([message, *_strangers(session, problem.goal_formula)])
            if status == "timeout" and complete:
                message = " ".join([message, *_unfit(session)])
        else:
            reached = _values(session, session.final_state())
            self._reached = _Present(reached, len(session.found.basis.brought))
        return _solution(session, self.settings.algorithm, status, message)

    def commit(self) -> None:
        """Let the state after the plan that was found last be the present one.

        Raises:
            ValueError: where the last question has no plan.
        """
        if self._reached is None:
            raise ValueError("there is no plan to commit: the last question was not solved, or its plan is committed")
        self._committed.append(self._reached)
        self._reached = None

    def rollback(self) -> None:
        """Take back the last commit.

        Raises:
            ValueError: where nothing is committed.
        """
        if not self._committed:
            raise ValueError("there is nothing to take back: no plan is committed")
        self._committed.pop()
        self._reached = None

    def _turn_to(self, goal: Formula, options: Options, started: float, frozen: Collection[Any]) -> Session | None:
        """The session of the question before, where it can answer this one."""
        session = self._session
        if session is None or not self._usable:
            return None
        wanted, inner = literals_of(goal, session.objects), session.schema.inner
        if wanted is None:
            return None
        wanted = Condition(tuple(map(inner, wanted.positive)), tuple(map(inner, wanted.negative)))
        if not session.answers(wanted):
            return None
        intern, brought = session.objects.intern, list(session.knowledge.brought)
        if self._committed:
            now = self._committed[-1]
            session.move_to([*(inner((f[0], *map(intern, f[1:]))) for f in now.state), *brought[now.brought :]])
        else:
            session.move_to([*session.given_state, *brought])
        kept = replace(session.options, timeout=options.timeout)
        session.ask(wanted, kept, started, frozenset(map(intern, frozen)))
        return session

    def _begin(self, problem: Problem, options: Options, started: float, frozen: Collection[Any]) -> Session:
        """A new session in the present state, with the facts that the last one knew."""
        before, known = self._session, None
        if self._committed and before is not None:
            now, brought = self._committed[-1], list(before.knowledge.brought)
            state = (*now.state, *_values(before, brought[now.brought :]))
            known = Known(_values(before, before.knowledge.real), state, _values(before, brought))
        eager = self.settings.algorithm == "incremental" and not options.optimistic
        session = Session(problem, options, self._search, eager, started)
        session.on_better = improve
        session.freeze(frozenset(map(session.objects.intern, frozen)))
        self._usable = True
        try:
            with self._punctual(session):
                session.begin(known)
        except Ended as ended:
            raise _Begun(session, ended) from None
        except KeyboardInterrupt:
            raise _Begun(session, Ended("interrupted", "The run was interrupted.")) from None
        self._session = session
        return session

    def _answer(self, session: Session) -> Restart | None:
        try:
            with self._punctual(session):
                ALGORITHMS[self.settings.algorithm](session)
        except Restart as restart:
            return restart
        return None

    @contextmanager
    def _punctual(self, session: Session) -> Iterator[None]:
        """End the block where it goes on past the limit without a look at the clock.

        The session may be left in the middle of anything: it answers no other question.

        Raises:
            Ended: "timeout", then.
            TimeUp: where the limit is that of whoever asks, who ends all that they do by it.
        """
        deadline = session.limits.deadline if self._until is None else self._until
        try:
            # Whoever watches from outside minds the limit of the whole, not that of one question.
            with clock.watched(lambda deadline: None), clock.ended_at(deadline):
                yield
        except TimeUp as late:
            self._usable = False
            if not clock.is_free():  # their alarm, which goes on ringing
                raise
            raise Ended("timeout", f"The time limit of {session.options.timeout:g} s was reached: {late}.") from None


@dataclass(frozen=True)
class _Present:
    """A state by values, and how many facts streams had brought by then."""

    state: tuple[Fact, ...]
    brought: int


def _values(session: Session, facts: Iterable[Fact]) -> tuple[Fact, ...]:
    return tuple(map(session.objects.values_of, facts))


class _Begun(Exception):  # noqa: N818  control flow inside this module
    """The run ended before all that is given was taken in."""

    def __init__(self, session: Session, ended: Ended) -> None:
        super().__init__()
        self.session = session
        self.ended = ended


def searcher(search: str | Search) -> Search:
    """The search of a name that `search_of` gives; one that is none stays."""
    if not isinstance(search, str):
        return search
    return BuiltinSearch() if search == "builtin" else FastDownward(search)


def _strangers(session: Session, formula: Formula) -> Iterator[str]:
    """A sentence for each object that goal or constraints name, and that no fact names and no stream has given."""
    knowledge, problem = session.knowledge, session.schema.problem
    known = {handle for fact in (*knowledge.real, *knowledge.state) if fact[0] != "object" for handle in fact[1:]}
    given = [arg.value for atom in problem.initial_state.facts for arg in atom.args if isinstance(arg, Constant)]
    given += [constant.value for constant in problem.parsed_domain.constants.values()]
    known.update(map(session.objects.intern, given))
    goal = [term for atom in atoms(formula) for term in atom.args if isinstance(term, Constant)]
    for who, values in (
        ("goal", [term.value for term in goal]),
        ("constraints", list(session.options.constraints.objects())),
    ):
        named = [reprlib.repr(v) for v in values if session.objects.find(v) not in known]
        for text in dict.fromkeys(named):
            verb = "names" if who == "goal" else "name"
            yield f"The {who} {verb} {text}, which no fact names and no stream has given."


def _unfit(session: Session) -> Iterator[str]:
    """A sentence about conditions that nothing fits, where time is over: a stream may certify too little."""
    text = "" if session.sampling.wild else unfit_conditions(session.schema, session.knowledge)
    yield from [text] if text else []


def _certified(session: Session) -> Iterator[Fact]:
    """What holds at the start and what streams have certified, in the words of the file."""
    knowledge, basis = session.knowledge, session.found.basis
    facts = (*basis.real, *session.given_state, *basis.brought)
    yield from (fact for fact in facts if not fact[0].startswith((OWN_MARK, VALUED_MARK)))
    for instance in knowledge.instances():
        for outputs in instance.results if instance.external.guarded else ():
            yield from (ground(pattern, instance.binding(outputs)) for pattern in instance.external.guarded)


def _solution(session: Session, algorithm: str, status: str, message: str) -> Solution:
    objects, best = session.objects, session.found.best
    plan = None
    if best is not None:
        plan = tuple(GroundAction(step.schema.name, tuple(map(objects.value, step.args))) for step in best)
        if status != "interrupted":
            status = "solved"
    seconds = {**session.stopwatch.seconds, "sampling": session.sampling.seconds}
    report = Report(
        algorithm,
        status,
        session.found.cost,
        clock.now() - session.started,
        seconds,
        session.sampling.report(),
        tuple(session.lessons.reports()),
        {
            "iterations": session.limits.iterations,
            "operators": session.symbolic.operators,
            "instances": len(session.knowledge.instances()),
        },
        message,
    )
    certified = tuple(map(objects.values_of, _certified(session)))
    picture = draw_plan(best, session.knowledge) if best is not None else ""
    return Solution(plan, session.found.cost, status, certified, report, picture)
