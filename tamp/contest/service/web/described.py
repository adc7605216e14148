"""What OpenAPI says of the API beside what FastAPI sees by itself: tokens, files, and the one form of all refusals."""

from __future__ import annotations

from typing import Any

from fastapi import Security
from fastapi.security import HTTPBearer
from pydantic import BaseModel

Responses = dict[int | str, dict[str, Any]]

TOKEN = Security(HTTPBearer(auto_error=False, scheme_name="token", description="A team's token."))
"""Tells the API's description where a token goes; the routes read it themselves."""
OPTIONAL: dict[str, Any] = {"security": [{}]}
"""Beside a token: that there may be none."""
BINARY = {"schema": {"type": "string", "format": "binary"}}
ARCHIVE: Responses = {200: {"content": {"application/zip": BINARY}}}
UPLOAD = {"requestBody": {"content": {"application/octet-stream": BINARY}, "required": True}}


class Refused(BaseModel):
    """Why something is not done."""

    detail: str


class Submitted(BaseModel):
    """A submission's number, whether it is new, and where its page is."""

    id: str
    new: bool
    page: str


ACCEPTED: Responses = {200: {"model": Submitted, "description": "This file was handed in before"}}

REFUSALS = {
    400: "The body cannot be read",
    401: "No team's token",
    403: "From a page of another site",
    404: "Not there, or not for you",
    408: "Too slow",
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
