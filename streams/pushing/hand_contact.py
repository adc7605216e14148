"""Where the hand touches what it pushes: behind the object, by its fingertips or its side, with room for it there."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.affordances.friction_cones import pad_cone
from tamp.streams.affordances.slide_path import SIDE, Way, center_from_above, tips_above
from tamp.streams.collisions import ARM_MARGIN
from tamp.streams.hand.finger_closing import felt, felt_surface
from tamp.streams.hand.hand_boxes import finger_reach, hand_boxes
from tamp.streams.values import Placement
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import Pose
from tamp.world.scene import Scene
from tamp.world.transforms import moved

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.world.robot.hand import FreeHand

    Array = NDArray[np.float64]

ABOVE_TABLE = 0.008  # of the fingertips while they push [m]
BELOW_TOP = 0.003  # of the object: the palm stays this far above what the fingers push [m]
TOUCHING = 0.0004  # between the fingers and the object when the push begins [m]
TOUCHED = 0.0015  # of an object, what is so near to a finger touches it as far as samples of its surface tell [m] ...
LEVER = 0.006  # ... at least so far to both sides of the centre of mass [m]
FARTHEST, COARSE, HALVINGS = 0.15, 0.01, 10  # of the search for that place behind the object [m]
INTO = 0.001  # so much farther ahead the hand is in the object, and does not only graze it [m]
LOWER = 0.02  # between two heights at which the hand is tried [m]
DIGITS = 9  # of a touch in metres: what differs by less is the same
STEP = 0.02  # between two places of a pushed object that are looked at [m]


def hands_at(
    workspace: Workspace, obj: str, placement: Placement, way: Way, slim: bool
) -> Iterator[tuple[Array, float]]:
    """Yield the two tools, (4, 4), whose fingers nearly touch the side that a way pushes, and their openings [m].

    The hand is turned one way or the other. It is as wide as it can be, with both fingers at that side, or slim: it is
    closed, and the flat back of one finger is there. At their height the side may be narrower than seen from above. The
    palm is above the object, or as little lower as lets the fingers touch a side that ends below there.
    """
    gripper = workspace.world.robot.spec.gripper  # each finger touches the side over all of its width, at least
    wide = float(np.clip(2.0 * (way.room - gripper.fingertip), 0.0, gripper.stroke))
    across = np.array([-way.behind[1], way.behind[0]])
    for beside in (across, -across) if slim else (way.behind, -way.behind):
        opening = 0.0 if slim else wide
        for height in _heights(workspace, obj, placement, opening):
            tool = _touching(workspace, obj, placement, way, opening, beside, height)
            if tool is not None and _embraces(workspace, obj, placement, way, tool, opening):
                yield tool, opening
                break


def _heights(workspace: Workspace, obj: str, placement: Placement, opening: float) -> Array:
    """Those of the tool that are tried, the highest first, shape (n,) [m]."""
    boxes = hand_boxes(workspace.world.robot)
    lowest = ABOVE_TABLE + boxes.tip(opening)
    highest = float(workspace.bounds(obj, placement.pose)[1][2]) + BELOW_TOP + boxes.palm(opening)
    return np.append(np.arange(highest, lowest, -LOWER), lowest)


def _embraces(workspace: Workspace, obj: str, placement: Placement, way: Way, tool: Array, opening: float) -> bool:
    """Whether fingers touch an object on both sides of the line of the push through its centre of mass.

    They do so no higher than where it would tip over, at last about an edge of the table.
    """
    T, boxes = placement.pose.matrix, hand_boxes(workspace.world.robot)
    points = felt(workspace, obj) @ T[:3, :3].T + T[:3, 3]
    lower, upper = (corners[0, boxes.side != 0.0] for corners in boxes.opened(np.array([opening])))
    local = ((points - tool[:3, 3]) @ tool[:3, :3])[:, None]
    touched = ((local > lower - TOUCHED) & (local < upper + TOUCHED)).all(axis=2).any(axis=1)
    center = T[:3, :3] @ workspace.world.geometries[obj].center_of_mass + T[:3, 3]
    ahead = np.append(way.shift, 0.0) / np.linalg.norm(way.shift)
    beside = (points[touched] - center)[:, :2] @ np.array([-ahead[1], ahead[0]])
    if not ((beside < -LEVER).any() and (beside > LEVER).any()):
        return False
    tips = min(tips_above(workspace, obj, at, ahead) for at in (placement, way.end))
    return _lowest_touch(workspace, points, way.behind, tool, opening) < tips


def _lowest_touch(workspace: Workspace, points: Array, behind: Array, tool: Array, opening: float) -> float:
    """From which height above what it lies on fingers touch the side of an object that faces `behind` (2,) [m].

    That is where the side, of points (n, 3), and the fingers together reach farthest towards each other.
    """
    robot = workspace.world.robot
    tip, foot = tool[2, 3] - hand_boxes(robot).tip(opening), points[:, 2].min()
    ahead = tool[:3, :3].T @ np.append(-behind, 0.0)
    slices, reach = finger_reach(robot, opening, ahead, points[:, 2].max() - tip)
    out = points[:, :2] @ behind
    inside = (points[:, 2] >= tip + slices[:, :1]) & (points[:, 2] <= tip + slices[:, 1:])
    together = reach + np.where(inside, out, -np.inf).max(axis=1)
    touching = together > together.max(initial=-np.inf) - SIDE
    return float((tip + slices.mean(axis=1) - foot)[touching].min(initial=np.inf))


def barred(workspace: Workspace, obj: str, placement: Placement, way: Way, others: Mapping[str, Placement]) -> bool:
    """Whether some others are in the way of an object, or of every hand that pushes it along; the arm is left out."""
    poses = {name: place.pose.matrix for name, place in others.items()}
    shift = np.append(way.shift, 0.0)
    shifts = np.linspace(0.0, 1.0, 2 + int(np.linalg.norm(shift) / STEP))[:, None] * shift
    along = moved(placement.pose.matrix, shifts)
    if any(workspace.world.overlaps(obj, along, name, T, tolerance=-ARM_MARGIN) for name, T in poses.items()):
        return True
    among = workspace.world.free_hand(Scene(poses), ARM_MARGIN)
    hands = chain.from_iterable(hands_at(workspace, obj, placement, way, slim) for slim in (False, True))
    return all(any(among.hit(moved(T, each), opening) for each in shifts) for T, opening in hands)


def _touching(
    workspace: Workspace, obj: str, placement: Placement, way: Way, opening: float, beside: Array, height: float
) -> Array | None:
    """The tool, shape (4, 4), where its upright fingers nearly touch the side that is pushed; None where they do not.

    The line of the push through the centre of mass passes midway between the fingers, which close across `beside` (2,).
    The tool is at a height [m]. Wherever the object is shifted to, the hand is shifted with it.
    """
    x, y, z = placement.pose.xyz
    there, touch = Pose((0.0, 0.0, z), placement.pose.quat), np.round(way.touch - (x, y), DIGITS)
    key = ("touching", obj, there, *map(tuple, (touch, way.behind, beside)), opening, height)
    tool = workspace.cache.value(
        key, lambda: _touching_at(workspace, obj, there, np.append(touch, height), way.behind, opening, beside)
    )
    return None if tool is None else moved(tool, np.array([x, y, 0.0]))


def _touching_at(
    workspace: Workspace, obj: str, pose: Pose, touch: Array, behind: Array, opening: float, beside: Array
) -> Array | None:
    T, tool = pose.matrix, upright(workspace, beside)
    tool[:3, 3] = touch
    scene, back = Scene({obj: T}), np.append(behind, 0.0)
    # A side that leans is met farther in than where it stands out most, at the latest above the centre of mass.
    inmost = float((center_from_above(workspace, obj, Placement(pose, ())) - touch[:2]) @ behind)

    def touches(away: float, margin: float = TOUCHING) -> bool:
        return workspace.world.hand_contact(moved(tool, away * back), opening, scene, margin=margin) == obj

    # From outside: farther in, the hand may be in a hollow, where it touches nothing either.
    near = next((away for away in np.arange(FARTHEST - COARSE, inmost, -COARSE) if touches(away)), None)
    if near is None:
        return None
    clear = near + COARSE
    for _ in range(HALVINGS):
        middle = (near + clear) / 2
        near, clear = (middle, clear) if touches(middle) else (near, middle)
    return moved(tool, clear * back) if touches(clear - INTO, margin=0.0) else None


def upright(workspace: Workspace, beside: Array) -> Array:
    """A tool at the origin, shape (4, 4), that points down, its closing axis level and across `beside` (2,)."""
    level, down = np.append(beside, 0.0), np.array([0.0, 0.0, -1.0])
    T = np.eye(4)
    T[:3, :3] = np.stack([level, np.cross(down, level), down], axis=1) @ workspace.world.robot.linkage.axes
    return T


OPENINGS = (0.0, 0.5, 1.0)  # of fingers of which one pushes, as shares of the stroke
FARTHEST_FINGERTIP, FINGERTIP_HALVINGS = 0.09, 14  # of the search for where the hand touches the object from behind [m]
STEEP = 0.9  # vertical component from which a normal is that of a top or a bottom, and of no flank
ASTRAY = 0.3  # angle between a nudge and the line from the touch to the centre of mass [rad]


def hands_behind(
    workspace: Workspace, obj: str, placement: Placement, ahead: Array, heights: Array, highest: float = np.inf
) -> Iterator[tuple[Array, float]]:
    """Yield upright tools, (4, 4), and openings [m] with which fingertips touch an object from behind.

    Args:
        workspace: where it is.
        obj: the object.
        placement: where it lies.
        ahead: unit vector in which it shall be pushed, level, (3,).
        heights: of the fingertips in the world, the best first [m].
        highest: where they may touch it in the world: what bulges is met above the fingertips [m].
    """
    aside, stroke = np.array([-ahead[1], ahead[0], 0.0]), workspace.world.robot.spec.gripper.stroke
    own = workspace.world.free_hand(Scene({obj: placement.pose.matrix}), TOUCHING, ignore=(TABLE,))
    center = (placement.pose.matrix @ np.append(workspace.world.geometries[obj].center_of_mass, 1.0))[:3]
    boxes, fingertip = hand_boxes(workspace.world.robot), workspace.world.robot.spec.gripper.fingertip
    for height in heights:
        for beside, shares in ((ahead, (0.0,)), (-ahead, (0.0,)), (aside, OPENINGS), (-aside, OPENINGS)):
            # Of fingers that close along the way the one behind pushes, of those that close across it both do.
            width = fingertip / 2 if shares is OPENINGS else fingertip
            finger = width, float(height), highest
            if not _presses_straight(workspace, obj, placement, center, ahead, finger):
                continue
            for opening in (share * stroke for share in shares):
                tool = upright(workspace, beside[:2])
                tool[:3, 3] = (*center[:2], height + boxes.tip(opening))
                T = _fingertips_touching(own, moved(tool, opening / 2 * ahead), opening, -ahead)
                if T is not None:
                    yield T, opening


def _fingertips_touching(own: FreeHand, tool: Array, opening: float, back: Array) -> Array | None:
    """The tool drawn back until the hand just touches the object that it is in; None where it is not or stays."""
    if not own.hit(tool, opening) or own.hit(moved(tool, FARTHEST_FINGERTIP * back), opening):
        return None
    near, clear = 0.0, FARTHEST_FINGERTIP
    for _ in range(FINGERTIP_HALVINGS):
        middle = (near + clear) / 2
        near, clear = (middle, clear) if own.hit(moved(tool, middle * back), opening) else (near, middle)
    return moved(tool, clear * back)


def _presses_straight(
    workspace: Workspace,
    obj: str,
    placement: Placement,
    center: Array,
    ahead: Array,
    finger: tuple[float, float, float],
) -> bool:
    """Whether a flat finger that reaches so far to both sides and down to a height [m] touches behind the centre.

    It does so no higher than the last number says [m], and does not slip along there.
    """
    T, surface = placement.pose.matrix, felt_surface(workspace, obj)
    points, inward = surface.points @ T[:3, :3].T + T[:3, 3], -surface.normals @ T[:3, :3].T
    across = np.array([-ahead[1], ahead[0], 0.0])
    aside, along = (points - center) @ across, (points - center) @ ahead
    touched = np.flatnonzero((np.abs(aside) < finger[0]) & (points[:, 2] > finger[1]))
    if not len(touched):
        return False
    first = touched[along[touched].argmin()]
    if not abs(aside[first]) < np.tan(ASTRAY) * -along[first]:
        return False
    met = touched[along[touched] < along[first] + TOUCHED]
    if points[met, 2].min() > finger[2]:
        return False
    pressed = inward[met]
    pressed = pressed[(pressed @ ahead > 0.0) & (np.abs(pressed[:, 2]) < STEEP)]
    turned, cone = np.arctan2(pressed @ across, pressed @ ahead), pad_cone(workspace, obj)
    # Of a corner, which the flat of the finger presses on, both sides are seen.
    return bool(turned.min(initial=np.inf) < cone and turned.max(initial=-np.inf) > -cone)
