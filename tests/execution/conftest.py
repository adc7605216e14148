"""Tests that ask for `simulator` run once in each simulator that comes with the program."""

from __future__ import annotations

import pytest

from tamp.execution.simulators import SIMULATORS


@pytest.fixture(params=SIMULATORS)
def simulator(request: pytest.FixtureRequest) -> str:
    """The name of a simulator; the test is skipped where its library is absent."""
    name = str(request.param)
    if not SIMULATORS[name].installed:
        pytest.skip(f"simulator {name!r} is not installed")
    return name
