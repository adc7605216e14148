"""Corruptions of the arm's motions: their way, their speed, their samples."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tamp.checking.robot.kinematics import read_kinematics
from tamp.task import Action, Box, Cylinder, Move, Object, Plan, Pose, Task, Trajectory, load_robot
from tests.checking.handmade import DOWN, OPEN, Hand, above, timed
from tests.checking.mutations.editing import Pair, added, choose, put, stand, step_at, steps_of

CARD, STAND = Box((0.004, 0.06, 0.15)), Box((0.06, 0.06, 0.06))
BAR, CAN = Box((0.12, 0.04, 0.05)), Cylinder(0.03, 0.1)
FRONT, PALM = 0.0091, 0.0105  # how far a finger reaches ahead of the tool, by its tip and by all of it [m]
BESIDE, TIP = 0.045, 0.00885  # of an open Panda's finger to the tool, and of its tip under that [m]
CLEAR = 0.15  # [m]


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
    return stand(task, plan, name, pose)


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


def jolt(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """A slow motion with one sample at another velocity: within all limits but for accelerations that jump there."""
    spec = load_robot(task.robot)
    where = choose(steps_of(plan, Move), rng)
    if where is None:
        return None
    move = step_at(plan, where)
    times, velocities = 3.0 * move.trajectory.times, move.trajectory.velocities / 3.0
    h = np.diff(times)
    wide = np.flatnonzero(np.minimum(h[:-1], h[1:]) > 0.006) + 1
    if not len(wide):
        return None
    k, joint = choose(wide.tolist(), rng), int(rng.integers(len(spec.joints)))
    jump = rng.uniform(1.8, 2.1) * spec.jerk[joint] * 0.001
    velocities[k, joint] += rng.choice([-1.0, 1.0]) * jump / (4.0 / h[k - 1] + 4.0 / h[k])
    jolted = Trajectory(times, move.trajectory.positions.copy(), velocities)
    return task, put(plan, where, replace(move, trajectory=jolted))


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


def closed_fingers(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The fingers are closed already when the hand comes down on the object."""
    where = choose(steps_of(plan, Move, "approach"), rng)
    if where is None:
        return None
    move = step_at(plan, where)
    return task, put(plan, where, replace(move, opening=rng.uniform(0.0, 0.015)))


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


def dip_between_samples(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """Before anything else the hand dips into the table and comes back, between two samples that are both at home."""
    where = choose(steps_of(plan, Move, "transit")[:1], rng)
    if where is None or not np.allclose(step_at(plan, where).trajectory.positions[0], plan.home):
        return None
    positions = np.tile(np.array(plan.home), (4, 1))
    velocities = np.zeros_like(positions)
    velocities[1, 1] = rng.uniform(0.5, 0.7)
    dip = Trajectory(np.array([0.0, 2.0, 22.0, 23.0]), positions, velocities)
    move = step_at(plan, where)
    return task, put(plan, where, replace(move, trajectory=dip), move)


def rub(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """Before anything else a finger comes down on a bar until it is hardly in it, and slides along it."""
    return _rubbed(task, plan, rng, 0.0006, 0.0009)


def rub_lightly(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The same by a tenth of a millimetre: the bar lies on the table, and gives no way."""
    return _rubbed(task, plan, rng, 0.00008, 0.00018)


def _rubbed(task: Task, plan: Plan, rng: np.random.Generator, least: float, most: float) -> Pair | None:
    if (place := _clear_place(task, plan, rng)) is None:
        return None
    x, y = place
    spot = Pose((x, y + BESIDE, BAR.size[2] / 2))
    hand, z = Hand(plan.home), BAR.size[2] + TIP - rng.uniform(least, most)
    first, last = (Pose((x + along, y, z), DOWN) for along in (-0.03, 0.03))
    ways = [hand.free(above(first)), hand.line(first), hand.line(last), hand.line(above(last))]
    ways.append(timed(np.array([hand.q, plan.home]), hand.spec))
    rubbing = Action("move", (), tuple(Move("transit", way, OPEN) for way in ways))
    return added(task, replace(plan, actions=(rubbing, *plan.actions)), Object("bar", BAR, spot))


def poke_what_rolls(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """Before anything else a finger stops in a can that lies, not even a millimetre deep, and goes back."""
    if (place := _clear_place(task, plan, rng)) is None:
        return None
    x, y = place
    can = Object("rolling", CAN, Pose.from_rpy((x, y + BESIDE, CAN.radius), (np.pi / 2, 0.0, 0.0)))
    hand, end = Hand(plan.home), x - CAN.radius - FRONT + rng.uniform(0.0006, 0.0008)
    first, last = (Pose((to, y, CAN.radius), DOWN) for to in (end - 0.06, end))
    ways = [hand.free(above(first)), *(hand.line(to) for to in (first, last, first, above(first)))]
    ways.append(timed(np.array([hand.q, plan.home]), hand.spec))
    poking = Action("move", (), tuple(Move("transit", way, OPEN) for way in ways))
    return added(task, replace(plan, actions=(poking, *plan.actions)), can)


def drag_what_is_narrow(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """Before anything else a finger comes down on a card that stands, hardly in it, and goes a few millimetres on."""
    if (place := _clear_place(task, plan, rng)) is None:
        return None
    x, y = place
    card = Object("card", CARD, Pose((x, y + BESIDE, CARD.size[2] / 2)), mass=rng.uniform(0.05, 0.3))
    hand, z, along = Hand(plan.home), CARD.size[2] + TIP - rng.uniform(0.0007, 0.0009), rng.uniform(0.0042, 0.0048)
    first, last = (Pose((x + by, y, z), DOWN) for by in (-along / 2, along / 2))
    ways = [hand.free(above(first)), hand.line(first), hand.line(last), hand.line(above(last))]
    ways.append(timed(np.array([hand.q, plan.home]), hand.spec))
    dragging = Action("move", (), tuple(Move("transit", way, OPEN) for way in ways))
    return added(task, replace(plan, actions=(dragging, *plan.actions)), card)


def meet_what_stays(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """A box is said to start a little aside, and before anything else the hand goes where the task has it."""
    if (place := _clear_place(task, plan, rng)) is None:
        return None
    x, y = place
    aside, middle = rng.uniform(0.0048, 0.0055), STAND.size[2] / 2
    task, plan = added(task, plan, Object("stand", STAND, Pose((x, y + BESIDE, middle))))
    hand, end = Hand(plan.home), x + aside - middle - PALM - rng.uniform(0.0012, 0.0016)
    first, last = (Pose((to, y, middle), DOWN) for to in (end - 0.06, end))
    ways = [hand.free(above(first)), *(hand.line(to) for to in (first, last, first, above(first)))]
    ways.append(timed(np.array([hand.q, plan.home]), hand.spec))
    meeting = Action("move", (), tuple(Move("transit", way, OPEN) for way in ways))
    start = {**plan.start, "stand": Pose((x + aside, y + BESIDE, middle))}
    return task, replace(plan, start=start, actions=(meeting, *plan.actions))


def _clear_place(task: Task, plan: Plan, rng: np.random.Generator) -> tuple[float, float] | None:
    """Where a Panda's finger reaches something low that is near nothing."""
    places = np.array([pose.xyz[:2] for pose in plan.start.values()])
    drawn = rng.uniform((0.0, -0.3), (0.1, 0.2), size=(100, 2)) if task.robot == "panda" else ()
    clear = (at for at in drawn if (np.linalg.norm(places - (at[0], at[1] + BESIDE), axis=1) > CLEAR).all())
    found = next(clear, None)
    return None if found is None else (float(found[0]), float(found[1]))
