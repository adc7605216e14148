"""Checks of the two moments that change hands: the grip and the release."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.actions.arm_motion import finger_touches, sentence_of
from tamp.checking.actions.closing_pads import (
    UP,
    check_drawn,
    drawn_along,
    hold_of,
    is_elsewhere,
    is_off,
    laid_between,
    note_lies,
)
from tamp.checking.actions.collisions.blow import upset_by_fall
from tamp.checking.actions.collisions.way_down import dropped_through
from tamp.checking.actions.collisions.wedging import jammed
from tamp.checking.actions.deviations import angle_between, check_attachment, check_strayed
from tamp.checking.actions.dynamics import unheld
from tamp.checking.actions.left_standing import check_rest, check_uncovered
from tamp.checking.geometry.pad_region import TURN, between_pads, laid_flush, pressed_slopes, slips_out, squeezed_out
from tamp.checking.geometry.solids import clearance
from tamp.checking.geometry.transforms import inverse, turned
from tamp.checking.physics.equilibrium import LEVEL
from tamp.checking.physics.support import carriers, height_above, overlaps, patch_between, sunk_balance
from tamp.checking.physics.tilting import tilted_off
from tamp.checking.scene import TABLE, Scene, State
from tamp.task.robot import PAD_FRICTION

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from tamp.checking.actions.arm_motion import Report
    from tamp.checking.tolerances import Tolerances
    from tamp.task.plan import Grip, Release

    Array = NDArray[np.float64]

ALIKE = 5e-4
"""What is narrower than what the pads close on by no more than this on each side is as wide [m]."""
RIM = 0.001
"""How much farther than pads may be off an object reaches between them to be held for certain [m]."""
WAYS = 8
"""Aside, in which an object is looked at."""
PRESSED = 2e-4
"""What is no deeper in something does not press on it [m]."""
TURNED = 1e-3
"""By less an object may be turned anywhere [rad]."""


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
    hold = hold_of(scene, grip, T_tool_object, opening)
    check_attachment(scene, name, T_tool_object, grip.attachment.T_tool_object.matrix, allow, report)
    if not 0.0 <= grip.width <= gripper.stroke:
        report("grasp", f"a width of {grip.width:.4f} m is outside the stroke of {gripper.stroke} m", bodies=(name,))
    elif grip.width > opening + 1e-6:
        report("grasp", f"the fingers are {opening:.4f} m apart and cannot close to {grip.width:.4f} m", bodies=(name,))
    else:
        _check_closing(scene, name, T_tool_object, grip.width, opening, allow, report, hold.slopes)
        _check_alone(scene, state, name, grip.width, opening, report)
        for touch in finger_touches(scene, state, opening, grip.width, {name: allow.contact}, allow):
            report("collision", f"the closing fingers: {sentence_of(touch)}", touch.bodies, touch.depth)
    for sentence in unheld(scene, grip, T_world_tool, state.poses[name]):
        report("grasp", sentence, bodies=(name,))
    check_uncovered(scene, state, name, allow, report)
    gripped = T_world_tool @ grip.attachment.T_tool_object.matrix
    check_strayed(scene, state, name, state.poses[name], gripped, allow, report)
    lies = laid_between(scene, name, T_tool_object, grip.width, opening)
    state.beside[name] = float(np.hypot(state.beside.get(name, 0.0), drawn_along(scene, name, T_tool_object, lies)))
    if name not in state.stayed and is_off(scene, state, name, gripped, state.poses[name]):
        state.stayed[name] = state.poses[name]
    state.held, state.hold = grip.attachment, hold
    state.nudged.pop(name, None)
    _check_as_stayed(scene, state, grip, gripped, opening, allow, report)
    check_drawn(scene, state, name, gripped, lies, allow, report)
    state.opening = grip.width if 0.0 <= grip.width <= opening else opening
    state.poses[name] = state.gripped = gripped


def _check_as_stayed(
    scene: Scene, state: State, grip: Grip, gripped: Array, opening: float, allow: Tolerances, report: Report
) -> None:
    """The fingers hold an object also where that stays elsewhere than it is said to.

    It is as much aside in the hand, but for the way that pads close: they draw it to half-way between them.
    """
    name = grip.attachment.object
    if name not in state.stayed:
        return
    tree, there = scene.links.tree, state.stayed[name].copy()
    tool = tree.tool(state.q[None])[0]
    axis = tool[:3, :3] @ tree.spec.gripper.axis
    found = _between(scene, state, name, there, opening, grip.width)
    if found is None:
        off = scene.center_of_mass(name, there) - scene.center_of_mass(name, gripped)
        there[:3, 3] -= axis * (axis @ off)
    else:
        there[:3, 3] -= axis * (sum(found) / 2)
    state.stayed[name] = there

    def say(kind: str, sentence: str, bodies: tuple[str, ...], depth: float = 0.0) -> None:
        report(kind, f"{sentence}, as it stays where the task has it", bodies=bodies, depth=depth)

    _check_closing(scene, name, inverse(tool) @ there, grip.width, opening, allow, say)


def check_release(
    scene: Scene, state: State, release: Release, allow: Tolerances, report: Report, *, falls: bool = False
) -> None:
    """Judge the opening of the fingers; afterwards the object stands where the release says.

    What `falls` does so from where it is held, which is about there.
    """
    name = release.object
    gripper = scene.links.tree.spec.gripper
    if state.held is None or state.held.object != name:
        holds = "nothing" if state.held is None else state.held.object
        report("precondition", f"releases {name} while the gripper holds {holds}", bodies=(name,))
        return
    if not 0.0 <= release.opening <= gripper.stroke + 1e-6:
        report("limits", f"an opening of {release.opening:.4f} m is outside the stroke of {gripper.stroke} m")
        release = replace(release, opening=gripper.stroke)
    elif release.opening < (state.opening or 0.0) + allow.opened:
        report("release", f"the fingers do not open: {name} is not let go", bodies=(name,))
    held, T = state.poses[name], release.pose.matrix
    for _, (_, other), depth in overlaps(scene, state, name, allow):
        report("release", f"{name} is pressed {1000 * depth:.1f} mm into {other}", bodies=(name, other), depth=depth)
    for other in carriers(scene, state, name, allow).bodies:
        for sentence, bodies in _tilted_by(scene, state, name, other, allow):
            report("release", sentence, bodies=bodies)
    for sentence, far in _not_let_go(scene, name, held, T, 0.0 if falls else allow.drop, allow):
        report("release", sentence, bodies=(name,), depth=far)
    check_strayed(scene, state, name, held, T, allow, report)
    before = gripper.stroke if state.opening is None else state.opening
    wide = _width(scene, state, name, T, before + 2 * allow.pad)
    if wide + allow.opened > release.opening:
        sentence = (
            f"the fingers open to {1000 * release.opening:.1f} mm, {name} between them is {1000 * wide:.1f} mm wide"
        )
        report("release", sentence, bodies=(name,))
    state.held = None
    state.opening = release.opening
    state.poses[name] = held if falls else T
    _hold_back(scene, state, name, allow)
    note_lies(scene, state, name, held)
    for touch in finger_touches(scene, state, before, release.opening, {name: allow.contact}, allow):
        report("collision", f"the opening fingers: {sentence_of(touch)}", touch.bodies, touch.depth)
    if not falls:
        _check_way(scene, state, name, held, allow, report)
        check_rest(scene, state, name, allow, report)


def _hold_back(scene: Scene, state: State, name: str, allow: Tolerances) -> None:
    """What was to follow as soon as the hand is out of its way does not where what was let go touches or bars it."""
    for other, end in [*state.follows.items()]:
        apart = inverse(state.poses[name]) @ end
        bars = clearance(scene.solids[name], scene.solids[other], apart, 0.0) < 0.0
        if other == name or bars or patch_between(scene, state, name, other, allow) is not None:
            del state.follows[other]


def _tilted_by(
    scene: Scene, state: State, name: str, other: str, allow: Tolerances
) -> Iterator[tuple[str, tuple[str, ...]]]:
    """What another object loses that what is held is pressed into, as `tilted_off`."""
    patch = None if other == TABLE else patch_between(scene, state, name, other, allow)
    if patch is None:
        return
    T = inverse(state.poses[other]) @ state.poses[name]
    deep = -clearance(scene.solids[other], scene.solids[name], T, 0.0)
    if deep > PRESSED:
        yield from tilted_off(scene, state, other, patch.points, deep, allow)


def _check_way(scene: Scene, state: State, name: str, held: Array, allow: Tolerances, report: Report) -> None:
    """What is let go where it was `held` comes to where it now stands: through nothing, and righted by its weight."""
    if allow.grasp < np.linalg.norm((held - state.poses[name])[:3, 3]) < 2 * allow.drop:
        for touch in dropped_through(scene, state, name, held, allow):
            sentence = f"{name} drops through {touch.bodies[0]}, {1000 * touch.depth:.1f} mm deep in it"
            report("release", sentence, bodies=touch.bodies, depth=touch.depth)
    for other in jammed(scene, state, name, held, allow):
        report("release", f"{name} gets stuck in {other}, which has no room for it to drop into", bodies=(name, other))
    check_righted(scene, state, name, held, allow, report)
    drop = float((scene.center_of_mass(name, held) - scene.center_of_mass(name, state.poses[name]))[2])
    if drop > allow.dropped:
        for sentence, bodies in upset_by_fall(scene, state, name, drop, allow):
            report("release", sentence, bodies=bodies)


def check_righted(scene: Scene, state: State, name: str, held: Array, allow: Tolerances, report: Report) -> None:
    """What was let go where it was `held`, and is said to stand, is righted by its weight, and over what carries it.

    What is tilted rights itself if its centre of mass is over what carries it all the same, and so does what is aside.
    It stands, too, wherever else shifts within tolerance may have taken it.
    """
    tilt = float(np.arccos(np.clip(held[2, :3] @ state.poses[name][2, :3], -1.0, 1.0)))
    way = scene.center_of_mass(name, held) - scene.center_of_mass(name, state.poses[name])
    aside = float(np.hypot(way[0], way[1]))
    margin = max(height_above(scene, name, state.poses[name]) * float(np.sin(tilt)), aside)
    if margin > allow.balance and sunk_balance(scene, state, name, allow, margin) < margin:
        sentence = f"{name} is let go {1000 * aside:.1f} mm aside, {np.degrees(tilt):.1f} degrees tilted, and tips over"
        report("release", sentence, bodies=(name,))
        return
    far, turn = _aside(scene, state, name, allow), state.turned.get(name, 0.0)
    moved = sorted(state.stayed.keys() & {*carriers(scene, state, name, allow).patches})
    if moved and not _stands_at(scene, state.as_stayed(*moved), name, state.poses[name], allow):
        sentence = f"{name} tips over where {moved[0]} stays as the task has it, or was let go, not as the plan says"
        report("release", sentence, (name, *moved))
    if not all(_stands_at(scene, state, name, T, allow) for T in _elsewhere(scene, state, name, far, turn, allow)):
        where = f"{1000 * far:.1f} mm aside and turned by {np.degrees(turn):.1f} degrees"
        report("release", f"{name} may be {where} by all that nothing explains, and tip over", (name,))
    if not all(_stands_at(scene, state, name, T, allow) for T in _as_pads_turn(scene, state, name, allow)):
        report("release", f"{name} tips over as it lies where closing pads have turned it", (name,))


def _aside(scene: Scene, state: State, name: str, allow: Tolerances) -> float:
    """How far aside an object may stand on what carries it [m]: what leans on something is led to where it does.

    What is known to stay elsewhere is asked about there.
    """
    under = carriers(scene, state, name, allow).patches
    level = all((touch.normals[:, 2] > LEVEL).all() for touch in under.values())
    return state.aside(name, under.keys() - state.stayed.keys()) if level else state.strayed.get(name, 0.0)


def _elsewhere(scene: Scene, state: State, name: str, far: float, turn: float, allow: Tolerances) -> Iterator[Array]:
    """Where an object may be that is so far aside [m], in whichever way, and turned so far, to either side [rad]."""
    T, center = state.poses[name], scene.center_of_mass(name, state.poses[name])
    for side in (-1.0, 1.0) if turn > TURNED else ():
        yield turned(T, center, UP, side * turn)
    for angle in np.linspace(0.0, 2 * np.pi, WAYS, endpoint=False) if far > allow.balance else ():
        moved = T.copy()
        moved[:2, 3] += far * np.array([np.cos(angle), np.sin(angle)])
        yield moved


def _as_pads_turn(scene: Scene, state: State, name: str, allow: Tolerances) -> Iterator[Array]:
    """Where an object is that pads have turned about the vertical, to the step in which that is looked for."""
    T = state.poses[name]
    lies = state.stayed.get(name, T)
    if is_elsewhere(scene, name, T, lies, allow) and lies[2, :3] @ T[2, :3] > np.cos(allow.grasp_angle):
        yield from (turned(lies, scene.center_of_mass(name, lies), UP, more) for more in (-TURN, 0.0, TURN))


def _stands_at(scene: Scene, state: State, name: str, T: Array, allow: Tolerances) -> bool:
    """Whether an object would stand at T as well."""
    there = replace(state, poses={**state.poses, name: T}, touching={})
    return sunk_balance(scene, there, name, allow, 0.0) >= 0.0


def _width(scene: Scene, state: State, name: str, T: Array, opening: float) -> float:
    """How wide an object at T is between pads so far apart [m]; 0 where it is not between them."""
    found = _between(scene, state, name, T, opening, opening)
    return 0.0 if found is None else found[1] - found[0]


def _between(
    scene: Scene, state: State, name: str, T: Array, opening: float, width: float
) -> tuple[float, float] | None:
    """What of an object at T lies in the room that pads `opening` apart close to `width`, see `between_pads` [m]."""
    tree = scene.links.tree
    T_tool_object = inverse(tree.tool(state.q[None])[0]) @ T
    return between_pads(scene.solids[name], T_tool_object, tree.spec.gripper, opening, tree.pad_depth(width))


def _near_pads(scene: Scene, state: State) -> list[str]:
    """The objects that may be between the pads, sorted."""
    tool, stroke = scene.links.tree.tool(state.q[None])[0], scene.links.tree.spec.gripper.stroke
    middles = {name: T[:3, :3] @ scene.solids[name].center + T[:3, 3] for name, T in state.poses.items()}
    return sorted(
        name
        for name, middle in middles.items()
        if float(np.linalg.norm(middle - tool[:3, 3])) < scene.solids[name].radius + stroke
    )


def check_unsqueezed(scene: Scene, state: State, opening: float, allow: Tolerances, report: Report) -> None:
    """An empty hand that moves away squeezes nothing between its pads, which would come along.

    What it merely touches with the ends of its fingers gives way: pads slip off there though twice the friction held.
    """
    for name in _near_pads(scene, state):
        wide = _width(scene, state, name, state.poses[name], opening + 2 * allow.pad)
        if wide > opening and not _slips_off(scene, state, name, opening):
            sentence = f"the empty hand squeezes {name}, {1000 * wide:.1f} mm wide between pads {1000 * opening:.1f} mm"
            report("grasp", f"{sentence} apart, and takes it along", (name,), wide - opening)


def _not_let_go(
    scene: Scene, name: str, held: Array, said: Array, drop: float, allow: Tolerances
) -> Iterator[tuple[str, float]]:
    """Why an object that is let go where it is held would not stand where it is said to: it only drops a little."""
    way = scene.center_of_mass(name, said) - scene.center_of_mass(name, held)
    aside, angle = float(np.hypot(way[0], way[1])), angle_between(held, said)
    if aside > allow.grasp or angle > allow.grasp_angle:
        yield (
            f"{name} is let go {1000 * aside:.1f} mm beside and {np.degrees(angle):.1f} degrees from where it lies",
            aside,
        )
    if way[2] > allow.grasp:
        yield f"{name} is let go {1000 * way[2]:.1f} mm below where it is said to stand", float(way[2])
    if -way[2] > drop + allow.grasp:
        yield f"{name} is let go {-1000 * way[2]:.1f} mm above where it is said to stand", float(-way[2])


def _check_closing(
    scene: Scene,
    name: str,
    T_tool_object: Array,
    width: float,
    opening: float,
    allow: Tolerances,
    report: Report,
    slopes: tuple[Array, Array] | None = None,
) -> None:
    """The pads close on an object to the width that it has, and hold it; `slopes` are `pressed_slopes`, where known."""
    tree, gripper = scene.links.tree, scene.links.tree.spec.gripper
    depth = tree.pad_depth(width)
    found = between_pads(scene.solids[name], T_tool_object, gripper, opening, depth)
    if found is None:
        report("grasp", f"the fingers close on nothing: {name} is not between the pads", bodies=(name,))
        return
    thick, wide, high = gripper.pad
    inner = replace(gripper, pad=(thick, wide - 2 * RIM, high - 2 * RIM))
    if between_pads(scene.solids[name], T_tool_object, inner, opening, depth) is None:
        report("grasp", f"{name} slips out of the fingers, which hold it by the rims of their pads", bodies=(name,))
    mu = PAD_FRICTION * scene.friction(name)
    slope = slips_out(slopes or pressed_slopes(scene.solids[name], T_tool_object, gripper, opening, depth), mu)
    if slope is not None:
        sentence = f"{name} slips out of the fingers, which press on a slope of {np.degrees(slope):.0f} degrees"
        report("grasp", sentence, bodies=(name,))
    flush = laid_flush(scene.solids[name], T_tool_object, gripper, opening, mu, depth)
    bound = allow.flush if len(scene.solids[name].pieces) == 1 else allow.bulging
    if (moved := scene.displacement(name, T_tool_object, flush)) > bound:
        sentence = f"the fingers turn {name} by {1000 * moved:.0f} mm as they close, until it lies flush on them"
        report("grasp", sentence, bodies=(name,), depth=moved)
    astray = max(abs(found[1] - width / 2), abs(found[0] + width / 2))
    if astray > allow.pad:
        sentence = (
            f"{name} fills {1000 * found[0]:.1f} to {1000 * found[1]:.1f} mm between the pads, which close to "
            f"{1000 * width:.1f} mm"
        )
        report("grasp", sentence, bodies=(name,), depth=astray)


def _slips_off(scene: Scene, state: State, name: str, opening: float) -> bool:
    """Whether pads so far apart [m] press on an object by a slope alone, from which twice the friction would slip."""
    tree, gripper = scene.links.tree, scene.links.tree.spec.gripper
    T_tool_object = inverse(tree.tool(state.q[None])[0]) @ state.poses[name]
    mu, depth = 2 * PAD_FRICTION * scene.friction(name), tree.pad_depth(opening)
    return squeezed_out(scene.solids[name], T_tool_object, gripper, gripper.stroke, mu, depth) is not None


def _check_alone(scene: Scene, state: State, name: str, width: float, opening: float, report: Report) -> None:
    """The pads close on one object alone: what else between them is as wide would come along."""
    gripped = _between(scene, state, name, state.poses[name], opening, width)
    for other in _near_pads(scene, state) if gripped is not None else ():
        found = _between(scene, state, other, state.poses[other], opening, width) if other != name else None
        if found is not None and gripped is not None and _wraps(found, gripped):
            report("grasp", f"the fingers that grip {name} close on {other} too, which would come along", (name, other))


def _wraps(outer: tuple[float, float], inner: tuple[float, float]) -> bool:
    """Whether pads that close on what lies between two coordinates [m] are stopped by what lies between others too."""
    return outer[0] < inner[0] + ALIKE and outer[1] > inner[1] - ALIKE
