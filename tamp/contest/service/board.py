"""The leaderboard, and how far each submission is: read from the recorded runs, and nothing else is kept on disk."""

from __future__ import annotations

import json
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from sqlalchemy import case, func, select

from tamp.contest.evaluation.standings import counting, improvement, standings
from tamp.contest.service.contest import Contest, Kind
from tamp.contest.service.store import ASIDE, DONE, SUBMISSIONS, TEAMS, TRIALS, Store
from tamp.results import Result, from_json, to_json
from tamp.scoring.ranking import Standing, placed


@dataclass(frozen=True)
class Place:
    """A team's place by its best submission.

    Attributes:
        standing: rank, errors, times, grasps.
        improvement: over the rules' default error.
        submission: its number.
        tasks: label -> the mean error of the runs that count [m].
        submissions: how many the team has that are done.
    """

    standing: Standing
    improvement: float | None
    submission: str
    tasks: Mapping[str, float]
    submissions: int

    def as_dict(self) -> dict[str, Any]:
        """JSON-like values."""
        return {
            "team": self.standing.solution,
            **{key: value for key, value in self.standing.as_dict().items() if key != "solution"},
            "improvement": self.improvement,
            "submission": self.submission,
            "tasks": dict(self.tasks),
            "submissions": self.submissions,
        }


@dataclass(frozen=True)
class Progress:
    """A submission and how far it is.

    Attributes:
        id, team, kind, file, created: as it was handed in.
        total, running, done: runs.
    """

    id: str
    team: str
    kind: Kind
    file: str
    created: float
    total: int
    running: int
    done: int

    @property
    def state(self) -> str:
        """In a word."""
        if self.done == self.total:
            return "done"
        return "running" if self.running or self.done else "queued"


@dataclass(frozen=True)
class _Scored:
    """What is kept of a submission that is done: its standing by itself, and its errors by task [m]."""

    standing: Standing
    tasks: Mapping[str, float]


class Board:
    """Reads the database for pages; what a submission that is done scored is read once, until a run of it changes."""

    def __init__(self, store: Store, contest: Contest) -> None:
        self._store, self._contest = store, contest
        self._lock = threading.Lock()
        self._scored: dict[str, tuple[Any, _Scored]] = {}

    def places(self, kind: Kind) -> tuple[Place, ...]:
        """Teams, the best first, each by its best submission; those without one that is done are left out."""
        if not self._contest.yardsticks[kind]:
            return ()
        columns = (SUBMISSIONS.c.id, TEAMS.c.name)
        with self._store.look() as connection:
            rows = connection.execute(
                select(*columns, func.count(), func.sum(TRIALS.c.id), func.sum(TRIALS.c.evaluations))
                .join(TEAMS, TEAMS.c.id == SUBMISSIONS.c.team)
                .join(TRIALS, TRIALS.c.submission == SUBMISSIONS.c.id)
                .where(TRIALS.c.state != ASIDE, SUBMISSIONS.c.kind == kind)
                .group_by(*columns)
                .having(func.sum(case((TRIALS.c.state == DONE, 0), else_=1)) == 0)
            ).all()
        of_team: dict[str, list[_Scored]] = {}
        with self._lock:
            for number, team, *runs in rows:
                if number not in self._scored or self._scored[number][0] != runs:
                    self._scored[number] = runs, self._score(kind, number)
                of_team.setdefault(team, []).append(self._scored[number][1])
        best = {team: placed(one.standing for one in theirs)[0].solution for team, theirs in of_team.items()}
        kept = {team: next(s for s in theirs if s.standing.solution == best[team]) for team, theirs in of_team.items()}
        return tuple(
            Place(
                standing,
                improvement(standing, self._contest.rules),
                best[standing.solution],
                kept[standing.solution].tasks,
                len(of_team[standing.solution]),
            )
            for standing in placed(replace(scored.standing, solution=team) for team, scored in kept.items())
        )

    def _score(self, kind: Kind, number: str) -> _Scored:
        results = self.results(number)
        (standing,) = standings({number: results}, self._contest.yardsticks[kind], self._contest.rules)
        return _Scored(standing, self.errors(kind, results))

    def errors(self, kind: Kind, results: Sequence[Result]) -> dict[str, float]:
        """Label -> mean error of the runs that count [m]; doing nothing where none does."""
        kept = counting(results, self._contest.yardsticks[kind], self._contest.rules)
        found = {}
        for task in self._contest.yardsticks[kind]:
            mine = [r.ede_m for r in kept if r.task == task.task and r.ede_m is not None]
            found[task.task] = sum(mine) / len(mine) if mine else task.do_nothing_m
        return found

    def results(self, submission: str) -> tuple[Result, ...]:
        """The recorded runs of a submission."""
        with self._store.look() as connection:
            rows = connection.execute(
                select(TRIALS.c.result)
                .where(TRIALS.c.submission == submission, TRIALS.c.state == "done")
                .order_by(TRIALS.c.id)
            ).scalars()
            return tuple(from_json(row) for row in rows if row is not None)

    def logs(self, submission: str) -> list[dict[str, Any]]:
        """What a submission's runs printed, and how each ended; for its owner's eyes only."""
        with self._store.look() as connection:
            rows = connection.execute(
                select(TRIALS).where(TRIALS.c.submission == submission, TRIALS.c.state == "done").order_by(TRIALS.c.id)
            ).all()
        found = []
        for row in rows:
            message = from_json(row.result).message
            found.append(
                {"trial": row.id, "task": row.task, "simulator": row.simulator, "run": row.run, "message": message,
                 "log": row.log or ""}
            )  # fmt: skip
        return found

    def submissions(self, kind: Kind | None = None, *, team: int | None = None) -> tuple[Progress, ...]:
        """All submissions of a set or a team, the newest first."""
        return progress(
            self._store,
            *([] if kind is None else [SUBMISSIONS.c.kind == kind]),
            *([] if team is None else [TEAMS.c.id == team]),
        )

    def submission(self, number: str) -> Progress | None:
        """One submission; None where there is none of that number."""
        return next(iter(progress(self._store, SUBMISSIONS.c.id == number)), None)

    def export(self, team: str) -> dict[str, Any]:
        """All results of the contest's submissions, and of a team's own trials, without tokens, logs and packages.

        What files are called, and what came of runs in words, is for their team alone. What a result says of single
        objects would tell what a hidden task is made of; it waits until they are revealed.
        """
        rows = []
        for submission in self.submissions():
            own, contest = submission.team == team, submission.kind == "contest"
            if not own and not contest:
                continue
            hidden: dict[str, Any] = {} if own else {"message": ""}
            if contest and not self._contest.rules.reveal:
                hidden |= {"objects": [], "goals_met": {}}
            results = [json.loads(to_json(result)) | hidden for result in self.results(submission.id)]
            said = vars(submission) if own else {**vars(submission), "file": ""}
            rows.append({**said, "state": submission.state, "results": results})
        return {"contest": self._contest.rules.name, "submissions": rows}


def progress(store: Store, *conditions: Any) -> tuple[Progress, ...]:
    """Submissions that meet all conditions, the newest first."""

    def count(state: str) -> Any:
        return func.sum(case((TRIALS.c.state == state, 1), else_=0))

    columns = (SUBMISSIONS.c.id, TEAMS.c.name, SUBMISSIONS.c.kind, SUBMISSIONS.c.file, SUBMISSIONS.c.created)
    query = (
        select(*columns, func.count(), count("running"), count("done"))
        .join(TEAMS, TEAMS.c.id == SUBMISSIONS.c.team)
        .join(TRIALS, TRIALS.c.submission == SUBMISSIONS.c.id)
        .where(TRIALS.c.state != ASIDE, *conditions)
        .group_by(*columns)
        .order_by(SUBMISSIONS.c.created.desc(), SUBMISSIONS.c.id)
    )
    with store.look() as connection:
        return tuple(Progress(*row) for row in connection.execute(query))
