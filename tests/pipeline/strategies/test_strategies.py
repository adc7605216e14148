"""The strategies by name: each plans what the others plan, and net benefit reaches what it can."""

import math
from dataclasses import dataclass, replace
from typing import ClassVar

import pytest

import tamp
from tamp.errors import PlanningFailure
from tamp.pipeline.options.settings import Settings
from tamp.pipeline.solving.solve import carry_out
from tamp.pipeline.strategies.all_at_once import AllAtOnce
from tamp.pipeline.strategies.named import STRATEGIES
from tamp.pipeline.strategies.subproblems.subproblem import Asker
from tamp.planning import NetBenefit, PlanningRun
from tamp.planning.search.best_first import BuiltinSearch
from tamp.task import At, Box, Object, Pose, Task

BLOCK = Box((0.05, 0.05, 0.08))
RED = Object("red", BLOCK, Pose((0.05, 0.2, 0.04)), At(Pose((0.05, -0.2, 0.04))))
HUGE = Object("huge", Box((0.3, 0.3, 0.2)), Pose((-0.2, 0.3, 0.1)), At(Pose((-0.2, -0.35, 0.1))))


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_each_strategy_moves_a_block_with_one_pick(strategy):
    plan = tamp.plan(Task("one", (RED,)), timeout=120.0, strategy=strategy)
    assert [action.name for action in plan.actions] == ["move", "pick", "move", "place"]


@dataclass(frozen=True)
class Patient:
    """Plans when it is asked a second time."""

    tries: int = 2
    name: ClassVar[str] = "patient"

    def __call__(self, problem, settings):
        for number in range(self.tries):
            limit = 0.0 if number == 0 else settings.options.timeout
            again = replace(settings, options=replace(settings.options, timeout=limit))
            solution = PlanningRun(problem, again).solve()
        return solution


THRICE = Patient(tries=3)


def blind(task, timeout, bound=None, effort=math.inf):
    SEARCHED.append(task)
    return BuiltinSearch()(task, timeout, bound, effort)


SEARCHED = []


@pytest.mark.parametrize(("name", "tries"), [("Patient", 2), ("THRICE", 3)])
def test_a_strategy_and_a_search_of_ones_own_are_named_by_their_address(name, tries):
    own = {"strategy": f"{__name__}:{name}", "search": f"{__name__}:blind"}
    SEARCHED.clear()
    plan = tamp.plan(Task("one", (RED,)), timeout=120.0, **own)
    assert [action.name for action in plan.actions] == ["move", "pick", "move", "place"]
    assert plan.report["strategy"] == {"name": "patient", "tries": tries}
    assert SEARCHED


def test_where_not_all_goals_can_be_reached_net_benefit_reaches_what_it_can():
    settings = Settings(strategy="net-benefit", clock="processor")
    run = carry_out(Task("two", (RED, HUGE)), timeout=3.0, settings=settings, execute=False)
    (plan,) = run.plans
    assert [action.name for action in plan.actions] == ["move", "pick", "move", "place"]
    assert set(plan.report["left"]) == {"huge"}


@dataclass(frozen=True)
class Thrifty:
    """Net benefit under another name."""

    name: ClassVar[str] = "thrifty"
    supports_soft_goals: ClassVar[bool] = True

    def __call__(self, problem, settings):
        return NetBenefit(enough=50.0)(problem, settings)


def test_a_strategy_of_ones_own_that_supports_soft_goals_reaches_what_it_can():
    settings = Settings(strategy=f"{__name__}:Thrifty", clock="processor")
    (plan,) = carry_out(Task("two", (RED, HUGE)), timeout=3.0, settings=settings, execute=False).plans
    assert [action.name for action in plan.actions] == ["move", "pick", "move", "place"]
    assert set(plan.report["left"]) == {"huge"} and plan.report["strategy"] == {"name": "thrifty"}


def test_all_at_once_says_why_there_is_no_plan():
    with pytest.raises(PlanningFailure) as failed:
        tamp.plan(Task("two", (RED, HUGE)), timeout=1.0, clock="processor", strategy="all-at-once")
    assert failed.value.status in ("failed", "timeout")


def test_all_at_once_lets_objects_be_regrasped_where_single_grasps_bring_nothing(monkeypatch):
    asked = []

    def ask(asker, workspace, iterations, movable, either, ask=Asker.ask, **options):
        asked.append(either)
        return ask(asker, workspace, iterations, movable if either else (), either=either, **options)

    monkeypatch.setattr(Asker, "ask", ask)
    plan = tamp.plan(Task("one", (RED,)), timeout=120.0, strategy="all-at-once")
    assert asked == [False, True]
    assert {action.name for action in plan.actions} == {"move", "pick", "place"}


def test_all_at_once_says_what_was_wrong_with_a_plan_that_no_other_followed(monkeypatch):
    answers = []

    def answer(strategy, answer=AllAtOnce._answer):
        answers.append(answer(strategy) if not answers else replace(answers[0], plan=None, status="timeout"))
        return answers[-1]

    monkeypatch.setattr(AllAtOnce, "_answer", answer)
    monkeypatch.setattr(Asker, "refused", lambda asker, actions: "transit: too near")
    with pytest.raises(PlanningFailure, match="red: timeout; the plan before was refused: transit: too near"):
        tamp.plan(Task("one", (RED,)), timeout=60.0, strategy="all-at-once")
