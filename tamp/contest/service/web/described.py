"""What OpenAPI says beside what FastAPI sees by itself: tokens, files, answers, and the one form of refusals."""

from __future__ import annotations

from typing import Any, Literal

from fastapi import Security
from fastapi.security import HTTPBearer
from pydantic import BaseModel, ConfigDict
from pydantic.json_schema import SkipJsonSchema

from tamp.contest.service.contest import Kind
from tamp.results import Result

Responses = dict[int | str, dict[str, Any]]

TOKEN = Security(HTTPBearer(auto_error=False, scheme_name="token", description="A team's token."))
"""Tells the API's description where a token goes; the routes read it themselves."""
OPTIONAL: dict[str, Any] = {"security": [{}]}
"""Beside a token: that there may be none."""
BINARY = {"schema": {"type": "string", "format": "binary"}}
ARCHIVE: Responses = {200: {"content": {"application/zip": BINARY}}}
UPLOAD = {"requestBody": {"content": {"application/octet-stream": BINARY}, "required": True}}


class Answer(BaseModel):
    """What is answered: what is listed, and nothing else."""

    model_config = ConfigDict(extra="forbid")


class Refused(Answer):
    """Why something is not done."""

    detail: str


class Submitted(Answer):
    """A submission's number, whether it is new, and where its page is."""

    id: str
    new: bool
    page: str


class Errors(Answer):
    """Errors over some tasks [m], and what was made good of doing nothing and of the mean upper error bound."""

    tasks: int
    error_m: float
    do_nothing_m: float
    improvement: float | None
    improvement_ueb: float | None


class Ranked(Answer):
    """A team's place by its best submission; errors in metres, times in simulated seconds."""

    rank: int
    team: str
    mean: Errors
    interval_m: tuple[float, float]
    levels: dict[int, Errors]
    attempted: int
    solved: int
    execution_s: float | None
    grasps_attempted: int
    grasps_succeeded: int
    grasp_success: float | None
    improvement: float | None
    submission: str
    tasks: dict[str, float]
    submissions: int


class Leaderboard(Answer):
    """Teams by their best submission, the best first."""

    contest: str
    baseline: Literal["ueb", "do-nothing"]
    places: list[Ranked]


class Listed(Answer):
    """A task as it may be seen."""

    label: str
    level: int | None


class TaskSets(Answer):
    """The tasks of both sets."""

    contest: list[Listed]
    trial: list[Listed]


class Handed(Answer):
    """A submission, when it was handed in [s, UTC], and how many of its runs are done."""

    id: str
    team: str
    kind: Kind
    created: float
    state: Literal["queued", "running", "done"]
    total: int
    running: int
    done: int


class Printed(Answer):
    """How a run ended, and what it printed."""

    trial: int
    task: str
    simulator: str
    run: int
    message: str
    log: str


class Followed(Handed):
    """A submission; when it is done its errors by task [m], for its team its file's name and what its runs printed."""

    put_off: int
    errors_m: dict[str, float] | SkipJsonSchema[None] = None
    file: str | SkipJsonSchema[None] = None
    runs: list[Printed] | SkipJsonSchema[None] = None


class Exported(Handed):
    """A submission with all of its results."""

    file: str
    results: list[Result]


class Export(Answer):
    """All that is recorded."""

    contest: str
    submissions: list[Exported]


class LoggedIn(Answer):
    """Whose token it was."""

    team: str


class LoggedOut(Answer):
    """Nothing."""


ACCEPTED: Responses = {200: {"model": Submitted, "description": "This file was handed in before"}}

REFUSALS = {
    400: "The body cannot be read",
    401: "No team's token",
    403: "From a page of another site",
    404: "Not there, or not for you",
    408: "Too slow",
    410: "Withdrawn; says why, to its team",
    413: "Too large",
    415: "A form, and not the file itself",
    422: "Not acceptable; says why",
    429: "Too many",
    500: "The server cannot write",
    503: "The database is out of reach",
    507: "The server's disk is full",
}


def refusals(*statuses: int) -> Responses:
    """What the API's description says of refusals; all have one form."""
    return {status: {"model": Refused, "description": REFUSALS[status]} for status in statuses}
