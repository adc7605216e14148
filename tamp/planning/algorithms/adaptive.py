"""The algorithms: how search for skeletons and sampling of values take turns."""

from __future__ import annotations

from dataclasses import replace

from tamp.planning.algorithms.session import Session
from tamp.planning.binding.attempt import Budget
from tamp.planning.binding.skeleton import Skeleton
from tamp.planning.grounding.task_builder import Scope
from tamp.planning.options import Ended, Restart
from tamp.planning.search.best_first import SearchResult

AHEAD = 6
"""How many streams in a row may be assumed before any sampling; afterwards chains without end must wait for it."""


OPTIMISTIC, SOBER = 4, 2
"""Optimistic plans that may fail before real values alone have a turn, and then between two such turns."""

FIRST_LOOK = 4
"""Rounds of sampling before streams that no plan seems to need are called as well; again after twice as many."""

DEAR = 500
"""Work of searches, as `Session.work` counts it, after which the first failure is followed by real values alone."""

GIVEN_UP = 8
"""Attempts to bind a skeleton, each with twice the budget, after which nothing more is expected of another."""


def adaptive(session: Session) -> None:
    """Search over optimistic facts, bind, learn; skeletons that failed get another turn with a growing budget.

    A turn of the search costs little, so each iteration searches with all that was learnt; a skeleton that comes out
    again is bound with twice the budget. Every few failures an old skeleton has a turn, so that each is tried again
    and again while its streams have values left.
    """
    _search_and_bind(session, revisit=4)


def binding(session: Session) -> None:
    """As `adaptive`, with twice as many turns for the skeletons that were found before."""
    _search_and_bind(session, revisit=2)


def _search_and_bind(session: Session, revisit: int) -> None:
    """Search and bind in turns; after every `revisit` failures an old skeleton has a turn."""
    budget = Budget()
    sobriety = Sobriety(session, budget)
    failures = 0
    earlier = session.earlier_plan()
    if earlier is not None:
        session.bind(earlier, budget)
    while True:
        skeleton = _next_skeleton(session)
        if skeleton is None:
            if failures >= OPTIMISTIC:
                sobriety.catch_up()
            continue
        _bind(session, skeleton, budget)
        failures += 1
        if failures % revisit == 0:
            _bind_oldest(session, skeleton, budget)
        if (failures >= OPTIMISTIC and (failures - OPTIMISTIC) % SOBER == 0) or sobriety.overdue:
            sobriety.take_turn()


class Sobriety:
    """Turns of real values alone: draw from every stream, and search after each round, as `incremental` does.

    Where tests mostly say no, as in a roadmap, each optimistic plan would fail at the next of them. Both kinds of
    turns share the work equally, so that neither costs more than twice what the other alone would.
    """

    def __init__(self, session: Session, budget: Budget) -> None:
        self._session = session
        self._budget = budget
        self._spent = 0
        self._learnt = True  # by optimistic plans
        self._seen = False
        self._searched = self._news = 0

    @property
    def news(self) -> bool:
        """Whether streams have brought facts since the last turn that no stream promises."""
        return self._session.sampling.news > self._news

    @property
    def overdue(self) -> bool:
        """Whether real values should have a turn at once: optimistic searches are dear and it had none, or of news."""
        return (not self._spent and self._session.searches.work > DEAR) or self.news

    def take_turn(self) -> None:
        """At least one round, and as many as it takes to spend what optimistic searches have."""
        if self._round():
            self.catch_up()

    def catch_up(self) -> None:
        """As many rounds as it takes to spend what optimistic searches have."""
        while 2 * self._spent < self._session.work and self._round():
            pass

    def _round(self) -> bool:
        """Draw, and search; whether it is worth going on. A plan that fails is followed by a search of the same values.

        Tests between them are asked where a plan rests on them: it takes several plans to know which values get along.
        """
        session, before = self._session, self._session.work
        self._news = session.sampling.news
        session.grounder.be_shallow(sober=True, drawing=True)
        if not self._learnt and not self._draw(before):
            return False
        refuted, searching, version = len(session.knowledge.refuted), session.searches.work, session.knowledge.version
        result = _searched(session, sure=True)
        if result.plan is not None and session.bind(session.skeleton_of(result.plan), self._budget):
            return False
        self._seen = result.plan is not None
        self._learnt = result.plan is not None and session.knowledge.version > version
        if result.plan is not None and len(session.knowledge.refuted) > refuted:
            session.rounds.ask_alike(refuted, most=session.searches.work - searching)
        self._searched = session.searches.work - searching
        self._spent += session.work - before
        return True

    def _draw(self, before: int) -> bool:
        """Draw from every stream, and again while that is less work than the last search was; whether any had more.

        Where that search has seen a plan, there are values enough to try: once is enough.
        """
        if not self._session.rounds.expand(tests=True):
            return False
        if self._seen:
            return True
        while self._session.work - before < self._searched and self._session.rounds.expand(tests=True):
            pass
        return True


def focused(session: Session) -> None:
    """Search over optimistic facts and bind with few samples, a few more as failures add up; what failed is avoided.

    Each time that samples become more, an old skeleton has a turn with them: where values are what fails, the search
    would try them in ever new combinations instead. Real values alone have their turn later than in `adaptive`, unless
    optimistic facts crowd the search.
    """
    budget = Budget(values=2, draws=60, patience=2, jumps=400)
    sobriety = Sobriety(session, budget)
    failures = 0
    while True:
        skeleton = _next_skeleton(session)
        if skeleton is not None:
            _bind(session, skeleton, budget.grown(failures // 8))
            failures += 1
            if failures % 8 == 0:
                _bind_oldest(session, skeleton, budget.grown(failures // 8))
            if failures % (SOBER if session.grounder.crowded else OPTIMISTIC) == 0 or sobriety.news:
                sobriety.take_turn()
        elif failures >= OPTIMISTIC:
            sobriety.catch_up()


def incremental(session: Session) -> None:
    """Draw from every stream in turn and search among real values only, after each round.

    Where tests say no to a plan, they are asked of other values as well, for as many calls as the search was worth.
    After a dear search in vain there are as many rounds as are as much work, but at most as many as before.
    Only motions that depend on the state are left to the end, as in the other algorithms. Where what optimizers
    give for each choice alone does not do, they are asked about whole plans, which are found over optimistic facts.

    Raises:
        Restart: then.
    """
    budget = Budget()
    if session.options.optimistic:
        _search_and_bind(session, revisit=4)
    while True:
        before, searching, refuted = session.searches.looking, session.searches.work, len(session.knowledge.refuted)
        result = _searched(session)
        if result.plan is not None:
            version, cost = session.knowledge.version, session.found.cost
            skeleton = session.skeleton_of(result.plan)
            bound = session.bind(skeleton, budget)
            if session.found.cost == cost and (bound or session.knowledge.version == version):
                _go_on(session, skeleton)
            elif not bound:
                session.rounds.ask_alike(refuted, most=session.searches.work - searching)
        elif result.timed_out:
            _replace_optimistic(session)
        elif session.optimizers and session.rounds.count:
            raise Restart(replace(session.options, optimistic=True))
        else:
            _expand(session, worth=session.searches.looking - before)


def _bind(session: Session, skeleton: Skeleton, budget: Budget) -> None:
    """Bind; where nothing was learnt from it, see to it that something new is known by the next search."""
    version, cost = session.knowledge.version, session.found.cost
    bound = session.bind(skeleton, budget)
    learnt = session.knowledge.version > version
    if not bound:
        lifted = session.lifted(skeleton)
        bound = lifted is not skeleton and session.bind(lifted, budget)
    if session.found.cost < cost:
        return  # the next search looks for a cheaper plan among what is known
    if bound or not learnt:
        _go_on(session, skeleton)


def _go_on(session: Session, skeleton: Skeleton) -> None:
    """Draw from every stream once more, after a skeleton was bound to no avail and nothing was learnt from it.

    That it cannot be bound proves nothing: the search may know of others by now.

    Raises:
        Ended: where there is nothing to draw any more, and the skeleton was tried again and again.
    """
    if not _sample(session, seen=True) and session.lessons.trial(skeleton).attempts >= GIVEN_UP:
        _conclude(session, proven=False)


def _bind_oldest(session: Session, latest: Skeleton, budget: Budget) -> None:
    """Bind the first of the skeletons that were tried least and leave anything open, unless it is the latest."""
    tried = session.lessons.tried
    oldest = min((s for s in tried if s.leaves_open), key=lambda s: tried[s].attempts, default=latest)
    if oldest is not latest:
        _bind(session, oldest, budget)


def _next_skeleton(session: Session) -> Skeleton | None:
    """The skeleton that the search finds, or None after it was given more to work with.

    Raises:
        Ended: where there is nothing more to give.
    """
    result = _searched(session)
    if result.plan is not None:
        return session.skeleton_of(result.plan)
    if result.timed_out:
        _replace_optimistic(session)
    elif not _deepen(session):
        _expand(session)
    return None


def _searched(session: Session, sure: bool = False) -> SearchResult:
    """A search without what was blamed for failures; less and less is left out where that finds nothing.

    First come also streams that were blamed, past what is not in the way of moves, or of the last; at last everything.
    """
    if session.lessons.tried and not sure:
        result = session.searches.search(Scope(novel=True))
        if result.plan is not None:
            return result
    if session.lessons.blames:
        for scope in (Scope(unbarred=True, sure=sure), Scope(arriving=True, sure=sure))[: 1 + session.goal_barred]:
            result = session.searches.search(scope)
            if result.plan is not None:
                return result
    return session.searches.search(Scope(sure=sure))


def _deepen(session: Session) -> bool:
    """Assume one more stream in a row, unless sampling should catch up first; whether that brought anything.

    What is assumed is never an object that the goal names: where no fact does, only a call can bring it.
    """
    rounds = session.rounds.count
    most = min(rounds, AHEAD) if session.goal_names_unknown else AHEAD + 1 + rounds // 2
    return session.grounder.deepen(most=most, patient=True)


def _replace_optimistic(session: Session) -> None:
    """Sample a while, after a search that took too long: fewer assumptions, or streams that end, may make it easier.

    Where there is a plan already, what was sampled is tried in it: a search for a cheaper one may ever take too long.
    """
    for _ in range(4):
        if not session.rounds.expand() and not session.grounder.deepen():
            break
    if session.found.best is not None:
        session.on_better(session)


def _expand(session: Session, worth: int = 0) -> None:
    """Draw from every stream after a search has found no plan, and again while that is less work than `worth`.

    Raises:
        Ended: where there is nothing to draw any more.
    """
    before, rounds = session.work, session.rounds.count
    if not _sample(session):
        _conclude(session, proven=session.lessons.proofs and not session.schema.undecided)
    for _ in range(rounds):
        if session.work - before >= worth or not session.rounds.expand():
            return


def _sample(session: Session, seen: bool = False) -> bool:
    """Draw from every stream once more, or assume more; whether there was anything left.

    `seen`: the search has just found a plan, so that the goal is within reach.
    """
    session.check_prospects(seen)
    session.grounder.be_shallow(drawing=True)
    count = session.rounds.count
    if count >= FIRST_LOOK and count.bit_count() == 1:
        session.surprises.look(besides=session.grounder.joined)
    return session.rounds.expand() or session.grounder.deepen() or session.surprises.look()


def _conclude(session: Session, proven: bool) -> None:
    """End the run, or begin it again without a simplification, as streams have nothing more to give.

    `proven`: a search has shown that there is no plan with what they gave.
    """
    session.check_surprises()
    if session.found.best is not None:
        raise Ended("solved", "No better plan exists." if proven else "No better plan was found in what streams gave.")
    if session.connectors.fluent and (session.lessons.failed_moves or not proven):
        raise Restart(replace(session.options, connectors=False))
    if session.options.lazy_tests and (session.schema.ambivalent or not proven):
        raise Restart(replace(session.options, lazy_tests=False))
    session.limits.check()  # a sampler may have ended because of the deadline
    gave_up = sorted({i.external.name for i in session.knowledge.instances() if i.exhausted and i.gave_up})
    if gave_up:
        raise Ended("failed", f"All streams have ended, but not because nothing more exists: {', '.join(gave_up)}.")
    if not proven:
        raise Ended("failed", "All streams are exhausted, but a search gave up, or plans failed for no named reason.")
    raise Ended("infeasible", "All streams are exhausted and no plan exists.")
