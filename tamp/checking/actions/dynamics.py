"""Do the fingers hold an object as they close, and all along a motion, against its weight and what speeds it up?

Force and moment that friction holds at once lie within an ellipsoid about (Howe and Cutkosky, International Journal of
Robotics Research 15(6), 1996). Pads are taken to press evenly.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.geometry.transforms import inverse
from tamp.checking.physics import equilibrium
from tamp.checking.physics.contacts import contacts
from tamp.checking.robot.cubic import interpolate
from tamp.checking.scene import GRAVITY, Scene
from tamp.task.robot import LEAST_FRICTION, PAD_FRICTION

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from tamp.checking.scene import Hold
    from tamp.task.plan import Attachment, Grip, Move, Trajectory

    Array = NDArray[np.float64]

ACROSS = 41
"""Places across a pad that stand for all of it."""
EASY = 0.1
"""A moment that fingers hold wherever they are found to touch: that is known within millimetres [N m]."""
PRIED = 1.1
"""So many times the fingers' force is more than they press with, for certain."""
NEAR = 0.002
"""What is no farther from the fingers than this may be where they touch what they close on [m]."""
FACING = 0.5
"""Cosine between the closing axis and a face that the fingers touch by theirs."""
FIRM = 0.88
"""Share of what friction holds beside a slope that is counted on.

Two simulators kept what asks for 0.87 of it, one lost what asks for 0.9, both what asks for all.
"""
STEEP = 0.05
"""The tangent of the least slope that is asked about: meshes are no smoother."""
PERIOD = 0.005
"""Between two looks at how fast something moves, at least [s]."""


def unheld(scene: Scene, grip: Grip, T_world_tool: Array, T: Array) -> Iterator[str]:
    """Why two fingers that press with all their force do not carry an object at T by friction, or let it swing down.

    Pads that press with their corners alone, across from each other, resist a turn about the closing axis the most.
    """
    name, tree, gripper = grip.attachment.object, scene.links.tree, scene.links.tree.spec.gripper
    if grip.force is not None and not 0.0 < grip.force <= gripper.force:
        yield f"the fingers cannot press with {grip.force:.1f} N: the most is {gripper.force:.1f} N"
        return
    weight = GRAVITY * scene.task.object(name).mass
    held = PAD_FRICTION * scene.friction(name) * gripper.force
    if PAD_FRICTION * scene.friction(name) < LEAST_FRICTION:
        yield f"{name} slips out of the fingers, whose friction with it is below {LEAST_FRICTION}"
    if weight > 2 * held:
        yield f"{name} weighs {weight:.1f} N, the fingers carry {2 * held:.1f} N by friction"
    pads = T_world_tool[:3, :3] @ (0.0, 0.0, tree.pad_depth(grip.width)) + T_world_tool[:3, 3]
    lever = scene.center_of_mass(name, T) - pads
    moment = abs(float(np.cross(T_world_tool[:3, :3] @ gripper.axis, lever)[2])) * weight
    resists = held * float(np.hypot(*gripper.pad[1:]))
    if moment > resists:
        sentence = f"{name} swings down in the fingers: its weight turns it by {moment:.2f} N m"
        yield f"{sentence}, they resist {resists:.2f} N m by friction"


def loosened(scene: Scene, held: Attachment, move: Move, times: Array) -> Iterator[str]:
    """Why an object would slip in fingers that press with all their force, as the arm moves.

    Args:
        scene: the world.
        held: what is held, and where in the hand.
        move: the motion.
        times: when it is looked at, so often that nothing moves far in between, shape (n,) [s].
    """
    tree, gripper, thing = scene.links.tree, scene.links.tree.spec.gripper, scene.task.object(held.object)
    moments = _spaced(move.trajectory, times)
    tools = tree.tool(interpolate(move.trajectory, moments))
    center = scene.center_of_mass(held.object, held.T_tool_object.matrix)
    lever = center - (0.0, 0.0, tree.pad_depth(move.opening))
    speeding = _accelerations(tools[:, :3, :3] @ center + tools[:, :3, 3], moments)
    forces = thing.mass * (speeding + np.array([0.0, 0.0, GRAVITY]))
    axes, turns = (tools[:, :3, :3] @ part for part in (np.array(gripper.axis), np.cross(gripper.axis, lever)))
    pulled = np.linalg.norm(forces - (forces * axes).sum(axis=1)[:, None] * axes, axis=1)
    spun = _torques(scene.inertia(held.object), tools[:, :3, :3] @ held.T_tool_object.matrix[:3, :3], moments)
    turned = np.abs((forces * turns + spun * axes).sum(axis=1))
    most = 2 * PAD_FRICTION * thing.friction * gripper.force
    x, y = np.meshgrid(*(np.linspace(-side / 2, side / 2, ACROSS) for side in gripper.pad[1:]))
    resisted = most * float(np.hypot(x, y).mean())
    worst = int(((pulled / most) ** 2 + (turned / resisted) ** 2).argmax())
    if (pulled[worst] / most) ** 2 + (turned[worst] / resisted) ** 2 > 1.0:
        asked = f"a {move.phase} motion pulls by {pulled[worst]:.1f} N and turns it by {turned[worst]:.2f} N m"
        yield f"{held.object} slips in the fingers: {asked}, friction holds {most:.1f} N or {resisted:.2f} N m"


def squeezed_off(scene: Scene, held: Attachment, hold: Hold, move: Move, times: Array) -> Iterator[str]:
    """Why an object would slip off pads whose rims press on slopes, as the arm moves: they squeeze it out themselves.

    Of friction that much is left to carry it, see `_left`. Other arguments as of `loosened`.
    """
    if max(float(np.linalg.norm(slope)) for slope in hold.slopes) < STEEP:
        return
    tree, thing, axis = scene.links.tree, scene.task.object(held.object), np.array(scene.links.tree.spec.gripper.axis)
    moments = _spaced(move.trajectory, times)
    tools = tree.tool(interpolate(move.trajectory, moments))
    center = scene.center_of_mass(held.object, held.T_tool_object.matrix)
    speeding = _accelerations(tools[:, :3, :3] @ center + tools[:, :3, 3], moments)
    forces = thing.mass * np.einsum("nji,nj->ni", tools[:, :3, :3], speeding + np.array([0.0, 0.0, GRAVITY]))
    along = forces - np.outer(forces @ axis, axis)
    pulled = np.linalg.norm(along, axis=1)
    ways = along / np.maximum(pulled, 1e-9)[:, None]
    left = [_left(slope, ways, PAD_FRICTION * thing.friction) for slope in hold.slopes]
    holds = hold.force * np.sum(left, axis=0)
    worst = int((pulled - FIRM * holds).argmax())
    if pulled[worst] > FIRM * holds[worst]:
        slope = np.degrees(np.arctan(max(float(np.linalg.norm(each)) for each in hold.slopes)))
        asked = f"a {move.phase} motion pulls by {pulled[worst]:.1f} N, {max(holds[worst], 0.0):.1f} N hold it"
        yield f"{held.object} slips off the pads, whose rims press on a slope of {slope:.0f} degrees: {asked}"


def _left(slope: Array, ways: Array, friction: float) -> Array:
    """What one pad holds an object with along unit vectors, shape (n, 3), as shares of what it presses with, (n,).

    A rim on a slope of tangent s pushes the object out by s. The friction that makes up for that, and for a force aside
    of it, holds the rest; straight against that it is the tangent of what the slope is less steep than friction's cone.
    """
    steep = float(np.linalg.norm(slope))
    against = ways @ slope
    aside = friction**2 - steep**2 + against**2
    left: Array = (np.sqrt(np.maximum(aside, 0.0)) + against) / (1.0 + friction * steep)
    return left


def pried_open(scene: Scene, held: Attachment, move: Move, times: Array) -> Iterator[str]:
    """Why an object would turn between the fingers, and pry them apart, as the arm moves.

    Arguments as of `loosened`. The fingers' faces touch it where they are near it, press straight on, each with all its
    force at most, and wherever they like: a linear program asks for pushes within friction that carry it.
    """
    tree, gripper, thing = scene.links.tree, scene.links.tree.spec.gripper, scene.task.object(held.object)
    moments = _spaced(move.trajectory, times)
    tools = tree.tool(interpolate(move.trajectory, moments))
    center = scene.center_of_mass(held.object, held.T_tool_object.matrix)
    speeding = _accelerations(tools[:, :3, :3] @ center + tools[:, :3, 3], moments)
    forces = thing.mass * np.einsum("nji,nj->ni", tools[:, :3, :3], speeding + np.array([0.0, 0.0, GRAVITY]))
    lever = center - (0.0, 0.0, tree.pad_depth(move.opening))
    turning = np.linalg.norm(np.cross(lever, forces), axis=1)
    if turning.max() < EASY:
        return
    points, sides = _touched(scene, held, move)
    if len({*sides.tolist()}) < 2:
        return  # that the fingers close on it is asked elsewhere
    normals = sides[:, None] * np.array(gripper.axis)
    friction = PAD_FRICTION * thing.friction
    for worst in sorted({int(turning.argmax()), int(np.linalg.norm(forces, axis=1).argmax())}):
        pushed = equilibrium.pressed(points - center, normals, friction, forces[worst])
        if pushed > PRIED * gripper.force:
            asked = "more than any force" if np.isinf(pushed) else f"{pushed:.0f} N"
            turned = f"{held.object} pries the fingers open as it turns in them"
            yield f"{turned}: a {move.phase} motion asks {asked} of each, they press with {gripper.force:.0f} N"
            return


def _touched(scene: Scene, held: Attachment, move: Move) -> tuple[Array, Array]:
    """Where the fingers are near what they hold, in the tool frame, shape (n, 3), and to which side they press there.

    Of each finger's places those are left out that lie between others.
    """
    tree = scene.links.tree
    placed = tree.forward(move.trajectory.positions[:1], move.opening)
    T_tool_world = inverse(tree.tool(move.trajectory.positions[:1])[0])
    hand = {s.name: (s, T_tool_world @ placed[s.name][0]) for s in scene.links.solids if s.name in scene.links.gripper}
    solid, T = scene.solids[held.object], held.T_tool_object.matrix
    points, sides = [np.empty((0, 3))], [np.empty(0)]
    for patch in contacts(solid, T, hand, NEAR).patches.values():
        along = patch.normals @ tree.spec.gripper.axis
        for side in (1.0, -1.0):
            facing = patch.points[side * along > FACING]
            if not len(facing):
                continue
            kept = equilibrium.outermost(facing, np.tile(tree.spec.gripper.axis, (len(facing), 1)))
            points.append(facing[kept])
            sides.append(np.full(len(kept), side))
    return np.concatenate(points), np.concatenate(sides)


def _spaced(trajectory: Trajectory, times: Array) -> Array:
    """Times at least a period apart, wherever it is looked at, from the start to the end, shape (n,) [s]."""
    end = trajectory.duration
    spaced = PERIOD * np.unique(np.floor(times / PERIOD))
    return np.append(spaced[spaced < end - PERIOD / 2], end) if end > PERIOD else np.array([0.0, end])


def _accelerations(path: Array, times: Array) -> Array:
    """How a point (n, 3) that begins and ends at rest is accelerated at each time, shape (n, 3) [m/s^2]."""
    still, dt = np.zeros((1, 3)), np.diff(times)
    rates = np.concatenate([still, np.diff(path, axis=0) / dt[:, None], still])
    between = np.concatenate([dt[:1] / 2, (dt[1:] + dt[:-1]) / 2, dt[-1:] / 2])
    found: Array = np.diff(rates, axis=0) / between[:, None]
    return found


def _torques(inertia: Array, turns: Array, times: Array) -> Array:
    """The moments that turn a body, which begins and ends at rest, as it goes on, at each time, shape (n, 3) [N m].

    Args:
        inertia: its tensor in its own frame, shape (3, 3) [kg m^2].
        turns: R_world_body at each time, shape (n, 3, 3).
        times: shape (n,) [s].
    """
    still, dt = np.zeros((1, 3)), np.diff(times)
    R = turns[1:] @ turns[:-1].transpose(0, 2, 1)
    rates = np.stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], axis=1) / 2
    rates /= dt[:, None]
    momenta = np.einsum("nij,jk,nlk,nl->ni", turns[1:], inertia, turns[1:], rates)
    between = np.concatenate([dt[:1] / 2, (dt[1:] + dt[:-1]) / 2, dt[-1:] / 2])
    found: Array = np.diff(np.concatenate([still, momenta, still]), axis=0) / between[:, None]
    return found
