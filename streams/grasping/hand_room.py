"""How much room hands have round an object that they could take from above, as its neighbours stand."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.affordances.neighbours import within
from tamp.streams.grasping.container import upright_pinches
from tamp.streams.hand.candidates import Pinches
from tamp.streams.hand.clearance import above_table, clear_of_object, reach_of_hand
from tamp.streams.values import Placement
from tamp.streams.workspace import Workspace
from tamp.world.scene import Scene

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

PROBE, HANDS = 1, 3000  # seed and number of the hands that tell how much room there is round an object
ENOUGH = 2  # hands with room round an object: it is not stuck


def hands_over(workspace: Workspace, obj: str, placement: Placement) -> Pinches:
    """Hands that could take an object from above, were there room for them; the same for every seed."""

    def found() -> Pinches:
        rng = np.random.default_rng(PROBE)
        hands = upright_pinches(workspace, obj, placement, rng)
        hands = hands.at(above_table(workspace, hands, placement))
        hands = hands.at(np.sort(rng.permutation(len(hands))[:HANDS]))
        return hands.at(clear_of_object(workspace, obj, hands))

    return workspace.cache.value(("hands over", obj, placement), found)


def with_room(workspace: Workspace, hands: Pinches, T_world_object: Array, poses: Mapping[str, Array]) -> Pinches:
    """Those of some hands that meet none of the others around an object, neither open nor closed."""
    among = workspace.world.free_hand(Scene(dict(poses)), workspace.hand.margin)
    stroke = workspace.world.robot.spec.gripper.stroke
    for openings in (np.minimum(stroke, hands.widths + 2 * hands.clearances), None):
        if len(hands):
            T = T_world_object @ hands.T_object_tool
            hands = hands.at(~among.hits(T, hands.widths if openings is None else openings))
    return hands


def roomy(workspace: Workspace, obj: str, without: str = "") -> Pinches:
    """Hands with room round an object as all stand at the start, but for one that is taken away."""
    place = workspace.start[obj]
    others = {other: standing for other, standing in _neighbours(workspace, obj).items() if other != without}
    return workspace.cache.value(
        ("roomy", obj, place, *others.items()),
        lambda: with_room(workspace, hands_over(workspace, obj, place), place.pose.matrix, matrices(others)),
    )


def hemmed_in(workspace: Workspace, obj: str) -> bool:
    """Whether neighbours alone leave no hand the room to take an object as all stand at the start."""
    if not _neighbours(workspace, obj):
        return False
    return len(roomy(workspace, obj)) < ENOUGH <= len(hands_over(workspace, obj, workspace.start[obj]))


def _neighbours(workspace: Workspace, obj: str) -> dict[str, Placement]:
    """What a hand may meet round an object as all stand at the start, in order of their names."""
    near = within(workspace, obj, reach_of_hand(workspace), workspace.start[obj]).start
    return {name: place for name, place in near.items() if name != obj}


def matrices(places: Mapping[str, Placement]) -> dict[str, Array]:
    """T_world_object of each, shape (4, 4)."""
    return {name: place.pose.matrix for name, place in places.items()}
