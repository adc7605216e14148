"""Speculative execution comes to what one process alone does, whatever was guessed, and leaves no process behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp import clock
from tamp.clock import TimeUp, ended_at, limits_in
from tamp.errors import PlanningFailure, TampError
from tamp.speculation import presumed, speculating

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="processes that end with their parent need Linux")


@settings(max_examples=25, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 2), st.integers(0, 2)), max_size=8), st.integers(1, 4))
def test_the_outcome_is_that_of_one_process(steps: list[tuple[int, int]], threads: int) -> None:
    def work() -> list[tuple[int, int]]:
        seen = []
        for outcome, guess in steps:
            found = presumed(lambda outcome=outcome: outcome, guess)  # type: ignore[misc]
            seen.append((found, sum(value for value, _ in seen)))
        return seen

    assert speculating(work, threads) == work()


def test_what_was_done_from_a_wrong_guess_is_undone() -> None:
    def work() -> list[str]:
        done: list[str] = []
        if presumed(lambda: time.sleep(0.2) or "refused", "accepted") == "accepted":
            done.append("went on")
        done.append("ended")
        return done

    assert speculating(work, 2) == ["ended"]


def test_a_test_runs_beside_what_comes_after_it(tmp_path: Path) -> None:
    def test() -> bool:
        end = time.monotonic() + 20.0
        while not (tmp_path / "after").exists():  # only a process that goes on at once ends this
            if time.monotonic() > end:
                return False
            time.sleep(0.01)
        return True

    def work() -> bool:
        found = presumed(test, True)
        (tmp_path / "after").touch()
        return found

    assert speculating(work, 2)
    assert (tmp_path / "after").exists()


def test_no_more_processes_compute_than_threads(tmp_path: Path) -> None:
    def work() -> int:
        for number in range(6):
            presumed(lambda number=number: busy(number), None)  # type: ignore[misc]
        return 6

    def busy(number: int) -> None:
        (tmp_path / f"{number}").touch()
        time.sleep(0.05)
        most = len(list(tmp_path.iterdir()))
        (tmp_path / f"{number}").unlink()
        assert most <= 3, f"{most} tests at once"

    assert speculating(work, 3) == 6


@pytest.mark.parametrize("threads", [1, 2, 3])
def test_an_exception_reaches_who_asked(threads: int) -> None:
    def work() -> None:
        presumed(lambda: None, None)
        raise PlanningFailure("failed", "a report", {"can": "why"})

    with pytest.raises(PlanningFailure, match="can: why") as caught:
        speculating(work, threads)
    assert caught.value.status == "failed"


def test_an_exception_in_a_test_comes_before_all_that_was_done_meanwhile() -> None:
    def work() -> str:
        presumed(lambda: 1 // 0, None)
        return "never"

    with pytest.raises(ZeroDivisionError):
        speculating(work, 2)


def test_a_crash_is_told_and_not_shared() -> None:
    def work() -> None:
        presumed(lambda: None, None)
        os.kill(os.getpid(), signal.SIGKILL)

    with pytest.raises(TampError, match="ended by SIGKILL"):
        speculating(work, 2)


def test_an_outcome_that_cannot_be_pickled_is_said_to_be_so() -> None:
    with pytest.raises(TampError, match="pickled"):
        speculating(lambda: lambda: None, 2)


def test_limits_hold_in_every_process() -> None:
    def work() -> None:
        with ended_at(clock.now() + 0.3):
            presumed(lambda: None, None)
            time.sleep(60.0)

    began = time.monotonic()
    with pytest.raises(TimeUp):
        speculating(work, 2)
    assert time.monotonic() - began < 30.0


def test_deadlines_are_told_to_who_watches() -> None:
    told: list[float | None] = []

    def work() -> None:
        presumed(lambda: None, None)
        with ended_at(clock.now() + 100.0):
            pass

    with clock.watched(told.append):
        speculating(work, 2)
    assert len(told) == 2
    assert told[0] is not None
    assert told[1] is None


def _compute(seconds: float) -> None:
    end = time.process_time() + seconds
    while time.process_time() < end:
        pass


def test_processor_time_counts_what_leads_to_the_outcome() -> None:
    def work() -> float:
        began = clock.now()
        for right in (True, False, True):
            presumed(lambda right=right: _compute(0.3) or right, True)  # type: ignore[misc]
        _compute(0.2)
        return clock.now() - began

    with limits_in("processor"):
        began = clock.now()
        inside = speculating(work, 2)
        outside = clock.now() - began
    # One test of three is in vain: what was computed beside the other two, if anything was, is not counted.
    assert 0.4 <= inside <= 1.3
    assert inside <= outside + 0.02 <= inside + 0.3


def test_what_is_printed_is_printed_once(tmp_path: Path) -> None:
    script = tmp_path / "prints.py"
    script.write_text(
        "from tamp.speculation import presumed, speculating\n"
        "print('before')\n"
        "def work():\n"
        "    print('first')\n"
        "    presumed(lambda: None, None)\n"
        "    print('second')\n"
        "speculating(work, 2)\n"
        "print('after')\n",
        encoding="utf-8",
    )
    said = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, check=True).stdout
    assert said.split() == ["before", "first", "second", "after"]


def test_all_end_with_who_asked(tmp_path: Path) -> None:
    script = tmp_path / "asks.py"
    script.write_text(
        "import os, sys, time\n"
        "from tamp.speculation import presumed, speculating\n"
        "def work():\n"
        "    for _ in range(3):\n"
        "        print(os.getpid(), flush=True)\n"
        "        presumed(lambda: time.sleep(0.05), None)\n"
        "    print(os.getpid(), 'last', flush=True)\n"
        "    time.sleep(600)\n"
        "speculating(work, 2)\n",
        encoding="utf-8",
    )
    with subprocess.Popen([sys.executable, str(script)], stdout=subprocess.PIPE, text=True) as asks:
        assert asks.stdout is not None
        seen = []
        for line in asks.stdout:
            seen.append(int(line.split()[0]))
            if "last" in line:
                break
        asks.kill()
    end = time.monotonic() + 20.0
    while (left := [number for number in seen if _lives(number)]) and time.monotonic() < end:
        time.sleep(0.05)
    assert not left


def _lives(number: int) -> bool:
    try:
        return Path(f"/proc/{number}/stat").read_text(encoding="utf-8").split()[2] not in "ZX"
    except OSError:
        return False
