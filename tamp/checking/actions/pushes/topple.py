"""Check of a topple: the hand pushes an object over one of its edges until it falls over by itself.

A push at some height turns an object about the edge ahead while the friction under it bears that push: the weight
times its lever about the edge, over that height (Lynch, IEEE International Conference on Robotics and Automation 1999).
Until its centre of mass is over the edge the object leans back on the hand, and goes no faster.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.actions.arm_motion import check_move
from tamp.checking.actions.closing_pads import note_turned_over
from tamp.checking.actions.deviations import check_attachment, check_strayed
from tamp.checking.actions.left_standing import check_uncovered
from tamp.checking.actions.pushes.push import aslant, check_force, founded, touched_behind, unfollowed, watch
from tamp.checking.geometry.transforms import inverse
from tamp.checking.physics.support import carriers
from tamp.checking.robot.sweep import Mover
from tamp.checking.scene import GRAVITY, TABLE, Scene, State

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from tamp.checking.actions.arm_motion import Report
    from tamp.checking.tolerances import Tolerances
    from tamp.task.plan import Attachment, Move

    Array = NDArray[np.float64]

LEAST = 0.02  # a smaller turn is none [rad]


def check_topple(scene: Scene, state: State, move: Move, pushed: Attachment, allow: Tolerances, report: Report) -> None:
    """Judge a motion that pushes an object over; afterwards it stands on the edge where the hand has left it."""
    name, move = pushed.object, founded(move, pushed.object, (TABLE,))
    if unfollowed(scene, state, move, allow, report):
        return
    under = carriers(scene, state, name, allow).bodies
    if under != (TABLE,):
        report("push", f"{name} stands on {', '.join(under) or 'nothing'}, not on the table alone", bodies=(name,))
    seen = watch(scene, move, pushed, allow, report)
    if seen is None:
        return
    swing, path = float(seen.swing.max()), seen.bodies[-1].T
    start = inverse(scene.links.tree.tool(move.trajectory.positions[:1])[0]) @ state.poses[name]
    check_attachment(scene, name, start, pushed.T_tool_object.matrix, allow, report)
    check_strayed(scene, state, name, state.poses[name], path[0], allow, report)
    check_uncovered(scene, state, name, allow, report)
    note_turned_over(scene, state, name, state.stayed.get(name, state.poses[name]), path[0], path[-1])
    check_force(scene, move, name, seen, _push_over(scene, move, name, path, allow), allow.push, allow, report)
    for sentence in (*_astray(scene, name, path, swing, allow), *_loose(scene, state, move, name, path, allow)):
        report("push", sentence, bodies=(name,))
    lies = state.stayed.get(name)
    turning = None if lies is None else Mover(scene.solids[name], lies @ inverse(path[-1]) @ path, astray=True)
    check_move(scene, state, move, allow, report, seen, turning)
    state.poses[name] = path[-1]


def _astray(scene: Scene, name: str, path: Array, swing: float, allow: Tolerances) -> Iterator[str]:
    """Why poses (n, 4, 4) are not those of an object that turns over an edge that stays where it is on the table.

    Between two of them no point of it leaves the straight line by more than `swing` [m].
    """
    turns = _turns(path)
    angle = float(np.linalg.norm(turns.sum(axis=0)))
    if angle < LEAST:
        yield f"{name} is said to be pushed over, but it does not turn"
        return
    axis = turns.sum(axis=0) / angle
    sideways = float(np.linalg.norm(turns - np.outer(turns @ axis, axis), axis=1).sum())
    turned = np.cumsum(turns @ axis)
    back = float((np.maximum.accumulate(turned) - turned).max())
    if abs(axis[2]) > np.sin(allow.level) or max(sideways, back) > allow.grasp_angle:
        yield f"{name} is not turned over one edge alone, the same way all the time"
    corners = _corners(scene, name, path)
    off = np.abs(corners[..., 2].min(axis=1) - scene.T_world_table[2, 3] - scene.task.table.thickness / 2).max() + swing
    if off > allow.standing:
        yield f"{name} is {1000 * off:.1f} mm above or below the table while it is pushed over"
    slid = _slid(corners) + swing
    if slid > allow.grasp:
        yield f"the edge that {name} is pushed over slides by {1000 * slid:.1f} mm"


def _turns(path: Array) -> Array:
    """How a body turns from each of its poses, shape (n, 4, 4), to the next: axis times sine, shape (n - 1, 3)."""
    R = path[1:, :3, :3] @ path[:-1, :3, :3].transpose(0, 2, 1)
    skew: Array = np.stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], axis=1) / 2
    return skew


def _slid(corners: Array) -> float:
    """How far corners (n, m, 3) of a body are aside at most, in all, that are the lowest one after the other [m]."""
    rows = np.arange(len(corners) - 1)
    lowest = corners[:-1, :, 2].argmin(axis=1)
    aside = corners[rows + 1, lowest, :2] - corners[rows, lowest, :2]
    return float(np.linalg.norm(np.cumsum(aside, axis=0), axis=1).max())


def _loose(scene: Scene, state: State, move: Move, name: str, path: Array, allow: Tolerances) -> Iterator[str]:
    """Why a push would not turn an object about its edge ahead, and let it fall over in the end."""
    ahead = _ahead(path)
    across = np.array([-ahead[1], ahead[0], 0.0])
    corners = _corners(scene, name, path)
    edges = [corner[corner[:, 2] < corner[:, 2].min() + allow.standing] for corner in corners[[0, -1]]]
    center = scene.center_of_mass(name, path[0])
    touching = touched_behind(scene, move, name, path[0], ahead, allow.push, allow)
    if not len(touching.points):
        yield f"no finger touches {name} on the side away from where it is pushed over"
        return
    yield from aslant(scene, name, touching, ahead)
    lever = float((edges[0] @ ahead).max() - center @ ahead)
    height = float(touching.points[:, 2].min() - corners[0, :, 2].min())
    if lever > scene.friction(name) * scene.friction(TABLE) * height:
        yield f"{name} would slide before it tips: it is pushed {1000 * height:.0f} mm above the table"
    pressed, carried = touching.points @ across, edges[1] @ across
    if pressed.min() > carried.max() or pressed.max() < carried.min():
        yield f"{name} would turn away: the finger presses beside the edge that it shall turn about"
    beyond = scene.center_of_mass(name, path[-1]) @ ahead - (edges[1] @ ahead).max()
    if not allow.balance + state.aside(name) < beyond < allow.beyond:
        yield f"{name} is left with its centre of mass {1000 * beyond:.0f} mm beyond the edge that it shall fall over"


def _push_over(scene: Scene, move: Move, name: str, path: Array, allow: Tolerances) -> Array:
    """The level force that begins to turn an object over its edge ahead where the fingers touch it, shape (3,) [N]."""
    ahead = _ahead(path)
    touching = touched_behind(scene, move, name, path[0], ahead, allow.push, allow).points
    corners = _corners(scene, name, path[:1])[0]
    low = corners[:, 2].min()
    lever = float((corners[corners[:, 2] < low + allow.standing] @ ahead).max())
    lever -= float(scene.center_of_mass(name, path[0]) @ ahead)
    height = float(touching[:, 2].max(initial=low)) - low
    weight = GRAVITY * scene.task.object(name).mass
    push: Array = ahead * weight * max(lever, 0.0) / max(height, 1e-3)
    return push


def _ahead(path: Array) -> Array:
    """The level unit vector towards which a body turns over, shape (3,)."""
    across = _turns(path).sum(axis=0) * (1.0, 1.0, 0.0)
    across /= max(float(np.linalg.norm(across)), 1e-12)
    return np.array([across[1], -across[0], 0.0])


def _corners(scene: Scene, name: str, path: Array) -> Array:
    """Where the corners of a body's hull are at poses (n, 4, 4), shape (n, m, 3)."""
    vertices = scene.solids[name].hull.part.vertices
    corners: Array = vertices @ path[:, :3, :3].transpose(0, 2, 1) + path[:, None, :3, 3]
    return corners
