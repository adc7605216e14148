"""Cheaper plans at little cost, once there is one: other values for its skeleton, and a brief search below its cost.

The first values that fit are as dear as chance has it, so that the choices of a plan are made anew, one at a time, and
what is cheaper is kept: local search in the space of assignments (Aarts and Lenstra, "Local Search in Combinatorial
Optimization", 1997). How much is done is counted in calls of streams and in states, whatever time these take.
"""

from __future__ import annotations

import math
from collections import Counter

from tamp.planning.algorithms.neighbourhood import Neighbourhood
from tamp.planning.algorithms.preview import Preview
from tamp.planning.algorithms.session import Session
from tamp.planning.binding.attempt import Budget
from tamp.planning.binding.skeleton import Choose
from tamp.planning.grounding.operators import GroundOperator
from tamp.planning.grounding.task_builder import Scope
from tamp.planning.model.stream_instances import Instance

CALLS, LEAST_CALLS = 0.5, 200
"""How many calls other values may take: a share of those that finding the plan took, or so many where that is more."""

CALLS_A_CHOICE = 12
"""The same for each choice of a long plan, so that all have their turn."""

AGAIN_CALLS, LEAST_AGAIN = 0.25, 100
"""The same of skeletons that are tried again."""

SEARCHING, LEAST_SEARCHING = 0.25, 400
"""The same of the work of searches."""

ROUNDS = 20
"""How many other values each choice may be given."""

TRIED_AGAIN, TRIES = 4, 3
"""How many skeletons that failed are tried again, and how often each."""

AGAIN = Budget(values=12, draws=30, jumps=250)
"""What the first attempt at one of them may spend; each after it spends twice as much."""

BRIEF = Budget(values=3, draws=20, patience=2, jumps=40, barren=0)
"""What an attempt at a cheaper skeleton may spend."""

NEIGHBOUR = Budget(values=1, draws=0, patience=2, jumps=4, barren=0)
"""What an attempt may spend that differs from the best plan in one choice."""


def improve(session: Session) -> None:
    """Improve on the best plan of a session, where actions have costs, or fewer actions are worth a moment.

    Raises:
        Ended: where time is over.
    """
    sampling = session.sampling
    if session.found.skeleton is None or (session.costs.unit and not _may_be_shorter(session)):
        return
    calls, searching = sampling.calls, session.searches.work
    again, anew = max(int(AGAIN_CALLS * calls), LEAST_AGAIN), max(int(CALLS * calls), LEAST_CALLS)
    worth = max(int(SEARCHING * searching), LEAST_SEARCHING)
    session.costs.guess(True)
    try:
        _try_again(session, sampling.calls + again)
        _draw_below(session, searching + worth // 4, sampling.calls + anew)
        if session.costs.unit:
            if session.eager:
                _search_near(session, session.searches.work + worth, sampling.calls + anew)
            return
        _choose_anew(session, sampling.calls + anew)
        cost = session.found.cost
        _search_below(session, session.searches.work + worth)
        _try_again(session, sampling.calls + again)
        if session.found.cost < cost:
            _choose_anew(session, sampling.calls + anew)
        _search_near(session, session.searches.work + worth, sampling.calls + anew)
    finally:  # a session may be asked further after its time was over
        session.costs.guess(False)


def _may_be_shorter(session: Session) -> bool:
    """Whether fewer actions are worth a moment; nothing is shorter than one."""
    return session.options.shorten and len(session.found.best or ()) > 1


def _try_again(session: Session, most: int) -> None:
    """Try skeletons again that failed before a dearer one was bound, while there are less than `most` calls in all.

    It may have been for want of luck: they have turns, the cheapest first, and each may spend twice as much as in the
    turn before. So what cannot be bound at all does not keep the others from theirs. Values that the search saw are
    left open again.
    """
    failed = [] if session.sampling.wild else session.failed()  # what streams bring besides is for the search to use
    lifted = dict.fromkeys(map(session.lifted, failed))
    prices = {s: sum(map(session.costs.of_operator, s.steps)) for s in lifted if s.leaves_open}
    waiting = sorted(prices, key=prices.__getitem__)[:TRIED_AGAIN]
    for tries in range(TRIES):
        for skeleton in tuple(waiting):
            bound, calls = session.found.bound(), session.sampling.calls
            if calls >= most or bound is None or prices[skeleton] >= bound:
                return
            session.limits.check()
            attempt = session.binder.bind(skeleton, AGAIN.grown(tries), turn=tries)
            if session.found.take(skeleton, attempt) or session.sampling.calls == calls:
                waiting.remove(skeleton)


def _draw_below(session: Session, enough: int, most: int) -> None:
    """Where the best plan was found among real values, draw from all streams once more, and search below its cost.

    Values that a cheaper plan needs may have been missing by chance. Where costs do not depend on values, and searches
    see what was drawn alone, it is done again and again. Nothing is drawn where streams would be called more often than
    `most` times in all; there is less work of searches than `enough` in all.
    """
    while (skeleton := session.found.skeleton) is not None and not skeleton.leaves_open:
        calls = session.sampling.calls + sum(i.unfinished for i in session.knowledge.instances())
        if calls >= most or session.searches.work >= enough or not session.rounds.expand(tests=True):
            return
        _search_below(session, enough, sure=True)
        if not (session.costs.unit and session.eager):  # other calls are for values, or enough was seen
            return


def _search_near(session: Session, enough: int, most: int) -> None:
    """Search below the cost of the best plan among its values and their like, and choose values anew.

    Each time that it finds a cheaper plan it looks near that. There is less work of searches than `enough` in all, and
    there are less than `most` calls of streams before values are chosen the first time.
    """
    share = most - session.sampling.calls
    cost = math.inf
    while not session.sampling.wild and session.found.cost < cost and session.searches.work < enough:
        cost = session.found.cost
        near = Neighbourhood(session)
        near.ask(session.sampling.calls + share)
        _search_below(session, enough, among=near.operators())
        if session.found.cost < cost:
            _choose_anew(session, session.sampling.calls + share)
            share //= 2


def _search_below(
    session: Session, enough: int, sure: bool = False, among: frozenset[GroundOperator] | None = None
) -> None:
    """Try skeletons below the cost of the best plan, while there is less work of searches than `enough` in all.

    Where the search sees none but one that was tried, it looks past streams that failed. What one value fails for is
    asked of its like, for as many calls as the search was work. `sure`: of values that are real alone;
    `among`: of these actions alone, with what each move costs that is left to binding, and below what was tried.
    """
    near = among is not None
    tried = {session.found.skeleton}
    for novel in (False,) if near else (False, True):
        below: int | None = None
        while session.searches.work < enough:
            searching, refuted = session.searches.work, len(session.knowledge.refuted)
            if near:
                session.costs.guess(True)  # until a cheaper plan is found
            found = session.cheaper(enough, Scope(sure=sure, novel=novel, pairs=near, among=among), below)
            if found is None:
                return
            skeleton, below = found[0], found[1] if near else None
            if skeleton in tried and not near:
                break
            if skeleton in tried:
                continue
            tried.add(skeleton)
            cost = session.found.cost
            attempt = session.attempt(skeleton, BRIEF)
            if near and attempt.steps is None:  # its order may do with other values
                attempt = session.attempt(session.lifted(skeleton), AGAIN)
            below = below if session.found.cost == cost else None  # costs have another scale
            if attempt.steps is None:
                session.rounds.ask_alike(refuted, most=session.searches.work - searching)


def _choose_anew(session: Session, most: int) -> None:
    """Make the choices of the best plan anew, while there are less than `most` calls of streams in all or few for each.

    What a plan costs is known by its choices, mostly: nothing is checked of those that make it no cheaper.
    """
    found = session.found
    if found.skeleton is None or not session.costs.by_values(step.schema for step in found.best or ()):
        return
    skeleton, values = session.reopened(found.skeleton)
    choices = [item.template for item in skeleton.items if isinstance(item, Choose)]
    most = max(most, session.sampling.calls + CALLS_A_CHOICE * len(choices))
    preview = Preview(session, skeleton, NEIGHBOUR)
    seen: Counter[tuple[Instance, tuple[int, ...]]] = Counter()
    for _ in range(ROUNDS):
        for template in preview.choices:
            session.limits.check()
            if session.sampling.calls >= most:
                return
            chosen = {(t, _inputs(t, values)): _number(session, t, values) for t in choices}
            key = template, _inputs(template, values)
            seen[key] += seen[key] == chosen[key]
            instance = session.knowledge.instance(template.external, key[1])
            if seen[key] < len(instance.results) or not instance.exhausted:
                begin = {**chosen, key: seen[key]}
                if preview.least(begin, values) < found.cost:
                    attempt = session.binder.bind(skeleton, NEIGHBOUR, begin=begin)
                    values = attempt.values if found.take(found.skeleton, attempt) else values
            seen[key] += 1


def _inputs(template: Instance, values: dict[int, int]) -> tuple[int, ...]:
    return tuple(values.get(h, h) for h in template.inputs)


def _number(session: Session, template: Instance, values: dict[int, int]) -> int:
    """The number of the result that stands in a plan for what a template leaves open."""
    results = session.knowledge.instance(template.external, _inputs(template, values)).results
    return results.index(tuple(values[h] for h in template.placeholders))
