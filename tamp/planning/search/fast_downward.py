"""Fast Downward's search as a program: the task goes in as SAS+ on standard input, the plan comes back as a file."""

from __future__ import annotations

import contextlib
import importlib.util
import math
import os
import re
import signal
import subprocess
import tempfile
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from tamp import clock
from tamp.errors import DomainError
from tamp.planning.grounding.ground_task import GroundTask, TaskOperator
from tamp.planning.search.best_first import SearchResult
from tamp.planning.search.sas import write_sas

_FF = "let(h, ff(axioms=approximate_negative), "

CONFIGURATIONS = {
    "ff": _FF + "lazy_wastar([h], preferred=[h], w=3, boost=1000{bound}))",
    "ff-greedy": _FF + "lazy_greedy([h], preferred=[h]{bound}))",
    "ff-eager": _FF + "eager_wastar([h], preferred=[h], w=2, boost=0{bound}))",
    "add": "let(h, add(axioms=approximate_negative), lazy_greedy([h], preferred=[h]{bound}))",
    "cea": "let(h, cea(axioms=approximate_negative), lazy_greedy([h], preferred=[h]{bound}))",
    "astar": "astar(blind(){bound})",
    "astar-max": "astar(hmax(axioms=approximate_negative){bound})",
    "astar-lmcut": "astar(lmcut(){bound})",
}
"""Name -> Fast Downward's search; see its documentation of search algorithms and evaluators."""


@dataclass(frozen=True)
class Cheap:
    """A search for cheaper plans, which comes first where a task is small enough for it.

    How much it may see is counted in states, so that its outcome does not depend on the machine: Fast Downward itself
    can only be given a time, after which the states are counted, and which is doubled where they were too few.

    Attributes:
        search: how, with places for `bound` and `seconds`.
        most: operators of a task.
        work: states that may be evaluated, times operators.
        seconds: processor time that this usually takes at most [s].
        most_states: how many may be evaluated, where those are fewer than `STATES`.
    """

    search: str
    most: int
    work: int
    seconds: float
    most_states: int = 1_000_000_000

    def states(self, operators: int) -> int:
        """How many states of a task with so many operators may be evaluated."""
        return min(STATES, self.most_states, self.work // max(1, operators))


SPARE = 2.0
"""How much more time a cheap search is given than one before it would have needed for as many states."""

BRIEF_S = 1.0
"""The effort up to which a search has another after it: its last try has as long as the cheap ones before that [s]."""

WORK_A_SECOND = 12_000_000
"""States times operators that are evaluated in a second, about, where a search is ended before it says how many."""

STATES = 10_000
"""States that a cheap search may evaluate, however few operators there are."""

EVER = 1_000_000_000
"""Operators of a task that is never too large."""

CHEAP = {
    "ff": (
        Cheap(_FF + "lazy_wastar([h], preferred=[h], w=1, boost=0, max_time={seconds}{bound}))", 300, 1_200_000, 0.1),
        Cheap(_FF + "eager_wastar([h], preferred=[h], w=2, boost=0, max_time={seconds}{bound}))", 1000, 2_000_000, 0.2),
        Cheap(_FF + "lazy_wastar([h], preferred=[h], w=3, boost=0, max_time={seconds}{bound}))", EVER, 8_000_000, 0.8),
    )
}
"""Name -> the searches for small tasks: each sees more states than what follows, for cheaper plans."""

CHEAPER_S, NEARBY_S = 0.08, 0.16
"""Efforts for which it is searched by `CHEAPER` and by `NEARBY` for a plan below the cost of another [s]."""

CHEAPER = Cheap(
    _FF + "lazy_wastar([h], preferred=[h], w=1, boost=1000, max_time={seconds}{bound}))",
    EVER,
    1_000_000,
    CHEAPER_S,
    2000,
)
"""The search for a plan below the cost of another, where so little time is given for it."""

NEARBY = (
    Cheap(
        _FF + "eager_greedy([h], preferred=[h], boost=0, max_time={seconds}{bound}))", EVER, 1_000_000, CHEAPER_S, 2000
    ),
    CHEAPER,
    Cheap(
        _FF + "eager_wastar([h], preferred=[h], w=2, boost=0, max_time={seconds}{bound}))",
        1000,
        1_000_000,
        CHEAPER_S,
        2000,
    ),
)
"""Searches where more comes of them, one after the other until one finds a plan. Under a bound, those in the order of
costs see all that is cheap at first: going downhill finds a plan for many things among few states. What is lazy takes a
state for as good as the one before it, and misses much of what is dear at first and cheap in the end."""

IN_PLACE = {"astar-lmcut": "astar-max"}
"""Name -> what is searched by in its place where its heuristic knows neither axioms nor conditional effects."""

MEMORY_KB = 2_000_000
UNSOLVABLE, UNSOLVED, OUT_OF_TIME = 11, 12, 23
"""Fast Downward's exit status where it knows at once that there is no plan; where its search has ended without one, at
its time or after the whole space; and where its processor time ran out."""

EXHAUSTED = b"Completely explored state space"
"""What it prints where the whole space was seen."""


@cache
def binary() -> Path:
    """Fast Downward's search binary, from the package up-fast-downward.

    Raises:
        DomainError: where the package is not installed.
    """
    spec = importlib.util.find_spec("up_fast_downward")
    for root in (spec.submodule_search_locations or ()) if spec is not None else ():
        path = Path(root) / "downward" / "builds" / "release" / "bin" / "downward"
        if path.is_file():
            return path
    raise DomainError("Fast Downward is not installed: pip install up-fast-downward, or choose search='builtin'")


class FastDownward:
    """One of Fast Downward's configurations by name.

    Raises:
        DomainError: for an unknown name, with those that exist.
    """

    def __init__(self, name: str = "ff") -> None:
        if name not in CONFIGURATIONS:
            raise DomainError(f"unknown search {name!r}; there are: builtin, {', '.join(CONFIGURATIONS)}")
        self._search = CONFIGURATIONS[name]
        self._in_place = CONFIGURATIONS[IN_PLACE.get(name, name)]
        self._cheap = CHEAP.get(name, ())
        self._most = [cheap.most for cheap in self._cheap]

    def __call__(
        self, task: GroundTask, timeout: float, bound: int | None = None, effort: float = math.inf
    ) -> SearchResult:
        """Search for a plan that costs less than `bound`.

        After `timeout` seconds the program is killed; after `effort` seconds of processor time, rounded up, it ends.
        Where there is a bound, and no more effort than for `NEARBY`, it is searched so and in no other way.
        """
        if not task.goal_positive and not task.goal_negative:
            return SearchResult(())
        limit = "" if bound is None else f", bound={bound}"
        deadline = clock.now() + timeout
        text = write_sas(task)
        if text is None:
            return SearchResult(None, proven=True)
        if bound is not None and effort <= NEARBY_S:
            return _seen_below(task, text, limit, deadline, effort)
        in_vain: list[int] = []
        states, given, pace = 0, 0.0, 0.0
        for number, cheap in enumerate(self._cheap):
            if len(task.operators) <= self._most[number]:
                end = _seen_cheaply(task, text, cheap, limit, deadline, effort, pace)
                states += end.states
                given += end.seconds
                pace = end.pace
                if end.plan is not None:
                    return self._found(task, end.plan, states, in_vain)
                if end.exhausted:
                    return SearchResult(None, proven=bound is None, states=states)
                in_vain.append(number)
        conditional = any(e.positive or e.negative for op in task.operators for e in op.effects)
        search = self._in_place if task.axioms or conditional else self._search
        brief = 0.0 < given < effort <= BRIEF_S
        if brief:
            effort, limit = given, f"{limit}, max_time={given}"
        end = _plan(task, text, search.format(bound=limit), deadline - clock.now(), effort)
        timed_out = end.code in (None, OUT_OF_TIME, -signal.SIGXCPU) or (brief and end.code == UNSOLVED)
        timed_out &= not end.exhausted
        spent = WORK_A_SECOND * min(effort, timeout) / max(1, len(task.operators))
        states += int(spent) if timed_out else end.states
        if end.plan is not None:
            return self._found(task, end.plan, states, in_vain)
        # Where a bound cut the space, that it was seen proves nothing.
        proven = end.code in (UNSOLVABLE, UNSOLVED) and bound is None and not timed_out
        return SearchResult(None, proven, timed_out, states)

    def _found(self, task: GroundTask, plan: tuple[TaskOperator, ...], states: int, in_vain: list[int]) -> SearchResult:
        """A plan, and the note that what is no smaller would take the cheap searches before it too long as well."""
        for number in in_vain:
            self._most[number] = min(self._most[number], len(task.operators) - 1)
        return SearchResult(plan, states=states)


@dataclass(frozen=True)
class _End:
    """How a run ended: its exit code, None where time ran out; its plan; how many states it has evaluated.

    Attributes:
        exhausted: whether there is no plan below the bound, for sure.
        seconds: the processor time that it was given, where that was limited.
    """

    code: int | None
    plan: tuple[TaskOperator, ...] | None = None
    states: int = 0
    exhausted: bool = False
    seconds: float = 0.0

    @property
    def pace(self) -> float:
        """How many states it has evaluated in a second; 0 where that is not known."""
        return self.states / self.seconds if self.seconds else 0.0


def _seen_below(task: GroundTask, text: str, limit: str, deadline: float, effort: float) -> SearchResult:
    """What is found below a bound by as many of the searches that are meant for that as the effort is enough for."""
    states = 0
    for cheap in NEARBY if effort > CHEAPER_S else (CHEAPER,):
        if len(task.operators) <= cheap.most:
            end = _seen_cheaply(task, text, cheap, limit, deadline, 1.0)
            states += end.states
            if end.plan is not None or end.exhausted or clock.now() >= deadline:
                return SearchResult(end.plan, timed_out=not end.exhausted, states=states)
    return SearchResult(None, timed_out=True, states=states)


def _seen_cheaply(
    task: GroundTask, text: str, cheap: Cheap, limit: str, deadline: float, effort: float, pace: float = 0.0
) -> _End:
    """What a cheap search finds among the states that it may evaluate; another one did `pace` a second, 0 for none."""
    most, seconds = cheap.states(len(task.operators)), cheap.seconds
    if pace:
        seconds = min(seconds, SPARE * most / pace)
    while True:
        search = cheap.search.format(bound=limit, seconds=seconds)
        end = replace(_plan(task, text, search, deadline - clock.now(), effort), seconds=seconds)
        if end.plan is not None:
            return end if end.states <= most else replace(end, plan=None)
        if end.exhausted or end.code != UNSOLVED or end.states >= most or clock.now() >= deadline:
            return end
        seconds *= 2.0


def _plan(task: GroundTask, text: str, search: str, timeout: float, effort: float) -> _End:
    """Run the binary once."""
    with tempfile.TemporaryDirectory(prefix="tamp-") as folder:
        code, output = _run(text, search, folder, max(0.01, timeout), effort)
        counted = re.search(rb"Evaluated (\d+) state", output)
        states = int(counted[1]) if counted else 0
        plan = Path(folder) / "plan"
        if code is None or not plan.is_file():
            return _End(code, None, states, code == UNSOLVABLE or EXHAUSTED in output)
        names = [line[1:-1].split() for line in plan.read_text().splitlines() if line.startswith("(")]
        return _End(code, tuple(task.operators[int(name[0][1:])] for name in names), states)


def _run(text: str, search: str, folder: str, timeout: float, effort: float) -> tuple[int | None, bytes]:
    """Run the binary in its own process group; its exit code, or None where time ran out, and what it printed."""
    # `ulimit` bounds the child's memory and processor time without code between fork and exec.
    seconds = "unlimited" if effort == math.inf else math.ceil(effort)
    script = f'ulimit -v {MEMORY_KB}; ulimit -S -t {seconds}; exec "$0" "$@"'
    command = ["/bin/sh", "-c", script, str(binary()), "--internal-plan-file", "plan", "--search", search]
    with subprocess.Popen(
        command,
        cwd=folder,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,  # its end tells at once that the program has ended; without it Python polls and sleeps
        stderr=subprocess.DEVNULL,
        start_new_session=True,
        env={**os.environ, "LC_ALL": "C"},
    ) as process:
        try:
            output, _ = process.communicate(text.encode(), timeout=min(timeout, clock.FOREVER_S))
            return process.returncode, output
        except subprocess.TimeoutExpired:
            return None, b""
        finally:
            if process.poll() is None:
                with contextlib.suppress(ProcessLookupError):
                    os.killpg(process.pid, signal.SIGKILL)
