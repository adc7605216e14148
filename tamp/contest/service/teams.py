"""Teams and their tokens; of a token, only the hash is kept."""

from __future__ import annotations

import hashlib
import secrets
import time
import unicodedata
from dataclasses import dataclass

from sqlalchemy import insert, select, update
from sqlalchemy.exc import IntegrityError

from tamp.contest.service.lookalikes import alike, misleading
from tamp.contest.service.store import TEAMS, Store
from tamp.errors import TampError, meant

LONGEST = 60


@dataclass(frozen=True)
class Team:
    """A team."""

    id: int
    name: str


def _hash(token: str) -> str:
    # Tokens are 256 random bits: there is nothing that a slow hash would protect.
    return hashlib.sha256(token.encode()).hexdigest()


def add_team(store: Store, name: str) -> str:
    """Add a team; its token, which nobody can look up later.

    Raises:
        TampError: where the name is taken, or looks like one that is, is empty, too long, mixes scripts in a word, or
            holds characters that cannot be seen.
    """
    name = _kept(name)
    mine = alike(name)
    if "" in mine or len(name) > LONGEST or any(unicodedata.category(c)[0] in "CZ" and c != " " for c in name):
        raise TampError(f"a team's name has 1 to {LONGEST} characters that can be seen, and spaces between them")
    if wrong := misleading(name):
        raise TampError(wrong)
    token = secrets.token_urlsafe(32)
    try:
        with store.change() as connection:
            for other in connection.execute(select(TEAMS.c.name)).scalars():
                if other != name and mine & alike(other):
                    raise TampError(f"{name!r} looks like the team {other!r}, which there is already")
            connection.execute(insert(TEAMS).values(name=name, token_sha256=_hash(token), created=time.time()))
    except IntegrityError:
        raise TampError(f"there is a team called {name!r} already") from None
    return token


def _kept(name: str) -> str:
    """A name as the database has it, however it was typed: accents are one character with their letter."""
    return unicodedata.normalize("NFC", name).strip()


def renew_token(store: Store, name: str) -> str:
    """A new token in place of a team's old one, which is worth nothing from then on.

    Raises:
        TampError: where there is no such team.
    """
    name, token = _kept(name), secrets.token_urlsafe(32)
    with store.change() as connection:
        changed = connection.execute(update(TEAMS).where(TEAMS.c.name == name).values(token_sha256=_hash(token)))
    if changed.rowcount != 1:
        near = meant(name, team_names(store)).strip()
        raise TampError(f"there is no team called {name!r}{near and f'; {near}'}")
    return token


def team_of(store: Store, token: str | None) -> Team | None:
    """Whose token it is; None where it is nobody's."""
    if not token or len(token) > 200 or not token.isascii():
        return None
    with store.look() as connection:
        row = connection.execute(select(TEAMS.c.id, TEAMS.c.name).where(TEAMS.c.token_sha256 == _hash(token))).first()
    return None if row is None else Team(row.id, row.name)


def team_names(store: Store) -> tuple[str, ...]:
    """All names, sorted."""
    with store.look() as connection:
        return tuple(connection.execute(select(TEAMS.c.name).order_by(TEAMS.c.name)).scalars())


def carry_teams(source: Store, store: Store) -> int:
    """Add the teams of another contest, whose tokens are then good for both; how many were not there yet.

    Raises:
        TampError: where one has a name that is taken, or looks like one that is; nothing was changed then.
    """
    with source.look() as connection:
        rows = connection.execute(select(TEAMS.c.name, TEAMS.c.token_sha256).order_by(TEAMS.c.id)).all()
    with store.change() as connection:
        there = connection.execute(select(TEAMS.c.name, TEAMS.c.token_sha256)).all()
        taken = frozenset[str]().union(*(alike(row.name) for row in there))
        new = [row for row in rows if tuple(row) not in map(tuple, there)]
        if clash := [row.name for row in new if alike(row.name) & taken]:
            raise TampError(f"there are other teams called {', '.join(clash)} or nearly so; nothing was changed")
        for row in new:
            connection.execute(insert(TEAMS).values(**row._mapping, created=time.time()))
    return len(new)
