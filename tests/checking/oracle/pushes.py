"""What is clearly wrong with an object that is pushed along the table."""

from __future__ import annotations

import numpy as np

from tamp.task import Box, Cylinder, Move
from tamp.task.model import TABLE_FRICTION
from tests.checking.oracle.bodies import links_along, meets, robot, tool_at
from tests.checking.oracle.world import World, rests, strains

REACH = 0.01  # a finger farther than this from an object does not push it [m]
LIFTED = 0.01  # [m]
ROLLS = 0.5  # share of a can's axis that is upright, or along the push, below which it rolls away
SLIPS = 0.7  # share of the friction that would just hold fingers on a flank
EVERY = 0.01  # between two looks at how fast it gets faster [s]
TIPS = 1.2  # so many times what resists a tip backwards is too much
MARGIN = 2.0  # no edge of it is so many radii ahead of its middle


def push(world: World, move: Move) -> str | None:
    """The object goes where the hand takes it; why it does not, or None."""
    if move.pushed is None:
        return None
    name, T_tool_object = move.pushed.object, move.pushed.T_tool_object.matrix
    before, q = world.poses[name], move.trajectory.positions
    claimed = tool_at(q[0]) @ T_tool_object
    if np.linalg.norm(claimed[:3, 3] - before[:3, 3]) > 0.006:
        return f"{name} is not where the push begins"
    riders = [other for other in world.others(name, "table") if rests(world, other) is None]
    fingers, ahead = fingers_at(world, move, name), tool_at(q[-1]) @ T_tool_object
    if not fingers:
        return f"no finger is at {name}"
    if abs(ahead[2, 3] - before[2, 3]) > LIFTED:
        return f"{name} leaves the table"
    height = _lowest(world, move, fingers) - _bottom(world, name)
    if world.task.object(name).friction * height > MARGIN * world.bodies[name].radius:
        return f"{name} tips over"
    if _tips_ahead(world, move, name, height):
        return f"{name} tips over the edge ahead"
    if _tips_back(world, move, name, fingers):
        return f"{name} tips over backwards"
    shape, way = world.task.object(name).shape, (ahead - before)[:3, 3]
    if isinstance(shape, Cylinder) and max(abs(before[:3, 2] @ way) / np.linalg.norm(way), abs(before[2, 2])) < ROLLS:
        return f"{name} rolls away"
    if isinstance(shape, Box) and world.task.object(name).friction < SLIPS * _aslant(before, way):
        return f"the fingers slip along {name}"
    tip = tool_at(q[0])
    sticks = 9.81 * world.task.object(name).mass * world.task.object(name).friction * TABLE_FRICTION
    if strains(q[0], np.linalg.inv(tip) @ _at(tip, height + _bottom(world, name)), sticks * way / np.linalg.norm(way)):
        return f"the arm cannot push {name}"
    world.poses[name] = ahead
    return rests(world, name) or next((text for o in riders if (text := rests(world, o)) is not None), None)


def _tips_ahead(world: World, move: Move, name: str, height: float) -> bool:
    """Whether friction takes what carries a box's weight beyond the outline of its base, on a level table."""
    thing, T = world.task.object(name), world.poses[name]
    if not isinstance(thing.shape, Box) or thing.inertia is None:
        return False
    half, local = np.array(thing.shape.size) / 2, T[:3, :3].T
    up = np.abs(local[:, 2]).argmax()
    way = local @ (tool_at(move.trajectory.positions[-1]) - tool_at(move.trajectory.positions[0]))[:3, 3]
    center, share = np.array(thing.inertia.frame.xyz), thing.friction * TABLE_FRICTION * height
    place = center + share / TIPS * way / np.linalg.norm(way)
    return bool(np.delete(np.abs(place) > half, up).any())


def _tips_back(world: World, move: Move, name: str, fingers: list[str]) -> bool:
    """Whether a centre of mass high above all of the fingers stays behind as these speed the object up."""
    from scipy.interpolate import CubicHermiteSpline

    thing, t = world.task.object(name), move.trajectory
    if thing.inertia is None:
        return False
    curve = CubicHermiteSpline(t.times, t.positions, t.velocities)
    path = np.array([tool_at(q) @ move.pushed.T_tool_object.matrix for q in curve(np.arange(0.0, t.times[-1], EVERY))])
    way = path[-1, :3, 3] - path[0, :3, 3]
    way /= max(np.linalg.norm(way), 1e-9)
    speeding = float(np.diff(path[:, :3, 3] @ way, n=2).max(initial=0.0)) / EVERY**2
    points = world.bodies[name].points @ path[0, :3, :3].T + path[0, :3, 3]
    center = path[0, :3, :3] @ thing.inertia.frame.xyz + path[0, :3, 3]
    placed, _ = links_along(t.positions[:1], move.opening)
    tops = [float((robot()[2][f].points @ placed[f][0][2, :3] + placed[f][0][2, 3]).max()) for f in fingers]
    pressed = min(max(tops), float(points[:, 2].max()))
    behind = float(center @ way - (points @ way).min())
    resists = behind + thing.friction * TABLE_FRICTION * (pressed - float(points[:, 2].min()))
    return bool((center[2] - pressed) * speeding / 9.81 > TIPS * resists)


def _aslant(T: np.ndarray, way: np.ndarray) -> float:
    """The tangent of the angle between a way, shape (3,), and the normal of the face of a box at T that looks back."""
    across = np.sort(np.abs(way @ T[:3, :3]))
    return float(across[1] / across[2])


def _at(tool: np.ndarray, height: float) -> np.ndarray:
    """The place straight under, or over, the tool's point at a height [m]."""
    place = tool.copy()
    place[2, 3] = height
    return place


def _lowest(world: World, move: Move, fingers: list[str]) -> float:
    placed, _ = links_along(move.trajectory.positions[:1], move.opening)
    return min(float((robot()[2][f].points @ placed[f][0][2, :3] + placed[f][0][2, 3]).min()) for f in fingers)


def _bottom(world: World, name: str) -> float:
    T = world.poses[name]
    return float((world.bodies[name].points @ T[2, :3] + T[2, 3]).min())


def fingers_at(world: World, move: Move, name: str) -> list[str]:
    """The fingers that are at an object as a push begins: moved a little ahead they would be in it."""
    tool = [tool_at(q) for q in move.trajectory.positions[[0, -1]]]
    way = tool[1][:3, 3] - tool[0][:3, 3]
    placed, _ = links_along(move.trajectory.positions[:1], move.opening)
    shift = np.eye(4)
    shift[:3, 3] = REACH * way / max(np.linalg.norm(way), 1e-9)
    body, T = world.bodies[name], world.poses[name]
    return [f for f in robot()[0].gripper.fingers if meets(robot()[2][f], shift @ placed[f], body, T, 0.0)]
