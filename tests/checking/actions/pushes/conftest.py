from __future__ import annotations

import pytest

from tests.planned import planned


@pytest.fixture(scope="module")
def task(request):
    """The scenario of a test module."""
    return planned(request.module.SCENARIO, 0)[0]


@pytest.fixture(scope="module")
def plan(request):
    return planned(request.module.SCENARIO, 0)[1]
