"""The world while a plan is replayed, and what may be wrong with each of its steps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import combinations, product

import numpy as np

from tamp.task import Action, At, Box, Cylinder, Grip, Move, Plan, Release, Sphere, Task, Trajectory
from tests.checking.oracle.bodies import Body, depth, links_along, meets, robot, tool_at, within
from tests.checking.oracle.flush import turned_into
from tests.checking.oracle.rubbing import rubs
from tests.checking.oracle.striking import MET, dragged_over
from tests.checking.oracle.truth import hanging, let_go_aside
from tests.checking.oracle.wedging import stuck

STEP = 0.01  # [s]
INSIDE = 0.004  # a point so deep inside another body is a collision [m] ...
TOUCHING = 0.008  # ... and so deep where the two may touch
STANDS = 0.008  # what stands flat and alone stays where it is written [m]
DROPS = 0.014  # what is no higher above the table comes to stand on it [m]
TURNS = 0.033  # what is gripped and let go turns no farther than this in all [rad]
STAYS = 0.05  # what stands on something is no farther aside than this from where it is written [m]
FAR = 0.01  # what is so far away carries nothing [m]
SQUEEZED = 0.004  # what lies no farther beside the pads is between them [m]
SAME = 1e-4  # what is narrower by no more on each side is as wide [m]
EDGE = 0.0012  # what lies flat has three corners so near the table [m]
SUNK = 0.006  # what stands so much lower than it should is too low [m]
POKED = 0.0005  # so deep something rolls from what pokes it [m]
BESIDE = 0.004  # what is let go goes no farther aside [m]
ROLLS = 0.012  # what is round rolls down a steeper slope [rad]
OUTWEIGHS = 25.0  # what rolls does not stay on what is so many times lighter
STRAINED = 1.3  # so many times what a joint bears is too much
ALLOWED = {
    "approach": True, "lift": True, "lower": True, "retreat": True, "push": True, "transit": False, "transfer": False,
}  # fmt: skip


@dataclass
class World:
    """Where everything is while the plan is replayed.

    What is held is said to be at `held`, and `hangs` in truth in the tool's frame. What `stays` is there, and not where
    it is said to be.
    """

    task: Task
    bodies: dict[str, Body]
    poses: dict[str, np.ndarray]
    q: np.ndarray
    held: tuple[str, np.ndarray] | None = None
    turned: dict[str, float] = field(default_factory=dict)
    stays: dict[str, np.ndarray] = field(default_factory=dict)
    hangs: np.ndarray | None = None

    def others(self, *but: str) -> dict[str, np.ndarray]:
        held = self.held[0] if self.held else None
        return {name: T for name, T in self.poses.items() if name not in (*but, held)}


def start(world: World) -> str | None:
    written = World(
        world.task, world.bodies, {**world.poses, **{o.name: o.pose.matrix for o in world.task.objects}}, world.q
    )
    for thing in world.task.objects:
        aside = np.linalg.norm((world.poses[thing.name][:3, 3] - thing.pose.xyz)[:2])
        if aside > STAYS and rests(written, thing.name) is None:
            return f"{thing.name} stands where it is written"
        if aside > STANDS and stands_flat(written, thing.name):
            return f"{thing.name} stands flat and alone where it is written"
        if np.linalg.norm(world.poses[thing.name][:3, 3] - thing.pose.xyz) > 0.27:
            return f"{thing.name} starts elsewhere"
    placed, _ = links_along(world.q[None], robot()[0].gripper.stroke)
    for name, (link, body) in product(sorted(world.others("table")), robot()[2].items()):
        if meets(body, placed[link], world.bodies[name], world.poses[name], INSIDE):
            return f"{name} starts in {link}"
    if (name := _too_low(world)) is not None:
        return f"{name} is too low for all that is under it"
    if (name := _tilted(world)) is not None:
        return f"{name} stands on its edge alone"
    for name in sorted(world.others("table")):
        if _rolling(world, name) and _rolls_off(world, name):
            return f"{name} rolls off the box that it lies on"
    for a, b in combinations(sorted(world.poses), 2):
        if depth(world.bodies[a], world.poses[a], world.bodies[b], world.poses[b]) > TOUCHING:
            return f"{a} starts inside {b}"
    return None


def _tilted(world: World) -> str | None:
    """A box on the table, near nothing else, of which two corners or one are lower than all others by far."""
    for thing in world.task.objects:
        if not isinstance(thing.shape, Box):
            continue
        low, high = _box(world, thing.name)
        boxes = (_box(world, other) for other in world.others(thing.name, "table"))
        alone = all((least > high + FAR).any() or (most < low - FAR).any() for least, most in boxes)
        corners = np.array(list(product((-0.5, 0.5), repeat=3))) * thing.shape.size
        T = world.poses[thing.name]
        heights = np.sort(corners @ T[2, :3] + T[2, 3])
        if alone and abs(heights[0]) < INSIDE and heights[2] > heights[1] + EDGE:
            return thing.name
    return None


def _too_low(world: World) -> str | None:
    """A box that stands upright on others of its size, and lower than all of them are high together."""
    boxes = {o.name: _box(world, o.name) for o in world.task.objects if isinstance(o.shape, Box)}
    sizes = {o.name: np.array(o.shape.size) for o in world.task.objects if isinstance(o.shape, Box)}
    for name, (low, _) in boxes.items():
        alike = [
            other
            for other, (least, most) in boxes.items()
            if np.allclose(most - least, sizes[name], atol=1e-6) and np.allclose(least[:2], low[:2], atol=1e-3)
        ]
        under = sum(sizes[other][2] for other in alike if boxes[other][0][2] < low[2] - SUNK)
        if under and under > low[2] + SUNK:
            return name
    return None


def stands_flat(world: World, name: str) -> bool:
    """Whether an object stands on a broad face on the table, its middle well over that, and nothing is near it.

    What is a little above the table drops onto it.
    """
    body, T = world.bodies[name], world.poses[name].copy()
    points = body.points @ T[:3, :3].T + T[:3, 3]
    if 0.0 < (gap := float(points[:, 2].min())) < DROPS:
        T[2, 3] -= gap
        points[:, 2] -= gap
    low = points[np.abs(points[:, 2]) < 5e-4, :2]
    if len(low) < 8 or points[:, 2].min() < -5e-4:
        return False
    offset = low - (points.min(axis=0) + points.max(axis=0))[:2] / 2
    angles = np.linspace(0.0, 2 * np.pi, 36, endpoint=False)
    reach = (offset @ np.array([np.cos(angles), np.sin(angles)])).max(axis=0)
    aside = [shift for x in (-0.01, 0.01) for shift in ((x, 0.0), (0.0, x))]
    for other, at in world.others(name, "table").items():
        if depth(body, world.poses[name], world.bodies[other], at) > -0.002:
            return False  # what is written inside something is pushed out of it
        for x, y in aside:
            moved = T.copy()
            moved[:2, 3] += (x, y)
            if depth(body, moved, world.bodies[other], at) > -0.002:
                return False
    return bool(reach.min() > 0.02 and reach.min() > 0.3 * np.ptp(points[:, 2]) / 2)


def misnamed(world: World, action: Action, on_table: Mapping[str, bool]) -> str | None:
    """Whether an action is named as one that is about the table, or about an object, and its own is far from that."""
    if action.name not in on_table:
        return None
    name = action.arguments[0]
    low, high = _box(world, name)
    if on_table[action.name]:
        return f"{name} is above the table" if low[2] > FAR else None
    boxes = (_box(world, other) for other in world.others(name, "table"))
    alone = all((least > high + FAR).any() or (most < low - FAR).any() for least, most in boxes)
    return f"{name} is alone on the table" if alone else None


def _box(world: World, name: str) -> tuple[np.ndarray, np.ndarray]:
    points = world.bodies[name].points @ world.poses[name][:3, :3].T + world.poses[name][:3, 3]
    return points.min(axis=0), points.max(axis=0)


def arrive(world: World, move: Move) -> None:
    world.q = move.trajectory.positions[-1]
    if world.held:
        world.poses[world.held[0]] = tool_at(world.q) @ world.held[1]


def _hermite(t: Trajectory) -> np.ndarray:
    from scipy.interpolate import CubicHermiteSpline

    times = np.append(np.arange(0.0, t.times[-1], STEP), t.times[-1])
    return CubicHermiteSpline(t.times, t.positions, t.velocities)(times)


def sweep(world: World, move: Move) -> str | None:
    """What the arm meets, or what it carries or pushes along, or None."""
    placed, tool = links_along(_hermite(move.trajectory), move.opening)
    taken = move.pushed.object if move.pushed is not None else None
    others = world.others(*([taken] if taken else []))
    carried = {name: tool @ T for name, T in ([world.held] if world.held else [])}
    if move.pushed is not None:
        carried[taken] = tool @ move.pushed.T_tool_object.matrix
    limit = TOUCHING if ALLOWED[move.phase] else INSIDE
    for other, T in others.items():
        for link, body in robot()[2].items():
            if (other, link) != ("table", "panda_link0") and meets(body, placed[link], world.bodies[other], T, INSIDE):
                return f"{link} in {other}"
            if other != "table" and move.pushed is None and rubs(body, placed[link], world.bodies[other], T):
                return f"{link} rubs along {other}"
            shape = None if other == "table" or move.pushed is not None else world.task.object(other).shape
            if shape is not None and dragged_over(shape, world.bodies[other], T, body, placed[link]):
                return f"{link} drags {other} over"
            if other in world.stays and meets(body, placed[link], world.bodies[other], world.stays[other], MET):
                return f"{link} meets {other} where the task has it"
            if _rolling(world, other) and meets(body, placed[link], world.bodies[other], T, POKED):
                return f"{link} sends {other} rolling"
            if other in world.stays and world.held and met_in_truth(world, tool, other):
                return f"{world.held[0]} meets {other} where it was let go"
        for name, poses in carried.items():
            hangs = tool @ world.hangs if move.phase == "transfer" and world.held else poses[:0]
            if shape is not None and dragged_over(shape, world.bodies[other], T, world.bodies[name], hangs):
                return f"{name} hangs lower than it is said to, and drags {other} over"
            if meets(world.bodies[name], poses, world.bodies[other], T, limit):
                return f"{name} in {other}"
            if move.phase == "lift" and other != "table" and stuck(world.bodies[name], poses, world.bodies[other], T):
                return f"{name} is wedged in {other}"
    return None


def met_in_truth(world: World, tool: np.ndarray, other: str) -> bool:
    """Whether what is held meets another object where that stays, the tool being at poses of shape (n, 4, 4)."""
    return meets(world.bodies[world.held[0]], tool @ world.hangs, world.bodies[other], world.stays[other], MET)


def _rolling(world: World, name: str) -> bool:
    """Whether a body is a ball, or a can that lies."""
    shape = None if name == "table" else world.task.object(name).shape
    return isinstance(shape, Sphere) or (isinstance(shape, Cylinder) and abs(world.poses[name][2, 2]) < 0.1)


def _rolls_off(world: World, name: str) -> bool:
    """Whether a ball or a can lies on one box alone, and that slopes, or is far lighter."""
    T, shape, ups = world.poses[name], world.task.object(name).shape, {}
    radius = shape.radius if isinstance(shape, Sphere | Cylinder) else 0.0
    for other, at in world.others(name, "table").items():
        held_by = world.task.object(other).shape
        if not isinstance(held_by, Box):
            if depth(world.bodies[name], T, world.bodies[other], at) > -FAR:
                return False
            continue
        half, middle = np.array(held_by.size) / 2, at[:3, :3].T @ (T[:3, 3] - at[:3, 3])
        up = at[:3, :3] @ (middle - np.clip(middle, -half, half))
        if np.linalg.norm(up) < radius + INSIDE:
            ups[other] = up / radius
    if len(ups) != 1 or T[2, 3] < radius + INSIDE:
        return False
    ((other, up),) = ups.items()
    level = up * (1.0, 1.0, 0.0)
    if isinstance(shape, Cylinder):
        level -= (level @ T[:3, 2]) * T[:3, 2]
    masses = [world.task.object(each).mass for each in (name, other)]
    return bool(np.linalg.norm(level) > ROLLS or masses[0] > OUTWEIGHS * masses[1])


def strains(q: np.ndarray, T_tool_point: np.ndarray, force: np.ndarray) -> bool:
    """Whether a force, shape (3,) [N], at a point at rest in the tool frame is far more than some joint bears."""
    spec, model, _ = robot()
    for index, name in enumerate(spec.joints):
        turned = q + 1e-4 * np.eye(len(q))[index], q - 1e-4 * np.eye(len(q))[index]
        ends = [(tool_at(each) @ T_tool_point)[:3, 3] for each in turned]
        bears = float(model.effortLimit[model.joints[model.getJointId(name)].idx_v])
        if abs(force @ (ends[0] - ends[1])) / 2e-4 > STRAINED * bears:
            return True
    return False


def between(world: World, name: str, tool: np.ndarray) -> np.ndarray:
    """Surface points of an object between the pads, along the closing axis [m]."""
    gripper = robot()[0].gripper
    T = np.linalg.inv(tool) @ world.poses[name]
    points = world.bodies[name].points @ T[:3, :3].T + T[:3, 3]
    along = points @ np.array(gripper.axis)
    across = points @ np.cross((0.0, 0.0, 1.0), gripper.axis)
    inside = (np.abs(across) < gripper.pad[1] / 2 - 0.002) & (np.abs(points[:, 2]) < gripper.pad[2] / 2 - 0.002)
    return along[inside & (np.abs(along) < gripper.stroke / 2)]


def _pressed(world: World, name: str, tool: np.ndarray, along: float) -> bool:
    """Whether a pad that far along the closing axis is in an object somewhere [m]."""
    gripper = robot()[0].gripper
    x, z = np.meshgrid(*(np.linspace(0.002 - size / 2, size / 2 - 0.002, 9) for size in gripper.pad[1:]))
    side = np.cross((0.0, 0.0, 1.0), gripper.axis)
    points = x.reshape(-1, 1) * side + z.reshape(-1, 1) * (0.0, 0.0, 1.0) + along * np.array(gripper.axis)
    return bool(within(world.bodies[name], world.poses[name], points @ tool[:3, :3].T + tool[:3, 3]).any())


def grip(world: World, grip: Grip) -> str | None:
    name = grip.attachment.object
    tool = tool_at(world.q)
    claimed = tool @ grip.attachment.T_tool_object.matrix
    if np.linalg.norm(claimed[:3, 3] - world.poses[name][:3, 3]) > 0.004 + 0.03 * world.bodies[name].radius:
        return "the object is not where the grip says"
    found = between(world, name, tool)
    if len(found) and max(found.max() - grip.width / 2, -grip.width / 2 - found.min()) > 0.006:
        return "the fingers close into the object"
    if len(found) and min(grip.width / 2 - found.max(), grip.width / 2 + found.min()) > 0.0025:
        return "the fingers stop before they touch the object"
    for other in world.others(name, "table"):
        if len(found) and all(_pressed(world, other, tool, end) for end in (found.min() + SAME, found.max() - SAME)):
            return f"the fingers close on {other} as well"
    item, gripper = world.task.object(name), robot()[0].gripper
    if item.inertia is not None:
        center = world.poses[name][:3, :3] @ item.inertia.frame.xyz + world.poses[name][:3, 3]
        turning = item.mass * 9.81 * abs(np.cross(tool[:3, :3] @ gripper.axis, center - tool[:3, 3])[2])
        if turning > 1.2 * item.friction * gripper.force * np.hypot(*gripper.pad[1:]):
            return "the object swings down in the fingers"
    if item.mass * 9.81 > 2.1 * item.friction * gripper.force:
        return "the object is too heavy for the fingers"
    if (other := turned_into(item, gripper, tool, world.bodies, world.poses)) is not None:
        return f"the fingers turn {name} into {other}"
    if (text := _turns(world, name, world.poses[name], claimed)) is not None:
        return text
    world.hangs = np.linalg.inv(tool) @ hanging(gripper, tool, world.stays.pop(name, world.poses[name]), claimed)
    world.poses[name] = claimed
    world.held = (name, grip.attachment.T_tool_object.matrix)
    return None


def let_go(world: World, release: Release) -> str | None:
    """The fingers open, wherever that is."""
    if (text := _turns(world, release.object, world.poses[release.object], release.pose.matrix)) is not None:
        return text
    if np.linalg.norm(release.pose.matrix[:3, 3] - world.poses[release.object][:3, 3]) > 0.02:
        return "released elsewhere than it stands"
    if np.linalg.norm((release.pose.matrix[:3, 3] - world.poses[release.object][:3, 3])[:2]) > BESIDE:
        return "goes aside as it is let go"
    world.held = None
    world.poses[release.object] = release.pose.matrix
    if (lies := let_go_aside(tool_at(world.q) @ world.hangs, release.pose.matrix)) is not None:
        world.stays[release.object] = lies
    found = between(world, release.object, tool_at(world.q))
    found = found[np.abs(found) < release.opening / 2 + SQUEEZED]
    if len(found) and np.ptp(found) > release.opening + 5e-4:
        return "the fingers are still closed on it"
    return None


def _turns(world: World, name: str, before: np.ndarray, after: np.ndarray) -> str | None:
    cosine = (np.trace(before[:3, :3].T @ after[:3, :3]) - 1) / 2
    world.turned[name] = world.turned.get(name, 0.0) + float(np.arccos(np.clip(cosine, -1.0, 1.0)))
    return f"{name} turns in the fingers" if world.turned[name] > TURNS else None


def rests(world: World, name: str) -> str | None:
    """Why an object cannot rest where it is, or None."""
    body, T = world.bodies[name], world.poses[name]
    lower = T.copy()
    lower[2, 3] -= 0.010
    carried = [o for o, at in world.others(name).items() if depth(body, lower, world.bodies[o], at) > 0.001]
    if not carried:
        return f"{name} is left in the air"
    if carried == ["table"]:
        (x, y), table = (body.points @ T[:3, :3].T + T[:3, 3]).mean(axis=0)[:2], world.task.table
        outside = max(abs(x - table.center[0]) - table.size[0] / 2, abs(y - table.center[1]) - table.size[1] / 2)
        if outside > 0.01:
            return f"{name} is left over the edge of the table"
    return None


def goals(world: World, plan: Plan) -> str | None:
    regions = {region.name: region for region in world.task.regions}
    for thing in world.task.objects:
        T, body = world.poses[thing.name], world.bodies[thing.name]
        if isinstance(thing.goal, At):
            if thing.name not in plan.goals or np.linalg.norm(T[:3, 3] - thing.goal.pose.xyz) > 0.04:
                return f"{thing.name} misses its goal"
        elif thing.goal is not None and thing.goal.target in regions:
            region, points = regions[thing.goal.target], body.points @ T[:3, :3].T + T[:3, 3]
            low, high = (side(points[:, :2], axis=0) - region.center for side in (np.min, np.max))
            if (np.abs(low + high) / 2 > np.array(region.size) / 2 + 0.005).any():
                return f"{thing.name} misses its region"
    return None
