from pathlib import Path

import pytest

import tamp
from tamp.pipeline.solving.solve import carry_out

SCENARIOS = Path(__file__).parents[2] / "scenarios"


@pytest.fixture(scope="session")
def one_object():
    return tamp.load_task(SCENARIOS / "one_object.yaml")


@pytest.fixture(scope="session")
def run(one_object):
    return carry_out(one_object, seed=0)
