"""The kits for searches and strategies: what is built in fits, and of each broken one its fault is told."""

from __future__ import annotations

import math
import random
import re
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import pytest

from tamp.conformance import checks
from tamp.conformance.findings import PartJudgement
from tamp.conformance.planner import check_search, check_strategy
from tamp.conformance.planner import strategy as kit
from tamp.errors import TampError
from tamp.pipeline.options.settings import SEARCHES
from tamp.planning import AllAtOnce, NetBenefit, PlanningRun, SearchResult
from tamp.planning.search.best_first import BuiltinSearch
from tamp.planning.solve import STRATEGIES


def wrong(judgement: PartJudgement) -> str:
    (told,) = [f"{f.check}: {f.text}" for f in judgement.findings if f.outcome == "wrong"]
    assert not judgement.fits and "\n" not in told
    return told


def notes(judgement: PartJudgement) -> list[str]:
    return [f"{f.check}: {f.text}" for f in judgement.findings if f.outcome == "note"]


@pytest.fixture
def hurried(monkeypatch: pytest.MonkeyPatch) -> None:
    """A kit with little patience."""
    monkeypatch.setattr(checks, "PATIENCE_S", 0.5)


@pytest.mark.parametrize("name", ["builtin", "ff", "astar"])
def test_a_built_in_search_fits(name: str) -> None:
    assert name in SEARCHES
    judgement = check_search(name)
    assert judgement.fits, str(judgement)
    assert judgement.as_dict()["search"] == name


def broken(change: Callable[[Any, SearchResult], Any]) -> Callable[..., Any]:
    """The built-in search, whose answers are changed."""

    def search(task: Any, timeout: float, bound: int | None = None, effort: float = math.inf) -> Any:
        return change(task, BuiltinSearch()(task, timeout, bound, effort))

    return search


def unbounded(task: Any, timeout: float, bound: int | None = None, effort: float = math.inf) -> SearchResult:
    return BuiltinSearch()(task, timeout, None, effort)


LUCK = random.Random(0)  # shared by all calls: the fault is that it belongs to no seed


def lucky(task: Any, timeout: float, bound: int | None = None, effort: float = math.inf) -> SearchResult:
    operators = tuple(LUCK.sample(task.operators, len(task.operators)))
    return BuiltinSearch()(replace(task, operators=operators), timeout, bound, effort)


def hasty(task: Any, timeout: float, bound: int | None = None, effort: float = math.inf) -> SearchResult:
    """Never looks at the clock."""
    return BuiltinSearch()(task, math.inf, bound, math.inf)


SEARCHES_THAT_FAIL = {
    "no function": (lambda: 5, "call: it cannot be called; a search is called with"),
    "no limits": (lambda: lambda task: None, r"call: it must take \(task, timeout, bound=None"),
    "raises": (lambda: broken(lambda task, result: 1 / 0), r"plans: .*: it raised ZeroDivisionError: .* at .*test_pl"),
    "prints": (lambda: broken(lambda task, result: print("hm") or result), "plans: .*: it printed 'hm"),
    "a bare plan": (lambda: broken(lambda task, result: result.plan), "plans: .*: expected a SearchResult, found"),
    "half a plan": (
        lambda: broken(lambda task, result: replace(result, plan=result.plan and result.plan[:-1])),
        "plans: .*: its plan does not lead from what is initial",
    ),
    "claims": (
        lambda: broken(lambda task, result: SearchResult(None, proven=True)),
        "plans: .*: it says that it is proven that there is no plan, and there is one",
    ),
    "nothing": (lambda: broken(lambda task, result: SearchResult(None)), "plans: it finds no plan for any of 3 tasks"),
    "chance": (lambda: lucky, "repetition: .*: a second call gives another plan"),
    "late": (lambda: hasty, "limit: .*: it had not come back after 1 s, its limit being 0.5 s"),
}


@pytest.mark.parametrize("case", SEARCHES_THAT_FAIL)
@pytest.mark.usefixtures("hurried")
def test_the_fault_of_a_broken_search_is_told(case: str) -> None:
    make, said = SEARCHES_THAT_FAIL[case]
    told = wrong(check_search(make()))
    assert re.search(said, told), told


def test_what_a_search_does_worse_is_noted() -> None:
    assert [note.partition(":")[0] for note in notes(check_search(unbounded))] == ["bound"]
    modest = broken(lambda task, result: replace(result, proven=False))
    assert [note.partition(":")[0] for note in notes(check_search(modest))] == ["proofs"]


@pytest.mark.parametrize("name", STRATEGIES)
def test_a_built_in_strategy_fits(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kit, "LIMIT_S", 2.0)  # net benefit takes all of it where a stream has no end
    judgement = check_strategy(name)
    assert judgement.fits, str(judgement)


def test_a_name_that_says_none_is_refused() -> None:
    with pytest.raises(TampError, match="unknown strategy 'serialised'; did you mean 'serialized'"):
        check_strategy("serialised")
    with pytest.raises(TampError, match="unknown search 'fff'; did you mean 'ff'"):
        check_search("fff")


@dataclass(frozen=True)
class Changed:
    """All at once, whose solutions are changed."""

    name: ClassVar[str] = "changed"

    def change(self, solution: Any) -> Any:
        return solution

    def __call__(self, problem: Any, settings: Any) -> Any:
        return self.change(AllAtOnce()(problem, settings))


@dataclass(frozen=True)
class Unrecorded(Changed):
    heuristic: Any = field(default=len)


class Raising(Changed):
    def change(self, solution: Any) -> Any:
        return 1 / 0


class Bare(Changed):
    def change(self, solution: Any) -> Any:
        return solution.plan


class Short(Changed):
    """Leaves out the last step."""

    def change(self, solution: Any) -> Any:
        return solution if not solution.plan else replace(solution, plan=solution.plan[:-1])


class Backwards(Changed):
    def change(self, solution: Any) -> Any:
        return solution if not solution.plan else replace(solution, plan=solution.plan[::-1])


class Cheap(Changed):
    def change(self, solution: Any) -> Any:
        return replace(solution, cost=0.5) if solution.plan else solution


class Pessimist(Changed):
    def change(self, solution: Any) -> Any:
        return replace(solution, plan=None, status="infeasible")


class Optimist(Changed):
    def change(self, solution: Any) -> Any:
        return replace(solution, plan=None, status="solved")


class Chatty(Changed):
    def change(self, solution: Any) -> Any:
        return replace(solution, status="fine")


class Inventive(Changed):
    def change(self, solution: Any) -> Any:
        return replace(solution, certified=(*solution.certified, ("dry", "chair", ("chair", -1))))


class Lucky(Changed):
    def __call__(self, problem: Any, settings: Any) -> Any:
        again = replace(settings.options, seed=LUCK.randrange(10**6))
        return PlanningRun(problem, replace(settings, options=again)).solve()


class Patient(Changed):
    """Goes on for ever where nothing is found."""

    def __call__(self, problem: Any, settings: Any) -> Any:
        while (solution := AllAtOnce()(problem, settings)).status == "timeout":
            time.sleep(0.01)
        return solution


class Idle(Changed):
    def change(self, solution: Any) -> Any:
        return replace(solution, plan=None, status="failed")


@dataclass(frozen=True)
class Forgetful:
    """Says nothing of what it leaves."""

    name: ClassVar[str] = "forgetful"
    supports_soft_goals: ClassVar[bool] = True

    def __call__(self, problem: Any, settings: Any) -> Any:
        return replace(NetBenefit(enough=20.0)(problem, settings), forgone=())


@pytest.mark.parametrize(
    ("strategy", "said"),
    [
        (AllAtOnce, "call: it is the class AllAtOnce; give an instance"),
        (Unrecorded(), "record: its options {'name': .*heuristic.*} cannot be written into a run's record: "),
        (Raising(), "plans: .*: strategy 'changed' raised ZeroDivisionError: .* at .*test_planner.py"),
        (Bare(), "plans: .*: strategy 'changed': expected a Solution, found "),
        (Short(), "plans: .*: the goal .* does not hold after its plan"),
        (Backwards(), "plans: .*: step 1 of its plan, unlock, cannot be taken: its precondition does not hold then"),
        (Cheap(), "plans: .*: it says that its plan costs 0.5; its actions cost "),
        (Pessimist(), "plans: .*: its status is 'infeasible', and there is a plan"),
        (Optimist(), "plans: .*: its status is 'solved', with no plan"),
        (Chatty(), "plans: .*: its status is 'fine'; valid are solved, infeasible"),
        (Inventive(), r"plans: .*: it says that .* is certified, and no stream gave \('chair', -1\)"),
        (Idle(), "plans: it plans for none of 4 problems"),
        (Lucky(), "repetition: a problem with a stream: the same seed gives another plan"),
        (Patient(), "limit: a stream that goes on .*: it had not come back after 1.5 s"),
        (Forgetful(), r"soft goals: soft goals: its plan leaves \(made table\), and it says none"),
    ],
    ids=lambda value: getattr(value, "__name__", type(value).__name__),
)
@pytest.mark.usefixtures("hurried")
def test_the_fault_of_a_broken_strategy_is_told(strategy: Any, said: str) -> None:
    told = wrong(check_strategy(strategy))
    assert re.search(said, told), told
