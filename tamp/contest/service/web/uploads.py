"""Uploads while they come in: how many of one team at once, how large, and for how long."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import anyio
from fastapi import HTTPException, Request

from tamp.contest.rules import Rules
from tamp.contest.service.submissions import TooManyError
from tamp.contest.service.teams import Team

UPLOAD_S = 900.0
"""How long an upload may take [s]."""


class Uploads:
    """The uploads that are under way.

    Args:
        rules: say how large an upload may be, and how many a team may begin in a minute.
    """

    def __init__(self, rules: Rules) -> None:
        self._rules = rules
        self._of_team = Counter[int]()

    @contextmanager
    def under_way(self, team: Team) -> Iterator[None]:
        """Of a team's uploads as many are received at once as it may begin within a minute: slow ones keep the disk.

        Raises:
            TooManyError: where there are so many already.
        """
        most = self._rules.uploads.a_minute
        if self._of_team[team.id] >= most:
            raise TooManyError(f"{most} uploads of your team are under way; wait until one has ended")
        self._of_team[team.id] += 1
        try:
            yield
        finally:
            self._of_team[team.id] -= 1

    async def receive(self, request: Request, path: Path) -> Path:
        """The request's body as a file, read no farther than the rules allow.

        Raises:
            HTTPException: where it is too large, or takes too long.
        """
        most = self._rules.uploads.size_kb << 10
        too_large = HTTPException(413, f"larger than {most >> 10} KiB")
        declared = request.headers.get("Content-Length", "0")
        if not declared.isdecimal() or int(declared) > most:
            raise too_large
        size = 0
        try:
            with path.open("wb") as file, anyio.fail_after(UPLOAD_S):
                async for piece in request.stream():
                    size += len(piece)
                    if size > most:
                        raise too_large
                    file.write(piece)
        except TimeoutError:  # an OSError, too
            raise HTTPException(408, f"the upload took longer than {UPLOAD_S:g} s") from None
        return path
