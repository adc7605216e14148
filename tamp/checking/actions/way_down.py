"""What does an object meet on its way from where it was let go to where it comes to rest?"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.physics.support import carriers
from tamp.checking.robot.sweep import Mover, Touch, standing, touches, travelled

if TYPE_CHECKING:
    from collections.abc import Collection

    from numpy.typing import NDArray

    from tamp.checking.scene import Scene, State
    from tamp.checking.tolerances import Tolerances

    Array = NDArray[np.float64]


def met_on_the_way(
    scene: Scene, state: State, name: str, path: Array, near: Collection[str], allow: Tolerances
) -> list[Touch]:
    """What stands in the way of an object at poses `path`, shape (n, 4, 4), deeper than it may be.

    `near` names the bodies that it touches at one of the ends.
    """
    body = Mover(scene.solids[name], path)
    others = [mover for mover in standing(scene.solids, state.standing(scene)) if mover.solid.name != name]
    depths = (allow.contact if other.solid.name in near else allow.collision for other in others)
    return touches((other, body, depth) for other, depth in zip(others, depths, strict=True))


def dropped_through(scene: Scene, state: State, name: str, held: Array, allow: Tolerances) -> list[Touch]:
    """What an object that now stands would meet as it drops straight down from where it was `held`, shape (4, 4)."""
    T = state.poses[name]
    above = state.without(name)
    above.poses[name] = held
    near = {*carriers(scene, above, name, allow).patches, *carriers(scene, state, name, allow).patches}
    ends = np.stack([held, T])
    count = int(np.ceil(travelled(scene.solids[name], ends).max() / allow.step)) + 2
    path = np.tile(T, (count, 1, 1))
    path[:, :3, 3] = np.linspace(held[:3, 3], T[:3, 3], count)
    return met_on_the_way(scene, state, name, path, near, allow)
