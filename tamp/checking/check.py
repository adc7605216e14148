"""The checker's front door."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tamp.checking.ends import check_goals, check_start
from tamp.checking.replay import Replay, sorted_by_time
from tamp.checking.scene import Scene
from tamp.checking.tolerances import DEFAULT, Tolerances
from tamp.checking.verdict import Verdict
from tamp.errors import PlanError
from tamp.task.robot import load_robot

if TYPE_CHECKING:
    from collections.abc import Mapping

    from tamp.task.model import Task
    from tamp.task.plan import Plan
    from tamp.task.pose import Pose


def check(
    task: Task,
    plan: Plan,
    *,
    start: Mapping[str, Pose] | None = None,
    goals: Mapping[str, Pose] | None = None,
    allow: Tolerances = DEFAULT,
) -> Verdict:
    """Judge a plan from the task and the plan alone.

    It replays every step from the plan's start state and holds it against the robot's limits, geometry and statics; it
    shares no collision code with the planner. Bodies are the unions of convex parts that tamp.task.mesh reads, links
    the convex hulls of the URDF's collision meshes; distances are python-fcl's.

    Args:
        task: what is to be done.
        plan: how.
        start: where the objects are known to stand (world frame). Without it the plan's start may differ from the
            task's by what settling explains.
        goals: the poses that goals given as poses are known to settle to. Without it the plan's may differ from the
            task's by what settling explains.
        allow: tolerances.

    Raises:
        PlanError: where the plan is for another task or robot.
        TaskError, RobotError: where a mesh or the robot cannot be used.
    """
    if plan.task != task.name or plan.robot != task.robot:
        raise PlanError(
            f"the plan is for task {plan.task!r} and robot {plan.robot!r}, not for {task.name!r} and {task.robot!r}"
        )
    joints = len(load_robot(task.robot).joints)
    if len(plan.home) != joints:
        raise PlanError(f"the plan's home has {len(plan.home)} values for the {joints} joints of robot {task.robot!r}")
    names = {thing.name for thing in task.objects}
    for mapping, title in ((plan.start, "the plan's start"), (start, "start")):
        if mapping is not None and set(mapping) != names:
            wrong = ", ".join(sorted(set(mapping) ^ names))
            raise PlanError(f"{title} does not give one pose for each object of task {task.name!r}: see {wrong}")
    replay = Replay(Scene.of(task), plan, allow)
    check_start(replay, start)
    replay.run()
    check_goals(replay, goals)
    return Verdict(sorted_by_time(replay.problems))
