"""The pairwise collision tests: may this placement, this handling, stand beside that placement?"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from tamp.streams.values import Grasp, Handling, Placement
from tamp.streams.workspace import Context, Workspace
from tamp.world.scene import Scene

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from tamp.world.collision import CollisionChecker

CONTACT_DEPTH = 0.003  # settled bodies touch; what overlaps deeper collides [m]
ARM_MARGIN = 0.002  # the arm and the hand stay clear of everything by this [m]


def test_cfree_placements(context: Context, obj: str, placement: Placement, other: str, standing: Placement) -> bool:
    """Whether two objects can stand at these placements together."""
    if obj == other:
        return True
    workspace: Workspace = context.scene
    overlap = workspace.world.overlap(obj, placement.pose.matrix, other, standing.pose.matrix, tolerance=CONTACT_DEPTH)
    if overlap:
        context.fail(f"{obj} would overlap {other}")
    return not overlap


def test_cfree_handling(context: Context, obj: str, handling: Handling, other: str, standing: Placement) -> bool:
    """Whether the arm can reach for `obj` and lift it (or put it down and leave) while `other` stands there."""
    workspace: Workspace = context.scene
    if ("clear", handling, other, standing) in workspace.memory:
        return True
    contact = handling_contact(workspace, handling, {other: standing})
    if contact is not None:
        context.fail(contact)
    return contact is None


def handling_contact(workspace: Workspace, handling: Handling, others: Mapping[str, Placement]) -> str | None:
    """The first collision along a handling with `others` standing around, in words; None where there is none."""
    poses = {name: others[name].pose.matrix for name in sorted(others)}
    obj, placement = handling.object, handling.placement
    contact = approach_contact(workspace, obj, placement, handling.opening, handling.approach, poses) or lift_contact(
        workspace, obj, handling.grasp, handling.lift, poses
    )
    if contact is None:  # clear of all of them is clear of each
        workspace.memory.update({("clear", handling, name, place): True for name, place in others.items()})
    return contact


def approach_contact(
    workspace: Workspace,
    obj: str,
    placement: Placement,
    opening: float,
    path: NDArray[np.float64],
    others: Mapping[str, NDArray[np.float64]],
) -> str | None:
    """What the empty open hand meets on its way to a grasp of `obj`, shape of `path` (n, joints); None if nothing."""
    scene = Scene(poses={**others, obj: placement.pose.matrix}, opening=opening)
    return _told(workspace.world.checker(scene, margin=ARM_MARGIN, touch={obj: 0.0}), path)


def lift_contact(
    workspace: Workspace,
    obj: str,
    grasp: Grasp,
    path: NDArray[np.float64],
    others: Mapping[str, NDArray[np.float64]],
) -> str | None:
    """What arm and held object meet while they leave the support; shape of `path` (n, joints); None if nothing."""
    scene = Scene(poses=others).attached(obj, grasp.T_object_tool.inverse().matrix, grasp.width)
    return _told(workspace.world.checker(scene, margin=ARM_MARGIN, held_margin=-CONTACT_DEPTH), path)


def _told(checker: CollisionChecker, path: NDArray[np.float64]) -> str | None:
    contact = checker.first_contact(path)
    return None if contact is None else f"{contact.a} would hit {contact.b}"
