"""Lifting: the short way on which an object leaves what it stands on, and what stands around it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from operator import itemgetter
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.affordances.neighbours import standing_around, standing_on
from tamp.streams.collisions import ARM_MARGIN, CONTACT_DEPTH
from tamp.streams.context import Context
from tamp.streams.motion.extraction import Way, extraction, meets
from tamp.streams.motion.handling_contacts import carrying_contact, told, touched
from tamp.streams.motion.payload import lift_too_heavy
from tamp.streams.rubbing import PRESSED
from tamp.streams.values import Grasp, Handling, Placement
from tamp.streams.workspace import Workspace
from tamp.task import Pose
from tamp.world.kinematics.inverse import straight_lines
from tamp.world.scene import Scene
from tamp.world.transforms import moved

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

LIFTS = (0.08, 0.15, 0.04, 0.25, 0.32)  # how far up the object is carried off, the last out of what is deep [m]
# How far straight up first, then up in all, and to a side, where it leans on something or is leant over [m].
OBLIQUE = ((0.0, 0.08, 0.03), (0.03, 0.12, 0.05))
SIDES = 8
COLLIDES = 2  # how badly an object meets something that it does not merely graze


@dataclass(frozen=True, eq=False)
class Reach:
    """The arm's way to an object, without the lift; its attributes are those of a handling."""

    object: str
    placement: Placement
    grasp: Grasp
    opening: float
    approach: Array
    fall: tuple[Pose, ...]

    @property
    def let_go(self) -> Pose:
        """Where the object is while the hand comes to it or leaves it."""
        return self.fall[0] if self.fall else self.placement.pose

    def lifted(self, lift: Array) -> Handling:
        """The handling that goes on with a lift, shape (n, joints)."""
        return Handling(self.object, self.placement, self.grasp, self.opening, self.approach, lift, self.fall)


def lifted(context: Context, reach: Reach) -> tuple[Way, Array] | None:
    """A way up from the grasp, as offsets and as a path of shape (n, joints); None, and the reason told.

    If possible it meets nothing that stands around and ends well clear of it, or at least of what the object stands on
    or in, since the way on begins there: what leans on something, or under something that leans over it, is drawn away
    obliquely, at once or after a bit; and where that meets something, whatever way out there is.

    Args:
        context: of the stream that is called.
        reach: how the arm gets to the grasp.
    """
    workspace: Workspace = context.scene
    obj, placement, grasp = reach.object, reach.placement, reach.grasp
    reason = ""
    T_tool_object = grasp.T_object_tool.inverse().matrix
    at_once = lift_too_heavy(workspace, obj, T_tool_object, grasp.width, reach.approach[-1:])
    if at_once is not None:  # no way off begins elsewhere
        context.fail(at_once)
        return None
    around = {name: place.pose.matrix for name, place in standing_around(workspace, obj, placement).items()}
    on = standing_under(workspace, obj, placement)
    scenes = (Scene(poses=poses).attached(obj, T_tool_object, grasp.width) for poses in (around, on))
    beyond = [workspace.world.checker(scene, margin=ARM_MARGIN, held_margin=ARM_MARGIN) for scene in scenes]
    found: list[tuple[int, Way, Array]] = []
    for way, meeting in _clear_first(workspace, reach):
        if found and meeting == COLLIDES:
            break
        path, why = _path(workspace, reach, way)
        if path is not None:
            met = sum(checker.first_contact(path[-1:]) is not None for checker in beyond)
            if met == 0:
                return way, path
            found.append((met, way, path))
        reason = why or reason
    if not found:
        context.fail(reason or "the lift leaves the joint limits")
        return None
    return min(found, key=itemgetter(0))[1:]


def _path(workspace: Workspace, reach: Reach, way: Way) -> tuple[Array | None, str]:
    """The arm's path along a way off, shape (n, joints); None, and why if that is known.

    It is clear of the table and itself, and within the arm's strength. The reason is empty where the arm cannot follow
    the way.
    """

    def found() -> tuple[Array | None, str]:
        robot, q = workspace.world.robot, reach.approach[-1]
        T = robot.forward(q)
        path = straight_lines(robot, q, [moved(T, np.array(offset)) for offset in way])
        if path is None:
            return None, ""
        T_tool_object = reach.grasp.T_object_tool.inverse().matrix
        if (heavy := lift_too_heavy(workspace, reach.object, T_tool_object, reach.grasp.width, path)) is not None:
            return None, heavy
        contact = carrying_contact(workspace, reach.object, reach.let_go, reach.grasp, path, {})
        return (path, "") if contact is None else (None, told(contact))

    return workspace.cache.value(("lift", reach, way), found)


def standing_under(workspace: Workspace, obj: str, placement: Placement) -> dict[str, Array]:
    """What an object stands on or in, T_world_support each, shape (4, 4)."""
    around = standing_around(workspace, obj, placement)
    return {name: place.pose.matrix for name, place in around.items() if name in placement.on}


def _clear_first(workspace: Workspace, reach: Reach) -> Iterator[tuple[Way, int]]:
    """Ways off and how badly the object itself, without a hand, meets something on each; 0, not at all, comes first."""
    around = standing_around(workspace, reach.object, reach.placement)
    pose = reach.let_go
    meeting: dict[Way, int] = {}
    for way in _ways():
        meeting[way] = _meets(workspace, reach.object, pose, way, around)
        if meeting[way] == 0:
            yield way, 0
    if 0 not in meeting.values() and (out := _extraction(workspace, reach.object, pose, around)) is not None:
        yield out, 0
    yield from sorted(((way, count) for way, count in meeting.items() if count), key=itemgetter(1))


def _extraction(workspace: Workspace, obj: str, pose: Pose, around: Mapping[str, Placement]) -> Way | None:
    """What `extraction` finds, remembered; nothing while something stands on the object, which is taken before."""
    if standing_on(obj, around):
        return None
    others = {name: place.pose.matrix for name, place in around.items()}
    return workspace.cache.value(
        ("extraction", obj, pose, *around.items()), lambda: extraction(workspace.world, obj, pose.matrix, others)
    )


def _ways() -> Iterator[Way]:
    """Ways to carry an object off, the preferred ones first."""
    yield from (((0.0, 0.0, up),) for up in LIFTS)
    for (first, up, aside), angle in product(OBLIQUE, np.arange(SIDES) * 2 * np.pi / SIDES):
        end = (aside * float(np.cos(angle)), aside * float(np.sin(angle)), up)
        yield ((0.0, 0.0, first), end) if first else (end,)


def _meets(workspace: Workspace, obj: str, pose: Pose, way: Way, around: Mapping[str, Placement]) -> int:
    """How badly an object meets what is around it on its way off: 0 not at all, 1 if it grazes, else COLLIDES."""
    lower, upper = workspace.bounds(obj, pose)
    corners = np.vstack([np.zeros(3), *way])
    low, high = lower + corners.min(axis=0), upper + corners.max(axis=0)
    boxes = {name: workspace.bounds(name, place.pose) for name, place in around.items()}
    near = {name: around[name] for name, (least, most) in boxes.items() if (least < high).all() and (low < most).all()}

    def found() -> int:
        others = {name: place.pose.matrix for name, place in near.items()}
        touch = touched(workspace.world, obj, pose.matrix, others, scraped=PRESSED)
        if not meets(workspace.world, obj, pose.matrix, corners, others, touch):
            return 0
        deep = dict.fromkeys(others, -CONTACT_DEPTH)
        return COLLIDES if meets(workspace.world, obj, pose.matrix, corners, others, deep) else 1

    return workspace.cache.value(("off", obj, pose, way, *near.items()), found) if near else 0
