"""Plans made by hand: numerical inverse kinematics and smooth curves, to try the checker without a planner."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, Slerp

from tamp.checking.robot.kinematics import KinematicTree, read_kinematics
from tamp.task import (
    Action,
    At,
    Attachment,
    Box,
    Cylinder,
    Grip,
    Move,
    Object,
    Plan,
    Pose,
    Release,
    RobotSpec,
    Task,
    Trajectory,
    load_robot,
)

OPEN = 0.08
RISE = 0.12
DOWN = (1.0, 0.0, 0.0, 0.0)
"""Orientation of a tool that points straight down."""


@lru_cache(maxsize=1)
def tree() -> KinematicTree:
    return read_kinematics(load_robot("panda"))


@lru_cache(maxsize=4096)
def solve_ik(target: Pose, near: tuple[float, ...]) -> tuple[float, ...]:
    """The configuration nearest to `near` that brings the tool to `target`."""
    spec, goal, q = tree().spec, target.matrix, np.array(near)

    def error(q: np.ndarray) -> np.ndarray:
        T = tree().tool(q)
        return np.concatenate([T[:, :3, 3] - goal[:3, 3], (T[:, :3, :3] - goal[:3, :3]).reshape(-1, 9)], axis=1)

    for _ in range(200):
        away = error(np.vstack([q, q + 1e-6 * np.eye(len(q))]))
        if np.abs(away[0]).max() < 1e-8:
            return tuple(float(v) for v in q)
        J = (away[1:] - away[0]).T / 1e-6
        step = np.linalg.solve(J.T @ J + 1e-6 * np.eye(len(q)), -J.T @ away[0])
        q = np.clip(q + step * min(1.0, 0.3 / np.abs(step).max()), spec.lower, spec.upper)
    raise AssertionError(f"out of reach: {target}")


def timed(waypoints: np.ndarray, spec: RobotSpec, share: float = 0.97) -> Trajectory:
    """A curve through waypoints, from rest to rest, as fast as `share` of the limits allows."""
    waypoints = np.asarray(waypoints, dtype=float)
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(waypoints, axis=0), axis=1))])
    if length[-1] < 1e-9:
        return Trajectory(np.array([0.0, 0.01]), waypoints[[0, -1]], np.zeros((2, waypoints.shape[1])))
    curve = CubicSpline(length / length[-1], waypoints, bc_type="clamped" if len(waypoints) == 2 else "natural")
    tau = np.linspace(0, 1, 400)
    s = 10 * tau**3 - 15 * tau**4 + 6 * tau**5
    rate, bend = 30 * tau**2 - 60 * tau**3 + 30 * tau**4, 60 * tau - 180 * tau**2 + 120 * tau**3
    v, a = curve(s, 1) * rate[:, None], curve(s, 2) * rate[:, None] ** 2 + curve(s, 1) * bend[:, None]
    needed = max(
        (np.abs(v) / spec.velocity).max() / share, np.sqrt((np.abs(a) / spec.acceleration).max() / share), 0.05
    )
    times = np.linspace(0, needed, max(int(np.ceil(needed / 0.01)) + 1, 6))
    tau = times / needed
    s = 10 * tau**3 - 15 * tau**4 + 6 * tau**5
    rate = (30 * tau**2 - 60 * tau**3 + 30 * tau**4) / needed
    velocities = curve(s, 1) * rate[:, None]
    velocities[[0, -1]] = 0.0
    return Trajectory(times, curve(s), velocities)


@dataclass
class Hand:
    """An arm that is led by hand; what it does becomes the steps of a plan."""

    q: tuple[float, ...]

    @property
    def spec(self) -> RobotSpec:
        return tree().spec

    def free(self, target: Pose) -> Trajectory:
        """Straight through joint space."""
        goal = solve_ik(target, self.q)
        path = timed(np.array([self.q, goal]), self.spec)
        self.q = goal
        return path

    def turned(self, target: Pose) -> Trajectory:
        """The same where the hand turns far: the configuration is found on a way straight there."""
        start, q = tree().tool(np.array([self.q]))[0], self.q
        turns = Slerp([0.0, 1.0], Rotation.from_matrix([start[:3, :3], target.matrix[:3, :3]]))
        for share in np.linspace(0.0, 1.0, 13)[1:]:
            xyz = (1 - share) * start[:3, 3] + share * np.array(target.xyz)
            q = solve_ik(Pose(tuple(xyz), tuple(turns(share).as_quat())), q)
        path = timed(np.array([self.q, q]), self.spec)
        self.q = q
        return path

    def line(self, end: Pose) -> Trajectory:
        """Straight through space, the orientation kept."""
        start = Pose.from_matrix(tree().tool(np.array([self.q]))[0])
        path = [self.q]
        for share in np.linspace(0, 1, 13)[1:]:
            xyz = (1 - share) * np.array(start.xyz) + share * np.array(end.xyz)
            path.append(solve_ik(Pose(tuple(xyz), end.quat), path[-1]))
        self.q = path[-1]
        return timed(np.array(path), self.spec)


def above(pose: Pose, by: float = RISE) -> Pose:
    return Pose((pose.xyz[0], pose.xyz[1], pose.xyz[2] + by), pose.quat)


def carry(
    hand: Hand,
    name: str,
    start: Pose,
    goal: Pose,
    width: float,
    under: tuple[str, str],
    grip_height: float = 0.005,
    aside: float = 0.0,
    across: float = 0.0,
    out: float = 0.0,
) -> list[Action]:
    """Pick an object from above and place it on the second of the bodies named in `under`.

    It is gripped `aside` of its middle along the pads, and `across` them, where they draw it half-way between them. It
    leaves straight up, or as far as `out` along x as it rises.
    """
    T_object_tool = Pose((aside, across, grip_height), DOWN)
    held = Attachment(name, T_object_tool.inverse())
    actions = []
    for kind, where, on in (("pick", start, under[0]), ("place", goal, under[1])):
        tool = where @ T_object_tool
        touching = frozenset({("robot", name)})
        resting = touching | {(name, on)}
        picking = kind == "pick"
        travel = Move("transit" if picking else "transfer", hand.free(above(tool)), OPEN if picking else width)
        reach = Move("approach" if picking else "lower", hand.line(tool), travel.opening, contacts=resting)
        up = Pose((out if picking else 0.0, 0.0, 0.0)) @ above(tool)
        leave = Move("lift" if picking else "retreat", hand.line(up), width if picking else OPEN)
        leave = Move(leave.phase, leave.trajectory, leave.opening, contacts=resting)
        if picking:
            leave = Move(leave.phase, leave.trajectory, leave.opening, held, resting)
            steps = (reach, Grip(held, width), leave)
            title = "pick" if on == "table" else "unstack"
        else:
            travel = Move(travel.phase, travel.trajectory, travel.opening, held)
            reach = Move(reach.phase, reach.trajectory, reach.opening, held, resting)
            steps = (reach, Release(name, goal, OPEN), leave)
            title = "place" if on == "table" else "stack"
        arguments = (name,) if on == "table" else (name, on)
        actions += [Action("move", (), (travel,)), Action(title, arguments, steps)]
    return actions


def two_boxes() -> tuple[Task, Plan]:
    """Carry a red box past a can, then put the green box on it."""
    red, green = Pose((0.05, -0.2, 0.04)), Pose((0.0, 0.05, 0.03))
    red_goal, green_goal = Pose((0.08, 0.2, 0.04)), Pose((0.08, 0.2, 0.11))
    task = Task(
        "two_boxes",
        (
            Object("red", Box((0.05, 0.05, 0.08)), red, At(red_goal)),
            Object("green", Box((0.06, 0.04, 0.06)), green, At(green_goal)),
            Object("can", Cylinder(0.03, 0.1), Pose((0.18, -0.02, 0.05))),
        ),
    )
    hand = Hand(load_robot("panda").home)
    actions = [
        *carry(hand, "red", red, red_goal, 0.05, ("table", "table")),
        *carry(hand, "green", green, green_goal, 0.04, ("table", "red")),
    ]
    starts = {thing.name: thing.pose for thing in task.objects}
    goals = {"red": red_goal, "green": green_goal}
    return task, Plan(task.name, "panda", 0, starts, load_robot("panda").home, goals, tuple(actions))


def scales() -> tuple[Task, Plan]:
    """A plank on a block, held down by ballast: one weight is taken from its end, another is put on the same."""
    at = {"red": Pose((-0.05, 0.0, 0.11)), "green": Pose((0.15, 0.0, 0.11)), "blue": Pose((0.05, -0.25, 0.03))}
    goals = {"red": Pose((0.05, 0.25, 0.03)), "blue": Pose((-0.04, 0.0, 0.11))}
    weights = [
        Object(name, Box((0.03, 0.04, 0.06)), at[name], At(goals[name]) if name in goals else None) for name in at
    ]
    stand = [
        Object("block", Box((0.05, 0.05, 0.06)), Pose((0.05, 0.0, 0.03))),
        Object("plank", Box((0.26, 0.05, 0.02)), Pose((0.05, 0.0, 0.07)), mass=0.05),
        Object("ballast", Box((0.05, 0.05, 0.02)), Pose((0.05, 0.0, 0.09)), mass=3.0),
    ]
    task = Task("scales", (*stand, *weights))
    home = load_robot("panda").home
    hand = Hand(home)
    actions = [
        *carry(hand, "red", at["red"], goals["red"], 0.04, ("plank", "table")),
        *carry(hand, "blue", at["blue"], goals["blue"], 0.04, ("table", "plank")),
    ]
    return task, Plan(task.name, "panda", 0, {o.name: o.pose for o in task.objects}, home, goals, tuple(actions))


def alone(
    shape, start: Pose, end: Pose, width: float, lift: float = 0.0, aside: float = 0.0, **about
) -> tuple[Task, Plan]:
    """One object carried across the table, gripped `lift` above its origin and `aside` of it."""
    task = Task("alone", (Object("red", shape, start, At(end), **about),))
    home = two_boxes()[1].home
    actions = carry(Hand(home), "red", start, end, width, ("table", "table"), lift, aside)
    return task, Plan("alone", "panda", 0, {"red": start}, home, {"red": end}, tuple(actions))


def unmoved(at: dict[str, tuple[object, Pose, Pose]]) -> tuple[Task, Plan]:
    """Nothing is done: each object, by its shape, start and goal, is said to start at its goal."""
    task = Task("unmoved", tuple(Object(name, shape, start, At(goal)) for name, (shape, start, goal) in at.items()))
    goals = {name: goal for name, (_, _, goal) in at.items()}
    return task, Plan("unmoved", "panda", 0, goals, two_boxes()[1].home, goals, ())
