"""Does an object stay where it stands: carried, in balance, in nothing else?"""

from __future__ import annotations

from typing import TYPE_CHECKING

from tamp.checking.distances import clearance
from tamp.checking.support import Contacts, contacts
from tamp.checking.transforms import inverse

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from tamp.checking.scene import Scene, State
    from tamp.checking.tolerances import Tolerances


def carriers(scene: Scene, state: State, name: str, allow: Tolerances) -> Contacts:
    """What an object touches, and what of that carries it from below."""
    others = {o: (scene.solids[o], T) for o, T in state.standing(scene).items() if o != name}
    return contacts(scene.solids[name], state.poses[name], others, allow.standing)


def unrest(scene: Scene, state: State, name: str, allow: Tolerances) -> Iterator[tuple[str, tuple[str, ...], float]]:
    """Why an object does not stay where it stands: sentence, bodies, depth [m]."""
    yield from overlaps(scene, state, name, allow)
    carried = carriers(scene, state, name, allow)
    if not carried.bodies:
        yield f"{name} stands in the air: nothing carries it", (name,), 0.0
        return
    balance = balanced(scene, state, name, carried, allow)
    if balance < allow.balance:
        outside = "on the edge of" if balance >= 0.0 else f"{-1000 * balance:.0f} mm outside"
        sentence = f"{name} tips over: its centre of mass is {outside} what carries it ({', '.join(carried.bodies)})"
        if balance == -float("inf"):
            sentence = f"{name} slides: friction does not hold it where it leans ({', '.join(sorted(carried.patches))})"
        yield sentence, (name, *carried.bodies), min(max(-balance, 0.0), scene.solids[name].radius)


def without_part(touching: Contacts, bodies: Sequence[str]) -> list[str]:
    """Those of some bodies that have no part in keeping an object up: it neither stands on them nor leans on them.

    Only what stands on one of them can lean on another: what pushes from the side alone carries no weight.
    """
    stands = any(body in touching.bodies for body in bodies)
    return [body for body in bodies if body not in (touching.patches if stands else touching.bodies)]


def balanced(scene: Scene, state: State, name: str, touching: Contacts, allow: Tolerances) -> float:
    """How well an object rests on certain contacts [m], see `statics.balance`."""
    center = scene.center_of_mass(name, state.poses[name])
    friction = {other: scene.friction(name) * scene.friction(other) for other in touching.patches}
    return touching.balance(center, friction, allow.balance)


def overlaps(scene: Scene, state: State, name: str, allow: Tolerances) -> Iterator[tuple[str, tuple[str, ...], float]]:
    """What an object stands deeper in than contact explains: sentence, bodies, depth [m]."""
    others = state.standing(scene)
    for other in sorted(others):
        if other == name:
            continue
        T = inverse(others[other]) @ state.poses[name]
        apart = clearance(scene.solids[other], scene.solids[name], T, allow.contact)
        if apart < -allow.contact:
            yield f"{name} stands {-1000 * apart:.1f} mm inside {other}", (name, other), -apart


def touched(scene: Scene, state: State, name: str, allow: Tolerances) -> bool:
    """Whether anything is within reach of an object, so that it cannot hang in the air."""
    others = state.standing(scene)
    solid, T = scene.solids[name], state.poses[name]
    return any(
        clearance(scene.solids[other], solid, inverse(others[other]) @ T, allow.contact) <= allow.standing
        for other in sorted(others)
        if other != name
    )
