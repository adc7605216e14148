"""Check of a fall: what is let go on one edge turns over it and lands flat, what is let go in the air falls straight.

Neither meets anything on its way, and both rest where they land.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.actions.closing_pads import note_lies, note_turned_over
from tamp.checking.actions.collisions.blow import (
    jolted,
    knocked_over,
    pushed_back,
    slid_past,
    struck_aside,
    tipped_over,
    tips_on,
    upset_by_fall,
)
from tamp.checking.actions.collisions.way_down import met_on_the_way
from tamp.checking.actions.collisions.wedging import jammed
from tamp.checking.actions.deviations import check_strayed
from tamp.checking.actions.grip_and_release import check_righted
from tamp.checking.actions.left_standing import check_rest
from tamp.checking.geometry.transforms import inverse, rotation
from tamp.checking.physics.equilibrium import LEVEL
from tamp.checking.physics.round_bodies.perching import rolls_away
from tamp.checking.physics.support import carriers
from tamp.checking.physics.tumbling import sliding
from tamp.checking.robot.sweep import Mover, touches, travelled

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from tamp.checking.actions.arm_motion import Report
    from tamp.checking.physics.contacts import Contacts
    from tamp.checking.scene import Scene, State
    from tamp.checking.tolerances import Tolerances
    from tamp.task.plan import Fall

    Array = NDArray[np.float64]

STRAIGHT = 1e-3  # what turns less than this falls straight [rad]
HALF_TURN = 0.99  # cosine, but for its sign, from which on a turn is nearly one to the opposite
MOST_LOOKS = 4096  # at a fall, however far it goes
LOOKS = 90  # at what is lowest while a body rolls over


def check_fall(
    scene: Scene, state: State, fall: Fall, allow: Tolerances, report: Report, *, toppled: bool = False
) -> None:
    """Judge the fall of what was let go or toppled; afterwards the object lies where the step says."""
    name, before, after = fall.object, state.poses[fall.object], fall.pose.matrix
    if state.held is not None and state.held.object == name:
        report("precondition", f"{name} cannot fall while the gripper holds it", bodies=(name,))
        return
    straight = falls_straight(before, after)
    farthest = allow.topple if toppled else allow.tilt
    turning = _not_turning(scene, state, name, after, farthest, allow)
    for sentence in _not_dropping(name, before, after, allow) if straight else turning:
        report("fall", sentence, bodies=(name,))
    if straight:
        check_strayed(scene, state, name, before, after, allow, report)
    touched = set(carriers(scene, state, name, allow).patches)
    landed = replace(state, poses={**state.poses, name: after})
    met = carriers(scene, landed, name, allow).without(*touched).patches
    path = _turned(before, after)
    while (step := travelled(scene.solids[name], path).max(initial=0.0)) > allow.step:
        if len(path) > MOST_LOOKS:
            report("fall", f"{name} is said to fall so far that nobody can look at its way", bodies=(name,), depth=step)
            return
        path = _turned(before, after, 2 * len(path))
    body, placed = Mover(scene.solids[name], path), scene.links.tree.forward(state.q[None], state.opening or 0.0)
    for touch in touches((Mover(link, placed[link.name]), body, allow.collision) for link in scene.links.solids):
        report("fall", f"{name} falls onto {touch.bodies[0]}", bodies=touch.bodies, depth=touch.depth)
    lay, state.poses[name] = state.stayed.get(name, before), after
    if straight:
        note_lies(scene, state, name, before)
    else:
        note_turned_over(scene, state, name, lay, before, after)
    for touch in met_on_the_way(scene, state, name, path, {*touched, *met}, allow):
        sentence = f"{name} falls {1000 * touch.depth:.1f} mm into {touch.bodies[0]}"
        report("fall", sentence, bodies=touch.bodies, depth=touch.depth)
    if straight:
        check_righted(scene, state, name, before, allow, report)
        for other in jammed(scene, state, name, before, allow):
            report("fall", f"{name} gets stuck in {other}, which has no room for it to fall into", bodies=(name, other))
    check_rest(scene, state, name, allow, report)
    blows = list(_blows(scene, state, name, before, after, allow))
    if state.stayed.keys() & {name, *touched, *met}:
        lies = state.stayed.get(name, after)
        blows += _blows(scene, state.as_stayed(), name, lies @ inverse(after) @ before, lies, allow)
    for sentence, bodies in dict.fromkeys(blows):
        report("fall", sentence, bodies=bodies)


def _blows(
    scene: Scene, state: State, name: str, before: Array, after: Array, allow: Tolerances
) -> Iterator[tuple[str, tuple[str, ...]]]:
    """What does not stay where it is as an object falls from one pose to the other, where it now lies, itself among it.

    Sentence, bodies.
    """
    straight = falls_straight(before, after)
    stood = replace(state, poses={**state.poses, name: before}, touching={})
    touched = set(carriers(scene, stood, name, allow).patches)
    met = carriers(scene, state, name, allow).without(*touched)
    ahead = scene.center_of_mass(name, after) - scene.center_of_mass(name, before)
    for other in () if straight else pushed_back(scene, stood, name, ahead, allow):
        yield f"{other} tips over backwards as {name} turns over on it", (other, name)
    drop = float(-ahead[2])
    if max(drop, _landing(met, before, after)) <= allow.dropped:
        return
    if drop > allow.drop and rolls_away(scene, state, name, None if straight else ahead, allow):
        yield f"{name} rolls on where it falls {1000 * drop:.0f} mm", (name,)
    if straight:
        yield from _upset_straight(scene, state, name, drop, allow)
        return
    axis, angle = _turn(before, after)
    tipped = tips_on(scene, state, name, drop, (axis, _pivot(before, after, axis, angle)), allow)
    if tipped is not None:
        yield f"{name} tips on over the edge of {tipped} as it comes down on it", (name, tipped)
    yield from _upset_turning(scene, state, name, before, touched, met, drop, allow)


def _landing(met: Contacts, before: Array, after: Array) -> float:
    """How far the places come down that a body, taken from one pose to another, lands on; 0 where it meets nothing."""
    came = before @ inverse(after)
    points = np.concatenate([np.zeros((0, 3)), *(patch.points for patch in met.patches.values())])
    return float((points @ came[2, :3] + came[2, 3] - points[:, 2]).max(initial=0.0))


def falls_straight(before: Array, after: Array) -> bool:
    """Whether an object does not turn on its way from one pose to another, shape (4, 4) each."""
    return _turn(before, after)[1] < STRAIGHT


def _upset_straight(
    scene: Scene, state: State, name: str, drop: float, allow: Tolerances
) -> Iterator[tuple[str, tuple[str, ...]]]:
    """What does not stay where it is as an object falls straight down to where it lies: sentence, bodies."""
    flanks = slid_past(scene, state, name, carriers(scene, state, name, allow))
    aside = struck_aside(scene, state, name, drop, None, flanks, allow)
    yield from upset_by_fall(scene, state, name, drop, allow, aside)


def _upset_turning(
    scene: Scene,
    state: State,
    name: str,
    before: Array,
    touched: set[str],
    met: Contacts,
    drop: float,
    allow: Tolerances,
) -> Iterator[tuple[str, tuple[str, ...]]]:
    """The same as it turns over: it had `touched` some bodies, and has `met` others."""
    after = state.poses[name]
    axis, angle = _turn(before, after)
    turn = axis, _pivot(before, after, axis, angle)
    leant = {other for other, patch in met.patches.items() if (patch.normals[:, 2] < LEVEL).any()}
    spared = tuple(sorted(touched | leant))
    aside = struck_aside(scene, state, name, drop, turn, met, allow)
    yield from tipped_over((*aside, *knocked_over(scene, state, name, drop, allow, spared=spared)), name, drop)
    yield from jolted(scene, state, name, drop, allow)


def _not_dropping(name: str, before: Array, after: Array, allow: Tolerances) -> Iterator[str]:
    """Why an object would not get from where it was let go to where it is said to come to rest by falling straight."""
    way = after[:3, 3] - before[:3, 3]
    aside = float(np.linalg.norm(way[:2]))
    if aside > allow.grasp:
        yield f"{name} is said to move {1000 * aside:.0f} mm aside while it falls"
    if way[2] > 0.0:
        yield f"{name} is said to fall {1000 * way[2]:.0f} mm upwards"
    if -way[2] > allow.fall:
        yield f"{name} falls {1000 * -way[2]:.0f} mm: nobody knows where it comes to rest"


def _not_turning(
    scene: Scene, state: State, name: str, after: Array, farthest: float, allow: Tolerances
) -> Iterator[str]:
    """Why an object would not get from where it was let go to where it is said to come to rest by falling alone."""
    before = state.poses[name]
    axis, angle = _turn(before, after)
    if angle > farthest:
        yield f"{name} cannot fall flat by a turn of {np.degrees(angle):.0f} degrees"
        return
    points = carriers(scene, state, name, allow).points
    friction = {other: scene.friction(name) * scene.friction(other) for other in points}
    if not points:
        yield f"{name} is let go in the air: no edge of it stands on anything"
        return
    edge = np.concatenate(list(points.values()))
    lever = scene.center_of_mass(name, before)[:2] - edge[:, :2]
    # Where its centre of mass is beside the ends of the edge, it falls over a corner, and sideways too.
    beside = max(float((lever @ axis[:2]).min()), float((lever @ -axis[:2]).min()), 0.0)
    over_corner = beside / max(float(np.linalg.norm(lever, axis=1).min()), 1e-9)
    if abs(axis[2]) > np.sin(allow.level) + allow.twist * over_corner:
        yield f"{name} is said to turn sideways while it falls"
    torque = float((lever[:, 0] * axis[1] - lever[:, 1] * axis[0]).min())
    high = float(scene.center_of_mass(name, before)[2] - edge[:, 2].min())
    # By as much as all shifts within tolerance come to it may be nearer to its balance.
    if torque < max(allow.balance, np.tan(allow.grasp_angle) * high) + state.aside(name, points):
        yield f"{name} may not fall to that side: its centre of mass is hardly beyond the edge it stands on, or is not"
    # It turns about where it stays on one of the bodies that carry it; what it leans on besides, it may leave.
    center = scene.center_of_mass(name, before)
    lean = float(np.arctan2(torque, high))
    slid = [_slid(on, after @ inverse(before), center, sliding(friction[other], lean)) for other, on in points.items()]
    corners = scene.solids[name].hull.part.vertices @ before[:3, :3].T + before[:3, 3]
    if edge[:, 2].min() < corners[:, 2].min() + allow.standing:
        said = (scene.center_of_mass(name, after) - center)[:2]
        most = sliding(min(friction.values()), lean)
        rolled = _rolled(corners - center, axis, angle)
        slid.append(float(_between(said - rolled, rolled, most)))
    if min(slid) > allow.skid + min(beside, allow.corner):
        yield f"{name} is said to slide {1000 * min(slid):.0f} mm farther than it can while it falls"


def _rolled(arms: Array, axis: Array, angle: float) -> Array:
    """How far aside the centre of mass of a body comes that rolls on a level plane and nowhere slides, shape (2,) [m].

    The corner that is lowest rests, so that the centre's velocity is that of a turn about it.

    Args:
        arms: from the centre of mass to the corners of the body's hull at first, shape (n, 3) [m].
        axis: that it turns about, a unit vector, shape (3,).
        angle: that it turns by [rad].
    """
    turns = (np.arange(LOOKS) + 0.5) * angle / LOOKS
    lowest = [(turned := arms @ rotation(axis, float(turn)).T)[turned[:, 2].argmin()] for turn in turns]
    return np.asarray(-np.cross(axis, lowest).mean(axis=0)[:2] * angle)


def _slid(points: Array, T: Array, center: Array, most: float) -> float:
    """How much farther aside the fastest point of an edge, shape (n, 3), goes where T takes a body than it may [m].

    Where friction holds it, it stays, and the turn takes the centre of mass (3,) aside. On ice that falls straight
    down, and the edge slides as far to the other side. All else is between, by a share of that, at `most`.
    """
    edge, middle = ((each @ T[:3, :3].T + T[:3, 3] - each)[..., :2] for each in (points, center))
    return float(_between(edge, middle - edge, most).max())


def _between(edge: Array, turned: Array, most: float) -> Array:
    """How far shifts of an edge, shape (..., 2), are from those between 0 and a share of what the turn undoes [m]."""
    share = -(edge * turned).sum(axis=-1) / np.maximum((turned**2).sum(axis=-1), 1e-12)
    return np.asarray(np.linalg.norm(edge + np.clip(share, 0.0, most)[..., None] * turned, axis=-1))


def _turn(before: Array, after: Array) -> tuple[Array, float]:
    """Axis, a unit vector in the world, and angle of the turn between two poses [rad]."""
    R = after[:3, :3] @ before[:3, :3].T
    skew = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2
    sine, cosine = float(np.linalg.norm(skew)), (np.trace(R) - 1) / 2
    if cosine < -HALF_TURN:  # there the skew part fades, and the symmetric one is 2 a a' - 1
        lengths, axes = np.linalg.eigh(R + R.T)
        axis = axes[:, lengths.argmax()]
        axis = axis if axis @ skew >= 0.0 else -axis
    else:
        axis = skew / max(sine, 1e-12)
    return axis, float(np.arctan2(sine, cosine))


def _pivot(before: Array, after: Array, axis: Array, angle: float) -> Array:
    """The point that stays where it is between two poses, but for a shift along the axis of the turn, shape (3,)."""
    shift = after[:3, 3] - rotation(axis, angle) @ before[:3, 3]
    along = axis * (axis @ shift)
    return np.asarray(np.linalg.lstsq(np.eye(3) - rotation(axis, angle), shift - along, rcond=None)[0], np.float64)


def _turned(before: Array, after: Array, count: int = 8) -> Array:
    """`count` poses, shape (count, 4, 4), between two: the turn about a fixed axis that takes one to the other."""
    axis, angle = _turn(before, after)
    if angle < STRAIGHT:
        straight = np.tile(after, (count, 1, 1))
        straight[:, :3, 3] = np.linspace(before[:3, 3], after[:3, 3], count)
        return straight
    center = _pivot(before, after, axis, angle)
    along = axis * (axis @ (after[:3, 3] - before[:3, 3]))
    poses = np.tile(np.eye(4), (count, 1, 1))
    for k, share in enumerate(np.linspace(0.0, 1.0, count)):
        poses[k, :3, :3] = rotation(axis, share * angle) @ before[:3, :3]
        poses[k, :3, 3] = center + rotation(axis, share * angle) @ (before[:3, 3] - center) + share * along
    return poses
