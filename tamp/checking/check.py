"""The checker's front door."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.actions.given_way import check_given_way, told_apart
from tamp.checking.actions.left_standing import check_rest
from tamp.checking.actions.tabletop import TABLETOP
from tamp.checking.replay import Replay
from tamp.checking.scene import ROBOT, TABLE, Scene, State
from tamp.checking.start_and_goals import check_continued, check_goals, check_home, check_start, note_stayed
from tamp.checking.tolerances import DEFAULT, Tolerances
from tamp.checking.verdict import Problem, Verdict
from tamp.errors import PartError, PlanError, TampError, TaskError, told
from tamp.task.robots import task_robot
from tamp.task.validate import check_sizes

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from tamp.checking.actions.rule import ActionRule
    from tamp.task.model import SymbolicFact, Task
    from tamp.task.plan import Action, Plan
    from tamp.task.pose import Pose


@np.errstate(over="ignore")  # what is beyond all bounds is infinitely far away
def check(
    task: Task,
    plan: Plan,
    *,
    start: Mapping[str, Pose] | None = None,
    goals: Mapping[str, Pose] | None = None,
    facts: Iterable[SymbolicFact] | None = None,
    rules: Mapping[str, ActionRule] = TABLETOP,
    allow: Tolerances = DEFAULT,
    after: State | None = None,
) -> Verdict:
    """Judge a plan from the task and the plan alone.

    It replays every step from the plan's start state and holds it against the robot's limits, geometry and statics; it
    shares no collision code with the planner. Bodies are the unions of convex parts that tamp.task.mesh.parts reads,
    links the convex hulls of the URDF's collision meshes; distances are python-fcl's.

    Args:
        task: what is to be done.
        plan: how.
        start: where the objects are known to stand (world frame). Without it the plan's start may differ from the
            task's by what settling explains, and the arm starts from the robot's home, its fingers open.
        goals: the poses that goals given as poses are known to settle to. Without it the plan's may differ from the
            task's by what settling explains.
        facts: the symbolic facts that are known to hold at the start. Without it those that the task names.
        rules: action name -> what must hold of such actions; a plan's actions without a rule are refused.
        allow: tolerances.
        after: the state that a check of what comes before has ended with, see `Verdict.state`. Then the plan is judged
            as its continuation, from where that has everything, and `start` and `facts` are not asked: what nothing
            explains goes on adding up, as if both were one plan.

    Raises:
        PlanError: where the plan is for another task or robot.
        TaskError, RobotError: where a shape, a mesh or the robot cannot be used.
        PartError: where a rule raises something.
    """
    _refuse_misfit(task, plan, start)
    scene = Scene.of(task)
    if after is None:
        replay = _begun(scene, plan, start, set(task.init if facts is None else facts), allow)
    else:
        replay = Replay(scene, after.copy(), allow)
        check_continued(replay, plan)
    for index, action in enumerate(plan.actions):
        replay.begin(index, action)
        own, falls = told_apart(action)
        if action.name in rules:
            _ruled(rules[action.name], replay, own)
        else:
            known = ", ".join(sorted(rules))
            replay.report("precondition", f"the checker has no rule for action {action.name!r}; it has: {known}")
        for fall in falls:
            check_given_way(replay, fall)
    replay.begin(None, "goal")
    check_goals(replay, plan, goals)
    problems = tuple(sorted(replay.problems, key=lambda problem: problem.time))
    return Verdict(problems, frozenset(replay.state.facts), replay.state)


def check_left(task: Task, name: str, poses: Mapping[str, Pose], *, allow: Tolerances = DEFAULT) -> tuple[Problem, ...]:
    """What is wrong with an object that is let go at a pose, whoever put it there: it would not stay, or upset others.

    Args:
        task: the shapes.
        name: the object.
        poses: where it is let go, and where all that is there stands (world frame).
        allow: tolerances.
    """
    scene = Scene.of(task)
    spec = scene.links.tree.spec
    q, matrices = np.array(spec.home, dtype=np.float64), {other: poses[other].matrix for other in sorted(poses)}
    replay = Replay(scene, State(matrices, q, spec.gripper.stroke), allow)
    check_rest(scene, replay.state, name, allow, replay.report)
    return tuple(replay.problems)


def _ruled(rule: ActionRule, replay: Replay, action: Action) -> None:
    """Have a rule judge an action; what it raises is a sentence, since rules may be anybody's."""
    try:
        rule.check(replay, action)
    except TampError:
        raise
    except Exception as error:
        raise PartError(f"the checker's rule for {action.name!r}: it raised {told(error)}") from error


def begin(task: Task, start: Mapping[str, Pose], facts: Iterable[SymbolicFact]) -> State:
    """The state before a plan from the task's own scene, settled to `start`, to be continued by pieces of that plan.

    The arm is at home, its fingers open. Whether settling explains the start is not asked here; where objects may stay
    although it says otherwise is noted as `check` notes it, so that pieces that are judged one after the other are
    judged as the whole plan is.
    """
    scene, poses = Scene.of(task), {name: start[name].matrix for name in sorted(start)}
    spec = scene.links.tree.spec
    q, stroke = np.array(spec.home, dtype=np.float64), spec.gripper.stroke
    state = State(poses, q, stroke, facts=set(facts), began=dict(poses))
    note_stayed(scene, state, DEFAULT)
    return state


def _begun(
    scene: Scene, plan: Plan, start: Mapping[str, Pose] | None, facts: set[SymbolicFact], allow: Tolerances
) -> Replay:
    """A plan before its first action, its start judged."""
    poses = {name: plan.start[name].matrix for name in sorted(plan.start)}
    opening = scene.links.tree.spec.gripper.stroke if start is None else None
    q = np.array(plan.home, dtype=np.float64)
    replay = Replay(scene, State(poses, q, opening, facts=facts, began=dict(poses)), allow)
    check_start(replay, start)
    check_home(replay, known=start is not None)
    return replay


def _refuse_misfit(task: Task, plan: Plan, start: Mapping[str, Pose] | None) -> None:
    """Raise where names or numbers of joints do not fit, or sizes are those of nothing: then nothing can be judged."""
    if plan.task != task.name or plan.robot != task.robot:
        raise PlanError(
            f"the plan is for task {plan.task!r} and robot {plan.robot!r}, not for {task.name!r} and {task.robot!r}"
        )
    joints = len(task_robot(task).joints)
    if len(plan.home) != joints:
        raise PlanError(f"the plan's home has {len(plan.home)} values for the {joints} joints of robot {task.robot!r}")
    check_sizes(task)
    named = [*(thing.name for thing in task.objects), *(region.name for region in task.regions)]
    for name in named:
        if name in (TABLE, ROBOT) or named.count(name) > 1:
            raise TaskError(f"task {task.name!r}: {name!r} is reserved or taken; names of objects and regions differ")
    objects = {thing.name for thing in task.objects}
    for mapping, title in ((plan.start, "the plan's start"), (start, "start")):
        if mapping is not None and set(mapping) != objects:
            wrong = ", ".join(sorted(set(mapping) ^ objects))
            raise PlanError(f"{title} does not give one pose for each object of task {task.name!r}: see {wrong}")
