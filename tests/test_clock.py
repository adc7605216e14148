"""Limits are kept by an alarm, which nothing leaves behind, whenever it rings."""

from __future__ import annotations

import gc
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import SimpleNamespace

import numpy as np
import pytest

from tamp import clock
from tamp.clock import TimeUp, ended_at


@pytest.fixture(autouse=True)
def at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(clock, "GRACE_S", 0.0)
    monkeypatch.setattr(clock, "AGAIN_S", 0.0002)


@pytest.fixture(autouse=True)
def without_finalizers() -> Iterator[None]:
    """What other tests left is not collected meanwhile: an exception that is raised in a finalizer goes nowhere."""
    gc.collect()
    gc.disable()
    yield
    gc.enable()


def armed() -> bool:
    return signal.getsignal(signal.SIGALRM) is not signal.SIG_DFL or signal.getitimer(signal.ITIMER_REAL)[0] > 0.0


def spin(seconds: float) -> None:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        pass


@contextmanager
def counted(deadline: float) -> Iterator[None]:
    with ended_at(deadline):
        yield


def test_what_goes_on_past_its_deadline_is_ended() -> None:
    with pytest.raises(TimeUp), ended_at(clock.now() + 0.01):
        spin(10.0)
    assert not armed()


@pytest.mark.parametrize("limit", [ended_at, counted])
def test_an_alarm_that_rings_as_its_block_ends_is_the_last(limit) -> None:
    for late in range(400):
        kept = []
        try:
            with limit(clock.now() + 0.0004):
                spin(0.0002 + 1e-6 * late)
        except TimeUp as up:
            kept.append(up)  # as reports of tests do: its traceback keeps what was left open from being closed
        assert not armed(), late


def test_a_block_that_is_abandoned_takes_its_alarm_along() -> None:
    def enter() -> object:
        left_open = ended_at(clock.now() + 0.002)
        left_open.__enter__()
        return left_open

    abandoned = enter()
    spin(0.02)
    assert not armed()
    with pytest.raises(TimeUp), ended_at(clock.now() + 0.005):
        del abandoned  # closing it leaves the alarm of others alone
        spin(10.0)
    assert not armed()


def test_an_alarm_that_gives_way_rings_again_after_one_inside() -> None:
    with pytest.raises(TimeUp), ended_at(clock.now() + 0.3, gives_way=True):
        assert clock.is_free()
        with pytest.raises(TimeUp), ended_at(clock.now() + 0.01):
            assert not clock.is_free()
            spin(10.0)
        assert clock.is_free() and armed()
        spin(10.0)
    assert not armed()


def test_no_alarm_inside_one_that_gives_way_rings_later_than_that() -> None:
    began = clock.now()
    with pytest.raises(TimeUp), ended_at(began + 0.01, gives_way=True), ended_at(began + 5.0):
        spin(10.0)
    assert clock.now() - began < 3.0
    assert not armed()


def test_what_compiled_code_calls_back_for_is_not_interrupted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Compiled code goes on without looking whether that raised: it was a SystemError, and not TimeUp."""
    from numba import njit
    from numba.core import serialize

    @njit
    def made() -> tuple[np.ndarray, np.ndarray]:
        return np.zeros(3), np.zeros(3)

    made()

    class Slow(dict[object, object]):
        def __getitem__(self, key: object) -> object:
            spin(0.02)
            return super().__getitem__(key)

    monkeypatch.setattr(serialize, "_unpickled_memo", Slow(serialize._unpickled_memo))
    with pytest.raises(TimeUp), ended_at(clock.now() + 0.005):
        while True:
            made()


def test_what_a_compiler_hands_over_is_taken_whole() -> None:
    """It hears of no exception: the code was lost, and whatever was to run it raised for the rest of the process."""
    from llvmlite.binding.executionengine import ExecutionEngine

    begun, ended = [], []

    def keep(module: object, code: bytes) -> None:
        begun.append(code)
        spin(0.002)
        ended.append(code)

    engine = SimpleNamespace(_object_cache_notify=keep, _find_module_ptr=lambda number: number)
    data = SimpleNamespace(contents=SimpleNamespace(module_ptr=1, buf_ptr=b"code", buf_len=4))
    with pytest.raises(TimeUp), ended_at(clock.now() + 0.005):
        while True:
            ExecutionEngine._raw_object_cache_notify(engine, data)
    assert len(begun) == len(ended) > 1
