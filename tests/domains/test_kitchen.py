"""The second domain is really solved: cleaned in the sink, cooked on the stove, checked, carried out and scored."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

import tamp
from tamp.domains import kitchen, tabletop
from tamp.domains.skill import FactChange
from tamp.errors import PartError, TaskError
from tamp.pipeline.prepare import domain_of
from tamp.pipeline.solving.run import Run
from tamp.pipeline.solving.solve import carry_out
from tamp.task import Action, Task

SCENARIOS = Path(__file__).parents[2] / "scenarios"


@pytest.fixture(scope="module")
def task() -> Task:
    return tamp.load_task(SCENARIOS / "cook_dinner.yaml")


@pytest.fixture(scope="module")
def run(task: Task) -> Run:
    return carry_out(task, seed=0, timeout=120.0)


def test_what_is_cooked_was_cleaned_before(run: Run) -> None:
    own = [str(a) for a in run.plans[0].actions if a.name in ("clean", "cook")]
    assert own.index("clean(potato, basin)") < own.index("cook(potato, hob)")
    assert "clean(mug, basin)" in own
    assert sum(a.name == "pick" for a in run.plans[0].actions) == 3, "the potato twice, the mug once"


def test_it_is_solved_and_says_by_what(run: Run) -> None:
    assert run.result.status == "solved", run.result.message
    assert run.result.goals_met == {"(cleaned mug)": True, "(cooked potato)": True}
    assert (run.result.domain, run.result.strategy) == ("kitchen", "all-at-once")


def test_things_stand_where_the_last_action_needed_them(task: Task, run: Run) -> None:
    for name, region in (("potato", "hob"), ("mug", "basin")):
        (place,) = (r for r in task.regions if r.name == region)
        x, y, _ = run.final_poses[name].xyz
        assert abs(x - place.center[0]) < place.size[0] / 2
        assert abs(y - place.center[1]) < place.size[1] / 2


@pytest.mark.parametrize("name", ["table", "basin", "nobody"])
def test_only_objects_are_cleaned(task: Task, run: Run, name: str) -> None:
    plan = replace(run.plans[0], actions=(Action("clean", (name, "basin"), ()),))
    said = " ".join(problem.sentence for problem in tamp.check(task, plan).problems)
    assert f"{name} is no object" in said or f"knows no {name}" in said


def test_it_is_solved_goal_by_goal_too(task: Task) -> None:
    plan = tamp.plan(task, timeout=120.0, strategy="serialized")
    assert not plan.report["left"]
    assert {"clean(mug, basin)", "cook(potato, hob)"} <= {str(action) for action in plan.actions}


def test_a_rule_and_its_skill_say_the_same_of_facts(task: Task, monkeypatch: pytest.MonkeyPatch) -> None:
    forgetful = replace(kitchen.COOK_AND_CLEAN, facts=lambda action: FactChange())
    domain = tabletop.DOMAIN.extended(forgetful, name="kitchen", strategy="all-at-once")
    monkeypatch.setattr("tamp.pipeline.prepare.load_domain", lambda name: domain)
    with pytest.raises(PartError, match=r"\(cleaned \w+\) holds by its rule and not by its `facts`"):
        tamp.plan(task, timeout=60.0)


@pytest.mark.parametrize("fact", [("not", "egg"), ("AND", "egg")])
def test_a_goal_that_is_no_list_of_facts_is_said(fact):
    with pytest.raises(TaskError, match=f"'{fact[0].lower()}' is no predicate: facts are listed that hold"):
        domain_of(Task("t", (), domain="kitchen", goal=(fact,)), None)
