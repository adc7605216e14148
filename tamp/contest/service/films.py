"""Moving pictures: frames are kept with each run, and the best and worst runs of a submission are drawn when idle."""

from __future__ import annotations

import errno
import gzip
import json
import logging
import shutil
from collections.abc import Sequence
from pathlib import Path

from sqlalchemy import select

from tamp.contest.service.contest import Contest, Kind
from tamp.contest.service.scratch import unfinished
from tamp.contest.service.store import ASIDE, SUBMISSIONS, TRIALS, Store
from tamp.execution.log import Frame
from tamp.report.rendering.film import render_execution
from tamp.results import from_json
from tamp.task import Pose, Task

LOG = logging.getLogger(__name__)

MOST_FRAMES = 60
"""Of a film; a longer run is shown with fewer frames a second."""

ROOM = 32 << 20
"""What is to be free on the disk before a film is drawn [bytes], more than any takes; until then its frames wait."""


def keep(data: Path, trial: int, frames: Sequence[Frame]) -> None:
    """Keep the frames of a run: all of them, or, where the disk has no room, none."""
    if len(frames) < 2:
        return
    place = data / "frames" / f"{trial}.json.gz"
    rows = [
        [f.time, {name: [*p.xyz, *p.quat] for name, p in f.poses.items()}, f.configuration, f.opening] for f in frames
    ]
    try:
        with unfinished(data, place) as part, gzip.open(part, "wt", encoding="utf-8") as file:
            json.dump(rows, file)
    except OSError as error:
        LOG.warning("the frames of run %d cannot be kept: %s", trial, error)


def film_path(data: Path, trial: int) -> Path:
    """Where the film of a run is, once it is drawn."""
    return data / "films" / f"{trial}.gif"


def shown(store: Store, submission: str) -> tuple[int, ...]:
    """Of a submission that is done, the runs with the smallest and the largest error against doing nothing."""
    with store.look() as connection:
        rows = connection.execute(
            select(TRIALS).where(TRIALS.c.submission == submission, TRIALS.c.state != ASIDE)
        ).all()
    scored = []
    for row in rows:
        if row.state != "done":
            return ()
        result = from_json(row.result)
        if result.improvement is not None:
            scored.append((-result.improvement, result.execution_sim_s, row.id))
    return tuple(dict.fromkeys((min(scored)[2], max(scored)[2]))) if scored else ()


def make_one(store: Store, contest: Contest, data: Path) -> bool:
    """Draw one film that is missing; False where there is none, or no room on the disk."""
    for frames in sorted((data / "frames").glob("*.json.gz")):
        trial = int(frames.name.split(".")[0])
        with store.look() as connection:
            row = connection.execute(
                select(TRIALS.c.submission, TRIALS.c.task, SUBMISSIONS.c.kind)
                .join(SUBMISSIONS, SUBMISSIONS.c.id == TRIALS.c.submission)
                .where(TRIALS.c.id == trial)
            ).first()
        chosen = () if row is None else shown(store, row.submission)
        if row is None or not chosen:
            continue  # its submission is not done
        drawn = trial in chosen and not film_path(data, trial).exists()
        if drawn and shutil.disk_usage(data).free < ROOM:
            continue
        if drawn:
            kind: Kind = row.kind
            try:
                _draw(contest.entry(kind, row.task).task, frames, data, film_path(data, trial))
            except Exception as error:  # a film that cannot be drawn must keep nothing else waiting
                if isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT):
                    return False
                LOG.warning("run %d has no film: %s: %s", trial, type(error).__name__, error)
        frames.unlink(missing_ok=True)
        if drawn:
            return True
    return False


def _draw(task: Task, source: Path, data: Path, path: Path) -> None:
    with gzip.open(source, "rt", encoding="utf-8") as file:
        rows = json.load(file)
    rows = rows[:: -(-len(rows) // MOST_FRAMES)]
    if len(rows) < 2:
        return
    frames = [
        Frame(time, {name: Pose(tuple(v[:3]), tuple(v[3:])) for name, v in poses.items()}, tuple(q), opening)
        for time, poses, q, opening in rows
    ]
    with unfinished(data, path) as part:
        render_execution(task, frames, part)


def forget(data: Path, trial: int) -> None:
    """Remove what a run that is done anew was to be shown by."""
    for path in (film_path(data, trial), data / "frames" / f"{trial}.json.gz"):
        path.unlink(missing_ok=True)


def submission_of(store: Store, trial: int) -> str | None:
    """The submission of a run; None where there is no such run."""
    with store.look() as connection:
        return connection.execute(select(TRIALS.c.submission).where(TRIALS.c.id == trial)).scalar()
