"""Checks of one arm motion: continuity, limits, what it says it holds, collisions."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.actions import dynamics
from tamp.checking.actions.collisions.pairs import SLIDING, astray, grazing, presses_from, pressing
from tamp.checking.actions.collisions.strike import pushed_over, set_off
from tamp.checking.actions.collisions.wedging import wedged
from tamp.checking.geometry.solids import clearance
from tamp.checking.geometry.transforms import inverse
from tamp.checking.physics.contacts import contacts
from tamp.checking.physics.equilibrium import LEVEL
from tamp.checking.robot.cubic import interpolate
from tamp.checking.robot.load import overloaded
from tamp.checking.robot.sweep import Looks, Mover, Touch, looks, passed, slid, standing, touches
from tamp.checking.robot.trajectory_limits import malformed, violations
from tamp.checking.scene import GRAVITY, ROBOT, TABLE, Scene, State

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from numpy.typing import NDArray

    from tamp.checking.tolerances import Tolerances
    from tamp.task.plan import Attachment, Move

    Array = NDArray[np.float64]
    Report = Callable[..., None]

EMPTY = ("transit", "approach", "retreat", "push")
HOLDING = ("transfer", "lift", "lower")
MAX_LOOKS = 100_000
RUBBED = 0.01  # how far things may slide in all on an object that they press on within tolerance [m]
JAMS = 5e-4  # how much deeper than they began fingers that swing may press into the table [m]
ROUNDING = 1e-5  # of depths at which things rest [m]
SAME_PLACE = 1e-9  # what rounding leaves of equal poses [m, or cosine]
TOO_WILD = "the {} motion is too wild or too long to be judged"


def check_move(
    scene: Scene,
    state: State,
    move: Move,
    allow: Tolerances,
    report: Report,
    seen: Looks | None = None,
    taken: Mover | None = None,
) -> None:
    """Judge a motion and bring the state to its end.

    Args:
        scene: the world.
        state: what is where; changed.
        move: the motion.
        allow: tolerances.
        report: called as report(kind, sentence, bodies=(), depth=0.0, after=seconds into the motion).
        seen: the motion as `look` sees it, where it was looked at already.
        taken: what is pushed, where it is in truth at these looks, if that is not where the plan says.
    """
    spec = scene.links.tree.spec
    if (reason := malformed(move.trajectory, spec)) is not None:
        report("limits", f"the {move.phase} motion is no trajectory: {reason}")
        return
    if not -1e-9 <= move.opening <= spec.gripper.stroke + 1e-6:
        stroke = f"the gripper's stroke of 0 to {spec.gripper.stroke} m"
        report("limits", f"an opening of {move.opening:.4f} m is outside {stroke}")
        move = replace(move, opening=spec.gripper.stroke)
    _check_phase(state, move, report)
    _check_joined(state, move, spec.joints, allow, report)
    _check_fingers(scene, state, move, allow, report)
    for time, sentence in violations(move.trajectory, spec, allow):
        report("limits", sentence, after=time)
    found = seen or look(scene, move, state.held or move.pushed, allow.step)
    if found is None:
        report("limits", TOO_WILD.format(move.phase))
    else:
        if state.held is not None:
            _check_hold(scene, state, state.held, move, found, report)
        _check_contacts(scene, state, move, found, taken, allow, report)
    began, state.q = state.q, move.trajectory.positions[-1]
    if state.held is None or state.opening is None:
        state.opening = move.opening  # what is held keeps the fingers where they are: noise does not add up
    state.time += move.trajectory.duration
    _carry(scene, state, began)
    _let_follow(scene, state, allow)


def _check_hold(scene: Scene, state: State, held: Attachment, move: Move, found: Looks, report: Report) -> None:
    """Report why the fingers would not hold an object on its way: its weight, its inertia, or what pries them open."""
    _check_load(scene, held.object, move, found, report)
    loosened = [*dynamics.loosened(scene, held, move, found.times)]
    if state.hold is not None and not loosened:
        loosened += dynamics.squeezed_off(scene, held, state.hold, move, found.times)
    for sentence in (*loosened, *dynamics.pried_open(scene, held, move, found.times)):
        report("grasp", sentence, bodies=(held.object,))


def _check_contacts(
    scene: Scene, state: State, move: Move, found: Looks, taken: Mover | None, allow: Tolerances, report: Report
) -> None:
    """Report what a motion meets, and what it presses on, pushes, squeezes, drags over or wedges within tolerance."""
    met = set[str]()
    pressed = pressing(scene, state, move, found, allow)
    for touch in touches(pressed, found.swing):
        met.update(touch.bodies)
        after = float(found.times[touch.sample])
        report("collision", sentence_of(touch), bodies=touch.bodies, depth=touch.depth, after=after)
    in_truth = astray(scene, state, move, found, taken, allow)
    grazed = [*pressed, *grazing(in_truth, found)]
    for link, name in _rubbing(state, grazed, met, allow):
        report("collision", f"{link} presses on {name} as it slides over it, and takes it along", bodies=(link, name))
    for link, name in dict.fromkeys(pushed_over(scene, state, grazed, met, found.times, allow)):
        report("collision", f"{link} pushes {name}, which rolls or tips over", bodies=(link, name))
    for still, mover in sorted({touch.bodies for touch in touches(in_truth, found.swing)}):
        link, name = (mover, still) if still in state.stayed else (still, mover)
        where = "which is where the task has it, pads turned it, it was let go or gave way, not where the plan says"
        report("collision", f"{link} meets {name}, {where}", bodies=(link, name))
    for name in sorted(_squeezed(scene, state, move, found) - met):
        report("collision", f"the hand closes round {name} as it moves, tighter than that is wide", bodies=(name,))
    for name in _dragged_over(scene, state, move, found, allow):
        report("collision", f"what is held is dragged over {name}, which would come along", bodies=(name,))
    for held, name in _wedged(scene, state, move, found, allow):
        sentence = f"{held} is wedged in {name}, and slides neither out of it nor into it"
        report("collision", sentence, bodies=(held, name))


def _check_load(scene: Scene, name: str, move: Move, found: Looks, report: Report) -> None:
    """The arm bears the weight of what it holds all the way."""
    T, weight = found.bodies[-1].T, GRAVITY * scene.task.object(name).mass
    middle = inverse(T[0]) @ np.append(scene.center_of_mass(name, T[0]), 1.0)
    q = interpolate(move.trajectory, found.times)
    if (wrong := overloaded(scene.links.tree, q, (T @ middle)[:, :3], np.array([0.0, 0.0, -weight]))) is not None:
        look, sentence = wrong
        report("limits", f"the weight of {name} {sentence}", bodies=(name,), after=float(found.times[look]))


def sentence_of(touch: Touch) -> str:
    """A touch in words."""
    return f"{touch.bodies[1]} and {touch.bodies[0]} interpenetrate by {1000 * touch.depth:.1f} mm"


def _carry(scene: Scene, state: State, began: Array) -> None:
    """Move the held object to where the tool now is, which was at `began` [rad]."""
    if state.held is not None:
        name, (before, after) = state.held.object, scene.links.tree.tool(np.stack([began, state.q]))
        state.poses[name] = after @ state.held.T_tool_object.matrix
        if name in state.stayed:
            state.stayed[name] = after @ inverse(before) @ state.stayed[name]


def _let_follow(scene: Scene, state: State, allow: Tolerances) -> None:
    """What gives way to what has left it has done so as soon as the hand, and what that holds, are out of its way."""
    if not state.follows:
        return
    held = {} if state.held is None else {state.held.object: state.poses[state.held.object]}
    placed = scene.links.tree.forward(state.q[None], state.opening or 0.0)
    hand = [Mover(s, placed[s.name]) for s in scene.links.solids if s.name in scene.links.gripper]
    leaving = [*standing(scene.solids, held), *hand]
    ends = {body.solid.name: body for body in standing(scene.solids, state.follows)}
    barred = touches((end, body, allow.collision) for end in ends.values() for body in leaving)
    for name in state.follows.keys() - {touch.bodies[0] for touch in barred}:
        if name not in state.stayed:
            state.came.add(name)
        state.stayed[name] = state.follows.pop(name)


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
    elif move.held is not None and state.held is not None and not _same_place(move.held, state.held):
        report("continuity", f"{claimed} changes its place in the gripper while held", bodies=(str(claimed),))
    if move.phase in (EMPTY if actual else HOLDING):
        report("continuity", f"a {move.phase} motion while the gripper holds {actual or 'nothing'}")
    if (move.phase == "push") != (move.pushed is not None):
        report("continuity", f"a {move.phase} motion that pushes {move.pushed.object if move.pushed else 'nothing'}")


def _same_place(one: Attachment, other: Attachment) -> bool:
    """Whether two attachments put an object at the same place in the hand: q and -q are one orientation."""
    return bool(np.abs(one.T_tool_object.matrix - other.T_tool_object.matrix).max() <= SAME_PLACE)


def _check_joined(state: State, move: Move, joints: tuple[str, ...], allow: Tolerances, report: Report) -> None:
    jump = np.abs(move.trajectory.positions[0] - state.q)
    state.jumped = state.jumped + jump
    if state.jumped.max() > allow.joint:
        name = joints[int(state.jumped.argmax())]
        far = "" if jump.max() > allow.joint else f", {state.jumped.max():.4f} rad with the jumps before"
        report("continuity", f"the {move.phase} motion starts {jump.max():.4f} rad from where {name} is{far}")
        state.jumped = np.zeros_like(state.q)


def _check_fingers(scene: Scene, state: State, move: Move, allow: Tolerances, report: Report) -> None:
    """The fingers keep their opening; an empty gripper may change it where nothing is in their way."""
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

    `near` gives the penetration [m] allowed for certain objects; all others get the numerical tolerance, and what rolls
    none.
    """
    # Fingers that slide move by half of the opening, links that swing by less than all of it.
    way = abs(after - before) * (0.5 if scene.links.tree.spec.gripper.pads is None else 1.0)
    count = max(2, int(np.ceil(way / allow.step)) + 1)
    openings = np.linspace(before, after, count)
    fingers = {s.name: s for s in scene.links.solids if s.name in scene.links.gripper}
    T = {name: [] for name in fingers}  # type: dict[str, list[Array]]
    for opening in openings:
        placed = scene.links.tree.forward(state.q[None], float(opening))
        for name in fingers:
            T[name].append(placed[name][0])
    movers = [Mover(solid, np.array(T[name])) for name, solid in fingers.items()]
    others = [*standing(scene.solids, state.standing(scene)), *standing(scene.solids, _elsewhere(state, near))]
    found = touches((o, m, _yielding(o, m, near, allow)) for o in others for m in movers)
    met = {touch.bodies[0] for touch in found}
    free = [o for o in others if o.solid.name in state.poses and o.solid.name not in {*near, *met}]
    off = ((o, m, SLIDING) for o in free for m in movers if set_off(scene, state, o, m, SLIDING, allow))
    return [*found, *touches(off)]


def _yielding(other: Mover, finger: Mover, near: dict[str, float], allow: Tolerances) -> float:
    """Depth to which a finger that swings may enter a body [m]: the table gives no way, and fingers jam on it."""
    if other.solid.name != TABLE:
        return near.get(other.solid.name, allow.collision)
    began = -clearance(other.solid, finger.solid, inverse(other.T[0]) @ finger.T[0], allow.contact)
    return min(max(began, 0.0) + JAMS, allow.collision)


def _elsewhere(state: State, near: dict[str, float]) -> dict[str, Array]:
    """Where objects stay at the start that are said to stand elsewhere, but for those that the fingers handle."""
    return {name: T for name, T in state.stayed.items() if name not in near}


def look(scene: Scene, move: Move, carried: Attachment | None, step: float) -> Looks | None:
    """A motion, looked at so often that nothing moves by more than `step` [m] in between; None where that is too often.

    What moves are the links, and `carried` after them, which is at rest in the tool frame.
    """
    links = scene.links
    reach = links.reach
    if carried is not None:
        reach = links.reach_with(scene.solids[carried.object], carried.T_tool_object.matrix)

    def movers(q: Array) -> list[Mover]:
        placed = links.tree.forward(q, move.opening)
        moving = [Mover(solid, placed[solid.name]) for solid in links.solids]
        if carried is not None:
            T_world_tool = placed[links.tree.spec.tool_parent] @ links.tree.spec.T_parent_tool.matrix
            moving.append(Mover(scene.solids[carried.object], T_world_tool @ carried.T_tool_object.matrix))
        return moving

    return looks(move.trajectory, movers, step, reach, MAX_LOOKS)


def _rubbing(
    state: State, pressed: list[tuple[Mover, Mover, float]], met: set[str], allow: Tolerances
) -> Iterator[tuple[str, str]]:
    """What moves, and objects that it slides on, though within tolerance, farther than shifts come to, or too often.

    Friction takes them along. What a motion leaves, or comes to, is asked about elsewhere.
    """
    farthest = dict[str, tuple[float, str]]()
    for still, mover, depth in pressed:
        name = still.solid.name
        if name in state.poses and name not in met and len(still.T) == 1 and depth <= allow.collision + ROUNDING:
            rubs = slid(still, mover, presses_from(still, mover, allow)), mover.solid.name
            farthest[name] = max(farthest.get(name, rubs), rubs)
    for name, (far, link) in farthest.items():
        state.rubbed[name] = state.rubbed.get(name, 0.0) + far
        if far > allow.strayed or (far > 0.0 and state.rubbed[name] > RUBBED):
            yield link, name


def _squeezed(scene: Scene, state: State, move: Move, found: Looks) -> set[str]:
    """Objects that two links of an empty hand press on at some time of a motion, though each within tolerance."""
    if state.held is not None or move.pushed is not None:
        return set()
    hand = [body for body in found.bodies if body.solid.name in scene.links.gripper]
    near = passed(hand, standing(scene.solids, state.poses))
    if len(hand) < 2 or not near:
        return set()
    pressed = [touch.bodies[0] for touch in touches(((o, link, SLIDING) for o in near for link in hand), found.swing)]
    return {name for name in pressed if pressed.count(name) > 1}


def _dragged_over(scene: Scene, state: State, move: Move, found: Looks, allow: Tolerances) -> Iterator[str]:
    """Objects that what is held leaves, or comes to, and that it slides on for more than shifts may come to.

    Friction would take them along: what stands level on an object is lifted off it.
    """
    if state.held is None or move.phase not in ("lift", "lower"):
        return
    taken = found.bodies[-1]
    resting = taken.T[0 if move.phase == "lift" else -1]
    aside = np.linalg.norm(taken.T[:, :2, 3] - resting[:2, 3], axis=1) > allow.strayed
    if not aside.any():
        return
    moved = Mover(taken.solid, np.ascontiguousarray(taken.T[aside]))
    for name in sorted({other for pair in move.contacts for other in pair} & state.poses.keys() - {taken.solid.name}):
        solid, T = scene.solids[name], state.poses[name]
        patch = contacts(taken.solid, resting, {name: (solid, T)}, allow.standing).patches.get(name)
        level = patch is not None and bool((patch.normals[:, 2] > LEVEL).all())
        if level and touches([(Mover(solid, T[None].copy()), moved, SLIDING)]):
            yield name


def _wedged(scene: Scene, state: State, move: Move, found: Looks, allow: Tolerances) -> Iterator[tuple[str, str]]:
    """What is held, and objects that it does not slide out of, or into, whatever a plan says that it touches."""
    if state.held is not None:
        for name in wedged(scene, state, move.phase, found, allow):
            yield state.held.object, name


def sensible(scene: Scene, state: State, move: Move, touched: str, allow: Tolerances) -> Move:
    """The motion with a word on contacts only that makes sense.

    What the hand holds touches what it leaves or comes to: what is near it where a lift begins, or where the object is
    lowered to. The hand itself touches what it holds, and what an action's rule says is `touched`: fingers that come to
    an object, or leave it, are open.
    """
    held, near = state.held, set[str]()
    if held is not None and malformed(move.trajectory, scene.links.tree.spec) is None:
        ends = scene.links.tree.tool(move.trajectory.positions[[0, -1]]) @ held.T_tool_object.matrix
        resting = {"lift": ends[:1], "lower": ends[1:]}.get(move.phase, ends)
        claimed = {other for pair in move.contacts if held.object in pair for other in pair}
        for other, T in state.standing(scene).items():
            gaps = (_gap(scene, other, T, held.object, end, allow) for end in resting if other in claimed)
            if any(gap <= allow.standing for gap in gaps):
                near.add(other)
    kept = {(held.object, other) for other in near} if held is not None else set()
    by_hand = {(ROBOT, touched), (touched, ROBOT)} & move.contacts
    return replace(move, contacts=frozenset(kept | by_hand))


def _gap(scene: Scene, a: str, T_a: Array, b: str, T_b: Array, allow: Tolerances) -> float:
    first, second = scene.solids[a], scene.solids[b]
    apart = T_a[:3, :3] @ first.center + T_a[:3, 3] - T_b[:3, :3] @ second.center - T_b[:3, 3]
    if float(np.linalg.norm(apart)) > first.radius + second.radius + allow.standing:
        return np.inf
    return clearance(first, second, inverse(T_a) @ T_b, allow.contact)
