from __future__ import annotations

import pytest

from tamp import clock
from tamp.pipeline.strategies.subproblems.subproblem import Asker


def test_a_share_of_the_time_is_given_and_taken_back(monkeypatch):
    monkeypatch.setattr(clock, "now", lambda: 2.0)
    asker = Asker(None, seed=0, deadline=12.0, algorithm="adaptive")
    for share, least, deadline in ((0.4, 0.0, 6.0), (0.4, 5.0, 7.0), (0.4, 20.0, 12.0), (1.0, 0.0, 12.0)):
        with asker.within(share, least):
            assert asker.deadline == pytest.approx(deadline)
        assert asker.deadline == 12.0
