"""Checks of the two moments that change hands: the grip and the release."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.distances import clearance
from tamp.checking.grasp import between_pads
from tamp.checking.motion import finger_touches, sentence_of
from tamp.checking.scene import Scene, State
from tamp.checking.slumping import slumps
from tamp.checking.standing import balanced, carriers, overlaps, unrest
from tamp.checking.transforms import inverse

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.checking.motion import Report
    from tamp.checking.tolerances import Tolerances
    from tamp.task.plan import Grip, Release

    Array = NDArray[np.float64]


def check_grip(scene: Scene, state: State, grip: Grip, allow: Tolerances, report: Report) -> None:
    """Judge the closing of the fingers; afterwards the object is held."""
    name = grip.attachment.object
    if state.held is not None:
        report("precondition", f"grips {name} while holding {state.held.object}", bodies=(name, state.held.object))
        return
    gripper = scene.links.tree.spec.gripper
    opening = gripper.stroke if state.opening is None else state.opening
    T_world_tool = scene.links.tree.tool(state.q[None])[0]
    T_tool_object = inverse(T_world_tool) @ state.poses[name]
    check_attachment(scene, name, T_tool_object, grip.attachment.T_tool_object.matrix, allow, report)
    if not 0.0 <= grip.width <= gripper.stroke:
        report("grasp", f"a width of {grip.width:.4f} m is outside the stroke of {gripper.stroke} m", bodies=(name,))
    elif grip.width > opening + 1e-6:
        report("grasp", f"the fingers are {opening:.4f} m apart and cannot close to {grip.width:.4f} m", bodies=(name,))
    else:
        _check_closing(scene, name, T_tool_object, grip.width, opening, allow, report)
        for touch in finger_touches(scene, state, opening, grip.width, {name: allow.contact}, allow):
            report("collision", f"the closing fingers: {sentence_of(touch)}", touch.bodies, touch.depth)
    check_uncovered(scene, state, name, allow, report)
    state.held = grip.attachment
    state.opening = grip.width
    state.poses[name] = T_world_tool @ grip.attachment.T_tool_object.matrix


def check_release(
    scene: Scene, state: State, release: Release, allow: Tolerances, report: Report, *, falls: bool = False
) -> None:
    """Judge the opening of the fingers; afterwards the object stands where the release says, or `falls` from there."""
    name = release.object
    gripper = scene.links.tree.spec.gripper
    if state.held is None or state.held.object != name:
        holds = "nothing" if state.held is None else state.held.object
        report("precondition", f"releases {name} while the gripper holds {holds}", bodies=(name,))
        return
    if not 0.0 <= release.opening <= gripper.stroke + 1e-6:
        report("limits", f"an opening of {release.opening:.4f} m is outside the stroke of {gripper.stroke} m")
    elif release.opening <= (state.opening or 0.0):
        report("release", f"the fingers do not open: {name} is not let go", bodies=(name,))
    T = release.pose.matrix
    dropped = scene.displacement(name, state.poses[name], T)
    if dropped > allow.drop:
        sentence = f"{name} is let go {1000 * dropped:.0f} mm from where it is said to stand"
        report("release", sentence, bodies=(name,), depth=dropped)
    before = gripper.stroke if state.opening is None else state.opening
    state.held = None
    state.opening = release.opening
    state.poses[name] = T
    for touch in finger_touches(scene, state, before, release.opening, {name: allow.contact}, allow):
        report("collision", f"the opening fingers: {sentence_of(touch)}", touch.bodies, touch.depth)
    for sentence, bodies, depth in (overlaps if falls else unrest)(scene, state, name, allow):
        report("support", sentence, bodies=bodies, depth=depth)


def check_attachment(scene: Scene, name: str, actual: Array, claimed: Array, allow: Tolerances, report: Report) -> None:
    """An object lies in the tool frame, T_tool_object of shape (4, 4), where a step claims that it does."""
    center = np.append((scene.solids[name].lower + scene.solids[name].upper) / 2, 1.0)
    shift = float(np.linalg.norm(((actual - claimed) @ center)[:3]))
    trace = float(np.trace(actual[:3, :3].T @ claimed[:3, :3]))
    angle = float(np.arccos(np.clip((trace - 1) / 2, -1.0, 1.0)))
    if shift > allow.grasp or angle > allow.grasp_angle:
        sentence = f"{name} lies {1000 * shift:.1f} mm and {np.degrees(angle):.1f} degrees from where the plan says"
        report("grasp", sentence, bodies=(name,), depth=shift)


def _check_closing(
    scene: Scene, name: str, T_tool_object: Array, width: float, opening: float, allow: Tolerances, report: Report
) -> None:
    found = between_pads(scene.solids[name], T_tool_object, scene.links.tree.spec.gripper, opening)
    if found is None:
        report("grasp", f"the fingers close on nothing: {name} is not between the pads", bodies=(name,))
        return
    astray = max(abs(found[1] - width / 2), abs(found[0] + width / 2))
    if astray > allow.pad:
        sentence = (
            f"{name} fills {1000 * found[0]:.1f} to {1000 * found[1]:.1f} mm between the pads, which close to "
            f"{1000 * width:.1f} mm"
        )
        report("grasp", sentence, bodies=(name,), depth=astray)


def check_uncovered(scene: Scene, state: State, name: str, allow: Tolerances, report: Report) -> None:
    """Nothing that stands on the object may fall when it leaves; it may slump to where the rest carries it."""
    for other in sorted(state.poses):
        T = inverse(state.poses[name]) @ state.poses[other]
        if other == name or clearance(scene.solids[name], scene.solids[other], T, allow.contact) > allow.standing:
            continue
        carried = carriers(scene, state, other, allow)
        if name not in carried.bodies:
            continue
        if balanced(scene, state, other, carried.without(name), allow) >= allow.balance:
            continue
        if not slumps(scene, state, other, name, allow):
            report("precondition", f"{other} stands on {name}, which is taken away", bodies=(name, other))
