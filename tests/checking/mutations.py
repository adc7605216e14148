"""Corruptions of valid plans, each with the kind of problem that the checker must find in it.

A mutation takes a task, a valid plan and a random generator and returns the corrupted pair, or None where the plan
gives it nothing to corrupt. `MUTATIONS` names them all with the kinds of problem that are the right reason for
rejecting them: the checker must name at least one of those.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from tamp.checking.kinematics import read_kinematics
from tamp.task import Action, At, Attachment, Grip, Move, Plan, Pose, Release, Step, Task, Trajectory, load_robot

Pair = tuple[Task, Plan]
Mutation = Callable[[Task, Plan, np.random.Generator], Pair | None]


def steps_of(plan: Plan, kind: type, *phases: str) -> list[tuple[int, int]]:
    """Indices (action, step) of steps of a kind, of moves in certain phases."""
    return [
        (i, j)
        for i, action in enumerate(plan.actions)
        for j, step in enumerate(action.steps)
        if isinstance(step, kind) and (not phases or (isinstance(step, Move) and step.phase in phases))
    ]


def put(plan: Plan, where: tuple[int, int], *steps: Step) -> Plan:
    """The plan with one step replaced by others."""
    i, j = where
    action = plan.actions[i]
    changed = replace(action, steps=(*action.steps[:j], *steps, *action.steps[j + 1 :]))
    return replace(plan, actions=(*plan.actions[:i], changed, *plan.actions[i + 1 :]))


def step_at(plan: Plan, where: tuple[int, int]) -> Step:
    return plan.actions[where[0]].steps[where[1]]


def choose(options: list, rng: np.random.Generator):
    return options[int(rng.integers(len(options)))] if options else None


def bumped(trajectory: Trajectory, offset: np.ndarray) -> Trajectory:
    """The motion with a smooth detour by `offset` [rad] in its middle, slowed until it is easy for the joints."""
    spec = load_robot("panda")
    share = trajectory.times / trajectory.duration
    size, rate = np.sin(np.pi * share) ** 2, np.sin(2 * np.pi * share) * np.pi / trajectory.duration
    q = trajectory.positions + size[:, None] * offset
    v = trajectory.velocities + rate[:, None] * offset
    a = np.diff(v, axis=0) / np.diff(trajectory.times)[:, None]
    slower = 1.05 * max(1.0, (np.abs(v) / spec.velocity).max(), np.sqrt((np.abs(a) / spec.acceleration).max()))
    v = v / slower
    v[[0, -1]] = 0.0
    return Trajectory(trajectory.times * slower, q, v)


def shifted(pose: Pose, by: np.ndarray) -> Pose:
    return Pose(tuple(np.array(pose.xyz) + by), pose.quat)


def sideways(rng: np.random.Generator, low: float, high: float) -> np.ndarray:
    """A horizontal vector of random direction and length [m]."""
    angle, length = rng.uniform(0, 2 * np.pi), rng.uniform(low, high)
    return length * np.array([np.cos(angle), np.sin(angle), 0.0])


def swap_actions(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    if len(plan.actions) < 2:
        return None
    i = int(rng.integers(len(plan.actions) - 1))
    actions = list(plan.actions)
    actions[i], actions[i + 1] = actions[i + 1], actions[i]
    return task, replace(plan, actions=tuple(actions))


def drop_action(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """Any action but the last, whose loss may go unnoticed where it only returns home."""
    if len(plan.actions) < 2:
        return None
    i = int(rng.integers(len(plan.actions) - 1))
    return task, replace(plan, actions=plan.actions[:i] + plan.actions[i + 1 :])


def repeat_action(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    i = choose([i for i, action in enumerate(plan.actions) if action.name != "move"], rng)
    return None if i is None else (task, replace(plan, actions=plan.actions[: i + 1] + plan.actions[i:]))


def shift_into_table(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """A smooth detour of a free motion through the table top."""
    where = choose(steps_of(plan, Move, "transit", "transfer"), rng)
    if where is None:
        return None
    move, tree = step_at(plan, where), read_kinematics(load_robot(task.robot))
    middle = move.trajectory.positions[len(move.trajectory.times) // 2]
    for angle in np.linspace(0.1, 2.0, 40):
        offset = np.zeros(len(middle))
        offset[1] = angle
        if tree.tool((middle + offset)[None])[0, 2, 3] < -rng.uniform(0.02, 0.05):
            return task, put(plan, where, replace(move, trajectory=bumped(move.trajectory, offset)))
    return None


def object_in_the_way(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """Another object stands where the tool passes."""
    where = choose(steps_of(plan, Move, "transit", "transfer"), rng)
    handled = {a.arguments[0] for a in plan.actions if a.arguments}
    name = choose([thing.name for thing in task.objects if thing.name not in handled], rng)
    if where is None or name is None:
        return None
    path = step_at(plan, where).trajectory.positions
    T = read_kinematics(load_robot(task.robot)).tool(path[int(rng.integers(len(path)))][None])[0]
    pose = Pose(tuple(T[:3, 3]), plan.start[name].quat)
    objects = tuple(replace(o, pose=pose) if o.name == name else o for o in task.objects)
    return replace(task, objects=objects), replace(plan, start={**plan.start, name: pose})


def speed_up(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """Everything faster, by at least a tenth over what the fastest motion of the plan may be."""
    factor = rng.uniform(1.1, 2.0)
    for i, j in steps_of(plan, Move):
        move = step_at(plan, (i, j))
        t = move.trajectory
        faster = Trajectory(t.times / factor, t.positions.copy(), t.velocities * factor)
        plan = put(plan, (i, j), replace(move, trajectory=faster))
    return task, plan


def hurry(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The clock runs faster, the velocities stay as they were."""
    where = choose(steps_of(plan, Move, "transit", "transfer"), rng)
    if where is None:
        return None
    move = step_at(plan, where)
    t = move.trajectory
    rushed = Trajectory(t.times / rng.uniform(1.3, 2.0), t.positions.copy(), t.velocities.copy())
    return task, put(plan, where, replace(move, trajectory=rushed))


def drop_waypoints(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """Samples are missing from the middle of a motion, and the time they took with them."""
    where = choose([w for w in steps_of(plan, Move) if len(step_at(plan, w).trajectory.times) >= 20], rng)
    if where is None:
        return None
    move = step_at(plan, where)
    t = move.trajectory
    n = len(t.times)
    first = int(rng.integers(n // 3, n // 2))
    count = int(rng.integers(2, max(3, n // 8)))
    keep = np.r_[0 : first + 1, first + count + 1 : n]
    times = t.times.copy()
    times[first + count + 1 :] -= times[first + count] - times[first]
    return task, put(
        plan, where, replace(move, trajectory=Trajectory(times[keep], t.positions[keep], t.velocities[keep]))
    )


def shift_waypoint(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """One sample is elsewhere."""
    where = choose(steps_of(plan, Move), rng)
    if where is None:
        return None
    move = step_at(plan, where)
    t = move.trajectory
    q = t.positions.copy()
    q[int(rng.integers(len(q))), int(rng.integers(q.shape[1]))] += rng.choice([-1, 1]) * rng.uniform(0.02, 0.5)
    return task, put(plan, where, replace(move, trajectory=Trajectory(t.times.copy(), q, t.velocities.copy())))


def beyond_joint_limit(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    where = choose(steps_of(plan, Move, "transit", "transfer"), rng)
    if where is None:
        return None
    spec, move = load_robot(task.robot), step_at(plan, where)
    middle = move.trajectory.positions[len(move.trajectory.times) // 2]
    offset, joint = np.zeros(len(middle)), int(rng.integers(len(middle)))
    offset[joint] = spec.upper[joint] - middle[joint] + rng.uniform(0.1, 0.5)
    return task, put(plan, where, replace(move, trajectory=bumped(move.trajectory, offset)))


def not_at_rest(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """A motion is cut off while the arm moves, and the next goes on from where it should have ended."""
    where = choose([w for w in steps_of(plan, Move) if len(step_at(plan, w).trajectory.times) >= 10], rng)
    if where is None:
        return None
    move = step_at(plan, where)
    t, n = move.trajectory, len(move.trajectory.times)
    cut = slice(0, int(rng.integers(n // 3, 2 * n // 3)))
    shorter = Trajectory(t.times[cut].copy(), t.positions[cut].copy(), t.velocities[cut].copy())
    return task, put(plan, where, replace(move, trajectory=shorter))


def teleport(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """A motion is missing: the arm is suddenly elsewhere."""
    where = choose([w for w in steps_of(plan, Move) if len(plan.actions) - 1 > w[0]], rng)
    return None if where is None else (task, put(plan, where))


def regrip(task: Task, plan: Plan, where: tuple[int, int], attachment: Attachment, width: float) -> Plan:
    """The plan with another grip and the same hold in the motions that follow, up to the release."""
    plan = put(plan, where, Grip(attachment, width))
    for other in steps_of(plan, Move):
        if other > where and (move := step_at(plan, other)).held is not None:
            plan = put(plan, other, replace(move, held=attachment))
        elif other > where:
            break
    return plan


def grasp_beside(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The object is elsewhere in the hand than where it stands."""
    where = choose(steps_of(plan, Grip), rng)
    if where is None:
        return None
    grip = step_at(plan, where)
    T = shifted(grip.attachment.T_tool_object, sideways(rng, 0.005, 0.05))
    return task, regrip(task, plan, where, replace(grip.attachment, T_tool_object=T), grip.width)


def grasp_air(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The object stands beside the place where the fingers close; task and plan agree on that."""
    where = choose(steps_of(plan, Grip), rng)
    if where is None:
        return None
    name = step_at(plan, where).attachment.object
    if any(step_at(plan, w).attachment.object == name for w in steps_of(plan, Grip) if w < where):
        return None
    pose = shifted(plan.start[name], sideways(rng, 0.1, 0.2))
    objects = tuple(replace(o, pose=pose) if o.name == name else o for o in task.objects)
    return replace(task, objects=objects), replace(plan, start={**plan.start, name: pose})


def wrong_width(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    where = choose(steps_of(plan, Grip), rng)
    if where is None:
        return None
    grip = step_at(plan, where)
    by = rng.uniform(0.01, 0.03) * (1 if grip.width < 0.04 else -1)
    return task, put(plan, where, replace(grip, width=grip.width + by))


def wrong_object(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    where = choose(steps_of(plan, Grip), rng)
    if where is None or len(task.objects) < 2:
        return None
    grip = step_at(plan, where)
    name = choose([o.name for o in task.objects if o.name != grip.attachment.object], rng)
    return task, regrip(task, plan, where, replace(grip.attachment, object=name), grip.width)


def wrong_argument(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The action's name speaks of another object than its steps."""
    i = choose([i for i, action in enumerate(plan.actions) if action.arguments], rng)
    others = [o.name for o in task.objects if i is not None and o.name != plan.actions[i].arguments[0]]
    if not others:
        return None
    changed = replace(plan.actions[i], arguments=(choose(others, rng), *plan.actions[i].arguments[1:]))
    return task, replace(plan, actions=(*plan.actions[:i], changed, *plan.actions[i + 1 :]))


def keep_holding(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The fingers never open."""
    where = choose(steps_of(plan, Release), rng)
    return None if where is None else (task, put(plan, where))


def never_grip(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    where = choose(steps_of(plan, Grip), rng)
    return None if where is None else (task, put(plan, where))


def slip_in_hand(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The held object jumps within the hand between two motions."""
    where = choose(steps_of(plan, Move, "transfer", "lower"), rng)
    if where is None:
        return None
    move = step_at(plan, where)
    T = shifted(move.held.T_tool_object, rng.normal(size=3) * 0.01)
    return task, put(plan, where, replace(move, held=replace(move.held, T_tool_object=T)))


def place_in_the_air(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """Let go above the support, and meant to stay there."""
    where = choose(steps_of(plan, Release), rng)
    if where is None:
        return None
    release = step_at(plan, where)
    up = np.array([0.0, 0.0, rng.uniform(0.02, 0.1)])
    return task, put(plan, where, replace(release, pose=shifted(release.pose, up)))


def drop_from_height(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The object is let go before it has been lowered."""
    where = choose(steps_of(plan, Move, "lower"), rng)
    if where is None:
        return None
    i, j = where
    rest = plan.actions[i].steps[j + 1 :]
    if not rest or not isinstance(rest[0], Release):
        return None
    lower = step_at(plan, where)
    empty = replace(lower, phase="retreat", held=None, opening=rest[0].opening, contacts=frozenset())
    action = replace(plan.actions[i], steps=(*plan.actions[i].steps[:j], rest[0], empty, *rest[1:]))
    return task, replace(plan, actions=(*plan.actions[:i], action, *plan.actions[i + 1 :]))


def place_elsewhere(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The object is said to stand where the hand never was; its goal moves along."""
    where = choose(steps_of(plan, Release), rng)
    if where is None:
        return None
    release = step_at(plan, where)
    pose = shifted(release.pose, sideways(rng, 0.025, 0.2))
    return task, put(plan, where, replace(release, pose=pose))


def half_off_the_table(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The table ends under an object that is put down."""
    name = choose([n for n in sorted(plan.goals) if abs(plan.goals[n].xyz[2]) < 0.2], rng)
    places = [w for w in steps_of(plan, Release) if step_at(plan, w).object == name]
    if not places or plan.actions[places[-1][0]].name != "place":
        return None
    y = step_at(plan, places[-1]).pose.xyz[1]
    table = task.table
    low, high = table.center[1] - table.size[1] / 2, table.center[1] + table.size[1] / 2
    low, high = (low, y - rng.uniform(0.012, 0.02)) if y > 0 else (y + rng.uniform(0.012, 0.02), high)
    table = replace(table, center=(table.center[0], (low + high) / 2), size=(table.size[0], high - low))
    return replace(task, table=table), plan


def forget_to_retreat(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The hand stays round what it has put down."""
    where = choose(steps_of(plan, Move, "retreat"), rng)
    return None if where is None else (task, put(plan, where))


def release_another(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """An object that nobody holds is moved."""
    where = choose(steps_of(plan, Release), rng)
    if where is None or len(task.objects) < 2:
        return None
    release = step_at(plan, where)
    name = choose([o.name for o in task.objects if o.name != release.object], rng)
    return task, put(plan, where, replace(release, object=name))


def stale_start(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The scene has changed since the plan was made."""
    name = choose(sorted(plan.start), rng)
    pose = shifted(plan.start[name], sideways(rng, 0.04, 0.2))
    return task, replace(plan, start={**plan.start, name: pose})


def start_in_the_air(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    name = choose(sorted(plan.start), rng)
    pose = shifted(plan.start[name], np.array([0.0, 0.0, rng.uniform(0.01, 0.1)]))
    return task, replace(plan, start={**plan.start, name: pose})


def other_home(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    home = list(plan.home)
    home[int(rng.integers(len(home)))] += rng.choice([-1, 1]) * rng.uniform(0.01, 0.3)
    return task, replace(plan, home=tuple(home))


def goal_missed(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The task asks for something else than the plan does."""
    name = choose([o.name for o in task.objects if isinstance(o.goal, At)], rng)
    if name is None:
        return None
    goal = At(shifted(task.object(name).goal.pose, sideways(rng, 0.035, 0.3)))
    objects = tuple(replace(o, goal=goal) if o.name == name else o for o in task.objects)
    return replace(task, objects=objects), plan


def stop_early(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The last object stays where it is."""
    picks = [i for i, action in enumerate(plan.actions) if action.name in ("pick", "unstack")]
    return None if not picks else (task, replace(plan, actions=plan.actions[: picks[-1]]))


def closed_fingers(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The fingers are closed already when the hand comes down on the object."""
    where = choose(steps_of(plan, Move, "approach"), rng)
    if where is None:
        return None
    move = step_at(plan, where)
    return task, put(plan, where, replace(move, opening=rng.uniform(0.0, 0.015)))


def unknown_action(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    i = int(rng.integers(len(plan.actions)))
    changed = Action("push", plan.actions[i].arguments, plan.actions[i].steps)
    return task, replace(plan, actions=(*plan.actions[:i], changed, *plan.actions[i + 1 :]))


MUTATIONS: dict[Mutation, tuple[str, ...]] = {
    swap_actions: ("continuity", "precondition"),
    drop_action: ("continuity", "precondition"),
    repeat_action: ("continuity", "precondition"),
    shift_into_table: ("collision",),
    object_in_the_way: ("collision",),
    speed_up: ("limits",),
    hurry: ("limits",),
    drop_waypoints: ("limits",),
    shift_waypoint: ("limits", "continuity"),
    beyond_joint_limit: ("limits",),
    not_at_rest: ("limits",),
    teleport: ("continuity",),
    grasp_beside: ("grasp",),
    grasp_air: ("grasp",),
    wrong_width: ("grasp",),
    wrong_object: ("grasp",),
    wrong_argument: ("precondition",),
    keep_holding: ("precondition", "continuity"),
    never_grip: ("continuity", "precondition"),
    slip_in_hand: ("continuity",),
    place_in_the_air: ("support",),
    drop_from_height: ("release",),
    place_elsewhere: ("release",),
    half_off_the_table: ("support",),
    forget_to_retreat: ("release",),
    release_another: ("precondition",),
    stale_start: ("start",),
    start_in_the_air: ("start",),
    other_home: ("continuity",),
    goal_missed: ("goal",),
    stop_early: ("goal",),
    closed_fingers: ("collision",),
    unknown_action: ("precondition",),
}
