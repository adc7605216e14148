"""What does an object meet on its way from where it was let go to where it comes to rest?"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.geometry.solids import clearance
from tamp.checking.geometry.transforms import inverse
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

    `near` names the bodies that it touches at one of the ends. Where it, or what stands there, is elsewhere in truth it
    is asked about there too, and may be no deeper in those than it is where the plan has them at the ends.
    """
    body = Mover(scene.solids[name], path)
    others = standing(scene.solids, {o: T for o, T in state.standing(scene).items() if o != name})
    elsewhere = standing(scene.solids, {o: T for o, T in state.stayed.items() if o != name}, astray=True)
    resting = {o.solid.name: _deepest(o, body, allow) for o in others if o.solid.name in near}
    pairs = [(other, body, allow.contact if other.solid.name in near else allow.collision) for other in others]
    movers = [body]
    if name in state.stayed:
        there = state.stayed[name] @ inverse(path[-1]) @ path
        movers.append(Mover(body.solid, np.ascontiguousarray(there), astray=True))
    for mover in movers:
        beside = [*elsewhere, *(others if mover.astray else [])]
        pairs += [(other, mover, allow.collision + resting.get(other.solid.name, 0.0)) for other in beside]
    return touches(pairs)


def _deepest(other: Mover, body: Mover, allow: Tolerances) -> float:
    """How deep a body is in another at the ends of its way [m]."""
    ends = (inverse(other.T[0]) @ body.T[k] for k in (0, -1))
    return max(0.0, *(-clearance(other.solid, body.solid, T, allow.contact) for T in ends))


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
