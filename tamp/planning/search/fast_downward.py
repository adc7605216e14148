"""Fast Downward's search as a program: the task goes in as SAS+ on standard input, the plan comes back as a file."""

from __future__ import annotations

import contextlib
import importlib.util
import math
import os
import signal
import subprocess
import tempfile
from functools import cache
from pathlib import Path

from tamp import clock
from tamp.errors import DomainError
from tamp.planning.grounding.ground_task import GroundTask, TaskOperator
from tamp.planning.search.best_first import SearchResult
from tamp.planning.search.sas import write_sas

_FF = "let(h, ff(axioms=approximate_negative), "

CONFIGURATIONS = {
    "ff": _FF + "lazy_wastar([h], preferred=[h], w=3, boost=0{bound}))",
    "ff-greedy": _FF + "lazy_greedy([h], preferred=[h]{bound}))",
    "ff-eager": _FF + "eager_wastar([h], preferred=[h], w=2, boost=0{bound}))",
    "add": "let(h, add(axioms=approximate_negative), lazy_greedy([h], preferred=[h]{bound}))",
    "cea": "let(h, cea(axioms=approximate_negative), lazy_greedy([h], preferred=[h]{bound}))",
    "astar": "astar(blind(){bound})",
    "astar-max": "astar(hmax(axioms=approximate_negative){bound})",
    "astar-lmcut": "astar(lmcut(){bound})",
}
"""Name -> Fast Downward's search; see its documentation of search algorithms and evaluators."""

SMALL, MEDIUM = 300, 1000
"""Operators of tasks of which cheaper plans are looked for first, where the configuration has other searches for it."""

CHEAP = {
    "ff": (
        (SMALL, _FF + "lazy_wastar([h], preferred=[h], w=1, boost=0, max_time=0.1{bound}))"),
        (MEDIUM, _FF + "eager_wastar([h], preferred=[h], w=2, boost=0, max_time=0.2{bound}))"),
    )
}
"""Name -> the searches for tasks of at most so many operators: each sees more states than what follows, for cheaper
plans, for 0.1 or 0.2 s of processor time."""

IN_PLACE = {"astar-lmcut": "astar-max"}
"""Name -> what is searched by in its place where its heuristic knows neither axioms nor conditional effects."""

MEMORY_KB = 2_000_000
OUT_OF_TIME = 23
"""Fast Downward's exit status where its processor time ran out."""


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
        self._most = [most for most, _ in self._cheap]

    def __call__(
        self, task: GroundTask, timeout: float, bound: int | None = None, effort: float = math.inf
    ) -> SearchResult:
        """Search for a plan that costs less than `bound`.

        After `timeout` seconds the program is killed; after `effort` seconds of processor time, rounded up, it ends.
        """
        if not task.goal_positive and not task.goal_negative:
            return SearchResult(())
        limit = "" if bound is None else f", bound={bound}"
        deadline = clock.now() + timeout
        text = write_sas(task)
        if text is None:
            return SearchResult(None, proven=True)
        in_vain: list[int] = []
        for number, (_, search) in enumerate(self._cheap):
            if len(task.operators) <= self._most[number]:
                code, plan = _plan(task, text, search.format(bound=limit), deadline - clock.now(), effort)
                if plan is not None:
                    return self._found(task, plan, in_vain)
                in_vain.append(number)
        conditional = any(e.positive or e.negative for op in task.operators for e in op.effects)
        search = self._in_place if task.axioms or conditional else self._search
        code, plan = _plan(task, text, search.format(bound=limit), deadline - clock.now(), effort)
        if plan is not None:
            return self._found(task, plan, in_vain)
        # 11 and 12: the whole space was seen; 12 also where a bound cut it, which proves nothing.
        timed_out = code in (None, OUT_OF_TIME, -signal.SIGXCPU)
        return SearchResult(None, proven=code in (11, 12) and bound is None, timed_out=timed_out)

    def _found(self, task: GroundTask, plan: tuple[TaskOperator, ...], in_vain: list[int]) -> SearchResult:
        """A plan, and the note that what is no smaller would take the cheap searches before it too long as well."""
        for number in in_vain:
            self._most[number] = min(self._most[number], len(task.operators) - 1)
        return SearchResult(plan)


def _plan(
    task: GroundTask, text: str, search: str, timeout: float, effort: float
) -> tuple[int | None, tuple[TaskOperator, ...] | None]:
    """The exit code of a run, and its plan."""
    with tempfile.TemporaryDirectory(prefix="tamp-") as folder:
        code = _run(text, search, folder, max(0.01, timeout), effort)
        plan = Path(folder) / "plan"
        if code is None or not plan.is_file():
            return code, None
        names = [line[1:-1].split() for line in plan.read_text().splitlines() if line.startswith("(")]
        return code, tuple(task.operators[int(name[0][1:])] for name in names)


def _run(text: str, search: str, folder: str, timeout: float, effort: float) -> int | None:
    """Run the binary in its own process group; its exit code, or None where time ran out."""
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
            process.communicate(text.encode(), timeout=min(timeout, clock.FOREVER_S))
            return process.returncode
        except subprocess.TimeoutExpired:
            return None
        finally:
            if process.poll() is None:
                with contextlib.suppress(ProcessLookupError):
                    os.killpg(process.pid, signal.SIGKILL)
