"""What holds for every request: who may send it, how large it may be, and what browsers and caches are told."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from fastapi import FastAPI, Request, Response
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from starlette.requests import ClientDisconnect

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Receive, Scope, Send

HEADERS = {
    "Content-Security-Policy": "default-src 'self'; img-src 'self' data:; "
    "frame-ancestors 'none'; base-uri 'none'; form-action 'self'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "private, no-cache",
}
"""With every answer, unless it says otherwise: no page or film of a team stays in a cache that others share."""
SAFE = ("GET", "HEAD", "OPTIONS")
"""Methods that change nothing."""
FOREIGN = "a page of another site must not do this with your session"
FAR_TOO_LARGE = "larger than anything that is asked for here"
SMALL = 4096
"""Of the body of a request that is no upload [bytes]; uploads have the rules' limit."""


def add_guards(app: FastAPI, uploads: str) -> None:
    """Look at each request before it is answered, and at each answer.

    Args:
        app: the service.
        uploads: the path to which large bodies may be sent.
    """

    @app.middleware("http")
    async def guard(request: Request, call_next: Callable[[Request], Awaitable[Response]]) -> Response:
        upload = request.url.path == uploads and request.method == "POST"
        response: Response
        if request.method not in SAFE and _is_foreign(request):
            response = JSONResponse({"detail": FOREIGN}, 403)
        elif not upload and _is_large(request):
            response = JSONResponse({"detail": FAR_TOO_LARGE}, 413)
        else:
            response = await call_next(request)
        for name, value in HEADERS.items():
            response.headers.setdefault(name, value)
        return response

    app.add_middleware(_HeadsAsGets)
    app.add_exception_handler(RequestValidationError, _not_valid)
    app.add_exception_handler(ClientDisconnect, lambda *_: Response(status_code=400))  # nobody is there to read it


class _HeadsAsGets:
    """Answers HEAD wherever GET is answered; the server leaves the body away."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "http" and scope["method"] == "HEAD":
            scope = {**scope, "method": "GET"}
        await self._app(scope, receive, send)


def _not_valid(_: Request, error: Exception) -> Response:
    """A parameter or body that is none, in a sentence as all refusals are, and without repeating what was sent."""
    assert isinstance(error, RequestValidationError)
    said = [f"{'.'.join(map(str, one['loc']))}: {one['msg']}" for one in error.errors()[:5]]
    return JSONResponse({"detail": "; ".join(said)}, 422)


def _is_foreign(request: Request) -> bool:
    """Whether a page of another origin sends it; cookies would go with it from other ports of the same machine."""
    site = request.headers.get("Sec-Fetch-Site")
    if site is not None:
        return site not in ("same-origin", "none")
    origin = request.headers.get("Origin")
    return origin is not None and urlsplit(origin).netloc != request.headers.get("Host")


def _is_large(request: Request) -> bool:
    """Whether a request announces a large body, or none of a size: it would be read into memory."""
    size = request.headers.get("Content-Length", "0")
    return "Transfer-Encoding" in request.headers or not size.isdecimal() or int(size) > SMALL
