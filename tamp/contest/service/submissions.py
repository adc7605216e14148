"""Handing in: an upload is checked whole before it is accepted, and accepted once, with all the runs it asks for."""

from __future__ import annotations

import hashlib
import os
import tempfile
import time
import uuid
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, func, insert, select

from tamp.contest.definition import objection
from tamp.contest.package import unpack
from tamp.contest.sandbox.isolation import visible
from tamp.contest.service.contest import Contest, Kind
from tamp.contest.service.store import ATTEMPTS, QUEUED, RUNNING, SUBMISSIONS, TEAMS, TRIALS, WITHDRAWN, Store
from tamp.contest.service.teams import Team
from tamp.errors import TampError

SUFFIXES = (".py", ".zip", ".whl")

LONGEST_NAME = 100
"""Of a file, as it is shown [characters]: the end of a longer one."""


class TooManyError(TampError):
    """A team has used up what it may hand in for now."""


@dataclass(frozen=True)
class Accepted:
    """A submission's number, and whether it is new: the same file handed in twice is one submission."""

    id: str
    new: bool


def count_attempt(store: Store, contest: Contest, team: Team) -> None:
    """Note an attempt to upload.

    Raises:
        TooManyError: where there were too many within a minute.
    """
    most, now = contest.rules.uploads.a_minute, time.time()
    with store.change() as connection:
        _lock(connection, team)
        query = select(func.count()).where(ATTEMPTS.c.team == team.id, ATTEMPTS.c.at.between(now - 60, now))
        if connection.execute(query).scalar_one() >= most:
            raise TooManyError(f"more than {most} uploads within a minute; wait a little")
        connection.execute(insert(ATTEMPTS).values(team=team.id, at=now))


def suffix_of(name: str) -> str:
    """The ending of a file's name, where it is one that is accepted.

    Raises:
        TampError: where it is none.
    """
    suffix = Path(name).suffix.lower()
    if suffix not in SUFFIXES or not name.isprintable():
        raise TampError(f"expected a file whose name ends in {', '.join(SUFFIXES)} and can be printed")
    return suffix


def accept(store: Store, contest: Contest, data: Path, team: Team, kind: Kind, name: str, upload: Path) -> Accepted:
    """Accept an upload, or say why not.

    Args:
        store: the database.
        contest: its rules and tasks.
        data: the service's folder.
        team: who hands in.
        kind: "contest" or "trial".
        name: what the team calls the file; its ending says what it is.
        upload: the file as it came, alone in a folder of `tamp.contest.service.scratch`; it may be moved away.

    Raises:
        TampError: where the package cannot be accepted; TooManyError where the team has no submission left.
    """
    suffix = suffix_of(name)
    if not contest.entries[kind]:
        raise TampError(f"the contest has no {kind} tasks")
    named = upload.with_name(upload.name + suffix)
    upload.replace(named)
    with tempfile.TemporaryDirectory(dir=upload.parent) as folder:
        shown = Path(name).name[-LONGEST_NAME:]
        package = unpack(named, Path(folder) / "solution", contest.rules.uploads, shown)
        wrong = visible(objection(package.source))
        if wrong:
            raise TampError(f"{shown} {wrong}" if suffix == ".py" else f"{shown}: {package.source.name} {wrong}")
    digest = hashlib.sha256(named.read_bytes()).hexdigest()
    with store.change() as connection:
        _lock(connection, team)
        same = select(SUBMISSIONS.c.id).where(
            SUBMISSIONS.c.team == team.id, SUBMISSIONS.c.kind == kind, SUBMISSIONS.c.sha256 == digest
        )
        known = connection.execute(same).scalar()
        gone = connection.execute(select(WITHDRAWN.c.why).where(WITHDRAWN.c.submission == known)).first()
        if gone is not None:
            raise TampError(f"this file was withdrawn{': ' * bool(gone.why)}{gone.why}")
        if known is not None:
            return Accepted(known, new=False)
        _refuse_surplus(connection, contest, team, kind)
        _keep(named, package_path(data, digest, suffix))
        return Accepted(_insert(connection, contest, team, kind, name, digest), new=True)


def package_path(data: Path, digest: str, suffix: str) -> Path:
    """Where an accepted package is kept."""
    return data / "packages" / f"{digest}{suffix}"


def require_packages(store: Store, data: Path, *, every: bool = False) -> None:
    """Make sure that a folder is its database's: a run whose package is not there could not be done, and be given up.

    Args:
        store: the database.
        data: the service's folder.
        every: look for all packages, and not only for those of runs that wait.

    Raises:
        TampError: where packages are missing.
    """
    wanted = select(SUBMISSIONS.c.sha256, SUBMISSIONS.c.file)
    if not every:
        wanted = wanted.join(TRIALS, TRIALS.c.submission == SUBMISSIONS.c.id).where(
            TRIALS.c.state.in_((QUEUED, RUNNING))
        )
    with store.look() as connection:
        rows = connection.execute(wanted.distinct()).all()
    missing = [row for row in rows if not package_path(data, row.sha256, Path(row.file).suffix.lower()).is_file()]
    if missing:
        raise TampError(
            f"{data / 'packages'}: {len(missing)} of {len(rows)} packages that are to be run are not there; is the "
            "folder that of another contest than the database, or a backup not whole?"
        )


def _keep(upload: Path, place: Path) -> None:
    """Put a file where it stays, written to the disk before the database speaks of it."""
    with upload.open("rb") as file:
        os.fsync(file.fileno())
    place.parent.mkdir(exist_ok=True)
    upload.replace(place)
    folder = os.open(place.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)


def _lock(connection: Connection, team: Team) -> None:
    """Let a team's other uploads wait; SQLite has but one writer at a time anyhow."""
    connection.execute(select(TEAMS.c.id).where(TEAMS.c.id == team.id).with_for_update())


def left_this_month(store: Store, contest: Contest, team: Team, kind: Kind) -> int:
    """How many submissions to a set a team may still make in this calendar month (UTC)."""
    with store.look() as connection:
        return _left(connection, contest, team, kind)


def month_began() -> float:
    """When this calendar month began [s, UTC]."""
    now = datetime.now(timezone.utc)
    return now.replace(day=1, hour=0, minute=0, second=0, microsecond=0).timestamp()


def _left(connection: Connection, contest: Contest, team: Team, kind: Kind) -> int:
    given_back = select(WITHDRAWN.c.submission).where(WITHDRAWN.c.counts.is_(False))
    mine = (SUBMISSIONS.c.team == team.id, SUBMISSIONS.c.kind == kind, SUBMISSIONS.c.created >= month_began())
    count = select(func.count()).where(*mine, SUBMISSIONS.c.id.not_in(given_back))
    return max(0, _most(contest, kind) - connection.execute(count).scalar_one())


def _most(contest: Contest, kind: Kind) -> int:
    uploads = contest.rules.uploads
    return uploads.a_month if kind == "contest" else uploads.trials_a_month


def _refuse_surplus(connection: Connection, contest: Contest, team: Team, kind: Kind) -> None:
    if not _left(connection, contest, team, kind):
        most = _most(contest, kind)
        raise TooManyError(
            f"{most} submissions to the {kind} set in this month are the most; the next month begins anew"
        )


def _insert(connection: Connection, contest: Contest, team: Team, kind: Kind, name: str, digest: str) -> str:
    number = uuid.uuid4().hex
    shown = Path(name).name[-LONGEST_NAME:]
    row = {"id": number, "team": team.id, "kind": kind, "file": shown, "sha256": digest, "created": time.time()}
    connection.execute(insert(SUBMISSIONS).values(row))
    runs: list[Mapping[str, Any]] = [
        {"submission": number, "task": entry.label, "simulator": simulator, "run": run, "state": "queued"}
        for run in range(contest.rules.runs)
        for entry in contest.entries[kind]
        for simulator in contest.rules.simulators
    ]
    connection.execute(insert(TRIALS), runs)
    return number
