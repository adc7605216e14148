"""The database: SQLite in the data folder, or PostgreSQL by URL."""

from __future__ import annotations

import sqlite3
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from sqlalchemy import (
    Boolean,
    Column,
    Connection,
    Float,
    ForeignKey,
    Integer,
    MetaData,
    String,
    Table,
    Text,
    UniqueConstraint,
    create_engine,
    event,
    inspect,
)
from sqlalchemy.exc import ArgumentError, DatabaseError, DBAPIError, InterfaceError, OperationalError
from sqlalchemy.exc import TimeoutError as NoConnectionError

from tamp.errors import TampError

BUSY_S = 30.0
"""How long a transaction waits for another one [s]."""

AGAIN_S = 0.01
"""After so long what SQLite does not wait for is asked again [s]."""

OUT_OF_REACH = (OperationalError, InterfaceError, NoConnectionError)
"""Raised where the database does not answer: it is down, a connection was lost, none is to be had, SQLite is locked."""

MAKING_TABLES = 0x7A3B
"""The number of PostgreSQL's lock that whoever makes tables holds; it means nothing else."""

META = MetaData()
TEAMS = Table(
    "teams",
    META,
    Column("id", Integer, primary_key=True),
    Column("name", String(80), nullable=False, unique=True),
    Column("token_sha256", String(64), nullable=False, unique=True),
    Column("created", Float, nullable=False),
)
ATTEMPTS = Table(
    "attempts",
    META,
    Column("id", Integer, primary_key=True),
    Column("team", ForeignKey("teams.id"), nullable=False, index=True),
    Column("at", Float, nullable=False),
)
SUBMISSIONS = Table(
    "submissions",
    META,
    Column("id", String(32), primary_key=True),
    Column("team", ForeignKey("teams.id"), nullable=False),
    Column("kind", String(8), nullable=False),
    Column("file", String(100), nullable=False),
    Column("sha256", String(64), nullable=False),
    Column("created", Float, nullable=False),
    UniqueConstraint("team", "kind", "sha256"),
)
TRIALS = Table(
    "trials",
    META,
    Column("id", Integer, primary_key=True),
    Column("submission", ForeignKey("submissions.id"), nullable=False, index=True),
    Column("task", String(100), nullable=False),
    Column("simulator", String(100), nullable=False),
    Column("run", Integer, nullable=False),
    Column("state", String(8), nullable=False, index=True),
    Column("lease", String(32)),
    Column("until", Float),
    Column("claims", Integer, nullable=False, default=0),
    Column("evaluations", Integer, nullable=False, default=0),
    Column("result", Text),
    Column("log", Text),
    UniqueConstraint("submission", "task", "simulator", "run"),
)
CONDITIONS = Table(
    "conditions",
    META,
    Column("id", Integer, primary_key=True),
    Column("at", Float, nullable=False),
    Column("value", Text, nullable=False),
)
"""Under what runs were done, the latest last: see `tamp.contest.service.conditions`."""
TURNS = Table(
    "turns",
    META,
    Column("id", Integer, primary_key=True),
    Column("team", ForeignKey("teams.id"), nullable=False, index=True),
)
"""The latest run of each team that was begun, by a number that rises."""
PUT_OFF = Table(
    "put_off",
    META,
    Column("trial", ForeignKey("trials.id"), primary_key=True),
    Column("since", Float, nullable=False),
    Column("times", Integer, nullable=False),
    Column("cause", Text, nullable=False),
)
"""Runs that could not be begun for want of something: since when, how often in a row, and why the last time."""
WITHDRAWN = Table(
    "withdrawn",
    META,
    Column("submission", ForeignKey("submissions.id"), primary_key=True),
    Column("at", Float, nullable=False),
    Column("why", Text, nullable=False),
    Column("counts", Boolean, nullable=False),
)
"""Submissions that the organisers withdrew, why, and whether they count among those of their month."""

QUEUED, RUNNING, DONE, ASIDE = "queued", "running", "done", "aside"
"""The states of a run; what is aside no longer counts, and keeps what came of it."""


class StoreFullError(Exception):
    """There is no room left for the database or the uploads."""


class DamagedError(TampError):
    """What is in the database cannot be read any more."""


class Store:
    """A database.

    Args:
        url: as SQLAlchemy takes it.

    Raises:
        TampError: where it cannot be reached, or its driver is not installed.
    """

    def __init__(self, url: str) -> None:
        try:
            self._engine = create_engine(url, pool_pre_ping=True)
            if self._engine.dialect.name == "sqlite":
                event.listen(self._engine, "connect", _prepare_sqlite)
                event.listen(self._engine, "begin", _begin_sqlite)
            self._make_tables()
        except ModuleNotFoundError as error:
            raise TampError(f"the database needs {error.name}: pip install 'tabletop-tamp[postgresql]'") from None
        except (ArgumentError, DBAPIError) as error:
            raise TampError(f"the database cannot be used: {str(error).splitlines()[0]}") from None

    def _make_tables(self) -> None:
        """Make those that are missing; where several processes find so at once, one after the other looks again."""
        with self._engine.connect() as connection:
            there = inspect(connection).get_table_names()
        if not META.tables.keys() <= set(there):
            with self._engine.connect().execution_options(writes=True) as connection, connection.begin():
                if self._engine.dialect.name == "postgresql":  # whose writers do not wait for each other
                    connection.exec_driver_sql(f"SELECT pg_advisory_xact_lock({MAKING_TABLES})")
                META.create_all(connection)

    def close(self) -> None:
        """Close all connections."""
        self._engine.dispose()

    @contextmanager
    def change(self) -> Iterator[Connection]:
        """A transaction that writes; all of it happens or nothing.

        Raises:
            StoreFullError: where there is no room left.
            DamagedError: where it cannot be read any more.
        """
        with _told(), self._engine.connect().execution_options(writes=True) as connection, connection.begin():
            yield connection

    @contextmanager
    def look(self) -> Iterator[Connection]:
        """A transaction that only reads.

        Raises:
            DamagedError: where it cannot be read any more.
        """
        with _told(), self._engine.connect() as connection, connection.begin():
            yield connection


@contextmanager
def _told() -> Iterator[None]:
    """What is for others to act upon, as errors of our own."""
    try:
        yield
    except OperationalError as error:
        text = str(error).lower()
        if "disk is full" in text or "no space" in text or "disk i/o" in text:
            raise StoreFullError("the disk is full") from error
        raise
    except DatabaseError as error:
        if type(error) is DatabaseError:  # none of its kinds: the file itself is wrong
            said = str(error.orig)
            raise DamagedError(
                f"the database is damaged ({said}); stop the service, and put a backup in place"
            ) from None
        raise


def _prepare_sqlite(connection: Any, _: Any) -> None:
    connection.isolation_level = None  # transactions begin below, and not where the driver guesses
    cursor = connection.cursor()
    cursor.execute(f"PRAGMA busy_timeout={round(1000 * BUSY_S)}")
    _log_ahead(cursor)
    for pragma in ("synchronous=FULL", "foreign_keys=ON"):
        cursor.execute(f"PRAGMA {pragma}")
    cursor.close()


def _log_ahead(cursor: sqlite3.Cursor) -> None:
    """Have a write-ahead log. SQLite does not wait where two connections to a new file ask for it at once."""
    until = time.monotonic() + BUSY_S
    while not _logs_ahead(cursor, last=time.monotonic() > until):
        time.sleep(AGAIN_S)


def _logs_ahead(cursor: sqlite3.Cursor, *, last: bool) -> bool:
    """Ask for that once; False where another connection is in the way, and this is not the last time."""
    try:
        cursor.execute("PRAGMA journal_mode=WAL")
    except sqlite3.OperationalError as error:
        if last or "locked" not in str(error):
            raise
        return False
    return True


def _begin_sqlite(connection: Connection) -> None:
    writes = connection.get_execution_options().get("writes")
    connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")


def open_store(data: Path, url: str | None = None) -> Store:
    """The database of a data folder, or of a URL."""
    data.mkdir(parents=True, exist_ok=True)
    return Store(url or f"sqlite:///{(data / 'contest.db').resolve()}")
