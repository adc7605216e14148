"""Which run is done next, and that each is done once: leases that expire, and a word that only their holder knows."""

from __future__ import annotations

import time
import uuid
from dataclasses import dataclass

from sqlalchemy import and_, func, or_, select, update

from tamp.contest.service.contest import Kind
from tamp.contest.service.store import SUBMISSIONS, TRIALS, Store

LEASE_S = 60.0
"""How long a worker may be silent before its run is given to another one [s]."""


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

    Submissions take turns: the one with the fewest runs begun comes first, so that nobody waits for a long one.
    """
    now, lease = time.time(), uuid.uuid4().hex
    free = or_(TRIALS.c.state == "queued", and_(TRIALS.c.state == "running", TRIALS.c.until < now))
    begun = (
        select(TRIALS.c.submission, func.sum(TRIALS.c.claims).label("begun")).group_by(TRIALS.c.submission).subquery()
    )
    following = (
        select(TRIALS.c.id)
        .join(begun, begun.c.submission == TRIALS.c.submission)
        .join(SUBMISSIONS, SUBMISSIONS.c.id == TRIALS.c.submission)
        .where(free)
        .order_by(begun.c.begun, SUBMISSIONS.c.created, TRIALS.c.id)
        .limit(1)
    )
    while True:
        with store.change() as connection:
            trial = connection.execute(following).scalar()
            if trial is None:
                return None
            taken = connection.execute(
                update(TRIALS)
                .where(TRIALS.c.id == trial, free)
                .values(state="running", lease=lease, until=now + lease_s, claims=TRIALS.c.claims + 1)
            )
            if taken.rowcount == 1:  # else another worker was faster
                row = connection.execute(
                    select(TRIALS, SUBMISSIONS.c.kind, SUBMISSIONS.c.file, SUBMISSIONS.c.sha256)
                    .join(SUBMISSIONS, SUBMISSIONS.c.id == TRIALS.c.submission)
                    .where(TRIALS.c.id == trial)
                ).one()
                return Claim(
                    row.id, lease, row.submission, row.kind, row.file, row.sha256, row.task, row.simulator, row.run,
                    row.claims,
                )  # fmt: skip


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
        return connection.execute(changed).rowcount == 1


def give_back(store: Store, held: Claim) -> None:
    """Put a run that could not be done back into the queue."""
    with store.change() as connection:
        mine = (TRIALS.c.id == held.trial, TRIALS.c.lease == held.lease, TRIALS.c.state == "running")
        connection.execute(update(TRIALS).where(*mine).values(state="queued", lease=None, until=None))


def waiting(store: Store) -> int:
    """Runs that are not done."""
    with store.look() as connection:
        return connection.execute(select(func.count()).where(TRIALS.c.state != "done")).scalar_one()
