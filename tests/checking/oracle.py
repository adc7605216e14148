"""A slow judge of plans by brute force: Pinocchio's kinematics, every 10 ms, points in half-spaces. No cleverness.

It shares nothing with the checker but the reading of meshes. It calls wrong only what is clearly wrong, well beyond the
checker's tolerances: the checker must reject all that it calls wrong. A motion that it has looked at among the same
bodies it does not look at again, so that of many mutants of one plan only what was changed costs time.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import combinations

import numpy as np
import pinocchio
from scipy.spatial import ConvexHull

from tamp.task import At, Box, Grip, Move, Plan, Pose, Release, RobotSpec, Shape, Task, Trajectory, load_robot
from tamp.task.mesh import parts

STEP = 0.01  # [s]
SPACING = 0.01  # of the points on a surface [m]
INSIDE = 0.004  # a point so deep inside another body is a collision [m] ...
TOUCHING = 0.008  # ... and so deep where the two may touch
STEPS = {"pick": [Grip], "unstack": [Grip], "place": [Release], "stack": [Release], "move": []}
ALLOWED = {"approach": True, "lift": True, "lower": True, "retreat": True, "transit": False, "transfer": False}


@dataclass(frozen=True, eq=False)
class Body:
    """Convex pieces as half-spaces (m, 4), points on their surfaces, the box round them, and a sphere."""

    planes: tuple[np.ndarray, ...]
    points: np.ndarray
    box: np.ndarray
    center: np.ndarray
    radius: float

    @staticmethod
    def of(clouds: list[np.ndarray]) -> Body:
        planes, points = [], []
        for cloud in clouds:
            hull = ConvexHull(cloud)
            planes.append(hull.equations)
            for corners in cloud[hull.simplices]:
                n = int(np.ceil(max(np.linalg.norm(corners - corners[[1, 2, 0]], axis=1)) / SPACING))
                share = np.array([(i, j, n - i - j) for i in range(n + 1) for j in range(n + 1 - i)]) / n
                points.append(share @ corners)
        every = np.vstack([*clouds, _thinned(np.vstack(points))])
        box = np.array([every.min(axis=0), every.max(axis=0)])
        center = box.mean(axis=0)
        return Body(tuple(planes), every, box, center, float(np.linalg.norm(every - center, axis=1).max()))


def _thinned(points: np.ndarray) -> np.ndarray:
    """One of the points in each cell of a grid, which is coarser on large bodies."""
    cell = max(SPACING, float(np.ptp(points, axis=0).max()) / 40)
    return points[np.unique(np.round(points / cell), axis=0, return_index=True)[1]]


def depth(a: Body, T_a: np.ndarray, b: Body, T_b: np.ndarray) -> float:
    """How deep the deepest surface point of one body lies inside the other [m]; negative where none does."""
    deepest = -np.inf
    for one, T_one, two, T_two in ((a, T_a, b, T_b), (b, T_b, a, T_a)):
        T = np.linalg.inv(T_two) @ T_one
        points = one.points @ T[:3, :3].T + T[:3, 3]
        points = points[((points > two.box[0]) & (points < two.box[1])).all(axis=1)]
        for planes in two.planes if len(points) else ():
            deepest = max(deepest, float((-(points @ planes[:, :3].T + planes[:, 3]).max(axis=1)).max()))
    return deepest


def meets(moving: Body, T: np.ndarray, still: Body, T_still: np.ndarray, limit: float) -> bool:
    """Whether a body is deeper than `limit` in another at any of its poses, shape (n, 4, 4)."""
    T_still_moving = np.linalg.inv(T_still) @ T
    center = T_still_moving[:, :3, :3] @ moving.center + T_still_moving[:, :3, 3]
    beyond = np.maximum(still.box[0] - center, center - still.box[1]).clip(min=0.0)
    near = np.flatnonzero(np.linalg.norm(beyond, axis=1) < moving.radius)
    return any(depth(moving, T[k], still, T_still) > limit for k in near)


@lru_cache(maxsize=256)
def body_of(shape: Shape) -> Body:
    return Body.of([part.vertices for part in parts(shape)])


@lru_cache(maxsize=1)
def robot() -> tuple[RobotSpec, pinocchio.Model, dict[str, Body]]:
    spec = load_robot("panda")
    model = pinocchio.buildModelFromUrdf(str(spec.urdf))
    geometry = pinocchio.buildGeomFromUrdf(
        model, str(spec.urdf), pinocchio.GeometryType.COLLISION, package_dirs=[str(spec.mesh_root)]
    )
    clouds: dict[str, list[np.ndarray]] = {}
    for item in geometry.geometryObjects:
        vertices = np.array(item.geometry.vertices()) * item.meshScale
        frame = model.frames[item.parentFrame]
        T = (frame.placement.inverse() * item.placement).homogeneous
        clouds.setdefault(frame.name, []).append(vertices @ T[:3, :3].T + T[:3, 3])
    return spec, model, {name: Body.of([c[ConvexHull(c).vertices] for c in cloud]) for name, cloud in clouds.items()}


def links_along(configurations: np.ndarray, opening: float) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """T_world_link of every link, and T_world_tool, each of shape (n, 4, 4)."""
    spec, model, bodies = robot()
    data, full = model.createData(), np.zeros(model.nq)
    columns = [model.joints[model.getJointId(name)].idx_q for name in (*spec.joints, *spec.gripper.joints)]
    frames = {name: model.getFrameId(name) for name in (*bodies, spec.tool_parent)}
    placed = {name: np.empty((len(configurations), 4, 4)) for name in frames}
    for k, q in enumerate(configurations):
        full[columns] = (*q, opening / 2, opening / 2)
        pinocchio.framesForwardKinematics(model, data, full)
        for name, frame in frames.items():
            placed[name][k] = data.oMf[frame].homogeneous
    base = spec.T_world_base.matrix
    placed = {name: base @ T for name, T in placed.items()}
    return placed, placed[spec.tool_parent] @ spec.T_parent_tool.matrix


def tool_at(q: np.ndarray) -> np.ndarray:
    return links_along(q[None], 0.0)[1][0]


@dataclass
class World:
    """Where everything is while the plan is replayed."""

    task: Task
    bodies: dict[str, Body]
    poses: dict[str, np.ndarray]
    q: np.ndarray
    held: tuple[str, np.ndarray] | None = None

    def others(self, *but: str) -> dict[str, np.ndarray]:
        held = self.held[0] if self.held else None
        return {name: T for name, T in self.poses.items() if name not in (*but, held)}


@dataclass
class Oracle:
    """The judge, and what it found of motions so far: by their trajectory and all that stood around."""

    swept: dict[bytes, str | None] = field(default_factory=dict)

    def wrong(self, task: Task, plan: Plan) -> str | None:
        """What is clearly wrong with a plan, or None."""
        bodies = {o.name: body_of(o.shape) for o in task.objects}
        bodies["table"] = body_of(Box((*task.table.size, task.table.thickness)))
        poses = {name: pose.matrix for name, pose in plan.start.items()}
        poses["table"] = Pose((*task.table.center, -task.table.thickness / 2)).matrix
        quick, slow = (World(task, bodies, dict(poses), np.array(plan.home)) for _ in range(2))
        return (
            _bookkeeping(plan)
            or _start(quick)
            or self._replay(quick, plan, sweep=False)
            or _goals(quick, plan)
            or self._replay(slow, plan, sweep=True)
        )

    def _replay(self, world: World, plan: Plan, sweep: bool) -> str | None:
        """Grips and releases, and with `sweep` everything on the way."""
        for action in plan.actions:
            for step in action.steps:
                if isinstance(step, Grip):
                    text = _grip(world, step)
                elif isinstance(step, Release):
                    text = _release(world, step)
                else:
                    text = self._swept(world, step) if sweep else None
                    _arrive(world, step)
                if text is not None:
                    return f"{action}: {text}"
            if action.name in ("place", "stack") and len(_between(world, action.arguments[0], tool_at(world.q))):
                return f"{action}: the hand stays round the object"
        return None

    def _swept(self, world: World, move: Move) -> str | None:
        arrays = (move.trajectory.times, move.trajectory.positions, move.trajectory.velocities, *world.poses.values())
        shapes = [(thing.name, thing.shape) for thing in world.task.objects]
        words = repr((move.phase, move.opening, move.held, list(world.poses), shapes, world.task.table))
        key = hashlib.sha256(words.encode() + b"".join(array.tobytes() for array in arrays)).digest()
        if key not in self.swept:
            self.swept[key] = _sweep(world, move)
        return self.swept[key]


def wrong(task: Task, plan: Plan) -> str | None:
    """What is clearly wrong with one plan, or None."""
    return Oracle().wrong(task, plan)


def _bookkeeping(plan: Plan) -> str | None:
    """Names, order and limits: all that needs no geometry."""
    q, held, opening, spec = np.array(plan.home), None, None, robot()[0]
    for action in plan.actions:
        kinds = [type(step) for step in action.steps if not isinstance(step, Move)]
        if kinds != {"pick": [Grip], "unstack": [Grip], "place": [Release], "stack": [Release], "move": []}.get(
            action.name
        ):
            return f"{action.name} has the wrong steps"
        if action.name == "move" and action.arguments and (held is None or held.object != action.arguments[0]):
            return "moves what it does not hold"
        for step in action.steps:
            if isinstance(step, Move):
                if np.abs(step.trajectory.positions[0] - q).max() > 1e-3:
                    return "the arm jumps"
                if step.held != held or (held and opening != step.opening):
                    return "what is held changes by itself"
                if (text := _limits(step.trajectory, spec)) is not None:
                    return text
                q, opening = step.trajectory.positions[-1], step.opening
            elif isinstance(step, Grip):
                if held is not None or step.attachment.object != action.arguments[0]:
                    return "grips with a full hand, or another object"
                held, opening = step.attachment, step.width
            else:
                if held is None or held.object != step.object or step.object != action.arguments[0]:
                    return "releases what it does not hold"
                held, opening = None, step.opening
    return "ends with an object in the hand" if held else None


def _limits(t: Trajectory, spec: RobotSpec) -> str | None:
    h = np.diff(t.times)[:, None]
    if (np.abs(t.velocities) > 1.01 * np.array(spec.velocity)).any():
        return "too fast"
    if (np.abs(np.diff(t.velocities, axis=0)) > 1.02 * np.array(spec.acceleration) * h).any():
        return "too much acceleration"
    if (t.positions < np.array(spec.lower) - 1e-3).any() or (t.positions > np.array(spec.upper) + 1e-3).any():
        return "beyond the joint limits"
    mean = (t.velocities[1:] + t.velocities[:-1]) / 2
    if (np.abs(np.diff(t.positions, axis=0) - mean * h) > 0.26 * np.array(spec.acceleration) * h**2 + 1e-5).any():
        return "positions do not follow velocities"
    return "not at rest" if max(np.abs(t.velocities[0]).max(), np.abs(t.velocities[-1]).max()) > 0.01 else None


def _start(world: World) -> str | None:
    for thing in world.task.objects:
        if np.linalg.norm(world.poses[thing.name][:3, 3] - thing.pose.xyz) > 0.27:
            return f"{thing.name} starts elsewhere"
    for a, b in combinations(sorted(world.poses), 2):
        if depth(world.bodies[a], world.poses[a], world.bodies[b], world.poses[b]) > TOUCHING:
            return f"{a} starts inside {b}"
    return None


def _arrive(world: World, move: Move) -> None:
    world.q = move.trajectory.positions[-1]
    if world.held:
        world.poses[world.held[0]] = tool_at(world.q) @ world.held[1]


def _hermite(t: Trajectory) -> np.ndarray:
    from scipy.interpolate import CubicHermiteSpline

    times = np.append(np.arange(0.0, t.times[-1], STEP), t.times[-1])
    return CubicHermiteSpline(t.times, t.positions, t.velocities)(times)


def _sweep(world: World, move: Move) -> str | None:
    placed, tool = links_along(_hermite(move.trajectory), move.opening)
    fingers = ("panda_hand", *robot()[0].gripper.fingers)
    held = world.held[0] if world.held else None
    for other, T in world.others().items():
        for link, body in robot()[2].items():
            near = ALLOWED[move.phase] and other != "table" and link in fingers
            limit = TOUCHING if near else INSIDE
            if (other, link) != ("table", "panda_link0") and meets(body, placed[link], world.bodies[other], T, limit):
                return f"{link} in {other}"
        limit = TOUCHING if ALLOWED[move.phase] else INSIDE
        if held and meets(world.bodies[held], tool @ world.held[1], world.bodies[other], T, limit):
            return f"{held} in {other}"
    return None


def _between(world: World, name: str, tool: np.ndarray) -> np.ndarray:
    """Surface points of an object between the pads, along the closing axis [m]."""
    gripper = robot()[0].gripper
    T = np.linalg.inv(tool) @ world.poses[name]
    points = world.bodies[name].points @ T[:3, :3].T + T[:3, 3]
    along = points @ np.array(gripper.axis)
    across = points @ np.cross((0.0, 0.0, 1.0), gripper.axis)
    inside = (np.abs(across) < gripper.pad[1] / 2 - 0.002) & (np.abs(points[:, 2]) < gripper.pad[2] / 2 - 0.002)
    return along[inside & (np.abs(along) < gripper.stroke / 2)]


def _grip(world: World, grip: Grip) -> str | None:
    name = grip.attachment.object
    tool = tool_at(world.q)
    claimed = tool @ grip.attachment.T_tool_object.matrix
    if np.linalg.norm(claimed[:3, 3] - world.poses[name][:3, 3]) > 0.004 + 0.03 * world.bodies[name].radius:
        return "the object is not where the grip says"
    found = _between(world, name, tool)
    if len(found) and max(found.max() - grip.width / 2, -grip.width / 2 - found.min()) > 0.006:
        return "the fingers close into the object"
    world.held = (name, grip.attachment.T_tool_object.matrix)
    return None


def _release(world: World, release: Release) -> str | None:
    name, T = release.object, release.pose.matrix
    if np.linalg.norm(T[:3, 3] - world.poses[name][:3, 3]) > 0.02:
        return "released elsewhere than it stands"
    world.held = None
    world.poses[name] = T
    body, lower = world.bodies[name], T.copy()
    lower[2, 3] -= 0.010
    carried = [o for o, at in world.others(name).items() if depth(body, lower, world.bodies[o], at) > 0.001]
    if not carried:
        return "released in the air"
    if carried == ["table"]:
        (x, y), table = (body.points @ T[:3, :3].T + T[:3, 3]).mean(axis=0)[:2], world.task.table
        outside = max(abs(x - table.center[0]) - table.size[0] / 2, abs(y - table.center[1]) - table.size[1] / 2)
        if outside > 0.01:
            return "released over the edge of the table"
    return None


def _goals(world: World, plan: Plan) -> str | None:
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
