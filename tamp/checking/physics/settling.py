"""What settling explains of the difference between where an object is written and where it is said to stand.

An object that is written in the air falls straight down until it touches something. Where it is in balance there it
stays, and does not turn about the vertical; where it is not, or only just, it may tip or roll on, down and as far aside
as it turns or has fallen. What is perfectly round, and comes down on what does not slope, rolls nowhere by itself. What
is written inside another body is pushed out, and a heap of which one body settles may jostle its others a little.
Nothing else moves by itself.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.geometry.solids import clearance, parting_normals
from tamp.checking.geometry.transforms import inverse, rotation, tilt, veer
from tamp.checking.physics.equilibrium import along
from tamp.checking.physics.round_bodies.perching import ROUND, STEEP, perched
from tamp.checking.physics.support import balanced, carriers, height_above, stays_after
from tamp.checking.physics.tumbling import tumbled

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from tamp.checking.scene import Scene, State
    from tamp.checking.tolerances import Tolerances

    Array = NDArray[np.float64]

LANDED = 5e-4
"""What is nearer than this to another body has come down on it [m]."""
LOOKS = 200
"""Of a fall; each falls by what is certainly free."""
SLIPS = 0.5
"""How far along a wall something goes that is pushed out of it, as a share of that."""


def unexplained(scene: Scene, state: State, name: str, written: Mapping[str, Array], allow: Tolerances) -> float:
    """How far an object is from where settling may have left it, as the score measures displacements [m]; 0 if not.

    Args:
        scene: the bodies.
        state: where all of them are said to stand.
        name: the object.
        written: object -> where the task puts it, T_world_object, shape (4, 4).
        allow: tolerances.
    """
    said, began = state.poses[name], written[name]
    far, veered = scene.displacement(name, began, said), veer(began, said)
    if far <= allow.placed and veered <= allow.veered:
        return 0.0
    inside, fallen = _inside(scene, state, name, written, allow), _fallen(scene, state, name, began, allow)
    pushed = 2 * max(inside, 0.0)
    drop = float(began[2, 3] - fallen[2, 3])
    out = fallen.copy()
    shift = scene.center_of_mass(name, said) - scene.center_of_mass(name, fallen)
    out[:3, 3] += (way := _pushed_out(scene, _as_written(state, written), name, began, shift, pushed))
    slid = SLIPS * float(np.linalg.norm(way))
    left = scene.displacement(name, out, said)
    if left <= min(allow.placed + drop, allow.settling) + slid and veered <= allow.veered:
        return 0.0
    steady = any(stays(scene, state, name, fallen, drop, inside, allow) for stays in (_steady, _firm))
    jostled = _jostled(scene, state, name, written, allow)
    if not (steady or jostled or inside > LANDED):
        tipped = tumbled(scene, state, name, fallen, drop, allow)
        if tipped is not None:
            return tipped
        if _lies_round(scene, state, name, fallen, written, allow):
            return left
    if left <= (allow.settling + slid if jostled or not steady else 0.0):
        return 0.0
    if left <= allow.jostling and any(_moves(scene, state, other, written, allow) for other in jostled):
        return 0.0
    if steady:
        return max(left, scene.solids[name].radius * veered)
    way = scene.center_of_mass(name, said) - scene.center_of_mass(name, fallen)
    rolled = scene.solids[name].radius * tilt(fallen, said)
    aside = float(np.hypot(way[0], way[1])) - allow.settling - drop - rolled
    risen = max(float(way[2]), _righted(scene, name, fallen, said)) - allow.settling - pushed
    beyond = max(aside, far - allow.falling, risen)
    return beyond if beyond > 0.0 else 0.0


def stayed(scene: Scene, state: State, name: str, written: Mapping[str, Array], allow: Tolerances) -> Array | None:
    """Where an object stays, as far as anybody can tell, that is said to start a little elsewhere; None of all others.

    That is, shape (4, 4), straight below where it is written, after a drop of `allow.settling` at most. What is written
    in another body by no more than noise is pushed out of that by no more than twice as much.

    Arguments as of `unexplained`.
    """
    if scene.displacement(name, written[name], state.poses[name]) <= allow.collision:
        return None
    inside, fallen = _inside(scene, state, name, written, allow), _fallen(scene, state, name, written[name], allow)
    drop = float(written[name][2, 3] - fallen[2, 3])
    pushed = 2 * inside if inside > LANDED else 0.0
    if scene.displacement(name, fallen, state.poses[name]) <= allow.collision + pushed:
        return None
    if drop > allow.settling or inside > allow.collision or _jostled(scene, state, name, written, allow):
        return None
    if any(_passed_by(scene, state, name, other, written, allow) for other in sorted(written) if other != name):
        return None
    if drop > allow.dropped:
        return fallen if _steady(scene, state, name, fallen, drop, inside, allow) else None
    there = replace(state, poses={**state.poses, name: fallen}, touching={})
    resting = balanced(scene, there, name, carriers(scene, there, name, allow), allow) >= allow.balance
    return fallen if resting and not any(True for _ in perched(scene, there, name, allow)) else None


def _passed_by(
    scene: Scene, state: State, name: str, other: str, written: Mapping[str, Array], allow: Tolerances
) -> bool:
    """Whether an object may have been struck by another that is said to settle by more than a little, and came near."""
    if not _moves(scene, state, other, written, allow):
        return False
    reach = scene.displacement(other, written[other], state.poses[other]) + allow.jostling
    ways = (inverse(poses[name]) @ poses[other] for poses in (written, state.poses))
    return any(clearance(scene.solids[name], scene.solids[other], T, allow.contact) <= reach for T in ways)


def _righted(scene: Scene, name: str, before: Array, after: Array) -> float:
    """How much higher above a plane a body's centre of mass is after a turn than half-way: it would have stayed there.

    What rolls is no higher in the end than on its way, and what falls over is lower.
    """
    R = after[:3, :3] @ before[:3, :3].T
    axis = np.linalg.eigh(R + R.T)[1][:, -1]
    skew = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    angle = float(np.arccos(np.clip((np.trace(R) - 1) / 2, -1.0, 1.0))) * (-1.0 if skew @ axis < 0.0 else 1.0)
    halfway = np.eye(4)
    halfway[:3, :3] = rotation(axis, angle / 2) @ before[:3, :3]
    return height_above(scene, name, after) - height_above(scene, name, halfway)


def _as_written(state: State, written: Mapping[str, Array]) -> State:
    """The scene as the task has it: no plan says what stands in an object's place at first."""
    return replace(state, poses={**state.poses, **written}, touching={})


def _inside(scene: Scene, state: State, name: str, written: Mapping[str, Array], allow: Tolerances) -> float:
    """How deep an object is written in others, where these are written [m]; negative where it is apart from them."""
    T = written[name]
    gaps = (
        clearance(scene.solids[other], scene.solids[name], inverse(at) @ T, allow.contact)
        for other, at in _below(scene, _as_written(state, written), name, T)
    )
    return -min(gaps, default=np.inf)


def _fallen(scene: Scene, state: State, name: str, written: Array, allow: Tolerances) -> Array:
    """Where an object that is written somewhere comes down if it falls straight, T_world_object, shape (4, 4)."""
    others, T = _below(scene, state, name, written), written.copy()
    for _ in range(LOOKS):
        gaps = (clearance(scene.solids[o], scene.solids[name], inverse(at) @ T, allow.contact) for o, at in others)
        room = min(gaps, default=np.inf)
        if np.isinf(room):
            room = allow.falling
        if room < LANDED or written[2, 3] - T[2, 3] > allow.falling:
            break
        T[2, 3] -= room
    return T


def _pushed_out(scene: Scene, state: State, name: str, T: Array, shift: Array, most: float) -> Array:
    """The part of a shift, shape (3,), by which an object at T is pushed out of what it is written in, `most` [m].

    It goes to the nearer side, along the normals of the planes that best part it from their pieces.
    """
    normals = [np.zeros(3)]
    for other, at in _below(scene, state, name, T) if most > 0.0 else ():
        found = parting_normals(scene.solids[other], scene.solids[name], inverse(at) @ T)
        normals += [-at[:3, :3] @ normal for normal in found]
    way = along(np.array(normals), shift)
    return way * min(1.0, most / max(float(np.linalg.norm(way)), 1e-12))


def _below(scene: Scene, state: State, name: str, T: Array) -> list[tuple[str, Array]]:
    """Bodies, with where they stand, that an object at T may meet when it falls straight down."""
    body, center = scene.solids[name], T[:3, :3] @ scene.solids[name].center + T[:3, 3]
    found = []
    for other, at in sorted(state.without(name).standing(scene).items()):
        solid = scene.solids[other]
        apart = at[:3, :3] @ solid.center + at[:3, 3] - center
        reach = body.radius + solid.radius
        if float(np.hypot(apart[0], apart[1])) <= reach and apart[2] <= reach:
            found.append((other, at))
    return found


def _steady(scene: Scene, state: State, name: str, T: Array, drop: float, inside: float, allow: Tolerances) -> bool:
    """Whether an object stays where it has come down, however it is jostled, after a drop, or `inside` others [m].

    What was as good as at rest needs half of the margin.
    """
    there = state.without(name)
    there.poses[name] = T
    if any(True for _ in perched(scene, there, name, allow)):
        return False
    resting = drop <= allow.dropped and inside <= LANDED
    least = scene.solids[name].radius * allow.steady * (0.5 if resting else 1.0)
    return stays_after(scene, there, name, allow.bounce * drop, allow, least)


def _firm(scene: Scene, state: State, name: str, T: Array, drop: float, inside: float, allow: Tolerances) -> bool:
    """Whether an object as good as at rest stands firmly, however narrow it is.

    On what all but touches it, it is in balance though it leans a little, or what is left of its drop tips it.
    """
    if drop > allow.dropped or inside > LANDED:
        return False
    there = state.without(name)
    there.poses[name] = T
    height = height_above(scene, name, T)
    tipped = float(np.sqrt((height + allow.bounce * max(drop, 0.0)) ** 2 - height**2))
    margin = max(allow.dropped, float(np.tan(allow.leaning)) * height, tipped)
    touching = carriers(scene, replace(there, touching={}), name, replace(allow, standing=allow.firm))
    if balanced(scene, there, name, touching, allow, margin) < margin:
        return False
    return not any(True for _ in perched(scene, there, name, allow))


def _lies_round(
    scene: Scene, state: State, name: str, T: Array, written: Mapping[str, Array], allow: Tolerances
) -> bool:
    """Whether what is perfectly round has come down at T where nothing makes it roll.

    That is over what carries it, which does not slope, with nothing beside it; and nothing that settles came near.
    """
    there = replace(state, poses={**state.poses, name: T}, touching={})
    touching = carriers(scene, there, name, replace(allow, standing=allow.firm))
    held = any((patch.normals[:, 2] < STEEP).any() for patch in touching.patches.values())
    if held or not isinstance(scene.task.object(name).shape, ROUND):
        return False
    if balanced(scene, there, name, touching, allow, 0.0) < 0.0 or any(
        True for _ in perched(scene, there, name, allow)
    ):
        return False
    return not any(_passed_by(scene, state, name, other, written, allow) for other in sorted(written) if other != name)


def _jostled(scene: Scene, state: State, name: str, written: Mapping[str, Array], allow: Tolerances) -> list[str]:
    """What an object touches, as written or in the end, that cannot stay where it is written."""
    found = []
    for other in sorted(written):
        for poses in (written, state.poses) if other != name else ():
            T = inverse(poses[name]) @ poses[other]
            if clearance(scene.solids[name], scene.solids[other], T, allow.contact) <= allow.standing:
                found.append(other)
                break
    return [other for other in found if _restless(scene, state, other, written, allow)]


def _restless(scene: Scene, state: State, name: str, written: Mapping[str, Array], allow: Tolerances) -> bool:
    """Whether an object settles from where it is written: it overlaps with something, falls, or is out of balance."""
    placed = _as_written(state, written)
    inside, fallen = _inside(scene, placed, name, written, allow), _fallen(scene, placed, name, written[name], allow)
    drop = float(written[name][2, 3] - fallen[2, 3])
    jolted = max(inside, drop) > allow.collision
    return jolted or not _steady(scene, placed, name, fallen, drop, inside, allow)


def _moves(scene: Scene, state: State, name: str, written: Mapping[str, Array], allow: Tolerances) -> bool:
    """Whether an object is said to settle by more than a little."""
    return scene.displacement(name, written[name], state.poses[name]) > allow.settling / 2
