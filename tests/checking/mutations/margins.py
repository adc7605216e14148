"""Corruptions that a careless judge calls tolerable: a little aside, a little too wide, turned, or heavy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tamp.task import Attachment, Grip, Move, Plan, Pose, Release, Task, load_robot
from tamp.task.robot import PAD_FRICTION
from tests.checking.mutations.editing import (
    Pair,
    changed,
    choose,
    put,
    put_action,
    shifted,
    sideways,
    step_at,
    steps_of,
)

TURN = 0.018  # [rad]


def start_a_little_aside(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """What stands flat on the table, and nobody touches, is said to start a centimetre from where it is written."""
    moved = {action.arguments[0] for action in plan.actions if action.arguments}
    named = {name for action in plan.actions for name in action.arguments}
    name = choose([o.name for o in task.objects if o.name not in moved | named], rng)
    if name is None:
        return None
    return task, replace(plan, start={**plan.start, name: shifted(plan.start[name], sideways(rng, 0.009, 0.014))})


def dropped_aside(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The same where it is written a little above the table: it comes down there, and not a centimetre aside."""
    if (mutant := start_a_little_aside(task, plan, rng)) is None:
        return None
    name = next(name for name, pose in mutant[1].start.items() if pose != plan.start[name])
    up, aside = rng.uniform(0.006, 0.012), sideways(rng, 0.0085, 0.0115)
    task = changed(task, name, pose=shifted(task.object(name).pose, np.array([0.0, 0.0, up])))
    return task, replace(plan, start={**plan.start, name: shifted(plan.start[name], aside)})


def home_on_the_way(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The arm starts elsewhere than at home; the first motion starts from there as well."""
    where = next(iter(steps_of(plan, Move)), None)
    if where is None:
        return None
    move = step_at(plan, where)
    t, by = move.trajectory, np.zeros(len(plan.home))
    by[int(rng.integers(len(by)))] = rng.choice([-1, 1]) * rng.uniform(0.005, 0.05)
    share = t.times / t.duration
    fade, rate = 1 - 10 * share**3 + 15 * share**4 - 6 * share**5, -30 * share**2 * (1 - share) ** 2 / t.duration
    led = replace(t, positions=t.positions + fade[:, None] * by, velocities=t.velocities + rate[:, None] * by)
    return task, replace(put(plan, where, replace(move, trajectory=led)), home=tuple(led.positions[0]))


def pads_stay_off(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The fingers stop before they touch the object, which comes along all the same."""
    where = choose(steps_of(plan, Grip), rng)
    if where is None:
        return None
    grip = step_at(plan, where)
    width = grip.width + rng.uniform(0.0065, 0.0078)
    plan = put(plan, where, replace(grip, width=width))
    for other in steps_of(plan, Move):
        if other > where and (move := step_at(plan, other)).held is not None:
            plan = put(plan, other, replace(move, opening=width))
        elif other > where:
            break
    return task, plan


def hardly_open(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The fingers are said to let go without moving away, and retreat so."""
    where = choose(steps_of(plan, Release), rng)
    if where is None:
        return None
    grip = step_at(plan, max(w for w in steps_of(plan, Grip) if w < where))
    opening = grip.width + 10 ** rng.uniform(-9, -4)
    plan = put(plan, where, replace(step_at(plan, where), opening=opening))
    i, j = where
    action = plan.actions[i]
    left = (replace(step, opening=opening) if isinstance(step, Move) else step for step in action.steps[j + 1 :])
    return task, put_action(plan, i, replace(action, steps=(*action.steps[: j + 1], *left)))


def still_squeezed(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The fingers close farther than the object lets them, and open again to less than it is wide."""
    where = choose(steps_of(plan, Release), rng)
    if where is None:
        return None
    gripped = max(w for w in steps_of(plan, Grip) if w < where)
    wide = step_at(plan, gripped).width
    width, opening = wide - rng.uniform(0.0034, 0.0038), wide - rng.uniform(0.0018, 0.0022)
    if width < 0.0:
        return None
    plan = put(plan, gripped, replace(step_at(plan, gripped), width=width))
    plan = put(plan, where, replace(step_at(plan, where), opening=opening))
    last = len(plan.actions[where[0]].steps)
    for other in [w for w in steps_of(plan, Move) if gripped < w < (where[0], last)]:
        plan = put(plan, other, replace(step_at(plan, other), opening=width if other < where else opening))
    return task, plan


def twist(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """An object turns a degree in the fingers as they close, and another as they open."""
    where = choose(steps_of(plan, Grip), rng)
    if where is None:
        return None
    by = TURN
    grip = step_at(plan, where)
    held = _turned(grip.attachment.T_tool_object, by)
    attachment = Attachment(grip.attachment.object, held)
    plan = put(plan, where, replace(grip, attachment=attachment))
    after = min(w for w in steps_of(plan, Release) if w > where)
    for other in [w for w in steps_of(plan, Move) if where < w < after]:
        if (move := step_at(plan, other)).held is not None:
            plan = put(plan, other, replace(move, held=attachment))
    release = step_at(plan, after)
    return task, put(plan, after, replace(release, pose=_turned(release.pose, 2 * by)))


def _turned(pose: Pose, by: float) -> Pose:
    return pose @ Pose.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, by))


def too_heavy(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """What is lifted weighs more than the fingers' friction carries."""
    where = choose(steps_of(plan, Grip), rng)
    if where is None:
        return None
    name = step_at(plan, where).attachment.object
    mass = rng.uniform(20.0, 100.0)
    return changed(task, name, mass=mass), plan


def too_heavy_for_the_arm(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """Fingers that stick to it carry it easily, the arm's joints do not."""
    where = choose(steps_of(plan, Grip), rng)
    if where is None:
        return None
    name, friction, force = step_at(plan, where).attachment.object, 50.0, load_robot(task.robot).gripper.force
    mass = rng.uniform(0.3, 0.9) * 2 * PAD_FRICTION * friction * force / 9.81
    return changed(task, name, mass=mass, friction=friction), plan


def too_heavy_to_hurry(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """Friction carries what is lifted as long as the arm stands still, and no more."""
    where = choose(steps_of(plan, Grip), rng)
    if where is None:
        return None
    thing = task.object(step_at(plan, where).attachment.object)
    mass = rng.uniform(0.96, 0.99) * 2 * PAD_FRICTION * thing.friction * load_robot(task.robot).gripper.force / 9.81
    return changed(task, thing.name, mass=mass), plan
