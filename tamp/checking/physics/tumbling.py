"""Where does something that tips over by itself, on a level face with nothing beside it, come to rest?

It turns over one edge after the other. Where friction holds it its edge stays, and on ice its centre of mass falls
straight down; in between nobody knows how far it slides, but no farther than it was seen to in two simulators.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.geometry.solids import clearance
from tamp.checking.geometry.transforms import inverse, tilt, turned, veer
from tamp.checking.physics.righting import FAN, TOUCHING, UP, Tip, on_level_face, tips
from tamp.checking.physics.round_bodies.perching import round_axes
from tamp.checking.physics.support import carriers, height_above

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from tamp.checking.scene import Scene, State
    from tamp.checking.tolerances import Tolerances

    Array = NDArray[np.float64]

CERTAIN = 0.003
"""How far beyond what it stands on a centre of mass is that tips to that side for certain [m]."""
SLIGHT = 0.1
"""A turn by less, as a share of the largest, decides nothing."""
TILTED = 0.15
"""How far from flat it may lie in the end [rad]."""
VEERED = 0.4
"""How far it turns about the vertical as it falls over a corner [rad]."""
PASSED = 0.3
"""Share of the energy of a turn that may take it over the next edge ahead."""
STAYS, STICKS, LEANS = 0.8, 1.5, 0.6
"""Share of all that an edge slides on ice: that of what stands upright, less for friction, more for each rad of lean.

It bounds what 250 boxes and cylinders did, let go or settling, in two simulators, with friction of 0.1 to 1.
"""
LEAST = 0.05
AHEAD = 0.5
"""Cosine to the way of a turn within which it may go on."""
BETWEEN = 4
"""Poses at which a turn is looked at."""


def tumbled(scene: Scene, state: State, name: str, fallen: Array, drop: float, allow: Tolerances) -> float | None:
    """How far an object is from where it can come to rest as it tips over [m], 0 if not; None where nobody knows that.

    Args:
        scene: the bodies.
        state: where all of them are said to be at rest.
        name: the object.
        fallen: where it has come down, T_world_object, shape (4, 4).
        drop: by how much [m].
        allow: tolerances.
    """
    there = replace(state, poses={**state.poses, name: fallen}, touching={})
    every = list(tips(scene, name, fallen))
    turns = [tip for tip in every if tip.angle > SLIGHT * max(tip.angle for tip in every)]
    if not turns or not on_level_face(scene, there, name, allow):
        return None
    if min(tip.beyond for tip in turns) < CERTAIN or not _alone(scene, there, name, fallen, turns, allow):
        return None
    last = every[-1]
    flat = replace(state, poses={**state.poses, name: last.pose}, touching={})
    if not on_level_face(scene, flat, name, allow):
        return None
    said, spread = state.poses[name], allow.settling + drop
    began, ended, rests = (scene.center_of_mass(name, T) for T in (fallen, said, last.pose))
    if float((began - ended) @ turns[0].ahead) > spread:
        return scene.displacement(name, last.pose, said)
    if round_axes(scene, flat, name) or _goes_on(scene, name, last.pose, turns, float(began[2] - rests[2]) + drop):
        return None
    if tilt(last.pose, said) > TILTED or veer(last.pose, said) > VEERED:
        return scene.displacement(name, last.pose, said)
    (under,) = carriers(scene, there, name, allow).bodies
    lean = float(np.arctan2(turns[0].beyond, began[2] - turns[0].pivot[2]))
    slid = rests + sliding(scene.friction(name) * scene.friction(under), lean) * (began - rests)
    return max(_beside(ended[:2], slid[:2], rests[:2]) - spread, 0.0)


def sliding(friction: float, lean: float) -> float:
    """How far an edge slides at most that something falls over, as a share of how far it would on ice.

    Args:
        friction: coefficient of the contact.
        lean: angle by which the centre of mass is beyond the edge at first [rad].
    """
    return float(np.clip(STAYS - STICKS * friction + LEANS * lean, LEAST, 1.0))


def _alone(scene: Scene, state: State, name: str, fallen: Array, turns: Sequence[Tip], allow: Tolerances) -> bool:
    """Whether an object comes near nothing but what is under it as it turns over."""
    (under,) = carriers(scene, state, name, allow).bodies
    others = [other for other in state.standing(scene) if other not in (name, under)]
    at = fallen
    for tip in turns:
        axis = np.cross(UP, tip.ahead)
        for share in np.linspace(0.0, 1.0, BETWEEN):
            T = turned(at, tip.pivot, axis, float(share) * tip.angle)
            for other in others:
                apart = inverse(state.standing(scene)[other]) @ T
                if clearance(scene.solids[other], scene.solids[name], apart, allow.settling) < allow.settling:
                    return False
        at = tip.pose
    return True


def _goes_on(scene: Scene, name: str, T: Array, turns: Sequence[Tip], energy: float) -> bool:
    """Whether an object that has come to lie at T may turn over the next edge ahead by what is left of its energy.

    That is given by how far its centre of mass has come down [m].
    """
    corners = scene.solids[name].hull.part.vertices @ T[:3, :3].T + T[:3, 3]
    touching = corners[corners[:, 2] < corners[:, 2].min() + TOUCHING]
    reach = ((touching - scene.center_of_mass(name, T))[:, :2] @ FAN).max(axis=0)
    onwards = np.max([tip.ahead[:2] @ FAN for tip in turns], axis=0) > AHEAD
    height, least = height_above(scene, name, T), float(reach[onwards].min())
    return bool(reach.min() < CERTAIN or np.hypot(least, height) - height < PASSED * energy)


def _beside(point: Array, a: Array, b: Array) -> float:
    """Distance of a point of the plane from the segment between two others, shape (2,) each [m]."""
    along = b - a
    share = np.clip(float((point - a) @ along) / max(float(along @ along), 1e-12), 0.0, 1.0)
    return float(np.linalg.norm(point - a - share * along))
