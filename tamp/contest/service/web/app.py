"""The web service: pages for people, and the same for programs under /api, which /api/docs documents."""

from __future__ import annotations

import errno
import io
import logging
import zipfile
from collections.abc import Callable
from contextlib import ExitStack
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

from fastapi import Body, FastAPI, HTTPException, Request, Response
from fastapi.concurrency import run_in_threadpool
from fastapi.responses import FileResponse, HTMLResponse, JSONResponse

from tamp.contest.service import films
from tamp.contest.service.board import Board, Progress
from tamp.contest.service.contest import KINDS, Contest, Kind
from tamp.contest.service.queue import put_off_now
from tamp.contest.service.scratch import scratch_folder
from tamp.contest.service.store import OUT_OF_REACH, DamagedError, Store, StoreFullError
from tamp.contest.service.submissions import TooManyError, accept, count_attempt, left_this_month, suffix_of
from tamp.contest.service.teams import Team, team_of
from tamp.contest.service.web import pages
from tamp.contest.service.web.described import (
    ACCEPTED,
    ARCHIVE,
    OPTIONAL,
    TOKEN,
    UPLOAD,
    Export,
    Followed,
    Handed,
    Leaderboard,
    LoggedIn,
    LoggedOut,
    Submitted,
    TaskSets,
    refusals,
)  # fmt: skip
from tamp.contest.service.web.guard import add_guards
from tamp.contest.service.web.pictures import picture, task_archive
from tamp.contest.service.web.uploads import Uploads
from tamp.contest.service.withdrawn import withdrawn
from tamp.errors import TampError

LOG = logging.getLogger(__name__)

COOKIE = "tamp_contest_token"
FULL = "the server's disk is full; nothing was accepted and nothing is lost, try again later"
GONE = "the database cannot be reached; try again in a moment"
UPLOADS = "/api/submissions"
MOST_SHOWN = 20_000
"""Characters of what a run printed, on a page that has them of all runs."""
HIGHEST = (1 << 31) - 1
"""Of a number in the database."""


def make_app(store: Store, contest: Contest, data: Path) -> FastAPI:
    """The service of a contest.

    Args:
        store: the database.
        contest: rules and tasks.
        data: the folder of packages, pictures and films.
    """
    title = f"{contest.rules.name}: the contest's API"
    app = FastAPI(title=title, docs_url=None, redoc_url=None, openapi_url="/api/openapi.json")
    board = Board(store, contest)
    routes = Routes(store, contest, data, board)
    routes.add_to(app)
    for status in (404, 410):
        app.add_exception_handler(status, routes.missing)
    app.add_exception_handler(TampError, _refuse)
    for kind in (*OUT_OF_REACH, DamagedError):
        app.add_exception_handler(kind, routes.out_of_reach)
    app.add_exception_handler(OSError, _cannot_write)
    app.add_exception_handler(StoreFullError, lambda *_: JSONResponse({"detail": FULL}, 507))

    add_guards(app, UPLOADS)
    return app


def _refuse(_: Request, error: Exception) -> Response:
    return JSONResponse({"detail": str(error)}, 429 if isinstance(error, TooManyError) else 422)


def _cannot_write(request: Request, error: Exception) -> Response:
    """That a file cannot be written, be it an upload or a picture that is drawn now; the log has the cause."""
    LOG.warning("%s: the server cannot write: %s", request.url.path, error)
    if getattr(error, "errno", None) in (errno.ENOSPC, errno.EDQUOT):
        return JSONResponse({"detail": FULL}, 507)
    return JSONResponse({"detail": "the server cannot write; nothing was accepted"}, 500)


def _wants_page(request: Request) -> bool:
    """Whether people read the answer."""
    return not request.url.path.startswith("/api/") and "text/html" in request.headers.get("Accept", "")


def _token(request: Request) -> str | None:
    scheme, _, token = request.headers.get("Authorization", "").partition(" ")
    return token.strip() if scheme.lower() == "bearer" else request.cookies.get(COOKIE)


class Routes:
    """What is answered under which path."""

    def __init__(self, store: Store, contest: Contest, data: Path, board: Board) -> None:
        self._store, self._contest, self._data, self._board = store, contest, data, board
        self._uploads = Uploads(contest.rules)

    def add_to(self, app: FastAPI) -> None:
        """Add pages and API."""
        for path, page in (
            ("/", self.leaderboard_page),
            ("/rules", self.rules_page),
            ("/tasks", self.tasks_page),
            ("/solutions", self.solutions_page),
            ("/team", self.team_page),
            ("/submissions/{number}", self.submission_page),
            ("/api/docs", self.api_page),
        ):
            app.get(path, response_class=HTMLResponse, include_in_schema=False)(page)
        for name, kind in pages.STATIC.items():
            app.get(f"/static/{name}", include_in_schema=False)(self._static(name, kind))
        app.get("/pictures/{kind}/{label}.png", include_in_schema=False)(self.task_picture)
        app.get("/films/{trial}.gif", include_in_schema=False)(self.film)
        token = [TOKEN]
        app.get("/api/leaderboard", response_model=Leaderboard, responses=refusals(422, 503))(self.leaderboard)
        app.get("/api/tasks", response_model=TaskSets)(self.tasks)
        app.get("/api/tasks/trial.zip", response_class=Response, responses=ARCHIVE | refusals(500, 507))(
            self.trial_tasks
        )
        app.get("/api/submissions", response_model=list[Handed], responses=refusals(401, 503), dependencies=token)(
            self.submissions
        )
        app.post(
            UPLOADS,
            status_code=201,
            response_model=Submitted,
            responses=ACCEPTED | refusals(401, 403, 408, 413, 415, 422, 429, 500, 503, 507),
            openapi_extra=UPLOAD,
            dependencies=token,
        )(self.submit)
        app.get(
            "/api/submissions/{number}",
            response_model=Followed,
            response_model_exclude_unset=True,
            responses=refusals(404, 410, 422, 503),
            dependencies=token,
            openapi_extra=OPTIONAL,
        )(self.submission)
        app.get("/api/export", response_model=Export, responses=refusals(401, 503), dependencies=token)(self.export)
        app.post("/api/session", response_model=LoggedIn, responses=refusals(400, 401, 403, 413, 422, 503))(self.log_in)
        app.delete("/api/session", response_model=LoggedOut, responses=refusals(403, 413))(self.log_out)

    def _static(self, name: str, kind: str) -> Callable[[], Response]:
        return lambda: Response(pages.static(name), media_type=kind)

    def _page(self, request: Request, name: str, **values: Any) -> str:
        team = team_of(self._store, _token(request))
        return pages.page(name, rules=self._contest.rules, team=team, here=request.url.path, **values)

    def leaderboard_page(self, request: Request) -> str:
        """Who is ahead."""
        boards = [(kind, self._board.places(kind), self._contest.yardsticks[kind]) for kind in self._contest.entries]
        return self._page(request, "leaderboard.html", boards=boards, put_off=put_off_now(self._store))

    def rules_page(self, request: Request) -> str:
        """What counts."""
        return self._page(request, "rules.html", counts={k: len(v) for k, v in self._contest.entries.items()})

    def tasks_page(self, request: Request) -> str:
        """The tasks, with pictures of those that may be seen."""
        measures = {kind: {one.task: one for one in self._contest.yardsticks[kind]} for kind in self._contest.entries}
        rows = {k: [(entry, measures[k].get(entry.label)) for entry in v] for k, v in self._contest.entries.items()}
        return self._page(request, "tasks.html", rows=rows)

    def solutions_page(self, request: Request) -> str:
        """How a solution is written: one to begin with, and what it may call."""
        return self._page(request, "solutions.html", calls=pages.standard_api(), sample=pages.sample())

    def team_page(self, request: Request) -> str:
        """Handing in, and what was handed in."""
        team = team_of(self._store, _token(request))
        mine = [] if team is None else self._board.submissions(team=team.id)
        left = {} if team is None else {k: left_this_month(self._store, self._contest, team, k) for k in KINDS}
        gone = () if team is None else withdrawn(self._store, team)
        return self._page(request, "team.html", submissions=mine, left=left, withdrawn=gone)

    def submission_page(self, request: Request, number: str) -> str:
        """One submission: live while it runs; what it printed for its owner only."""
        team, found = team_of(self._store, _token(request)), self._visible(request, number)
        owner = team is not None and team.name == found.team
        place = self._board.results(number)
        return self._page(
            request,
            "submission.html",
            submission=found,
            owner=owner,
            errors=self._board.errors(found.kind, place) if found.state == "done" else {},
            yardsticks={task.task: task for task in self._contest.yardsticks[found.kind]},
            logs=self._board.logs(number) if owner else [],
            shown=MOST_SHOWN,
            films=self._films(found),
            put_off=put_off_now(self._store, number),
        )

    def missing(self, request: Request, error: Exception) -> Response:
        """What is not there, or not any more: a page for who reads pages, JSON for programs."""
        detail, status = str(getattr(error, "detail", "")) or "Not Found", getattr(error, "status_code", 404)
        if not _wants_page(request):
            return JSONResponse({"detail": detail}, status)
        try:
            return HTMLResponse(self._page(request, "missing.html", detail=detail, gone=status == 410), status)
        except (*OUT_OF_REACH, DamagedError) as error:  # nobody else looks after what a handler raises
            return self.out_of_reach(request, error)

    def out_of_reach(self, request: Request, error: Exception) -> Response:
        """That the database does not answer: as a page or as JSON, like what is not there; the log has the cause."""
        LOG.warning("%s: the database does not answer: %s", request.url.path, str(error).splitlines()[0])
        if not _wants_page(request):
            return JSONResponse({"detail": GONE}, 503)
        rules = self._contest.rules  # who asks is in the database, and not known
        return HTMLResponse(pages.page("gone.html", rules=rules, team=None, here=request.url.path, detail=GONE), 503)

    def api_page(self, request: Request) -> str:
        """What programs may ask, from the API's own description."""
        return self._page(request, "api.html", paths=request.app.openapi()["paths"])

    def _films(self, submission: Progress) -> list[tuple[str, int]]:
        """What each film of a submission shows, and its run; those of hidden tasks wait until these are revealed."""
        if submission.kind == "contest" and not self._contest.rules.reveal:
            return []
        shown = films.shown(self._store, submission.id)
        names = ("best run", "worst run") if len(shown) > 1 else ("the run",)
        pairs = zip(names, shown, strict=False)
        return [(name, trial) for name, trial in pairs if films.film_path(self._data, trial).exists()]

    def leaderboard(self, kind: Kind = "contest") -> dict[str, Any]:
        """Teams by their best submission, the best first; errors in metres, times in simulated seconds."""
        rules = self._contest.rules
        return {
            "contest": rules.name,
            "baseline": rules.baseline,
            "places": [p.as_dict() for p in self._board.places(kind)],
        }

    def tasks(self) -> dict[str, list[dict[str, Any]]]:
        """The tasks of both sets; of the contest set only numbers and levels."""
        return {
            kind: [{"label": entry.label, "level": entry.task.level} for entry in entries]
            for kind, entries in self._contest.entries.items()
        }

    def trial_tasks(self) -> Response:
        """The trial set with its models, as a zip."""
        return Response(self._trial_archive, media_type="application/zip")

    @cached_property
    def _trial_archive(self) -> bytes:
        """Made once: anybody may ask for it, as often as they like."""
        buffer = io.BytesIO()
        with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
            task_archive([entry.task for entry in self._contest.entries["trial"]], archive)
        return buffer.getvalue()

    def submissions(self, request: Request) -> list[dict[str, Any]]:
        """The team's own submissions, the newest first."""
        return [_progress(one) for one in self._board.submissions(team=self._team(request).id)]

    async def submit(self, request: Request, name: str, kind: Kind = "contest") -> Response:
        """Hand in a .py, .zip or .whl as the request's body; `name` is the file's name."""
        team = await run_in_threadpool(self._team, request)
        suffix_of(name)
        if request.headers.get("Content-Type", "").startswith("multipart/"):
            raise HTTPException(415, "the file itself is the request's body, not a form: curl --data-binary @FILE")
        await run_in_threadpool(count_attempt, self._store, self._contest, team)
        with self._uploads.under_way(team), ExitStack() as stack:
            folder = await run_in_threadpool(stack.enter_context, scratch_folder(self._data))
            upload = await self._uploads.receive(request, folder / "upload")
            found = await run_in_threadpool(accept, self._store, self._contest, self._data, team, kind, name, upload)
        answer = {"id": found.id, "new": found.new, "page": f"/submissions/{found.id}"}
        return JSONResponse(answer, 201 if found.new else 200)

    def submission(self, request: Request, number: str, runs: bool = True) -> dict[str, Any]:
        """How far a submission is, what it scored, and for its owner, unless `runs` is false, what came of each run."""
        found = self._visible(request, number)
        team = team_of(self._store, _token(request))
        values = _progress(found)
        put_off = put_off_now(self._store, number)
        values["put_off"] = 0 if put_off is None else put_off.runs
        if found.state == "done":
            values["errors_m"] = self._board.errors(found.kind, self._board.results(number))
        if team is not None and team.name == found.team:
            values |= {"file": found.file} | ({"runs": self._board.logs(number)} if runs else {})
        return values

    def export(self, request: Request) -> dict[str, Any]:
        """All results of all contest submissions, for whoever has a team; trial results of the own team only."""
        return self._board.export(self._team(request).name)

    def log_in(self, request: Request, response: Response, token: Annotated[str, Body(embed=True)]) -> dict[str, str]:
        """Keep a token in a cookie, for pages."""
        team = team_of(self._store, token)
        if team is None:
            raise HTTPException(401, "this is no team's token")
        secure = request.url.scheme == "https"
        response.set_cookie(COOKIE, token, httponly=True, samesite="strict", secure=secure, max_age=90 * 86400)
        return {"team": team.name}

    def log_out(self, response: Response) -> dict[str, str]:
        """Forget the cookie."""
        response.delete_cookie(COOKIE)
        return {}

    def task_picture(self, kind: Kind, label: str) -> Response:
        """A task's start and goal; hidden tasks have none until the rules reveal them."""
        if kind == "contest" and not self._contest.rules.reveal:
            raise HTTPException(404, "there is no such picture")
        try:
            task = self._contest.entry(kind, label).task
        except TampError:
            raise HTTPException(404, "there is no such picture") from None
        return FileResponse(picture(task, self._data, kind))

    def film(self, request: Request, trial: int) -> Response:
        """The film of a run, where its submission's page shows it."""
        owner = films.submission_of(self._store, trial) if 0 < trial <= HIGHEST else None
        shown = [] if owner is None else self._films(self._visible(request, owner))
        if trial not in (run for _, run in shown):
            raise HTTPException(404, "there is no such film")
        return FileResponse(films.film_path(self._data, trial))

    def _team(self, request: Request) -> Team:
        team = team_of(self._store, _token(request))
        if team is None:
            raise HTTPException(401, "a team's token is needed: Authorization: Bearer TOKEN")
        return team

    def _visible(self, request: Request, number: str) -> Progress:
        """A submission that may be seen: contest submissions by all, trial submissions by their team."""
        found = self._board.submission(number) if number.isalnum() and number.isascii() else None
        team = team_of(self._store, _token(request))
        for gone in () if found or team is None else withdrawn(self._store, team):
            if gone.id == number:
                raise HTTPException(410, f"this submission was withdrawn{': ' * bool(gone.why)}{gone.why}")
        if found is None or (found.kind == "trial" and (team is None or team.name != found.team)):
            raise HTTPException(404, "there is no such submission")
        return found


def _progress(found: Progress) -> dict[str, Any]:
    return {
        "id": found.id,
        "team": found.team,
        "kind": found.kind,
        "created": found.created,
        "state": found.state,
        "total": found.total,
        "running": found.running,
        "done": found.done,
    }
