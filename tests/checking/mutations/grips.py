"""Corruptions of grips and of what the hand holds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from tamp.checking.robot.kinematics import read_kinematics
from tamp.checking.scene import Scene
from tamp.task import At, Attachment, Box, Grip, Gripper, Inertia, Move, Object, Plan, Pose, Release, Task, load_robot
from tamp.task.robot import PAD_FRICTION
from tests.checking.mutations.editing import (
    Pair,
    added,
    changed,
    choose,
    put,
    recentred,
    shifted,
    sideways,
    stand,
    step_at,
    steps_of,
)
from tests.checking.mutations.motions import bumped


def regrip(task: Task, plan: Plan, where: tuple[int, int], attachment: Attachment, width: float) -> Plan:
    """The plan with another grip and the same hold in the motions that follow, up to the release."""
    plan = put(plan, where, Grip(attachment, width))
    for other in steps_of(plan, Move):
        if other > where and (move := step_at(plan, other)).held is not None:
            plan = put(plan, other, replace(move, held=attachment))
        elif other > where:
            break
    return plan


def grasp_beside(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The object is elsewhere in the hand than where it stands."""
    where = choose(steps_of(plan, Grip), rng)
    if where is None:
        return None
    grip = step_at(plan, where)
    T = shifted(grip.attachment.T_tool_object, sideways(rng, 0.005, 0.05))
    return task, regrip(task, plan, where, replace(grip.attachment, T_tool_object=T), grip.width)


def grasp_air(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The object stands beside the place where the fingers close; task and plan agree on that."""
    where = choose(steps_of(plan, Grip), rng)
    if where is None:
        return None
    name = step_at(plan, where).attachment.object
    if any(step_at(plan, w).attachment.object == name for w in steps_of(plan, Grip) if w < where):
        return None
    pose = shifted(plan.start[name], sideways(rng, 0.1, 0.2))
    return stand(task, plan, name, pose)


def wrong_width(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    where = choose(steps_of(plan, Grip), rng)
    if where is None:
        return None
    grip = step_at(plan, where)
    by = rng.uniform(0.01, 0.03) * (1 if grip.width < 0.04 else -1)
    return task, put(plan, where, replace(grip, width=grip.width + by))


def wrong_object(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    where = choose(steps_of(plan, Grip), rng)
    if where is None or len(task.objects) < 2:
        return None
    grip = step_at(plan, where)
    name = choose([o.name for o in task.objects if o.name != grip.attachment.object], rng)
    return task, regrip(task, plan, where, replace(grip.attachment, object=name), grip.width)


def keep_holding(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The fingers never open."""
    where = choose(steps_of(plan, Release), rng)
    return None if where is None else (task, put(plan, where))


def never_grip(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    where = choose(steps_of(plan, Grip), rng)
    return None if where is None else (task, put(plan, where))


def slip_in_hand(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The held object jumps within the hand between two motions."""
    where = choose(steps_of(plan, Move, "transfer", "lower"), rng)
    if where is None:
        return None
    move = step_at(plan, where)
    T = shifted(move.held.T_tool_object, rng.normal(size=3) * 0.01)
    return task, put(plan, where, replace(move, held=replace(move.held, T_tool_object=T)))


def swings_down(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The centre of mass of what is lifted is far beside the line between the pads."""
    where = choose(steps_of(plan, Grip), rng)
    if where is None:
        return None
    grip, gripper, holds = _held(task, plan, where)
    mass = rng.uniform(0.5, 0.9) * holds / 9.81
    beside = rng.uniform(1.5, 3.0) * np.hypot(*gripper.pad[1:]) / 2 * holds / (mass * 9.81)
    away = np.cross(gripper.axis, (0.0, 0.0, rng.choice([-1.0, 1.0]))) * beside
    return _with_center(task, grip, mass, away), plan


def pries_open(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The centre of mass of what is lifted is far to the side to which a finger closes."""
    where = choose(steps_of(plan, Grip), rng)
    if where is None:
        return None
    grip, gripper, holds = _held(task, plan, where)
    mass = rng.uniform(0.4, 0.7) * holds / 9.81
    resists = gripper.force * 0.05 + holds / 2 * gripper.stroke
    away = np.array(gripper.axis) * rng.choice([-1.0, 1.0]) * rng.uniform(1.5, 2.5) * resists / (mass * 9.81)
    return _with_center(task, grip, mass, away), plan


def _held(task: Task, plan: Plan, where: tuple[int, int]) -> tuple[Grip, Gripper, float]:
    """A grip, its gripper, and what friction holds in it at most [N]."""
    grip, gripper = step_at(plan, where), load_robot(task.robot).gripper
    return grip, gripper, 2 * PAD_FRICTION * task.object(grip.attachment.object).friction * gripper.force


def _with_center(task: Task, grip: Grip, mass: float, away: np.ndarray) -> Task:
    """The task whose gripped object is so heavy [kg], its centre of mass `away` in the tool frame, shape (3,) [m]."""
    center = grip.attachment.T_tool_object.inverse() @ Pose(tuple(away))
    return changed(task, grip.attachment.object, mass=mass, inertia=Inertia(Pose(center.xyz), (1e-3, 1e-3, 1e-3)))


def swings_on_the_way(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The centre of mass hangs far below the pads as they close; on its way the hand leans too much for that."""
    where = choose(steps_of(plan, Grip), rng)
    carrying = [w for w in steps_of(plan, Move, "transfer") if where is not None and w > where]
    if where is None or not carrying:
        return None
    grip, spec = step_at(plan, where), load_robot(task.robot)
    thing, tree, move = task.object(grip.attachment.object), read_kinematics(spec), step_at(plan, carrying[0])
    led = bumped(move.trajectory, np.eye(len(spec.joints))[-2] * rng.uniform(0.5, 0.8))
    led = replace(led, times=1.6 * led.times, velocities=led.velocities / 1.6)
    before = max(w for w in steps_of(plan, Move) if w < where)
    down = tree.tool(step_at(plan, before).trajectory.positions[-1:])[0, :3, :3].T @ (0.0, 0.0, -1.0)
    tools = tree.tool(led.positions)[:, :3, :3]
    turned = float(np.abs(np.cross(tools @ np.array(spec.gripper.axis), tools @ down)[:, 2]).max())
    holds = PAD_FRICTION * thing.friction * spec.gripper.force
    mass = rng.uniform(0.3, 0.6) * 2 * holds / 9.81
    below = rng.uniform(1.5, 2.0) * holds * float(np.hypot(*spec.gripper.pad[1:])) / (mass * 9.81 * turned)
    center = grip.attachment.T_tool_object.inverse() @ Pose(tuple(below * down))
    heavy = changed(task, thing.name, mass=mass, inertia=Inertia(Pose(center.xyz), (1e-3, 1e-3, 1e-3)))
    return heavy, put(plan, carrying[0], replace(move, trajectory=led))


def spins_on_the_way(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The hand is turned back and forth about its closing axis, and what it holds is as bulky as a long dumbbell."""
    where = choose(steps_of(plan, Grip), rng)
    carrying = [w for w in steps_of(plan, Move, "transfer") if where is not None and w > where]
    if where is None or not carrying:
        return None
    grip, gripper, holds = _held(task, plan, where)
    thing, tree, move = task.object(grip.attachment.object), read_kinematics(load_robot(task.robot)), carrying[0]
    if thing.inertia is not None:
        return None
    led = bumped(step_at(plan, move).trajectory, np.eye(len(tree.spec.joints))[-2] * rng.uniform(0.5, 0.8))
    led = replace(led, times=1.6 * led.times, velocities=led.velocities / 1.6)
    times = np.linspace(0.0, led.duration, 200)
    tools = tree.tool(CubicHermiteSpline(led.times, led.positions, led.velocities)(times))[:, :3, :3]
    turns = tools[1:] @ tools[:-1].transpose(0, 2, 1)
    rates = np.stack(
        [turns[:, 2, 1] - turns[:, 1, 2], turns[:, 0, 2] - turns[:, 2, 0], turns[:, 1, 0] - turns[:, 0, 1]]
    )
    speeds = (rates.T * (tools[1:] @ gripper.axis)).sum(axis=1) / 2 / times[1]
    fastest = np.abs(np.diff(speeds)).max() / times[1]
    moment = rng.uniform(3.0, 5.0) * holds / 2 * float(np.hypot(*gripper.pad[1:])) / fastest
    center = tuple(Scene.of(task).center_of_mass(thing.name, np.eye(4)))
    bulky = changed(task, thing.name, inertia=Inertia(Pose(center), (moment, moment, moment)))
    return bulky, put(plan, move, replace(step_at(plan, move), trajectory=led))


def cut_between_pads(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """What the pads close on is two objects side by side, of which the plan takes one."""
    where = choose(steps_of(plan, Grip), rng)
    if where is None or not isinstance(task.object(step_at(plan, where).attachment.object).shape, Box):
        return None
    T = step_at(plan, where).attachment.T_tool_object.matrix
    along = np.cross(load_robot(task.robot).gripper.axis, (0.0, 0.0, 1.0)) @ T[:3, :3]
    axis = int(np.abs(along).argmax())
    thing = task.object(step_at(plan, where).attachment.object)
    half, cut = thing.shape.size[axis] / 2, float(-T[:3, 3] @ T[:3, axis]) + rng.uniform(-0.003, 0.003)
    if abs(along[axis]) < 0.999 or abs(cut) > half - 0.004:
        return None
    ways = [np.eye(3)[axis] * (side * half + cut) / 2 for side in (-1.0, 1.0)]
    sizes = [np.array(thing.shape.size) for _ in ways]
    for size, side in zip(sizes, (-1.0, 1.0), strict=True):
        size[axis] = half - side * cut - 0.0005
    first, second = (Pose(tuple(way)) for way in ways)
    goal = At(thing.goal.pose @ first) if isinstance(thing.goal, At) else thing.goal
    kept = replace(thing, shape=Box(tuple(sizes[0])), pose=thing.pose @ first, goal=goal)
    left = Object(f"{thing.name} cut", Box(tuple(sizes[1])), thing.pose @ second, friction=thing.friction)
    start = {left.name: plan.start[thing.name] @ second}
    cut = recentred(plan, kept.name, first)
    return _cut(task, kept, left), replace(cut, start={**cut.start, **start})


def turned_flush(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """A box lies askew between the pads, is long, and something narrow stands where its end comes to as they close."""
    where = choose(steps_of(plan, Grip), rng)
    grip = None if where is None else step_at(plan, where)
    name = "" if grip is None else grip.attachment.object
    if grip is None or [step_at(plan, w).attachment.object for w in steps_of(plan, Grip)].count(name) > 1:
        return None
    thing, gripper, T = task.object(name), load_robot(task.robot).gripper, grip.attachment.T_tool_object
    beside = np.cross(gripper.axis, (0.0, 0.0, 1.0))
    axis, across = (int(np.abs(way @ T.matrix[:3, :3]).argmax()) for way in (beside, np.array(gripper.axis)))
    up = plan.start[name].matrix[2, :3]
    level = abs(up[axis]) < 0.01 and abs(up[across]) < 0.01
    if not isinstance(thing.shape, Box) or not level:
        return None
    turn, side = rng.uniform(0.07, 0.1) * rng.choice([-1.0, 1.0]), rng.choice([-1.0, 1.0])
    by = T.inverse() @ Pose.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, turn)) @ T
    size = np.array(thing.shape.size)
    size[axis] = rng.uniform(0.18, 0.22)
    end = np.array(T.inverse().matrix[:3, 3])
    end[axis] = side * (size[axis] / 2 - 0.01)
    swings = by.inverse().matrix[:3, :3] @ (end - T.inverse().xyz) + T.inverse().xyz - end
    end[across] = np.sign(swings[across]) * (size[across] / 2 + 0.003)
    high = 1.5 * size[3 - axis - across]
    goal = At(thing.goal.pose @ by) if isinstance(thing.goal, At) else thing.goal
    slippery = min(thing.friction, 0.012 / size[across])  # so that nothing keeps it askew
    longer = changed(task, name, shape=Box(tuple(size)), pose=thing.pose @ by, goal=goal, friction=slippery)
    stood = (plan.start[name] @ by).matrix @ np.append(end, 1.0)
    yaw = np.arctan2(*(plan.start[name] @ by).matrix[[1, 0], axis])
    narrow = Object("narrow", Box((0.01, 0.004, high)), Pose.from_rpy((*stood[:2], high / 2), (0.0, 0.0, yaw)))
    return added(longer, recentred(plan, name, by), narrow)


def _cut(task: Task, kept: Object, left: Object) -> Task:
    return replace(task, objects=(*(kept if o.name == kept.name else o for o in task.objects), left))
