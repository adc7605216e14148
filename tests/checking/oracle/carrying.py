"""Does friction carry what the hand holds, as fast as the arm moves?"""

from __future__ import annotations

import numpy as np

from tamp.task import Move
from tests.checking.oracle.bodies import robot, tool_at
from tests.checking.oracle.world import World

EVERY = 0.01  # between two looks [s]
SWINGS = 1.2  # so many times the moment that pads resist which press with their corners alone is too much
FINGER = 0.05  # along which fingers touch what they hold, at most [m]
SLIPS = 1.04  # so many times what friction carries is too much
BULKY = 2e-3  # smaller moments of inertia speed up with the hand [kg m^2]


def jerked_out(world: World, move: Move) -> str | None:
    """Why what is held slips out of the fingers during a motion, or None."""
    from scipy.interpolate import CubicHermiteSpline

    if world.held is None:
        return None
    name, T = world.held
    thing, gripper = world.task.object(name), robot()[0].gripper
    carried = 2 * thing.friction * gripper.force
    middle = world.bodies[name].center if thing.inertia is None else np.array(thing.inertia.frame.xyz)
    lever = T[:3, :3] @ middle + T[:3, 3]
    resists = SWINGS * carried / 2 * np.hypot(*gripper.pad[1:])
    opens = SWINGS * (gripper.force * FINGER + carried / 2 * gripper.stroke)
    light = thing.mass * 9.81 < 0.5 * carried and thing.mass * 9.81 * np.linalg.norm(lever) < resists
    if light and (thing.inertia is None or max(thing.inertia.moments) < BULKY):
        return None
    t = move.trajectory
    curve = CubicHermiteSpline(t.times, t.positions, t.velocities)
    tools = np.array([tool_at(q) for q in curve(np.arange(0.0, t.times[-1], EVERY))])
    if thing.inertia is not None and len(tools) > 2:
        frames = tools[:, :3, :3] @ T[:3, :3] @ thing.inertia.frame.matrix[:3, :3]
        if _spun(frames, np.array(thing.inertia.moments), tools[:, :3, :3] @ gripper.axis) > resists:
            return f"{name} spins in the fingers"
    if light:
        return None
    path = tools[:, :3, 3] + tools[:, :3, :3] @ lever
    turning = thing.mass * 9.81 * np.abs(np.cross(tools[:, :3, :3] @ gripper.axis, tools[:, :3, :3] @ lever)[:, 2])
    if turning.max(initial=0.0) > resists:
        return f"{name} swings down in the fingers"
    weighs = tools[:, :3, :3].transpose(0, 2, 1) @ np.array([0.0, 0.0, thing.mass * 9.81])
    prying = np.cross(np.cross(lever, weighs), gripper.axis)
    if np.linalg.norm(prying, axis=1).max(initial=0.0) > opens:
        return f"{name} pries the fingers open"
    if len(path) < 3:
        return None
    pulls = thing.mass * (np.diff(path, n=2, axis=0) / EVERY**2 + np.array([0.0, 0.0, 9.81]))
    across = np.cross(pulls, tools[1:-1, :3, :3] @ gripper.axis)
    return f"{name} slips out of the fingers" if np.linalg.norm(across, axis=1).max() > SLIPS * carried else None


def _spun(frames: np.ndarray, moments: np.ndarray, axes: np.ndarray) -> float:
    """The largest moment about axes (n, 3) that turns a body as its principal axes (n, 3, 3) turn [N m]."""
    from scipy.spatial.transform import Rotation

    turns = Rotation.from_matrix(frames)
    rates = (turns[1:] * turns[:-1].inv()).as_rotvec() / EVERY
    momenta = turns[1:].apply(moments * turns[1:].inv().apply(rates))
    torques = np.diff(momenta, axis=0) / EVERY
    return float(np.abs((torques * axes[1:-1]).sum(axis=1)).max())
