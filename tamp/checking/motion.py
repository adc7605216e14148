"""Checks of one arm motion: continuity, limits, what it says it holds, collisions."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.limits import interpolate, malformed, violations
from tamp.checking.scene import ROBOT, TABLE, Scene, State
from tamp.checking.sweep import Mover, Touch, sample_times, standing, touches

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from numpy.typing import NDArray

    from tamp.checking.solids import Solid
    from tamp.checking.tolerances import Tolerances
    from tamp.task.plan import Move

    Array = NDArray[np.float64]
    Report = Callable[..., None]

EMPTY = ("transit", "approach", "retreat", "push")
HOLDING = ("transfer", "lift", "lower")
FREE = ("transit", "transfer")
MAX_SAMPLES = 100_000


def check_move(scene: Scene, state: State, move: Move, allow: Tolerances, report: Report) -> None:
    """Judge a motion and bring the state to its end.

    Args:
        scene: the world.
        state: what is where; changed.
        move: the motion.
        allow: tolerances.
        report: called as report(kind, sentence, bodies=(), depth=0.0, after=seconds into the motion).
    """
    spec = scene.links.tree.spec
    if (reason := malformed(move.trajectory, spec)) is not None:
        report("limits", f"the {move.phase} motion is no trajectory: {reason}")
        return
    _check_phase(state, move, report)
    _check_joined(state, move, spec.joints, allow, report)
    _check_fingers(scene, state, move, allow, report)
    broken = list(violations(move.trajectory, spec, allow))
    for time, sentence in broken:
        report("limits", sentence, after=time)
    if not broken or _samples(move) < MAX_SAMPLES:
        for time, touch in collisions(scene, state, move, allow):
            report("collision", sentence_of(touch), bodies=touch.bodies, depth=touch.depth, after=time)
    state.q = move.trajectory.positions[-1]
    state.opening = move.opening
    state.time += move.trajectory.duration
    _carry(scene, state)


def sentence_of(touch: Touch) -> str:
    """A touch in words."""
    return f"{touch.bodies[1]} and {touch.bodies[0]} interpenetrate by {1000 * touch.depth:.1f} mm"


def _samples(move: Move) -> float:
    """How many samples the motion may need at least: its joint travel in hundredths of a radian."""
    speed = np.abs(move.trajectory.velocities).max(axis=1)
    return float((np.maximum(speed[1:], speed[:-1]) * np.diff(move.trajectory.times)).sum()) * 100


def _carry(scene: Scene, state: State) -> None:
    """Move the held object to where the tool now is."""
    if state.held is not None:
        T_world_tool = scene.links.tree.tool(state.q[None])[0]
        state.poses[state.held.object] = T_world_tool @ state.held.T_tool_object.matrix


def _check_phase(state: State, move: Move, report: Report) -> None:
    if move.phase not in (*EMPTY, *HOLDING):
        report("continuity", f"unknown phase {move.phase!r}; valid are {', '.join((*EMPTY, *HOLDING))}")
    claimed = None if move.held is None else move.held.object
    actual = None if state.held is None else state.held.object
    if claimed != actual:
        report(
            "continuity",
            f"the {move.phase} motion claims to hold {claimed or 'nothing'}, the gripper holds {actual or 'nothing'}",
            bodies=tuple(name for name in (claimed, actual) if name),
        )
    elif move.held is not None and move.held != state.held:
        report("continuity", f"{claimed} changes its place in the gripper while held", bodies=(str(claimed),))
    if move.phase in (EMPTY if actual else HOLDING):
        report("continuity", f"a {move.phase} motion while the gripper holds {actual or 'nothing'}")
    if (move.phase == "push") != (move.pushed is not None):
        report("continuity", f"a {move.phase} motion that pushes {move.pushed.object if move.pushed else 'nothing'}")


def _check_joined(state: State, move: Move, joints: tuple[str, ...], allow: Tolerances, report: Report) -> None:
    jump = np.abs(move.trajectory.positions[0] - state.q)
    if jump.max() > allow.joint:
        name = joints[int(jump.argmax())]
        report("continuity", f"the {move.phase} motion starts {jump.max():.4f} rad from where {name} is")


def _check_fingers(scene: Scene, state: State, move: Move, allow: Tolerances, report: Report) -> None:
    """The fingers keep their opening; an empty gripper may change it where nothing is in their way."""
    stroke = scene.links.tree.spec.gripper.stroke
    if not -1e-9 <= move.opening <= stroke + 1e-6:
        report("limits", f"an opening of {move.opening:.4f} m is outside the gripper's stroke of 0 to {stroke} m")
        return
    before = move.opening if state.opening is None else state.opening
    if abs(before - move.opening) <= 1e-6:
        return
    if state.held is not None:
        report("continuity", f"the fingers move from {before:.4f} m to {move.opening:.4f} m while holding")
        return
    for touch in finger_touches(scene, state, before, move.opening, {}, allow):
        report("collision", f"the fingers change their opening: {sentence_of(touch)}", touch.bodies, touch.depth)


def finger_touches(
    scene: Scene, state: State, before: float, after: float, near: dict[str, float], allow: Tolerances
) -> list[Touch]:
    """What the fingers touch while they change their opening and the arm stands still.

    `near` gives the penetration [m] allowed for certain objects; all others get the numerical tolerance.
    """
    count = max(2, int(np.ceil(abs(after - before) / 2 / allow.step)) + 1)
    openings = np.linspace(before, after, count)
    fingers = {s.name: s for s in scene.links.solids if s.name in scene.links.gripper}
    T = {name: [] for name in fingers}  # type: dict[str, list[Array]]
    for opening in openings:
        placed = scene.links.tree.forward(state.q[None], float(opening))
        for name in fingers:
            T[name].append(placed[name][0])
    movers = [Mover(solid, np.array(T[name])) for name, solid in fingers.items()]
    others = standing(scene.solids, state.standing(scene))
    return touches((o, m, near.get(o.solid.name, allow.collision)) for o in others for m in movers)


def collisions(scene: Scene, state: State, move: Move, allow: Tolerances) -> Iterator[tuple[float, Touch]]:
    """Time [s] within the motion and bodies of everything that touches and must not."""
    robot, carried = scene.links, state.held or move.pushed

    def movers(q: Array) -> list[Mover]:
        placed = robot.tree.forward(q, move.opening)
        found = [Mover(solid, placed[solid.name]) for solid in robot.solids]
        if carried is not None:
            T_world_tool = placed[robot.tree.spec.tool_parent] @ robot.tree.spec.T_parent_tool.matrix
            found.append(Mover(scene.solids[carried.object], T_world_tool @ carried.T_tool_object.matrix))
        return found

    times = sample_times(move.trajectory, movers, allow.step)
    bodies = movers(interpolate(move.trajectory, times))
    for touch in touches(_pairs(scene, state, move, bodies, allow)):
        yield float(times[touch.sample]), touch


def _pairs(
    scene: Scene, state: State, move: Move, bodies: list[Mover], allow: Tolerances
) -> Iterator[tuple[Mover, Mover, float]]:
    robot, carried = scene.links, state.held or move.pushed
    by_name = {body.solid.name: body for body in bodies}
    held = by_name[carried.object] if carried is not None else None
    for other in standing(scene.solids, state.standing(scene)):
        if carried is not None and other.solid.name == carried.object:
            continue
        for solid in robot.solids:
            if other.solid.name == TABLE and solid.name in robot.fixed:
                continue
            yield other, by_name[solid.name], _allowed(move, ROBOT, solid, other.solid.name, robot.gripper, allow)
        if held is not None:
            yield other, held, _allowed(move, held.solid.name, held.solid, other.solid.name, frozenset(), allow)
    for a, b in robot.pairs:
        yield by_name[a.name], by_name[b.name], allow.collision
    if held is not None:
        for solid in robot.solids:
            yield by_name[solid.name], held, allow.contact if solid.name in robot.gripper else allow.collision


def _allowed(move: Move, body: str, solid: Solid, other: str, gripper: frozenset[str], allow: Tolerances) -> float:
    """Depth to which a body may enter another during a motion.

    A motion's word counts only where a contact makes sense: never on a free motion, and of the robot only for the
    gripper, and not with the table.
    """
    claimed = (body, other) in move.contacts or (other, body) in move.contacts
    if not claimed or move.phase in FREE:
        return allow.collision
    if body == ROBOT and (solid.name not in gripper or other == TABLE):
        return allow.collision
    return allow.contact
