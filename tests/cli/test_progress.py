"""How far a batch is, where nobody has a terminal."""

from __future__ import annotations

import time

import pytest

from tamp.cli.progress import Count, _lines
from tamp.results import Result


def test_a_line_comes_at_every_pause_whether_results_do_or_not(capsys: pytest.CaptureFixture[str]) -> None:
    with _lines(Count(4), pause_s=0.05) as advance:
        time.sleep(0.5)
        advance(Result("a", 0, "solved"))
        advance(Result("b", 0, "failed"))
        time.sleep(0.5)
    first, *_, last = capsys.readouterr().err.splitlines()
    assert first == "tamp: 0 of 4 done after 0 min: 0 solved, 0 not"
    assert last == "tamp: 2 of 4 done after 0 min: 1 solved, 1 not, about 0 min left"
