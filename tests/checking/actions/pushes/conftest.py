from __future__ import annotations

import pytest

import tamp


@pytest.fixture(scope="module")
def task(request):
    """The scenario of a test module."""
    return tamp.load_task(request.module.SCENARIO)


@pytest.fixture(scope="module")
def plan(task):
    return tamp.plan(task, seed=0, timeout=100.0)
