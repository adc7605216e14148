"""The pairwise collision tests: may this placement, this handling, stand beside that placement?"""

from __future__ import annotations

from tamp.streams.values import Handling, Placement
from tamp.streams.workspace import Context, Workspace
from tamp.world.scene import Scene

CONTACT_DEPTH = 0.003  # settled bodies touch; what overlaps deeper collides [m]
ARM_MARGIN = 0.002  # the arm and the hand stay clear of everything by this [m]


def test_cfree_placements(context: Context, obj: str, placement: Placement, other: str, standing: Placement) -> bool:
    """Whether two objects can stand at these placements together."""
    workspace: Workspace = context.scene
    overlap = workspace.world.overlap(obj, placement.pose.matrix, other, standing.pose.matrix, tolerance=CONTACT_DEPTH)
    if overlap:
        context.fail(f"{obj} would overlap {other}")
    return not overlap


def test_cfree_handling(context: Context, obj: str, handling: Handling, other: str, standing: Placement) -> bool:
    """Whether the arm can reach for `obj` and lift it (or put it down and leave) while `other` stands there."""
    workspace: Workspace = context.scene
    contact = handling_contact(workspace, handling, {other: standing})
    if contact is not None:
        context.fail(contact)
    return contact is None


def handling_contact(workspace: Workspace, handling: Handling, others: dict[str, Placement]) -> str | None:
    """The first collision along a handling with `others` standing around, in words; None where there is none."""
    poses = {name: placement.pose.matrix for name, placement in sorted(others.items())}
    empty = Scene(poses={**poses, handling.object: handling.placement.pose.matrix}, opening=handling.opening)
    approach = workspace.world.checker(empty, margin=ARM_MARGIN, touch={handling.object: 0.0})
    contact = approach.first_contact(handling.approach)
    if contact is None:
        holding = Scene(poses=poses).attached(
            handling.object, handling.grasp.T_object_tool.inverse().matrix, handling.grasp.width
        )
        lift = workspace.world.checker(holding, margin=ARM_MARGIN, held_margin=-CONTACT_DEPTH)
        contact = lift.first_contact(handling.lift)
    return None if contact is None else f"{contact.a} would hit {contact.b}"
