from pathlib import Path

import tamp
from tamp.checking import Problem, Verdict
from tamp.pipeline import attempt
from tamp.pipeline.planning import plan
from tamp.pipeline.solving import carry_out
from tamp.scoring import score
from tamp.task import At, Box, Object, Pose, Task
from tamp.task.plan_file import plan_sha256
from tests.pipeline.samplers import no_grasp

SCENARIOS = Path(__file__).parents[2] / "scenarios"


def test_one_object_is_solved(run):
    result = run.result
    assert result.status == "solved"
    assert result.plan_checked
    assert dict(result.goals_met) == {"red": True}
    assert result.ede_m < 0.03
    assert result.message == ""
    assert result.grasps_succeeded == result.grasps_attempted == 1
    assert result.n_actions == 4


def test_the_record_agrees_with_what_happened(run, one_object):
    assert run.result.plan_sha256 == plan_sha256(run.plans[0])
    assert run.result.n_replans == len(run.plans) - 1
    assert run.result.ede_m == score(one_object, run.final_poses).ede_m
    assert run.result.execution_sim_s == sum(e.sim_s for e in run.executions)


def test_without_execution_a_task_is_planned_and_has_no_score(run, one_object):
    result = tamp.solve(one_object, seed=0, execute=False)
    assert result.status == "planned"
    assert result.plan_checked
    assert result.plan_sha256 == run.result.plan_sha256
    assert result.ede_m is None
    assert result.improvement is None
    assert result.improvement_ueb is None
    assert result.objects == ()
    assert result.execution_sim_s == 0.0
    assert result.n_actions == 4


def test_solve_and_plan_find_the_same_plan(run, one_object):
    assert plan_sha256(plan(one_object, seed=0)) == run.result.plan_sha256


def test_a_rejected_plan_sends_the_planner_back_and_is_counted(run, one_object, monkeypatch):
    """The checker is made to find something in the first plan: another is made, and the record says so."""
    refusal = Verdict((Problem(0, "move()", 0.5, "collision", ("red", "hand"), 0.002, "red and hand touch"),))
    verdicts = iter([refusal])
    monkeypatch.setattr(attempt, "check", lambda *args, **options: next(verdicts, Verdict()))
    second = carry_out(one_object, seed=0, execute=False)
    assert second.result.status == "planned"
    assert second.result.plans_rejected == 1
    assert second.result.plan_sha256 != run.result.plan_sha256
    assert second.plans[0].report["rejected"] == [str(refusal)]
    assert second.rejections == (str(refusal),)
    assert run.result.plans_rejected == 0


def test_two_things_change_places():
    result = tamp.solve(tamp.load_task(SCENARIOS / "swap.yaml"), seed=0)
    assert result.status == "solved"
    assert dict(result.goals_met) == {"cup": True, "jar": True}
    assert result.n_actions >= 12  # one of them moves twice


def test_a_task_that_is_done_already_needs_no_action():
    there = Pose((0.05, 0.2, 0.04))
    result = tamp.solve(Task("done", (Object("red", Box((0.05, 0.05, 0.08)), there, At(there)),)))
    assert result.status == "solved"
    assert result.n_actions == 0


def test_without_a_plan_the_objects_stay_and_the_message_says_why(one_object):
    given_up = carry_out(one_object, seed=0, timeout=60.0, samplers={"sample-grasp": no_grasp})
    assert given_up.result.status in ("timeout", "failed", "infeasible")
    assert given_up.result.plan_sha256 == ""
    assert not given_up.result.plan_checked
    assert given_up.result.message.startswith("no plan (")
    assert "red: " in given_up.result.message
    assert given_up.failure is not None
    assert given_up.executions == ()
    assert given_up.result.ede_m == given_up.result.do_nothing_ede_m


def test_time_that_is_up_before_anything_has_settled_is_a_timeout(one_object):
    run = carry_out(one_object, seed=0, timeout=0.0)
    assert run.result.status == "timeout"
    assert run.final_poses == {thing.name: thing.pose for thing in one_object.objects}
