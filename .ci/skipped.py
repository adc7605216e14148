"""A plugin for pytest: what was skipped, test or whole module, stands in the file `SKIPPED` afterwards, a node a line.

`pytest @FILE` runs those again, where what they asked for is there.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest


def pytest_configure(config: pytest.Config) -> None:
    """Listen where tests are led from, not in each of several workers."""
    if not hasattr(config, "workerinput"):
        config.pluginmanager.register(Skipped(Path(os.environ["SKIPPED"])))


class Skipped:
    """What was skipped so far."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._nodes: dict[str, None] = {}

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """A test."""
        self._keep(report)

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        """A module that skips itself as it is imported."""
        self._keep(report)

    def pytest_sessionfinish(self) -> None:
        """Written once, at the end."""
        self._path.write_text("".join(f"{node}\n" for node in self._nodes), encoding="utf-8")

    def _keep(self, report: pytest.TestReport | pytest.CollectReport) -> None:
        if report.skipped:
            self._nodes[report.nodeid] = None
