"""A run to report on."""

from __future__ import annotations

from pathlib import Path

import pytest

import tamp
from tamp.pipeline.solving.solve import Run, carry_out
from tamp.task import Task


@pytest.fixture(scope="session")
def one_object() -> Task:
    return tamp.load_task(Path(__file__).parents[2] / "scenarios" / "one_object.yaml")


@pytest.fixture(scope="session")
def run(one_object: Task) -> Run:
    return carry_out(one_object, seed=0)
