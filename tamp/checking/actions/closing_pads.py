"""What closing pads do to an object besides holding it: they draw it half-way between them, and turn it flush.

What it meets on that way it pushes; and it is carried, and put down, as it lies then.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.actions.collisions.pairs import SLIDING
from tamp.checking.actions.collisions.strike import pushed_over
from tamp.checking.geometry.pad_region import between_pads, laid_flush, pressed_slopes
from tamp.checking.geometry.solids import clearance
from tamp.checking.geometry.transforms import inverse, rotation, turned
from tamp.checking.physics.support import carriers
from tamp.checking.robot.sweep import Mover, passed, standing, touches
from tamp.checking.scene import GRAVITY, TABLE, Hold, Scene, State
from tamp.task.robot import PAD_FRICTION

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.checking.actions.arm_motion import Report
    from tamp.checking.tolerances import Tolerances
    from tamp.task.plan import Grip

    Array = NDArray[np.float64]

CLOSING = 0.05
"""How fast pads close, about [m/s]."""

MOST_LOOKS = 200
"""At an object on its way, however long it is."""

UP = np.array([0.0, 0.0, 1.0])

ASIDE = 1e-4
"""By less, in all that nothing explains, an object is aside nowhere [m]."""

ROUNDING = 1e-6
"""Of poses [m]."""

CARRIES = 0.5
"""Vertical component of a contact normal from which on an object stands on what it touches, or in it."""


def laid_between(scene: Scene, name: str, T_tool_object: Array, width: float, opening: float) -> Array | None:
    """Where an object lies in the tool frame, shape (4, 4), when pads have closed on it: flush, half-way between.

    None where they close on nothing.
    """
    tree, gripper, solid = scene.links.tree, scene.links.tree.spec.gripper, scene.solids[name]
    depth, mu = tree.pad_depth(width), PAD_FRICTION * scene.friction(name)
    lies = laid_flush(solid, T_tool_object, gripper, opening, mu, depth)
    if (found := between_pads(solid, lies, gripper, opening, depth)) is None:
        return None
    drawn = lies.copy()
    drawn[:3, 3] -= sum(found) / 2 * np.array(gripper.axis)
    return drawn


def hold_of(scene: Scene, grip: Grip, T_tool_object: Array, opening: float) -> Hold:
    """How the pads hold what a grip closes on."""
    thing, tree, gripper = scene.task.object(grip.attachment.object), scene.links.tree, scene.links.tree.spec.gripper
    _, force = gripper.pressing(GRAVITY * thing.mass, thing.friction, grip.force)
    solid, depth = scene.solids[thing.name], tree.pad_depth(grip.width)
    return Hold(force, pressed_slopes(solid, T_tool_object, gripper, opening, depth))


def drawn_along(scene: Scene, name: str, T_tool_object: Array, lies: Array | None) -> float:
    """How far closing pads take an object's centre of mass from T_tool_object to where it `lies`, if they do [m]."""
    if lies is None:
        return 0.0
    off = scene.center_of_mass(name, lies) - scene.center_of_mass(name, T_tool_object)
    return float(np.linalg.norm(off))


def check_drawn(
    scene: Scene, state: State, name: str, said: Array, lies: Array | None, allow: Tolerances, report: Report
) -> None:
    """What is gripped pushes nothing over as pads turn it, and draw it along, until it is where it `lies`.

    Where they turn it farther than the plan has `said`, T_world_object, or less, it is noted where it lies,
    T_tool_object, from then on. What is of several pieces bulges, and nobody knows for certain how far it turns.
    """
    if lies is None:
        return
    start, end = state.poses[name], scene.links.tree.tool(state.q[None])[0] @ lies
    if len(scene.solids[name].pieces) > 1:
        end[:3, :3] = start[:3, :3]
    path = _way(start, end, scene.solids[name].radius, allow.step)
    for other in [] if path is None else _met(scene, state, Mover(scene.solids[name], path), allow):
        report("collision", f"closing pads turn, or draw, {name} into {other}", bodies=(name, other))
    if is_elsewhere(scene, name, said, end, allow):
        state.stayed[name] = end


def is_elsewhere(scene: Scene, name: str, said: Array, lies: Array, allow: Tolerances) -> bool:
    """Whether an object lies turned otherwise than it is said to: by how far its ends are off, if it is long."""
    return _turn(said, lies)[1] > allow.grasp_angle or scene.swing(name, said, lies) > allow.grasp


def note_lies(scene: Scene, state: State, name: str, held: Array) -> None:
    """Note where an object lies that was let go where it was `held`, if that is not where the plan says.

    So that small ways aside do not add up unseen, the least that is no rounding is noted, as are small turns.
    """
    said, carried = state.poses[name], state.stayed.get(name, held)
    lies = come_down(scene, name, carried, said)
    if name in state.stayed or is_off(scene, state, name, said, lies):
        state.stayed[name] = lies


def note_turned_over(scene: Scene, state: State, name: str, lay: Array, before: Array, after: Array) -> None:
    """Note where an object is that turned over from where it `lay`, and not from `before` to `after`, as it is said to.

    Nothing takes it aside as it turns: it is as far aside afterwards, and as much turned about the vertical.
    """
    way = scene.center_of_mass(name, after) - scene.center_of_mass(name, before)
    veered = _veered(before, lay)
    lies = _beside(scene, name, after, veered, scene.center_of_mass(name, lay) + rotation(UP, veered) @ way)
    state.stayed.pop(name, None)
    if is_aside(scene, state, name, after, lies):
        state.stayed[name] = lies


def is_aside(scene: Scene, state: State, name: str, said: Array, lies: Array) -> bool:
    """Whether an object lies beside where it is said to."""
    off = scene.center_of_mass(name, lies) - scene.center_of_mass(name, said)
    return float(np.hypot(off[0], off[1])) > _least(scene, state, name)


def is_off(scene: Scene, state: State, name: str, said: Array, lies: Array) -> bool:
    """Whether an object is elsewhere than it is said to be: aside, higher or lower, or turned."""
    off = scene.center_of_mass(name, lies) - scene.center_of_mass(name, said)
    return max(float(np.linalg.norm(off)), scene.swing(name, said, lies)) > _least(scene, state, name)


def _least(scene: Scene, state: State, name: str) -> float:
    """How far an object must be elsewhere to be noted [m]: at all, once it is by a tenth of a millimetre in all."""
    crept = state.strayed.get(name, 0.0) + state.turned.get(name, 0.0) * scene.solids[name].radius
    return ASIDE if crept <= ASIDE else ROUNDING


def come_down(scene: Scene, name: str, carried: Array, said: Array) -> Array:
    """Where an object lies that was let go where it was `carried` in truth: as it is said to, but where that is aside.

    Nothing turns it about the vertical, or takes it aside, as it comes down.
    """
    return _beside(scene, name, said, _veered(said, carried), scene.center_of_mass(name, carried))


def _beside(scene: Scene, name: str, T: Array, veered: float, center: Array) -> Array:
    """A pose turned about the vertical by an angle [rad], with the centre of mass over a place, shape (3,)."""
    moved = turned(T, scene.center_of_mass(name, T), UP, veered)
    moved[:2, 3] += (center - scene.center_of_mass(name, T))[:2]
    return moved


def _veered(before: Array, after: Array) -> float:
    """By how much the turn from one pose to another, near each other, is about the vertical [rad]."""
    R = after[:3, :3] @ before[:3, :3].T
    return float(np.arctan2(R[1, 0] - R[0, 1], R[0, 0] + R[1, 1]))


def _way(start: Array, end: Array, radius: float, step: float) -> Array | None:
    """Poses from one to another, shape (n, 4, 4), no farther apart than a step; None where it is no way at all."""
    axis, angle = _turn(start, end)
    far = float(np.linalg.norm(end[:3, 3] - start[:3, 3])) + radius * angle
    if far < SLIDING:
        return None
    shares = np.linspace(0.0, 1.0, max(int(np.ceil(min(far / step, MOST_LOOKS))), 2) + 1)
    path = np.tile(np.eye(4), (len(shares), 1, 1))
    path[:, :3, :3] = [rotation(axis, share * angle) @ start[:3, :3] for share in shares]
    path[:, :3, 3] = start[:3, 3] + shares[:, None] * (end[:3, 3] - start[:3, 3])
    return path


def _turn(before: Array, after: Array) -> tuple[Array, float]:
    """Axis, a unit vector in the world, and angle of the turn between two poses, less than a right one [rad]."""
    R = after[:3, :3] @ before[:3, :3].T
    sines = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2
    sine = float(np.linalg.norm(sines))
    return sines / max(sine, 1e-12), float(np.arcsin(min(sine, 1.0)))


def _met(scene: Scene, state: State, drawn: Mover, allow: Tolerances) -> list[str]:
    """What an object meets as it is drawn along, or pushes within tolerance, so that it rolls or tips over.

    What it stands or leans on, such as the rack that it is taken from, is not asked about.
    """
    pairs, rest = [], state.without(drawn.solid.name)
    under = carriers(scene, state, drawn.solid.name, allow).patches.items()
    spared = {other for other, patch in under if (patch.normals[:, 2] > CARRIES).any()}
    for other in passed([drawn], standing(scene.solids, rest.standing(scene))):
        if other.solid.name not in {TABLE, *spared}:
            deep = -clearance(other.solid, drawn.solid, inverse(other.T[0]) @ drawn.T[0], allow.contact)
            pairs.append((other, drawn, max(deep, 0.0) + allow.collision))
    met = {touch.bodies[0] for touch in touches(pairs)}
    way = float(np.linalg.norm(np.diff(drawn.center, axis=0), axis=1).sum())
    times = np.linspace(0.0, max(way, SLIDING) / CLOSING, len(drawn.T))
    return sorted({*met, *(name for _, name in pushed_over(scene, rest, pairs, met, times, allow))})
