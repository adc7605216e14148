"""How the hand pushes: it comes down behind an object, touches it with its fingers, goes ahead and draws back."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.affordances.friction_cones import sliding_share
from tamp.streams.affordances.slide_path import Way
from tamp.streams.collisions import ARM_MARGIN, CONTACT_DEPTH
from tamp.streams.context import Context
from tamp.streams.motion.handling_contacts import approach_contact, told
from tamp.streams.motion.payload import push_too_heavy
from tamp.streams.pushing.hand_contact import STEP, hands_at
from tamp.streams.rubbing import close_together, rubbed
from tamp.streams.values import Placement, Slide
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import Pose
from tamp.world.kinematics.inverse import inverse, straight_line
from tamp.world.scene import Scene
from tamp.world.transforms import moved

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

SOLUTIONS = 4  # arm configurations tried for one way
GRAZED = 0.0005  # depth that tells what touches in a narrow container from what is in the way [m]


def pushes(
    context: Context, obj: str, placement: Placement, way: Way, gap: float, slim: bool = False
) -> Iterator[Slide]:
    """Yield slides along a way that the arm can follow, as if nothing else stood on the table.

    The hand comes down and goes up again as far behind the object as `gap` says [m].
    """
    for T, opening in hands_at(context.scene, obj, placement, way, slim):
        yield from pushed(context, obj, placement, way.end, T, opening, np.append(gap * way.behind, 0.0))


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
    share = sliding_share(workspace, obj, start.on)
    for q in inverse(robot, moved(T, shift), context.rng, count=SOLUTIONS):
        heavy = push_too_heavy(workspace, obj, shift, opening, q[None], share)
        push = straight_line(robot, q, T) if heavy is None else None
        begin = None if push is None else drawn_back(workspace, push[-1], back)
        after = None if push is None else drawn_back(workspace, push[0], back)
        if push is None or begin is None or after is None:
            context.fail(heavy or "the way to push it leaves the joint limits")
            continue
        T_tool_object = Pose.from_matrix(T).inverse() @ start.pose
        slide = Slide(obj, start, end, opening, begin[::-1], push[::-1], after, T_tool_object)
        hit = push_too_heavy(workspace, obj, shift, opening, push, share) or push_hits(workspace, slide, {})
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
    nearest = -ARM_MARGIN if slide.start.on == (TABLE,) else GRAZED
    passed = _passed(workspace, slide)
    for name, T in poses.items():
        deep = sinks_into(workspace, obj, slide.start, name, T) if name in slide.start.on else nearest
        if workspace.world.overlaps(obj, passed, name, T, tolerance=deep):
            return f"{obj} would be pushed into {name}"
    beside = {name: T for name, T in poses.items() if name not in slide.start.on}
    contact = rubbed(workspace.world, obj, close_together(_ahead(workspace, slide)), beside)
    return None if contact is None else f"{obj} would be pushed along {contact.b}"


def learn_refused_push(workspace: Workspace, slide: Slide) -> None:
    """Let an object not be pushed again as the checker has refused it: from there to there by a hand that is there."""
    workspace.cache.learn(_push_key(slide), True)


def is_refused_push(workspace: Workspace, slide: Slide) -> bool:
    """Whether the checker has refused such a push."""
    return workspace.cache.value(_push_key(slide), lambda: False)


def _push_key(slide: Slide) -> Hashable:
    return "refused push", slide.object, slide.start, slide.end, slide.T_tool_object, slide.opening


def sinks_into(workspace: Workspace, obj: str, start: Placement, carrier: str, T: Array) -> float:
    """How deep an object may be in what carries it, which is at T (4, 4), as it is pushed: hardly more than at rest."""
    return max(0.0, -workspace.world.separation(obj, start.pose.matrix, carrier, T)) + GRAZED


def _passed(workspace: Workspace, slide: Slide) -> Array:
    """Poses of the object on its way before the hand, and as it falls after that, shape (n, 4, 4)."""
    if slide.fall:
        return np.array([*_ahead(workspace, slide), *(pose.matrix for pose in slide.fall)])
    shift = np.subtract(slide.end.pose.xyz, slide.start.pose.xyz)
    shares = np.linspace(0.0, 1.0, 2 + int(np.linalg.norm(shift) / STEP))
    return moved(slide.start.pose.matrix, shares[:, None] * shift)


def _ahead(workspace: Workspace, slide: Slide) -> Array:
    """Poses of what a hand pushes on its way, shape (n, 4, 4)."""
    return np.array([workspace.world.robot.forward(q) @ slide.T_tool_object.matrix for q in slide.push])


def drawn_back(workspace: Workspace, q: Array, back: Array) -> Array | None:
    """From `q` back from the object, (3,) [m], then up, shape (n, joints); None where the arm cannot."""
    robot, path = workspace.world.robot, q[None]
    for shift in (back, np.array([0.0, 0.0, workspace.hand.push_height])):
        line = straight_line(robot, path[-1], moved(robot.forward(path[-1]), shift)) if shift.any() else path[-1:]
        if line is None:
            return None
        path = np.vstack([path, line[1:]])
    return path
