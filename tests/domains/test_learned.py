"""A model is read once in a process, before planning's clock starts, and its sampler serves a stream like any other."""

from __future__ import annotations

import inspect
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import tamp
from tamp.conformance import check_sampler
from tamp.domains.learned import load_models, with_model
from tamp.errors import SamplerError
from tests.pipeline.samplers import from_above

ONE = Path(__file__).parents[2] / "scenarios" / "one_object.yaml"
LIMITS: list[float] = []


def read() -> float:
    """A model, which notes whether a limit is running, as `tamp.clock.ended_at` sets it."""
    LIMITS.append(signal.getitimer(signal.ITIMER_REAL)[0])
    return 0.75


@with_model(read)
def learned(context: Any, model: float, obj: str) -> Iterator[tamp.Grasp]:
    assert model == 0.75
    assert signal.getitimer(signal.ITIMER_REAL)[0] > 0.0
    yield from from_above(context, obj)


def test_a_model_is_read_once_and_not_on_the_clock() -> None:
    assert list(inspect.signature(learned).parameters) == ["context", "obj"]
    task = tamp.load_task(ONE)
    assert tamp.solve(task, samplers={"sample-grasp": learned}, execute=False).status == "planned"
    assert tamp.plan(task, samplers={"sample-grasp": learned}).actions
    assert LIMITS == [0.0]
    assert check_sampler(learned, "sample-grasp", tasks=[task]).fits


def test_a_model_that_cannot_be_read_is_one_sentence() -> None:
    @with_model(lambda: Path("nowhere.bin").read_bytes())
    def broken(context: Any, model: bytes, obj: str) -> Iterator[tamp.Grasp]:
        yield from ()

    with pytest.raises(SamplerError, match=r"the model of sampler .*broken cannot be read: FileNotFoundError"):
        load_models([broken])
