"""On what does a body rest that it really touches, and how does it give way where that does not carry it?

Contact points are those within a tolerance of millimetres, for plans and meshes err by as much. On a level face that
changes nothing. Of a slope, or of the ridge of what leans, it makes a strip that nothing touches: a can would stand on
the edge of a slanting slab, and the face of a neighbour hold by friction what it is not pressed to. Here only what is
closer counts. What is not in balance on that turns over the edge of it, until more of it touches and carries it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.geometry.transforms import turned
from tamp.checking.physics.equilibrium import LEVEL
from tamp.checking.physics.round_bodies.perching import round_axes
from tamp.checking.physics.stacks import WITHIN, stack_of
from tamp.checking.physics.support import balanced, carriers, gaps, tipping

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from tamp.checking.scene import Scene, State
    from tamp.checking.tolerances import Tolerances

STEP = 0.001
"""How far the fastest side of a body that gives way moves between two looks [m]."""
LOOKS = 400
"""At a body that gives way."""


def tips_over(scene: Scene, state: State, name: str, allow: Tolerances) -> bool:
    """Whether an object that is let go comes down on what it first touches, and tips over that by more than a little.

    That is more than shifts may come to. Pieces of what is not convex bulge, and nobody knows within a millimetre what
    is touched first: it is not asked about. What slides there, as what is round does in a bowl, is not said to tip.
    """
    if not convex(scene, state, name, allow):
        return False
    lowered = lowered_onto(scene, state, name, allow.standing, allow)
    return _gives(scene, lowered, name, allow.strayed, allow) == "tips"


def let_down(
    scene: Scene, before: State, after: State, names: Iterable[str], allow: Tolerances
) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Which of certain bodies tip over or slide, among others that stay, that did not before a change.

    What is not convex is not asked about, as above.

    Yields:
        Sentence and bodies.
    """
    for name in names:
        if not convex(scene, before, name, allow):
            continue
        how, was = (_gives(scene, state, name, allow.slump, allow) for state in (after, before))
        if how and not was:
            yield f"{name} {how} on what it still touches", (name,)


def on_edge(scene: Scene, state: State, name: str, allow: Tolerances) -> bool:
    """Whether an object on which nothing stands has its middle on the very edge of level faces, or beyond, and tips.

    What is not convex is not asked about, as above; nor is what is round, or stands on that: see `perched`.
    """
    touching = carriers(scene, state, name, allow)
    if not touching.bodies or balanced(scene, state, name, touching, allow) >= allow.balance:
        return False  # nothing else is near an edge
    stack = stack_of(scene, state, name, allow)
    loaded = any(name in stack.below(other) for other in stack.names if other != name)
    touched = carriers(scene, state, name, replace(allow, standing=allow.firm)).patches
    level = all((patch.normals[:, 2] > LEVEL).all() for patch in touched.values())
    if loaded or not (touched and level and convex(scene, state, name, allow)):
        return False
    if any(round_axes(scene, state, body) for body in (name, *touched) if body in state.poses):
        return False
    return _gives(scene, state, name, allow.strayed, allow, WITHIN) == "tips"


def convex(scene: Scene, state: State, name: str, allow: Tolerances) -> bool:
    """Whether an object, and all that it touches, is of one piece."""
    touched = (name, *carriers(scene, state, name, allow).patches)
    return all(len(scene.solids[body].pieces) == 1 for body in touched)


def _gives(scene: Scene, state: State, name: str, most: float, allow: Tolerances, least: float | None = None) -> str:
    """How an object gives way until what it really touches carries it: "" where that is by so much at `most` [m].

    It is carried where its middle is `least` within the edge of that, or else as much beyond that as balance may err.
    """
    wanted = -allow.balance if least is None else least
    there, tight = replace(state, poses=dict(state.poses), touching={}), replace(allow, standing=allow.firm)
    began, angle = state.poses[name], STEP / scene.solids[name].radius
    for _ in range(LOOKS):
        touching = carriers(scene, there, name, tight)
        if not touching.patches:
            there = lowered_onto(scene, there, name, most, allow)
            touching = carriers(scene, there, name, tight)
        if balanced(scene, there, name, touching, allow, max(wanted, 0.0)) >= wanted:
            return ""
        if (over := tipping(touching, scene.center_of_mass(name, there.poses[name]), max(wanted, 0.0))) is None:
            return "slides"
        there.poses[name] = turned(there.poses[name], *over, angle)
        if scene.displacement(name, began, there.poses[name]) > most:
            return "tips"
    return "tips"


def lowered_onto(scene: Scene, state: State, name: str, most: float, allow: Tolerances) -> State:
    """The same with an object straight down where it first touches something, if it is no higher than `most` [m]."""
    gap = min(gaps(scene, state, name, allow).values(), default=np.inf)
    if not 0.0 < gap <= most:
        return state
    lowered = state.poses[name].copy()
    lowered[2, 3] -= gap
    return replace(state, poses={**state.poses, name: lowered}, touching={})
