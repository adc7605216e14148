"""A plugin for pytest: what was skipped, test or whole module, stands in the file `SKIPPED` afterwards, a node a line.

`pytest @FILE` runs those again, where what they asked for is there.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest

_NODES: dict[str, None] = {}


def _keep(report: pytest.TestReport | pytest.CollectReport) -> None:
    if report.skipped:
        _NODES[report.nodeid] = None


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """A test: with several workers, this is told where they are led from."""
    _keep(report)


def pytest_collectreport(report: pytest.CollectReport) -> None:
    """A module that skips itself as it is imported."""
    _keep(report)


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Written once, not by each worker."""
    if not hasattr(session.config, "workerinput"):
        Path(os.environ["SKIPPED"]).write_text("".join(f"{node}\n" for node in _NODES))
