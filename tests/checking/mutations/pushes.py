"""Corruptions of pushes along the table."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from tamp.checking.robot.kinematics import read_kinematics
from tamp.checking.robot.links import read_links
from tamp.task import At, Box, Cylinder, Inertia, Move, Object, Plan, Pose, Task, load_robot
from tamp.task.mesh.parts import parts
from tests.checking.mutations.editing import (
    Pair,
    added,
    changed,
    choose,
    put,
    recentred,
    shifted,
    sideways,
    step_at,
    steps_of,
)


def push_beside(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The push begins elsewhere than where the object is."""
    where = _push(plan, rng)
    if where is None:
        return None
    move = step_at(plan, where)
    T = shifted(move.pushed.T_tool_object, sideways(rng, 0.008, 0.05))
    return task, put(plan, where, replace(move, pushed=replace(move.pushed, T_tool_object=T)))


def push_nothing(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    where = _push(plan, rng)
    return None if where is None else (task, put(plan, where, replace(step_at(plan, where), pushed=None)))


def push_from_afar(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The object lies where no finger is; task and plan agree on that."""
    where = _push(plan, rng)
    if where is None:
        return None
    move = step_at(plan, where)
    name, by = move.pushed.object, sideways(rng, 0.15, 0.25)
    T = Pose(tuple(by)) @ plan.start[name]
    away = plan.start[name].inverse() @ T
    attached = replace(move.pushed, T_tool_object=move.pushed.T_tool_object @ away)
    moved = put(plan, where, replace(move, pushed=attached))
    return changed(task, name, pose=T), replace(moved, start={**plan.start, name: T})


def push_through(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """Something stands where the object is pushed to."""
    where = _push(plan, rng)
    if where is None:
        return None
    move = step_at(plan, where)
    last = read_kinematics(load_robot(task.robot)).tool(move.trajectory.positions[-1:])[0]
    end = (last @ move.pushed.T_tool_object.matrix)[:3, 3]
    x, y, _ = end + sideways(rng, 0.0, 0.02)
    return added(task, plan, Object("peg", Box((0.03, 0.03, 0.06)), Pose((float(x), float(y), 0.03))))


def push_loaded(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """Something stands on what is pushed."""
    where = _push(plan, rng)
    if where is None:
        return None
    name = step_at(plan, where).pushed.object
    x, y, z = plan.start[name].xyz
    dx, dy, _ = sideways(rng, 0.0, 0.02)
    corners = np.concatenate([part.vertices for part in parts(task.object(name).shape)])
    top = z + float((corners @ plan.start[name].matrix[2, :3]).max())
    return added(task, plan, Object("rider", Box((0.03, 0.03, 0.03)), Pose((x + dx, y + dy, top + 0.015))))


def push_over_the_edge(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The table ends earlier than the plan thinks."""
    if _push(plan, rng) is None:
        return None
    less = rng.uniform(0.1, 0.2)
    length, width = task.table.size
    return replace(task, table=replace(task.table, size=(length - less, width - less))), plan


def push_hastily(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The hand stops as fast as no arm can, and as nothing would that is pushed."""
    where = _push(plan, rng)
    if where is None:
        return None
    move, factor = step_at(plan, where), rng.uniform(6.0, 10.0)
    t = move.trajectory
    faster = replace(t, times=t.times / factor, velocities=t.velocities * factor)
    return task, put(plan, where, replace(move, trajectory=faster))


def push_what_sticks(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """It stands on so much friction that it tips over its edge ahead before it slides."""
    where = _push(plan, rng)
    if where is None:
        return None
    name, friction = step_at(plan, where).pushed.object, rng.uniform(60.0, 200.0)
    return changed(task, name, friction=friction), plan


def push_what_is_heavy(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """No arm slides that much over the table."""
    where = _push(plan, rng)
    if where is None:
        return None
    name, mass = step_at(plan, where).pushed.object, rng.uniform(300.0, 1000.0)
    return changed(task, name, mass=mass), plan


def push_what_rolls(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """It is a can that lies about across the push, its flank where that of a box was."""
    where = _push(plan, rng)
    if where is None or not isinstance(task.object(step_at(plan, where).pushed.object).shape, Box):
        return None
    move = step_at(plan, where)
    thing = task.object(move.pushed.object)
    length, width, height = thing.shape.size
    tool = read_kinematics(load_robot(task.robot)).tool(move.trajectory.positions[[0, -1]])
    x, y, z = (tool[1, :3, 3] - tool[0, :3, 3]) @ (tool[0] @ move.pushed.T_tool_object.matrix)[:3, :3]
    if abs(z) > 0.1 * np.hypot(x, y):
        return None
    ahead = np.array([np.sign(x), 0.0, 0.0] if abs(x) > abs(y) else [0.0, np.sign(y), 0.0])
    radius, reach = height / 2, float(abs(ahead) @ thing.shape.size) / 2
    turn = (np.pi / 2, 0.0, 0.0) if ahead[0] else (0.0, np.pi / 2, 0.0)
    by = Pose.from_rpy(tuple((radius - reach) * ahead), turn)
    can = Cylinder(radius, width if ahead[0] else length)
    goal = At(thing.goal.pose @ by) if isinstance(thing.goal, At) else thing.goal
    rolling = replace(thing, shape=can, pose=thing.pose @ by, goal=goal)
    objects = tuple(rolling if o.name == thing.name else o for o in task.objects)
    return replace(task, objects=objects), recentred(plan, thing.name, by)


def push_what_slips(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """Its flank is pushed so far aslant that the fingers slip along it."""
    where = _push(plan, rng)
    if where is None or not isinstance(task.object(step_at(plan, where).pushed.object).shape, Box):
        return None
    move = step_at(plan, where)
    tool = read_kinematics(load_robot(task.robot)).tool(move.trajectory.positions[[0, -1]])
    way = np.abs((tool[1, :3, 3] - tool[0, :3, 3]) @ (tool[0] @ move.pushed.T_tool_object.matrix)[:3, :3])
    low, middle, high = np.sort(way)
    if middle < 0.08 * high or low > 0.01 * high:
        return None
    return changed(task, move.pushed.object, friction=float(rng.uniform(0.2, 0.6) * middle / high)), plan


def push_tips_backwards(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """Its centre of mass is so high that the hand, which speeds it up near its foot, tips it over backwards."""
    where = _push(plan, rng)
    if where is None:
        return None
    move = step_at(plan, where)
    thing, t = task.object(move.pushed.object), move.trajectory
    times = np.arange(0.0, t.times[-1], 0.01)
    tool = read_kinematics(load_robot(task.robot)).tool(CubicHermiteSpline(t.times, t.positions, t.velocities)(times))
    path = tool @ move.pushed.T_tool_object.matrix
    ahead = (path[-1] - path[0])[:3, 3] / np.linalg.norm((path[-1] - path[0])[:3, 3])
    if len(path) < 4 or abs(ahead[2]) > 0.05:
        return None
    fastest = float(np.diff(path[:, :3, 3] @ ahead, n=2).max()) / 0.01**2
    corners = np.concatenate([part.vertices for part in parts(thing.shape)]) @ path[0, :3, :3].T
    long, high = float(np.ptp(corners @ ahead)), float(np.ptp(corners[:, 2]))
    up = high + rng.uniform(1.5, 2.5) * (long + thing.friction * high) * 9.81 / fastest
    center = path[0, :3, :3].T @ (0.0, 0.0, up)
    spread = Inertia(Pose(tuple(center)), (1e-3, 1e-3, 1e-3))
    return changed(task, thing.name, inertia=spread), plan


def push_tips_aslant(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """Its centre of mass is just behind the edge that a push aslant to that leads over; a corner is far ahead of it."""
    where = _push(plan, rng)
    move = None if where is None else step_at(plan, where)
    if move is None or not isinstance(task.object(move.pushed.object).shape, Box):
        return None
    links, thing = read_links(load_robot(task.robot)), task.object(move.pushed.object)
    path = links.tree.tool(move.trajectory.positions[[0, -1]]) @ move.pushed.T_tool_object.matrix
    way, half = path[0, :3, :3].T @ (path[1] - path[0])[:3, 3], np.array(thing.shape.size) / 2
    way /= np.linalg.norm(way)
    up, aside, ahead = np.argsort(np.abs(way))
    left = float(rng.uniform(0.011, 0.013))
    center = way * (half[ahead] - left) / abs(way[ahead])
    needed = left * float(rng.uniform(1.3, 1.4))  # of what carries its weight, by friction
    corner = left * abs(way[ahead]) + (half[aside] - abs(center[aside])) * abs(way[aside])
    if abs(way[up]) > 0.01 or needed > 0.85 * corner:
        return None
    placed = links.tree.forward(move.trajectory.positions[:1], move.opening)
    fingers = [s.hull.part.vertices @ placed[s.name][0, 2, :3] + placed[s.name][0, 2, 3] for s in links.solids]
    touched = min(float(z.min()) for z, s in zip(fingers, links.solids, strict=True) if s.name in links.gripper)
    touched -= path[0, 2, 3] - half @ np.abs(path[0, 2, :3])
    spread = Inertia(Pose(tuple(center)), (1e-3, 1e-3, 1e-3))
    return changed(task, thing.name, inertia=spread, friction=needed / max(touched, 1e-3)), plan


def _push(plan: Plan, rng: np.random.Generator) -> tuple[int, int] | None:
    """Where a push is, or None."""
    return choose([where for where in steps_of(plan, Move) if step_at(plan, where).pushed is not None], rng)
