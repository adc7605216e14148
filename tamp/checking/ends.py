"""Checks of a plan's two ends: does it start from the task's scene, and does it reach the task's goals?"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.replay import Replay, in_region
from tamp.checking.scene import Scene, State
from tamp.checking.standing import carriers, overlaps, touched, unrest
from tamp.checking.transforms import inverse
from tamp.task.model import At, In, On

if TYPE_CHECKING:
    from collections.abc import Mapping

    from tamp.checking.tolerances import Tolerances
    from tamp.task.pose import Pose


def check_start(replay: Replay, exact: Mapping[str, Pose] | None) -> None:
    """The plan starts from the scene as it is known, or else from the task's scene after settling.

    A task's scene that is at rest as it is written stays there; one that is not may fall further. An observed scene is
    the truth, whatever it looks like; a settled one has nothing in the air and nothing inside anything else.

    Args:
        replay: a replay before its first action.
        exact: the poses that the scene is known to have, or None where only the task is known.
    """
    scene, state, allow = replay.scene, replay.state, replay.allow
    written = {thing.name: thing.pose for thing in scene.task.objects} if exact is None else exact
    bound = allow.reached if exact is not None else _settling(scene, written, allow)
    for name in sorted(written):
        drift = scene.displacement(name, written[name].matrix, state.poses[name])
        if drift > bound:
            replay.report("start", f"{name} starts {1000 * drift:.0f} mm from where it stands", (name,), drift)
        if exact is not None:
            continue
        if not touched(scene, state, name, allow):
            replay.report("start", f"{name} starts in the air", (name,))
        for sentence, bodies, depth in overlaps(scene, state, name, allow):
            replay.report("start", f"at the start {sentence}", bodies, depth)


def _settling(scene: Scene, written: Mapping[str, Pose], allow: Tolerances) -> float:
    """How far objects may be from a scene as it is written: far only where that scene cannot stay as it is."""
    poses = {name: pose.matrix for name, pose in written.items()}
    state = State(poses, np.array(scene.links.tree.spec.home))
    resting = not any(True for name in sorted(poses) for _ in unrest(scene, state, name, allow))
    return allow.settling if resting else allow.falling


def check_goals(replay: Replay, settled: Mapping[str, Pose] | None) -> None:
    """Every goal of the task holds at the end of the plan.

    Args:
        replay: a replay after its last action.
        settled: where goal poses are known to settle, or None where only the task is known.
    """
    state = replay.state
    if state.held is not None:
        replay.report("goal", f"the plan ends with {state.held.object} still in the hand", (state.held.object,))
    for thing in replay.scene.task.objects:
        if isinstance(thing.goal, At):
            _check_at(replay, thing.name, thing.goal.pose, settled)
        elif thing.goal is not None:
            _check_relation(replay, thing.name, thing.goal)


def _check_at(replay: Replay, name: str, goal: Pose, settled: Mapping[str, Pose] | None) -> None:
    scene, allow = replay.scene, replay.allow
    meant = replay.plan.goals.get(name)
    if meant is None:
        replay.report("goal", f"the plan names no pose for the goal of {name}", (name,))
        return
    known = goal if settled is None else settled[name]
    bound = allow.settling if settled is None else allow.reached
    astray = scene.displacement(name, meant.matrix, known.matrix)
    if astray > bound:
        sentence = f"the plan's goal of {name} is {1000 * astray:.0f} mm from the task's"
        replay.report("goal", sentence, (name,), astray)
    missed = scene.displacement(name, replay.state.poses[name], meant.matrix)
    if missed > allow.reached:
        replay.report("goal", f"{name} ends {1000 * missed:.0f} mm from its goal", (name,), missed)


def _check_relation(replay: Replay, name: str, goal: On | In) -> None:
    scene, state = replay.scene, replay.state
    regions = {region.name: region for region in scene.task.regions}
    if goal.target in regions:
        holds = in_region(scene, state, name, regions[goal.target])
    elif isinstance(goal, On):
        holds = goal.target in carriers(scene, state, name, replay.allow).bodies
    else:
        holds = _contains(scene, state, goal.target, name)
    if not holds:
        relation = "in" if isinstance(goal, In) else "on"
        replay.report("goal", f"{name} does not end {relation} {goal.target}", (name, goal.target))


def _contains(scene: Scene, state: State, container: str, name: str) -> bool:
    """Whether the centre of an object's box lies in the box of another."""
    inner, outer = scene.solids[name], scene.solids[container]
    center = np.append((inner.lower + inner.upper) / 2, 1.0)
    local = (inverse(state.poses[container]) @ state.poses[name] @ center)[:3]
    return bool(((local >= outer.lower) & (local <= outer.upper)).all())
