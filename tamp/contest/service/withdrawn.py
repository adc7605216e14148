"""What is withdrawn, by organisers or since it cannot be loaded: it is neither run nor ranked nor shown any more.

Nothing of it is lost: its runs are put aside (see `tamp.contest.service.store`), and follow changes of rules and tasks
there.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

from sqlalchemy import Connection, delete, func, insert, select, update

from tamp.contest.service.contest import Kind
from tamp.contest.service.queue import Claim
from tamp.contest.service.store import ASIDE, RUNNING, SUBMISSIONS, TEAMS, TRIALS, WITHDRAWN, Store
from tamp.contest.service.submissions import month_began
from tamp.contest.service.teams import Team
from tamp.errors import TampError


@dataclass(frozen=True)
class Withdrawn:
    """A submission that was withdrawn.

    Attributes:
        id, team, kind, file, created: as it was handed in.
        why: as the organisers or the worker say it; may be empty.
        counts: whether it counts among the submissions of its month.
    """

    id: str
    team: str
    kind: Kind
    file: str
    created: float
    why: str
    counts: bool


def withdraw(store: Store, numbers: Sequence[str], why: str, *, counts: bool) -> None:
    """Withdraw submissions, all of them or, where one is unknown, none; a run that is being done is not recorded.

    Args:
        store: the database.
        numbers: of the submissions.
        why: for the team.
        counts: they still count among the submissions of their month.

    Raises:
        TampError: names numbers that no submission has.
    """
    with store.change() as connection:
        _require(connection, numbers)
        _withdraw(connection, numbers, why, counts=counts)


def _withdraw(connection: Connection, numbers: Sequence[str], why: str, *, counts: bool) -> None:
    connection.execute(delete(WITHDRAWN).where(WITHDRAWN.c.submission.in_(numbers)))
    rows = [{"submission": n, "at": time.time(), "why": why, "counts": counts} for n in dict.fromkeys(numbers)]
    if rows:
        connection.execute(insert(WITHDRAWN), rows)
    mine = TRIALS.c.submission.in_(numbers)
    connection.execute(update(TRIALS).where(mine).values(state=ASIDE, lease=None, until=None))


def withdraw_unloadable(store: Store, held: Claim, why: str, most: int) -> bool:
    """Withdraw the submission of a run that is held, without its counting in its month.

    Args:
        store: the database.
        held: the run; none of its submission's is done.
        why: as the team reads it.
        most: how many of a team's in this month may be given back, all in all; each takes a worker's time.

    Returns:
        False, and nothing changed, where the team had so many, or another worker has the run by now.
    """
    mine = (TRIALS.c.id == held.trial, TRIALS.c.lease == held.lease, TRIALS.c.state == RUNNING)
    with store.change() as connection:
        team = connection.execute(
            select(SUBMISSIONS.c.team).join(TRIALS).where(*mine, SUBMISSIONS.c.id == held.submission)
        ).scalar()
        if team is None or _given_back(connection, team) >= most:
            return False
        _withdraw(connection, [held.submission], why, counts=False)
    return True


def restore(store: Store, numbers: Sequence[str]) -> None:
    """Take submissions back into the contest; their runs stay aside until `tamp.contest.service.queue.refresh`.

    Raises:
        TampError: names numbers that no submission that was withdrawn has.
    """
    with store.change() as connection:
        _require(connection, numbers)
        known = {one.id for one in _found(connection)}
        if some := [number for number in numbers if number not in known]:
            raise TampError(f"{', '.join(some)}: not withdrawn; nothing was changed")
        connection.execute(delete(WITHDRAWN).where(WITHDRAWN.c.submission.in_(numbers)))


def withdrawn(store: Store, team: Team | None = None) -> tuple[Withdrawn, ...]:
    """All submissions that were withdrawn, or those of a team, the newest first."""
    with store.look() as connection:
        return tuple(one for one in _found(connection) if team is None or one.team == team.name)


def submissions_of(store: Store, team: str) -> tuple[str, ...]:
    """The numbers of all submissions of a team."""
    with store.look() as connection:
        rows = connection.execute(select(SUBMISSIONS.c.id).join(TEAMS).where(TEAMS.c.name == team))
        return tuple(rows.scalars())


def _found(connection: Connection) -> list[Withdrawn]:
    columns = (SUBMISSIONS.c.id, TEAMS.c.name, SUBMISSIONS.c.kind, SUBMISSIONS.c.file, SUBMISSIONS.c.created)
    query = (
        select(*columns, WITHDRAWN.c.why, WITHDRAWN.c.counts)
        .select_from(WITHDRAWN.join(SUBMISSIONS).join(TEAMS))
        .order_by(SUBMISSIONS.c.created.desc(), SUBMISSIONS.c.id)
    )
    return [Withdrawn(*row) for row in connection.execute(query)]


def _require(connection: Connection, numbers: Sequence[str]) -> None:
    known = set(connection.execute(select(SUBMISSIONS.c.id).where(SUBMISSIONS.c.id.in_(numbers))).scalars())
    if some := [number for number in numbers if number not in known]:
        raise TampError(f"no submission has the number {', '.join(some)}; nothing was changed")


def _given_back(connection: Connection, team: int) -> int:
    """How many submissions of a team in this month were withdrawn and do not count."""
    mine = (SUBMISSIONS.c.team == team, SUBMISSIONS.c.created >= month_began(), WITHDRAWN.c.counts.is_(False))
    return connection.execute(select(func.count()).select_from(WITHDRAWN.join(SUBMISSIONS)).where(*mine)).scalar_one()
