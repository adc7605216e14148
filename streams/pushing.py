"""How the hand pushes: it comes down behind an object, touches it with open fingers, goes ahead and draws back."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.collisions import ARM_MARGIN, CONTACT_DEPTH, approach_contact, told
from tamp.streams.hand import hand_boxes
from tamp.streams.slides import Way
from tamp.streams.values import Placement, Slide
from tamp.streams.workspace import TABLE, Context, Workspace
from tamp.task import Pose
from tamp.world.kinematics import inverse, straight_line
from tamp.world.scene import Scene

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

ABOVE_TABLE = 0.008  # of the fingertips while they push [m]
BELOW_TOP = 0.003  # of the object: the palm stays this far above what the fingers push [m]
FINGERTIP = 0.016  # each finger touches the side that is pushed over at least this width [m]
TOUCHING = 0.0004  # between the fingers and the object when the push begins [m]
FARTHEST, HALVINGS = 0.15, 14  # of the search for that place behind the object [m]
BEHIND = 0.025  # the object is where the hand comes down and goes up again [m]
CLOSE = 0.008  # behind it is where it does so if others leave no more room [m]
UP = 0.12  # how far above that it begins and ends [m]
SOLUTIONS = 4  # arm configurations tried for one way
STEP = 0.02  # between two places of a pushed object that are looked at [m]
GRAZED = 0.0005  # depth that tells what touches in a narrow container from what is in the way [m]


def pushes(context: Context, obj: str, placement: Placement, way: Way, behind: float = BEHIND) -> Iterator[Slide]:
    """Yield slides along a way that the arm can follow, as if nothing else stood on the table.

    The hand comes down and goes up again as far behind the object as `behind` says [m].
    """
    for T, opening in hands_at(context.scene, obj, placement, way):
        yield from pushed(context, obj, placement, way.end, T, opening, np.append(behind * way.behind, 0.0))


def hands_at(workspace: Workspace, obj: str, placement: Placement, way: Way) -> Iterator[tuple[Array, float]]:
    """Yield the two tools, (4, 4), whose open fingers nearly touch the side that a way pushes, and their openings [m].

    The hand is turned one way or the other.
    """
    opening = float(np.clip(2.0 * (way.room - FINGERTIP), 0.0, workspace.world.robot.spec.gripper.stroke))
    for side in (1.0, -1.0):
        yield _touching(workspace, obj, placement, way, opening, side), opening


def barred(workspace: Workspace, obj: str, placement: Placement, way: Way, others: Mapping[str, Placement]) -> bool:
    """Whether some others are in the way of an object, or of every hand that pushes it along; the arm is left out."""
    poses = {name: place.pose.matrix for name, place in others.items()}
    shift = np.append(way.shift, 0.0)
    shifts = np.linspace(0.0, 1.0, 2 + int(np.linalg.norm(shift) / STEP))[:, None] * shift
    for name, T in poses.items():
        along = (_moved(placement.pose.matrix, each) for each in shifts)
        if any(workspace.world.overlap(obj, at, name, T, tolerance=-ARM_MARGIN) for at in along):
            return True
    among = workspace.world.free_hand(Scene(poses), ARM_MARGIN)
    hands = hands_at(workspace, obj, placement, way)
    return all(any(among.hit(_moved(T, each), opening) for each in shifts) for T, opening in hands)


def pushed(
    context: Context, obj: str, start: Placement, end: Placement, T: Array, opening: float, back: Array
) -> Iterator[Slide]:
    """Yield slides in which a hand pushes an object from one placement to another, as if nothing else stood there.

    Args:
        context: of the stream that is called.
        obj: the object.
        start: where it stands.
        end: where it stands afterwards, as it was turned before.
        T: the tool, shape (4, 4), where the hand touches the object from behind.
        opening: distance between the pads [m].
        back: how the hand comes from above to there, and leaves from the end: drawn back by this, (3,) [m].
    """
    workspace: Workspace = context.scene
    robot = workspace.world.robot
    shift = np.subtract(end.pose.xyz, start.pose.xyz) * (1.0, 1.0, 0.0)
    for q in inverse(robot, _moved(T, shift), context.rng, count=SOLUTIONS):
        push = straight_line(robot, q, T)
        begin = None if push is None else drawn_back(workspace, push[-1], back)
        after = None if push is None else drawn_back(workspace, push[0], back)
        if push is None or begin is None or after is None:
            context.fail("the way to push it leaves the joint limits")
            continue
        T_tool_object = Pose.from_matrix(T).inverse() @ start.pose
        slide = Slide(obj, start, end, opening, begin[::-1], push[::-1], after, T_tool_object)
        hit = push_hits(workspace, slide, {})
        if hit is None:
            yield slide
        else:
            context.fail(hit)


def push_hits(workspace: Workspace, slide: Slide, others: Mapping[str, Placement]) -> str | None:
    """What arm and object meet on a slide, among others that stand where they stand, in words; None if nothing."""
    poses = {name: others[name].pose.matrix for name in sorted(others)}
    obj, start, end = slide.object, slide.start.pose, slide.end.pose
    scene = Scene(poses).attached(obj, slide.T_tool_object.matrix, slide.opening)
    checker = workspace.world.checker(scene, margin=ARM_MARGIN, held_margin=-CONTACT_DEPTH)
    contact = (
        approach_contact(workspace, obj, start, slide.opening, slide.approach, poses)
        or checker.first_contact(slide.push)
        or approach_contact(workspace, obj, end, slide.opening, slide.retreat[::-1], poses)
    )
    if contact is not None:
        return told(contact)
    # Within a container neighbours touch, and nothing is far from a wall.
    beside = -ARM_MARGIN if slide.start.on == (TABLE,) else GRAZED
    passed = _passed(workspace, slide)
    for name, T in poses.items():
        deep = CONTACT_DEPTH if name in slide.start.on else beside
        if any(workspace.world.overlap(obj, at, name, T, tolerance=deep) for at in passed):
            return f"{obj} would be pushed into {name}"
    return None


def _passed(workspace: Workspace, slide: Slide) -> list[Array]:
    """Poses (4, 4) of the object on its way before the hand, and as it falls after that."""
    if slide.fall:
        T_tool_object = slide.T_tool_object.matrix
        return [workspace.world.robot.forward(q) @ T_tool_object for q in slide.push] + [
            pose.matrix for pose in slide.fall
        ]
    shift = np.subtract(slide.end.pose.xyz, slide.start.pose.xyz)
    shares = np.linspace(0.0, 1.0, 2 + int(np.linalg.norm(shift) / STEP))
    return [_moved(slide.start.pose.matrix, share * shift) for share in shares]


def _touching(workspace: Workspace, obj: str, placement: Placement, way: Way, opening: float, side: float) -> Array:
    """The tool, shape (4, 4), where its upright open fingers nearly touch the side of the object that is pushed.

    The line of the push through the centre of mass passes midway between the fingers. `side` 1 or -1 turns the hand
    one way or the other.
    """
    T, boxes = placement.pose.matrix, hand_boxes(workspace.world.robot)
    fingers = boxes.side != 0.0
    tip, root = boxes.upper[fingers, 2].max(), boxes.upper[~fingers, 2].max()
    top = float(workspace.bounds(obj, placement.pose)[1][2])
    tool = upright(workspace, side * way.behind)
    tool[:2, 3] = way.touch
    tool[2, 3] = max(ABOVE_TABLE + tip, top + BELOW_TOP + root)
    scene, near, clear = Scene({obj: T}), 0.0, FARTHEST
    back = np.append(way.behind, 0.0)
    for _ in range(HALVINGS):
        middle = (near + clear) / 2
        if workspace.world.hand_contact(_moved(tool, middle * back), opening, scene, margin=TOUCHING) == obj:
            near = middle
        else:
            clear = middle
    return _moved(tool, clear * back)


def upright(workspace: Workspace, beside: Array) -> Array:
    """A tool at the origin, shape (4, 4), that points down, its closing axis level and across `beside` (2,)."""
    closing, down = np.array(workspace.world.robot.spec.gripper.axis), np.array([0.0, 0.0, -1.0])
    basis = np.stack([np.cross(closing, [0.0, 0.0, 1.0]), closing, [0.0, 0.0, 1.0]], axis=1)
    level = np.append(beside, 0.0)
    T = np.eye(4)
    T[:3, :3] = np.stack([level, np.cross(down, level), down], axis=1) @ basis.T
    return T


def drawn_back(workspace: Workspace, q: Array, back: Array) -> Array | None:
    """From `q` back from the object, (3,) [m], then up, shape (n, joints); None where the arm cannot."""
    robot, path = workspace.world.robot, q[None]
    for shift in (back, np.array([0.0, 0.0, UP])):
        line = straight_line(robot, path[-1], _moved(robot.forward(path[-1]), shift)) if shift.any() else path[-1:]
        if line is None:
            return None
        path = np.vstack([path, line[1:]])
    return path


def _moved(T: Array, shift: Array) -> Array:
    moved = T.copy()
    moved[:3, 3] += shift
    return moved
