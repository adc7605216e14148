"""Which run is done next, and that each is done once: leases that expire, and a word that only their holder knows.

Which runs there are follows from rules and tasks; where these have changed, it is held against them anew.
"""

from __future__ import annotations

import time
import uuid
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sqlalchemy import ColumnElement, Connection, and_, delete, func, insert, or_, select, update

from tamp.contest.rules import LONGEST_LEASE_S
from tamp.contest.service.conditions import (
    Conditions,
    Run,
    changes,
    conditions,
    from_text,
    labelled,
    labels,
    runs,
    to_text,
)  # fmt: skip
from tamp.contest.service.contest import Contest, Kind
from tamp.contest.service.store import (
    ASIDE,
    CONDITIONS,
    DONE,
    PUT_OFF,
    QUEUED,
    RUNNING,
    SUBMISSIONS,
    TRIALS,
    TURNS,
    WITHDRAWN,
    Store,
)
from tamp.errors import TampError
from tamp.results import from_json

LEASE_S = 60.0
"""How long a worker may be silent before its run is given to another one [s]."""

PUT_OFF_S, LONGEST_PUT_OFF_S = 60.0, 600.0
"""When a run is tried again that could not be begun for want of something, twice as late each time, and at most [s]."""

HOPELESS = 3
"""A run that was put off so often in a row is not waited for by who waits for the end of all."""


@dataclass(frozen=True)
class Claim:
    """A run that a worker holds.

    Attributes:
        trial: its number.
        lease: the word by which it is held.
        submission, kind, file, sha256: whose it is, and its package.
        task, simulator, run: what is to be done.
        claims: how often it has been begun, this time included.
    """

    trial: int
    lease: str
    submission: str
    kind: Kind
    file: str
    sha256: str
    task: str
    simulator: str
    run: int
    claims: int


def claim(store: Store, lease_s: float = LEASE_S) -> Claim | None:
    """Take the next run; None where there is none.

    Teams take turns, however much each has handed in, and so do the submissions of a team: the one with the fewest runs
    begun comes first, so that none waits for a long one.
    """
    now, lease = time.time(), uuid.uuid4().hex
    # What ends later than anything given now was given by a clock that has been put back since.
    rested = or_(TRIALS.c.until.is_(None), TRIALS.c.until < now, TRIALS.c.until > now + LONGEST_LEASE_S)
    free = and_(TRIALS.c.state.in_((QUEUED, RUNNING)), rested)
    begun = (
        select(TRIALS.c.submission, func.sum(TRIALS.c.claims).label("begun")).group_by(TRIALS.c.submission).subquery()
    )
    turns = select(TURNS.c.team, func.max(TURNS.c.id).label("last")).group_by(TURNS.c.team).subquery()
    following = (
        select(TRIALS.c.id, SUBMISSIONS.c.team)
        .join(begun, begun.c.submission == TRIALS.c.submission)
        .join(SUBMISSIONS, SUBMISSIONS.c.id == TRIALS.c.submission)
        .outerjoin(turns, turns.c.team == SUBMISSIONS.c.team)
        .where(free)
        .order_by(func.coalesce(turns.c.last, 0), begun.c.begun, SUBMISSIONS.c.created, TRIALS.c.id)
        .limit(1)
    )
    while True:
        with store.change() as connection:
            first = connection.execute(following).first()
            if first is None:
                return None
            trial, team = first
            taken = connection.execute(
                update(TRIALS)
                .where(TRIALS.c.id == trial, free)
                .values(state="running", lease=lease, until=now + lease_s, claims=TRIALS.c.claims + 1)
            )
            if taken.rowcount == 1:  # else another worker was faster
                connection.execute(delete(TURNS).where(TURNS.c.team == team))
                connection.execute(insert(TURNS).values(team=team))
                row = connection.execute(
                    select(TRIALS, SUBMISSIONS.c.kind, SUBMISSIONS.c.file, SUBMISSIONS.c.sha256)
                    .join(SUBMISSIONS, SUBMISSIONS.c.id == TRIALS.c.submission)
                    .where(TRIALS.c.id == trial)
                ).one()
                return Claim(
                    row.id, lease, row.submission, row.kind, row.file, row.sha256, row.task, row.simulator, row.run,
                    row.claims,
                )  # fmt: skip


def untried(store: Store, held: Claim) -> bool:
    """Whether no run of a submission is done yet."""
    done = (TRIALS.c.submission == held.submission, TRIALS.c.state == DONE)
    with store.look() as connection:
        return connection.execute(select(TRIALS.c.id).where(*done).limit(1)).first() is None


def renew(store: Store, held: Claim, lease_s: float = LEASE_S) -> bool:
    """Hold a run longer; False where another worker has it by now."""
    with store.change() as connection:
        mine = (TRIALS.c.id == held.trial, TRIALS.c.lease == held.lease, TRIALS.c.state == "running")
        return connection.execute(update(TRIALS).where(*mine).values(until=time.time() + lease_s)).rowcount == 1


def finish(store: Store, held: Claim, result: str, log: str) -> bool:
    """Record what came of a run; False, and nothing recorded, where another worker has it by now."""
    with store.change() as connection:
        mine = (TRIALS.c.id == held.trial, TRIALS.c.lease == held.lease, TRIALS.c.state == "running")
        values = {"state": "done", "lease": None, "until": None, "result": result, "log": log}
        changed = update(TRIALS).where(*mine).values(**values, evaluations=TRIALS.c.evaluations + 1)
        if connection.execute(changed).rowcount != 1:
            return False
        connection.execute(delete(PUT_OFF).where(PUT_OFF.c.trial == held.trial))
        return True


def give_back(store: Store, held: Claim) -> None:
    """Put a run that could not be done back into the queue."""
    with store.change() as connection:
        _requeue(connection, held, until=None)


def put_off(store: Store, held: Claim, cause: str) -> float:
    """Put a run that could not be begun back into the queue as if it had not been claimed, for later.

    Args:
        store: the database.
        held: the run.
        cause: why, for the organisers.

    Returns:
        How long others come before it [s]: what has been claimed least often is first otherwise.
    """
    now = time.time()
    with store.change() as connection:
        before = connection.execute(select(PUT_OFF).where(PUT_OFF.c.trial == held.trial)).first()
        since, times = (now, 1) if before is None else (before.since, before.times + 1)
        pause_s = min(PUT_OFF_S * 2.0 ** min(times - 1, 30), LONGEST_PUT_OFF_S)
        if _requeue(connection, held, until=now + pause_s, claims=TRIALS.c.claims - 1):
            connection.execute(delete(PUT_OFF).where(PUT_OFF.c.trial == held.trial))
            connection.execute(insert(PUT_OFF).values(trial=held.trial, since=since, times=times, cause=cause))
    return pause_s


def _requeue(connection: Connection, held: Claim, **values: Any) -> bool:
    """Queue a run again; False where another worker has it by now."""
    mine = (TRIALS.c.id == held.trial, TRIALS.c.lease == held.lease, TRIALS.c.state == RUNNING)
    return connection.execute(update(TRIALS).where(*mine).values(state=QUEUED, lease=None, **values)).rowcount == 1


def waiting(store: Store) -> int:
    """Runs that are not done, but for those that were put off again and again."""
    hoped = or_(TRIALS.c.state == RUNNING, PUT_OFF.c.times.is_(None), PUT_OFF.c.times < HOPELESS)
    with store.look() as connection:
        return connection.execute(
            select(func.count())
            .select_from(TRIALS.outerjoin(PUT_OFF))
            .where(TRIALS.c.state.in_((QUEUED, RUNNING)), hoped)
        ).scalar_one()


@dataclass(frozen=True)
class PutOff:
    """Runs that cannot be begun.

    Attributes:
        runs: how many.
        since: when the first of them was put off [s, UTC].
        cause: why the one that was tried last could not be begun; for the organisers, since it may name files.
    """

    runs: int
    since: float
    cause: str

    def __str__(self) -> str:
        since = time.strftime("%d %b %Y %H:%M UTC", time.gmtime(self.since))
        return f"{self.runs} run{'s' * (self.runs > 1)} put off since {since}: {self.cause}"


def put_off_now(store: Store, submission: str | None = None) -> PutOff | None:
    """What is put off, of all submissions or of one; None where nothing is."""
    there: list[ColumnElement[bool]] = [TRIALS.c.state.in_((QUEUED, RUNNING))]
    if submission is not None:
        there.append(TRIALS.c.submission == submission)
    with store.look() as connection:
        rows = connection.execute(
            select(PUT_OFF.c.since, PUT_OFF.c.cause).join(TRIALS).where(*there).order_by(TRIALS.c.until)
        ).all()
    return PutOff(len(rows), min(row.since for row in rows), rows[-1].cause) if rows else None


def settled(store: Store, contest: Contest) -> Contest:
    """The contest with the labels that its tasks have in the database, where they are kept from now on.

    Raises:
        TampError: where something was handed in that was run under other conditions.
    """
    with store.change() as connection:
        history = _recorded(connection)
        contest = labelled(contest, labels(history)["contest"])
        now, before = conditions(contest), history[-1] if history else None
        different = [] if before is None else list(changes(before, now))
        if different and connection.execute(select(SUBMISSIONS.c.id).limit(1)).first() is not None:
            path = contest.rules.path or Path()
            raise TampError(
                f"{path}: what was handed in was run under other conditions: {'; '.join(different)}; change it back, "
                f"or hold all submissions against the new ones: tamp contest again --data {path.parent}"
            )
        if before != now:
            _record(connection, now)
    return contest


@dataclass(frozen=True)
class Renewal:
    """What became of the runs of all submissions.

    Attributes:
        queued: numbers of those that are to be done.
        aside: how many no longer count.
    """

    queued: tuple[int, ...]
    aside: int


def refresh(store: Store, contest: Contest, *, everything: bool = False) -> Renewal:
    """Hold all submissions against rules and tasks as they are now; no worker may be at work.

    Runs that are missing, that the server could not do, or that were done under other conditions are queued, and those
    that no longer count put aside.

    Args:
        store: the database.
        contest: as it was read.
        everything: do every run anew.
    """
    with store.change() as connection:
        history = _recorded(connection)
        known = labels(history)
        now = conditions(labelled(contest, known["contest"]))
        afresh = everything or (bool(history) and history[-1].scene != now.scene)
        withdrawn = set(connection.execute(select(WITHDRAWN.c.submission)).scalars())
        queued, aside = [], 0
        for number, kind in connection.execute(select(SUBMISSIONS.c.id, SUBMISSIONS.c.kind)).all():
            same = {label for label, digest in now.tasks[kind].items() if known[kind].get(label, digest) == digest}
            wanted = list(runs(now, kind))
            _add_missing(connection, number, wanted)
            for row in connection.execute(select(TRIALS).where(TRIALS.c.submission == number)).all():
                lost = row.result is None or from_json(row.result).status == "error"
                stale = afresh or lost or (row.task in now.tasks[kind] and row.task not in same)
                counts = number not in withdrawn and (row.task, row.simulator, row.run) in wanted
                _put(connection, row.id, (QUEUED if stale else DONE) if counts else ASIDE, stale=stale)
                queued += [row.id] if stale and counts else []
                aside += not counts
        _record(connection, now)
    return Renewal(tuple(queued), aside)


def _add_missing(connection: Connection, submission: str, wanted: Sequence[Run]) -> None:
    """Add the runs of a submission that it does not have."""
    columns = (TRIALS.c.task, TRIALS.c.simulator, TRIALS.c.run)
    there = {tuple(row) for row in connection.execute(select(*columns).where(TRIALS.c.submission == submission))}
    rows = [
        {"submission": submission, "task": task, "simulator": simulator, "run": run, "state": QUEUED}
        for task, simulator, run in wanted
        if (task, simulator, run) not in there
    ]
    if rows:
        connection.execute(insert(TRIALS), rows)


def _put(connection: Connection, trial: int, state: str, *, stale: bool) -> None:
    """Give a run a state; one that is stale forgets what came of it."""
    values: dict[str, Any] = {"state": state, "lease": None, "until": None}
    values |= {"result": None, "log": None, "claims": 0} if stale else {}
    connection.execute(delete(PUT_OFF).where(PUT_OFF.c.trial == trial))
    connection.execute(update(TRIALS).where(TRIALS.c.id == trial).values(**values))


def _recorded(connection: Connection) -> tuple[Conditions, ...]:
    """All conditions that there were, the latest last."""
    rows = connection.execute(select(CONDITIONS.c.value).order_by(CONDITIONS.c.id)).scalars()
    return tuple(map(from_text, rows))


def _record(connection: Connection, now: Conditions) -> None:
    connection.execute(insert(CONDITIONS).values(at=time.time(), value=to_text(now)))
