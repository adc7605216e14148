"""Which grasps are firm: how far an object moves in each, by turning and slipping together, and how hard to press."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import zip_longest
from operator import itemgetter

from tamp.streams.hand.squeezed import Squeezed
from tamp.streams.hand.stability import FIRM, slipping, swinging, turned_flush, turning
from tamp.streams.values import Grasp, Placement
from tamp.streams.workspace import Workspace
from tamp.task import Pose
from tamp.world.robot.payload import GRAVITY

LOST = 0.5  # one in which it turns by more does not hold it at all [rad]
FIRMER = 2.0  # so many times their usual force holds what is not held firmly; three times turns plates on their rims
ARM = 0.1  # so far, as the score measures it, is what turns by one radian [m]
AS_BAD = 0.02  # slipping so far is as bad as turning by one radian [m]


def looseness(workspace: Workspace, obj: str, grasp: Grasp, *poses: Pose) -> float:
    """How far an object moves in a hand that lifts it from any of some poses: the angle, or what is as bad [rad]."""

    def found() -> float:
        squeezed = Squeezed(workspace, obj, grasp)
        angle = max(turning(squeezed, *poses), swinging(squeezed, *poses))
        return max(angle, slipping(squeezed, *poses) / AS_BAD)

    return workspace.cache.value(("looseness", obj, grasp, poses), found)


def unsteadiness(workspace: Workspace, obj: str, grasp: Grasp, *poses: Pose) -> float:
    """How far an object moves in a hand that closes on it, and then lifts it [rad]; `LOST` where it loses it then."""
    loose = looseness(workspace, obj, grasp, *poses)
    return loose if loose >= LOST else min(loose + turned_flush(workspace, obj, grasp) / ARM, 0.99 * LOST)


def firmer(workspace: Workspace, obj: str, grasp: Grasp, pose: Pose) -> float | None:
    """What fingers press with as they carry what their usual force does not hold firmly [N]; None where it does."""
    if looseness(workspace, obj, grasp, pose) <= FIRM:
        return None
    item, gripper = workspace.task.object(obj), workspace.world.robot.spec.gripper
    return min(gripper.force, FIRMER * gripper.holding_force(item.mass * GRAVITY, item.friction))


def second_best(
    workspace: Workspace, obj: str, place: Placement, loose: Sequence[tuple[float, Grasp]], partly: Sequence[Grasp]
) -> Iterator[Grasp | None]:
    """Yield by turns a grasp of all placements in which the object moves, and a firm one of some of them.

    An object that moves in the hand while it is lifted costs a new plan, and so does a grasp that only serves once
    others have moved: neither is clearly better. Grasps that are not even firm come last; those that lose the object
    never.

    Args:
        workspace: where the object is.
        obj: the object.
        place: where it stands.
        loose: grasps that serve all placements, with how loosely each holds the object [rad].
        partly: grasps that serve some of them, best first.

    Yields:
        Grasps, and None where one was looked at for nothing.
    """
    shaky: list[tuple[float, Grasp]] = []
    for one, other in zip_longest(sorted(loose, key=itemgetter(0)), partly):
        if one is not None and one[0] < LOST:
            yield one[1]
        angle = LOST if other is None else looseness(workspace, obj, other, place.pose)
        if other is not None and FIRM < angle < LOST:
            shaky.append((angle, other))
        yield other if angle <= FIRM else None
    yield from (grasp for _, grasp in sorted(shaky, key=itemgetter(0)))
