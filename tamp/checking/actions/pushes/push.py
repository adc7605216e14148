"""Check of a push along the table: the object stays before the fingers, and comes to rest where it is left.

While it slides evenly, the table's friction acts as one force through the object's centre of mass against its motion
(Mason, International Journal of Robotics Research 5, 1986). Fingers that touch it on both sides of the line of that
force, within their own cone of friction, neither turn it nor slip along it (Lynch and Mason, same journal 15, 1996).
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.actions.arm_motion import TOO_WILD, check_move, look
from tamp.checking.actions.closing_pads import ASIDE, is_aside
from tamp.checking.actions.deviations import check_attachment, check_shifted, check_strayed
from tamp.checking.actions.left_standing import check_uncovered
from tamp.checking.geometry.solids import clearance
from tamp.checking.geometry.transforms import inverse
from tamp.checking.physics.contacts import Patch, contacts
from tamp.checking.physics.equilibrium import holds_ahead, reach
from tamp.checking.physics.round_bodies.perching import rolls_on
from tamp.checking.physics.support import carriers, height_above
from tamp.checking.robot.cubic import interpolate
from tamp.checking.robot.load import overloaded
from tamp.checking.robot.sweep import Mover
from tamp.checking.robot.trajectory_limits import malformed
from tamp.checking.scene import GRAVITY, TABLE, Scene, State
from tamp.task.robot import PAD_FRICTION

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from numpy.typing import NDArray

    from tamp.checking.actions.arm_motion import Report
    from tamp.checking.robot.sweep import Looks
    from tamp.checking.tolerances import Tolerances
    from tamp.task.plan import Attachment, Move

    Array = NDArray[np.float64]

HOLDS = 0.75
"""Share of the friction of pads that keeps most things from slipping along a flank.

What is high may slip sooner: of 15 slides 20 degrees aslant, where friction holds 26.6, 5 ended 12 mm aside or more.
"""

LEANS = 0.9
"""Share of the moment that keeps a pushed object from tipping that is counted on: of nudges that ask for 0.94 of it or
more, all lagged behind in a simulator by 9 to 16 mm, riding on their foremost edge; of 0.8 none."""


def check_push(scene: Scene, state: State, move: Move, pushed: Attachment, allow: Tolerances, report: Report) -> None:
    """Judge a motion that pushes an object; afterwards the object stands where the hand has left it."""
    name, move = pushed.object, founded(move, pushed.object, (TABLE,))
    if unfollowed(scene, state, move, allow, report):
        return
    seen = watch(scene, move, pushed, allow, report)
    if seen is None:
        return
    path = check_path(scene, state, move, pushed, (TABLE,), seen, allow, report)
    wrong = (*_loose(scene, move, name, path, allow), *tipping(scene, state, move, name, seen, (TABLE,), allow))
    for sentence in wrong:
        report("push", sentence, bodies=(name,))
    _check_stand(scene, state, name, allow, report)
    check_move(scene, state, move, allow, report, seen, sliding(scene, state, name, (TABLE,), path, allow))
    state.poses[name] = path[-1]
    _check_stand(scene, state, name, allow, report)
    check_stopped(scene, state, name, direction(path), allow, report)


def check_stopped(scene: Scene, state: State, name: str, ahead: Array, allow: Tolerances, report: Report) -> None:
    """What the hand has pushed `ahead`, shape (3,), stays where the hand stops."""
    level = ahead * (1.0, 1.0, 0.0)
    if rolls_on(scene, state, name, level / max(float(np.linalg.norm(level)), 1e-9), allow):
        report("push", f"{name} rolls on when the hand stops", bodies=(name,))


def founded(move: Move, name: str, under: Iterable[str]) -> Move:
    """The motion with a word on contacts only that makes sense: what is pushed may touch what carries it, no others."""
    return replace(move, contacts=frozenset(pair for pair in move.contacts if {*pair} in ({name, on} for on in under)))


def unfollowed(scene: Scene, state: State, move: Move, allow: Tolerances, report: Report) -> bool:
    """Judge a motion as any other where no empty hand pushes, or its trajectory is malformed; whether that is so."""
    found = state.held is not None or malformed(move.trajectory, scene.links.tree.spec) is not None
    if found:
        check_move(scene, state, move, allow, report)
    return found


def watch(scene: Scene, move: Move, pushed: Attachment, allow: Tolerances, report: Report) -> Looks | None:
    """A motion that pushes something, which is the last of its bodies; None, and a report, where it is too wild."""
    seen = look(scene, move, pushed, allow.step)
    if seen is None:
        report("limits", TOO_WILD.format(move.phase))
    return seen


def check_path(
    scene: Scene,
    state: State,
    move: Move,
    pushed: Attachment,
    under: Iterable[str],
    seen: Looks,
    allow: Tolerances,
    report: Report,
) -> Array:
    """Judge how an object is said to be pushed over `under`, and return the poses on its way, shape (n, 4, 4)."""
    name, path = pushed.object, seen.bodies[-1].T
    start = inverse(scene.links.tree.tool(move.trajectory.positions[:1])[0]) @ state.poses[name]
    check_attachment(scene, name, start, pushed.T_tool_object.matrix, allow, report)
    if (off := scene.swing(name, state.poses[name], path[0])) > allow.grasp:
        sentence = f"{name} is said to be turned, where the push begins, so that its ends lie {1000 * off:.1f} mm aside"
        report("push", sentence, (name,), off)
    check_strayed(scene, state, name, state.poses[name], path[0], allow, report)
    check_shifted(state, name, _lag(scene, move, name, path[0], allow), allow, report)
    for sentence in _astray(name, path, float(seen.swing.max()), allow):
        report("push", sentence, bodies=(name,))
    slowing = float(-_rates(path, seen.times).min())
    sticks = GRAVITY * scene.friction(name) * min((scene.friction(other) for other in under), default=0.0)
    if slowing > sticks:
        report("push", f"{name} slides on when the hand slows down by {slowing:.1f} m/s^2", bodies=(name,))
    _note_beside(scene, state, name, path)
    push = sticks * scene.task.object(name).mass * direction(path)
    check_force(scene, move, name, seen, push, allow.nudge, allow, report)
    check_uncovered(scene, state, name, allow, report)
    return path


def sliding(
    scene: Scene, state: State, name: str, under: Iterable[str], path: Array, allow: Tolerances
) -> Mover | None:
    """What was pushed along poses, shape (n, 4, 4), where it slides in truth; None where that is as said.

    That is on what carries it, and not by a gap that counts as standing above what lies in its way, nor by a depth that
    counts as touching in what it would have to climb; and as much to the side of its path as it is in the end.
    """
    body, standing_on = scene.solids[name], {on: T for on, T in state.standing(scene).items() if on in under}
    gaps = [clearance(scene.solids[on], body, inverse(T) @ path[0], allow.contact) for on, T in standing_on.items()]
    slides = path.copy()
    slides[:, 2, 3] -= np.clip(min(gaps, default=0.0), -allow.contact, allow.standing)
    slides[:, :2, 3] += (state.stayed.get(name, path[-1]) - path[-1])[:2, 3]
    return Mover(body, slides, astray=True) if np.abs(slides - path).max() > ASIDE else None


def _note_beside(scene: Scene, state: State, name: str, path: Array) -> None:
    """Note where an object ends that is not where it is said to be pushed from: as much to the side of its path.

    Fingers take it along wherever it is ahead of them, and to no side.
    """
    off = scene.center_of_mass(name, state.stayed.pop(name, state.poses[name])) - scene.center_of_mass(name, path[0])
    ahead = direction(path)
    aside = path[-1].copy()
    aside[:2, 3] += (off - off @ ahead * ahead)[:2]
    if is_aside(scene, state, name, path[-1], aside):
        state.stayed[name] = aside


def _lag(scene: Scene, move: Move, name: str, T: Array, allow: Tolerances) -> float:
    """How far behind it is said to go an object at T stays which a hand pushes that does not quite touch it [m]."""
    placed = scene.links.tree.forward(move.trajectory.positions[:1], move.opening)
    hand = (solid for solid in scene.links.solids if solid.name in scene.links.gripper)
    gaps = (clearance(scene.solids[name], link, inverse(T) @ placed[link.name][0], allow.standing) for link in hand)
    return float(np.clip(min(gaps, default=0.0), 0.0, allow.standing))


def check_force(
    scene: Scene, move: Move, name: str, seen: Looks, push: Array, within: float, allow: Tolerances, report: Report
) -> None:
    """The arm bears what it pushes with, `push`, shape (3,) [N], where the fingers touch as it begins, all the way."""
    path = seen.bodies[-1].T
    ahead = push / max(float(np.linalg.norm(push)), 1e-12)
    touching = touched_behind(scene, move, name, path[0], ahead, within, allow).points
    if not len(touching):
        return
    at = path @ inverse(path[0]) @ np.append(touching.mean(axis=0), 1.0)
    q = interpolate(move.trajectory, seen.times)
    if (wrong := overloaded(scene.links.tree, q, at[:, :3], -push)) is not None:
        look, sentence = wrong
        report("limits", f"to push {name} {sentence}", bodies=(name,), after=float(seen.times[look]))


def _astray(name: str, path: Array, swing: float, allow: Tolerances) -> Iterator[str]:
    """Why poses (n, 4, 4) are not those of an object that slides straight ahead over the table, without turning.

    Between two of them it leaves the straight line by at most `swing` [m].
    """
    shift = path[:, :3, 3] - path[0, :3, 3]
    ahead = direction(path)
    turned = float(np.linalg.norm(path[:, :3, :3] - path[0, :3, :3], axis=(1, 2)).max() / np.sqrt(2.0))
    beside = float(np.linalg.norm(shift - np.outer(shift @ ahead, ahead), axis=1).max()) + swing
    if turned > allow.grasp_angle:
        yield f"{name} is said to turn by {np.degrees(turned):.1f} degrees while it is pushed"
    if beside > allow.grasp:
        yield f"{name} is said to leave a straight line by {1000 * beside:.1f} mm while it is pushed"
    if (np.maximum.accumulate(shift @ ahead) - shift @ ahead).max() > allow.grasp:
        yield f"{name} does not come back with a hand that pushes it"


def _loose(scene: Scene, move: Move, name: str, path: Array, allow: Tolerances) -> Iterator[str]:
    """Why the fingers would not keep an object before them, as they touch it at the start."""
    ahead = direction(path)
    touching = touched_behind(scene, move, name, path[0], ahead, allow.push, allow)
    if not len(touching.points):
        yield f"no finger touches {name} on the side away from where it is pushed"
        return
    yield from aslant(scene, name, touching, ahead, scene.center_of_mass(name, path[0]))
    across = np.array([-ahead[1], ahead[0], 0.0])
    beside = (touching.points - scene.center_of_mass(name, path[0])) @ across
    if beside.min() > -allow.lever or beside.max() < allow.lever:
        yield f"{name} would turn away: its centre of mass is not between the contacts that push it"


def tipping(
    scene: Scene, state: State, move: Move, name: str, seen: Looks, under: Iterable[str], allow: Tolerances
) -> Iterator[str]:
    """Why an object would tip over its foremost edge, over which the hand pushes it, or back over it, and not slide.

    The push overcomes friction and speeds the object up, or slows it down less than friction would: about the edge
    ahead its moment, at the lowest place where fingers press, and that of inertia stay below the weight's. About the
    edge behind inertia does, less what the push resists at the highest such place.
    """
    path = seen.bodies[-1].T
    ahead = direction(path)
    touching = touched_behind(scene, move, name, path[0], ahead, allow.nudge, allow).points
    if not len(touching):
        return
    friction = scene.friction(name) * min((scene.friction(other) for other in under), default=0.0)
    low = (scene.solids[name].hull.part.vertices @ path[0, 2, :3] + path[0, 2, 3]).min()
    height, middle = float(touching[:, 2].min() - low), height_above(scene, name, path[0])
    rates = _rates(path, seen.times)
    yield from _tipping_back(scene, state, name, path[0], ahead, float(rates.max()), touching, friction, allow)
    straight = _straight(scene, replace(state, poses={**state.poses, name: path[0]}), name, ahead, allow)
    for T, slowing in ((path[0], min(-rates.max(), 0.0)), (path[-1], max(-rates.min(), 0.0))):
        there = replace(state, poses={**state.poses, name: T})
        lever = min(straight, _farthest(scene, there, name, ahead, allow))
        turning = max(height * friction, height * friction + (middle - height) * slowing / GRAVITY)
        if turning > LEANS * lever:
            yield (
                f"{name} would tip over: it is pushed {1000 * height:.0f} mm above what it slides on, and carried "
                f"{1000 * lever:.0f} mm ahead of its centre of mass"
            )
            return


def _tipping_back(
    scene: Scene,
    state: State,
    name: str,
    T: Array,
    ahead: Array,
    speeding: float,
    touching: Array,
    friction: float,
    allow: Tolerances,
) -> Iterator[str]:
    """Why an object at T would tip backwards, over the hand that speeds it up [m/s^2] by pushing it near its foot."""
    there = replace(state, poses={**state.poses, name: T})
    lever = _straight(scene, there, name, -ahead, allow)
    below = float(scene.center_of_mass(name, T)[2] - touching[:, 2].max())
    high = height_above(scene, name, T) - below
    if np.isfinite(lever) and below * speeding / GRAVITY - high * friction > lever:
        where = f"{1000 * below:.0f} mm below its middle"
        yield f"{name} would tip backwards: it is sped up by {speeding:.1f} m/s^2 {where}"


def _straight(scene: Scene, state: State, name: str, way: Array, allow: Tolerances) -> float:
    """How far what carries an object reaches from its centre of mass along a way, a level unit vector, shape (3,) [m].

    It tips about the edge of that which the line of a push crosses, however far ahead a corner aside of it is.
    """
    points = np.concatenate([np.empty((0, 3)), *carriers(scene, state, name, allow).points.values()])
    return reach(points[:, :2], scene.center_of_mass(name, state.poses[name])[:2], way[:2])


def _farthest(scene: Scene, state: State, name: str, way: Array, allow: Tolerances) -> float:
    """How far the farthest of the same is that way [m].

    What an edge of the table leaves of it counts so: about that it tips on the last of its way alone, and comes back as
    the hand stops. Of pushes that end aslant over an edge all ended within a millimetre in two simulators, up to those
    that ask for three times the moment about it.
    """
    points = np.concatenate([np.empty((0, 3)), *carriers(scene, state, name, allow).points.values()])
    return float(((points - scene.center_of_mass(name, state.poses[name])) @ way).max(initial=-np.inf))


def touched_behind(
    scene: Scene, move: Move, name: str, T: Array, ahead: Array, within: float, allow: Tolerances
) -> Patch:
    """Where fingers touch an object at T when a motion starts, and press within an angle [rad] of ahead.

    `ahead` is a unit vector, shape (3,).
    """
    placed = scene.links.tree.forward(move.trajectory.positions[:1], move.opening)
    hand = {s.name: (s, placed[s.name][0]) for s in scene.links.solids if s.name in scene.links.gripper}
    patches = contacts(scene.solids[name], T, hand, allow.standing).patches
    points = np.concatenate([np.empty((0, 3)), *(patches[link].points for link in sorted(patches))])
    normals = np.concatenate([np.empty((0, 3)), *(patches[link].normals for link in sorted(patches))])
    behind = normals @ ahead > np.cos(within)
    return Patch(points[behind], normals[behind])


def aslant(scene: Scene, name: str, touching: Patch, ahead: Array, about: Array | None = None) -> Iterator[str]:
    """Why fingers would slip along the flank of an object that they push aslant, where they touch it.

    What they press with, within friction, adds up to a force straight `ahead`, a level unit vector, shape (3,); without
    a moment about a place, shape (3,), where one is given.
    """
    arms = np.zeros_like(touching.points) if about is None else touching.points - about
    if not holds_ahead(arms, touching.normals, HOLDS * PAD_FRICTION * scene.friction(name), ahead):
        off = float(np.degrees(np.arccos(np.clip((touching.normals @ ahead).max(), -1.0, 1.0))))
        yield f"the fingers would slip along {name}, which they push {off:.0f} degrees aslant"


def _rates(path: Array, times: Array) -> Array:
    """At which rates a pushed object gets faster and slower, from rest to rest, shape (n,) [m/s^2]."""
    dt = np.diff(times)
    speed = np.concatenate([[0.0], np.linalg.norm(np.diff(path[:, :3, 3], axis=0), axis=1) / dt, [0.0]])
    between = np.concatenate([[dt[0] / 2], (dt[1:] + dt[:-1]) / 2, [dt[-1] / 2]])
    rates: Array = np.diff(speed) / between
    return rates


def direction(path: Array) -> Array:
    """Unit vector from the first to the last position."""
    shift = path[-1, :3, 3] - path[0, :3, 3]
    ahead: Array = shift / max(float(np.linalg.norm(shift)), 1e-9)
    return ahead


def _check_stand(scene: Scene, state: State, name: str, allow: Tolerances, report: Report) -> None:
    """The object rests on the table and on nothing else, its centre of mass well inside the table's edge."""
    touching = carriers(scene, state, name, allow)
    if touching.bodies != (TABLE,):
        report("push", f"{name} stands on {', '.join(touching.bodies) or 'nothing'}, not on the table alone", (name,))
        return
    friction = {other: scene.friction(name) * scene.friction(other) for other in touching.patches}
    least = max(allow.edge, state.aside(name) + allow.balance)
    inside = touching.balance(scene.center_of_mass(name, state.poses[name]), friction, least)
    if inside < least:
        sentence = f"{name} may tip over: its centre of mass is {1000 * inside:.0f} mm inside what carries it"
        report("support", sentence, (name, TABLE))
