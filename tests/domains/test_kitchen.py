"""The second domain is really solved: cleaned in the sink, cooked on the stove, and carried out in the simulator."""

from __future__ import annotations

import pytest

from tamp.domains.catalog import load_domain
from tamp.domains.kitchen import assemble, kitchen_problem
from tamp.domains.samplers import resolve_samplers
from tamp.execution.executor import execute
from tamp.planning import Solution, solve
from tamp.streams.values import Configuration
from tamp.streams.workspace import Workspace
from tamp.task import Box, Cylinder, Object, Plan, Pose, Region, load_robot
from tests.streams.tables import workspace_of

POTATO = Object("potato", Cylinder(0.025, 0.06), Pose((0.05, 0.0, 0.03)))
MUG = Object("mug", Box((0.05, 0.05, 0.08)), Pose((-0.1, 0.0, 0.04)))
BASIN = Region("basin", (0.0, 0.28), (0.2, 0.16))
HOB = Region("hob", (0.0, -0.28), (0.2, 0.16))


@pytest.fixture(scope="module")
def workspace() -> Workspace:
    return workspace_of(POTATO, MUG, regions=(BASIN, HOB))


@pytest.fixture(scope="module")
def solution(workspace: Workspace) -> Solution:
    spec = load_robot("panda")
    problem = kitchen_problem(
        workspace,
        resolve_samplers(load_domain("kitchen").samplers),
        Configuration(spec.home, spec.gripper.stroke),
        sinks=["basin"],
        stoves=["hob"],
        cooked=["potato"],
        cleaned=["mug"],
    )
    return solve(problem, timeout=120.0, seed=0)


def test_what_is_cooked_was_cleaned_before(solution: Solution) -> None:
    assert solution.plan is not None, str(solution.report)
    own = [(a.name, *a.args) for a in solution.plan if a.name in ("clean", "cook")]
    assert own.index(("clean", "potato", "basin")) < own.index(("cook", "potato", "hob"))
    assert ("clean", "mug", "basin") in own
    assert sum(a.name == "pick" for a in solution.plan) == 3, "the potato twice, the mug once"


def test_the_plan_is_carried_out(workspace: Workspace, solution: Solution) -> None:
    assert solution.plan is not None
    actions = assemble(workspace, solution.plan)
    assert [a.name.partition("-")[0] for a in actions] == [a.name.partition("-")[0] for a in solution.plan]
    task, start = workspace.task, {name: place.pose for name, place in workspace.start.items()}
    run = execute(task, Plan(task.name, task.robot, 0, start, load_robot("panda").home, {}, actions))
    assert run.status == "done"
    for name, region in (("potato", HOB), ("mug", BASIN)):
        x, y, _ = run.final_poses[name].xyz
        assert abs(x - region.center[0]) < region.size[0] / 2
        assert abs(y - region.center[1]) < region.size[1] / 2
