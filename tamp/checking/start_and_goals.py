"""Checks of a plan's two ends: does it start from the task's scene, and does it reach the task's goals?"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.geometry.solids import clearance
from tamp.checking.geometry.transforms import inverse
from tamp.checking.physics.giving_way import on_edge
from tamp.checking.physics.round_bodies.perching import perched, pressed_away, round_axes
from tamp.checking.physics.round_bodies.rocking import rocked
from tamp.checking.physics.settling import stayed, unexplained
from tamp.checking.physics.stacks import off_balance, stack_of
from tamp.checking.physics.support import balanced, carriers, misplaced, overlaps
from tamp.checking.robot.sweep import Mover, standing, touches
from tamp.checking.scene import Scene, State, footprint_center, in_region
from tamp.task.mesh.enclosure import lies_in
from tamp.task.model import At, In, On

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from tamp.checking.replay import Replay
    from tamp.checking.tolerances import Tolerances
    from tamp.task.plan import Plan
    from tamp.task.pose import Pose

    Array = NDArray[np.float64]

STEEP = 0.7
"""Vertical component of a contact normal from which on what it carries is on it though something else carries that."""
SAME = 1e-6
"""Poses that are no farther apart are the same [m]."""
DISJOINT = 0.005
"""Deeper in a goal pose, an object without one is not part of the scene in which the goals settle [m]."""


def check_start(replay: Replay, exact: Mapping[str, Pose] | None) -> None:
    """The plan starts from the scene as it is known, or else from the task's scene after settling.

    An observed scene is the truth, whatever it looks like. A settled one is where settling takes each object from its
    pose in the task, with nothing in the air, nothing inside anything else, nothing round pressed to roll, and every
    stack in balance.

    Args:
        replay: a replay before its first action.
        exact: the poses that the scene is known to have, or None where only the task is known.
    """
    scene, state, allow = replay.scene, replay.state, replay.allow
    if exact is not None:
        for name in sorted(exact):
            drift = scene.displacement(name, exact[name].matrix, state.poses[name])
            if drift > allow.reached:
                replay.report("start", f"{name} starts {1000 * drift:.0f} mm from where it stands", (name,), drift)
        return
    note_stayed(scene, state, allow)
    written = {thing.name: thing.pose.matrix for thing in scene.task.objects}
    for name in sorted(written):
        astray = unexplained(scene, state, name, written, allow)
        if (stays := state.stayed.get(name)) is not None:
            off = scene.displacement(name, stays, state.poses[name])
            astray = max(astray, off if off > allow.placed else 0.0)
        if astray > 0.0:
            sentence = f"{name} starts {1000 * astray:.0f} mm from where it settles from its pose in the task"
            replay.report("start", sentence, (name,), astray)
        for sentence, bodies, depth in overlaps(scene, state, name, allow):
            replay.report("start", f"at the start {sentence}", bodies, depth)
        for where, far in misplaced(scene, state, name, allow):
            replay.report("start", f"{name} starts {where}, with what carries it", (name,), far)
        rolls = (found for found in pressed_away(scene, state, name, allow) if round_axes(scene, state, found[1][1]))
        for sentence, bodies in (*perched(scene, state, name, allow), *rolls):
            replay.report("start", f"at the start {sentence}", bodies)
    for sentence, bodies in rocked(scene, state, sorted(written), allow):
        replay.report("start", f"at the start {sentence}", bodies)
    for name in sorted(written):
        if on_edge(scene, state, name, allow):
            sentence = f"{name} starts on the very edge of what carries it, or beyond, and tips over that"
            replay.report("start", sentence, (name,))
    for name, far in _off_balance(scene, state, allow).items():
        how = f"{1000 * far:.0f} mm off balance"
        if np.isinf(far):
            how = "where friction does not hold it" if carriers(scene, state, name, allow).bodies else "in the air"
        replay.report("start", f"{name} starts {how}", (name,), min(far, 1.0))


def note_stayed(scene: Scene, state: State, allow: Tolerances) -> None:
    """Note of each object where it stays as the task has it, though it is said to start a little elsewhere."""
    written = {thing.name: thing.pose.matrix for thing in scene.task.objects}
    for name in sorted(written):
        state.beside[name] = _beside(scene, name, written[name], state.poses[name], allow)
        if (stays := stayed(scene, state, name, written, allow)) is not None:
            state.stayed[name] = stays


def check_continued(replay: Replay, plan: Plan) -> None:
    """A plan that continues another starts where that has left everything, the arm too."""
    scene, state, allow = replay.scene, replay.state, replay.allow
    for name in sorted(plan.start):
        drift = scene.displacement(name, state.poses[name], plan.start[name].matrix)
        if drift > allow.reached:
            replay.report("start", f"{name} starts {1000 * drift:.0f} mm from where it was left", (name,), drift)
    off = float(np.abs(state.q - np.array(plan.home)).max())
    if not off <= allow.joint:
        replay.report("start", f"the arm starts {off:.4f} rad from where it was left")


def _beside(scene: Scene, name: str, written: Array, said: Array, allow: Tolerances) -> float:
    """How far aside of where it is said to stand an object stays, that may stay where it is written [m]."""
    way = scene.center_of_mass(name, said) - scene.center_of_mass(name, written)
    return float(np.hypot(way[0], way[1])) if scene.displacement(name, written, said) <= allow.placed else 0.0


def check_home(replay: Replay, *, known: bool) -> None:
    """The arm starts from the robot's home, or, where the scene is `known`, from wherever a plan before has left it."""
    home = np.array(replay.scene.links.tree.spec.home)
    if not np.isfinite(replay.state.q).all():
        replay.report("start", "the plan's home holds numbers that are not finite")
        replay.state.q = home
    off = np.abs(replay.state.q - home)
    if not known and off.max() > replay.allow.joint:
        joint = replay.scene.links.tree.spec.joints[int(off.argmax())]
        replay.report("start", f"the arm starts {off.max():.4f} rad from the robot's home, at {joint}")
    if not known:
        _check_beside(replay, home)


def _check_beside(replay: Replay, home: Array) -> None:
    """Nothing starts in the robot, which stands at home with its fingers open."""
    scene, state = replay.scene, replay.state
    placed = scene.links.tree.forward(home[None], scene.links.tree.spec.gripper.stroke)
    robot = [Mover(solid, placed[solid.name]) for solid in scene.links.solids]
    things = standing(scene.solids, state.poses)
    for touch in touches((thing, link, replay.allow.collision) for thing in things for link in robot):
        name, link = touch.bodies
        replay.report("start", f"{name} starts {1000 * touch.depth:.1f} mm in {link}", (name, link), touch.depth)


def _off_balance(scene: Scene, state: State, allow: Tolerances) -> dict[str, float]:
    """The objects that would not stay where they stand, and by how much they are off balance [m]."""
    found, waiting = dict[str, float](), sorted(state.poses)
    while waiting:
        stack = stack_of(scene, state, waiting[0], allow)
        waiting = [name for name in waiting if name not in stack.names]
        found |= {name: far for name, far in off_balance(scene, state, stack).items() if far > allow.balance}
        for name in stack.names:
            touching = carriers(scene, state, name, allow)
            balance = balanced(scene, state, name, touching, allow) if touching.bodies else -np.inf
            if balance < -allow.balance:
                found.setdefault(name, -balance)
    return found


def check_goals(replay: Replay, plan: Plan, settled: Mapping[str, Pose] | None) -> None:
    """Every goal of the task holds at the end of the plan.

    Args:
        replay: a replay after its last action.
        plan: says what it takes the goals for.
        settled: where goal poses are known to settle, or None where only the task is known.
    """
    state = replay.state
    if state.held is not None:
        replay.report("goal", f"the plan ends with {state.held.object} still in the hand", (state.held.object,))
    asked = {thing.name for thing in replay.scene.task.objects if isinstance(thing.goal, At)}
    for name in sorted(plan.goals.keys() - asked) if settled is None else ():
        replay.report("goal", f"the plan names a pose as the goal of {name}, for which the task asks none", (name,))
    for thing in replay.scene.task.objects:
        if isinstance(thing.goal, At):
            _check_at(replay, plan, thing.name, settled)
        elif thing.goal is not None:
            _check_relation(replay, thing.name, thing.goal)
    for fact in replay.scene.task.goal:
        if fact not in state.facts:
            replay.report("goal", f"({' '.join(fact)}) does not hold at the end", fact[1:])


def _check_at(replay: Replay, plan: Plan, name: str, settled: Mapping[str, Pose] | None) -> None:
    scene, allow = replay.scene, replay.allow
    meant = plan.goals.get(name)
    if meant is None:
        replay.report("goal", f"the plan names no pose for the goal of {name}", (name,))
        return
    if settled is None:
        _check_settled(replay, plan, name, meant)
    else:
        astray = scene.displacement(name, meant.matrix, settled[name].matrix)
        if astray > allow.reached:
            sentence = f"the plan's goal of {name} is {1000 * astray:.0f} mm from the task's"
            replay.report("goal", sentence, (name,), astray)
    given = replay.state.given.get(name)
    missed = scene.error(name, replay.state.poses[name] if given is None else given.pose, meant.matrix)
    missed += replay.state.strayed.get(name, 0.0)  # small shifts on the way and at the end do not add up
    if missed > allow.reached:
        replay.report("goal", f"{name} ends {1000 * missed:.0f} mm from its goal", (name,), missed)


def _check_settled(replay: Replay, plan: Plan, name: str, meant: Pose) -> None:
    """The plan's goal, and where the object ends, are each where the task's goal settles to, among all as they end.

    What carries the goal as the task has it is not to be taken away, so that the goal would settle elsewhere.
    """
    scene = replay.scene
    asked = {o.name: o.goal.pose.matrix for o in scene.task.objects if isinstance(o.goal, At)}
    ends, founded = replay.state, _founded(replay, plan, name, asked)
    among = {**ends.poses, **founded}
    barring = _barring(replay, plan, name, asked, among)
    if founded or barring:
        ends = replace(ends, poses={other: T for other, T in among.items() if other not in barring}, touching={})
    claimed = replace(ends, poses={**ends.poses, name: meant.matrix})
    both = [(claimed, f"the plan's goal of {name} is"), (ends, f"{name} ends")]
    same = scene.displacement(name, meant.matrix, ends.poses[name]) < SAME
    for state, title in both[same:]:
        astray = unexplained(scene, state, name, asked, replay.allow)
        if astray > 0.0:
            replay.report("goal", f"{title} {1000 * astray:.0f} mm from where the task's settles", (name,), astray)


def _founded(replay: Replay, plan: Plan, name: str, asked: Mapping[str, Array]) -> dict[str, Array]:
    """Where objects without a goal pose started that the plan has moved, and that carry another's goal from there."""
    scene, state = replay.scene, replay.state
    began = {other: plan.start[other].matrix for other in sorted(plan.start.keys() - asked.keys())}
    idle = {other: T for other, T in began.items() if scene.displacement(other, T, state.poses[other]) > SAME}
    if not idle:
        return {}
    wanted = replace(state, poses={**state.poses, **idle, name: asked[name]}, touching={})
    carrying = carriers(scene, wanted, name, replay.allow).bodies
    return {other: T for other, T in idle.items() if other in carrying}


def _barring(replay: Replay, plan: Plan, name: str, asked: Mapping[str, Array], among: Mapping[str, Array]) -> set[str]:
    """Objects without a goal pose, of some, that stand where another's is: they have to leave, and do not push it.

    What has stood there from the beginning, and is in it by no more than rounding, pushes it aside by as much.
    """
    scene, found = replay.scene, set[str]()
    for other in sorted(plan.start.keys() - asked.keys()):
        T = among[other]
        stood = scene.displacement(other, T, plan.start[other].matrix) <= SAME
        apart = clearance(scene.solids[name], scene.solids[other], inverse(asked[name]) @ T, replay.allow.contact)
        if -apart > (DISJOINT if stood else replay.allow.collision):
            found.add(other)
    return found


def _check_relation(replay: Replay, name: str, goal: On | In) -> None:
    scene, state = replay.scene, replay.state
    regions = {region.name: region for region in scene.task.regions}
    if goal.target in regions:
        holds = in_region(scene, state, name, regions[goal.target])
    elif isinstance(goal, On):
        holds = _stands_on(scene, state, name, goal.target, replay.allow)
    else:
        shape, container = (scene.task.object(each).shape for each in (name, goal.target))
        holds = lies_in(shape, state.poses[name], container, state.poses[goal.target])
    if not holds:
        relation = "in" if isinstance(goal, In) else "on"
        replay.report("goal", f"{name} does not end {relation} {goal.target}", (name, goal.target))


def _stands_on(scene: Scene, state: State, name: str, target: str, allow: Tolerances) -> bool:
    """Whether an object is on another one: over it, and carried by it, not merely beside it and touching its slope."""
    touching, T = carriers(scene, state, name, allow), state.poses[target]
    corners = (scene.solids[target].hull.part.vertices @ T[:3, :3].T + T[:3, 3])[:, :2]
    middle = np.array(footprint_center(scene, state.poses[name], name))
    beside = np.maximum(corners.min(axis=0) - middle, middle - corners.max(axis=0)).max()
    if target not in touching.bodies or beside > 0.0:
        return False
    level = (touching.patches[target].normals[:, 2] > STEEP).any()
    return bool(level or balanced(scene, state, name, touching.without(target), allow) < allow.balance)
