"""Six samplers as a newcomer writes them from the manual alone: nothing but `tamp.sampling` is imported."""

import numpy as np

from tamp.sampling import (
    ARM_MARGIN,
    RELEASE_HEIGHT,
    TABLE,
    ArmPath,
    Configuration,
    Grasp,
    Handling,
    Placement,
    Pose,
    Scene,
    approach_contact,
    lift_contact,
    moved,
    opening_for,
    plan_motion,
    standing,
    straight_line,
    with_model,
)  # fmt: skip


def mesh_grasps(context, obj):
    """Yield pinches of two opposite triangles of an object's mesh, from above."""
    scene = context.scene
    parts, stroke = scene.world.geometries[obj].parts, scene.world.robot.spec.gripper.stroke
    corners = np.concatenate([part.vertices[part.faces] for part in parts])
    middles, normals = corners.mean(axis=1), np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    up = scene.start[obj].pose.matrix[2, :3]  # the world's z in the object's frame
    pairs = context.rng.permutation(np.argwhere(normals @ normals.T < -0.98))
    heights = (middles[pairs[:, 0]] + middles[pairs[:, 1]]) @ up
    for i, j in pairs[np.argsort(-heights, kind="stable")]:  # high ones first: the hand stays clear of the table
        between = middles[j] - middles[i]
        width = float(np.linalg.norm(between))
        if not 0.005 < width < stroke - 0.01 or between @ normals[j] < 0.97 * width or abs(normals[j] @ up) > 0.05:
            continue
        y = between / width
        z = -(up - (up @ y) * y)
        z /= np.linalg.norm(z)
        T = np.eye(4)
        T[:3, :3] = np.column_stack([np.cross(y, z), y, z])
        T[:3, 3] = (middles[i] + middles[j]) / 2
        yield Grasp(Pose.from_matrix(T), width)
    context.fail(f"no opposite triangles on {obj} that a hand fits round")


def grid(context, obj, region):
    """Yield placements on a grid of 3 cm, turned as the object stands."""
    place, now = context.scene.region(region), context.scene.start[obj].pose
    lower, upper = context.scene.bounds(obj, now)
    room = np.array(place.size) / 2 - (upper - lower)[:2] / 2
    if (room < 0).any():
        context.fail(f"{obj} is too large for {region}")
        return
    axes = [np.arange(c - r, c + r + 1e-9, 0.03) for c, r in zip(place.center, room, strict=True)]
    shift = np.array(now.xyz[:2]) - (lower + upper)[:2] / 2
    for x, y in context.rng.permutation(np.array(np.meshgrid(*axes)).reshape(2, -1).T + shift):
        yield Placement(Pose((x, y, now.xyz[2] - lower[2] + RELEASE_HEIGHT), now.quat), (TABLE,))


def newton(robot, T, q):
    """Damped least squares with a numerical Jacobian, shape (7,), or None."""

    def error(q):
        E = np.linalg.inv(robot.forward(q)) @ T
        R = E[:3, :3]
        return np.concatenate([E[:3, 3], 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])])

    for _ in range(60):
        e = error(q)
        if np.abs(e).max() < 1e-6:
            return q
        J = np.column_stack([(error(q + d) - e) / 1e-6 for d in 1e-6 * np.eye(len(q))])
        step = np.linalg.solve(J.T @ J + 1e-4 * np.eye(len(q)), -J.T @ e)
        q = np.clip(q + np.clip(step, -0.4, 0.4), robot.lower, robot.upper)
    return None


def own_kinematics(context, obj, placement, grasp):
    """Yield (?a, ?l, ?h) by Newton's method from home and from chance."""
    scene, robot = context.scene, context.scene.world.robot
    opening = opening_for(robot.spec.gripper, grasp)
    T = placement.pose.matrix @ grasp.T_object_tool.matrix
    starts = [robot.home, *(robot.home + context.rng.uniform(-0.8, 0.8, (6, robot.dof)))]
    for q in filter(lambda q: q is not None, (newton(robot, T, start) for start in starts)):
        back = straight_line(robot, q, moved(T, -0.08 * T[:3, 2]))
        lift = straight_line(robot, q, moved(T, np.array([0.0, 0.0, 0.08])))
        if back is None or lift is None:
            continue
        approach = back[::-1]
        if approach_contact(scene, obj, placement.pose, opening, approach, {}):
            continue
        if lift_contact(scene, obj, grasp, lift, {}):
            continue
        handling = Handling(obj, placement, grasp, opening, approach, lift)
        yield Configuration(tuple(approach[0]), opening), Configuration(tuple(lift[-1]), grasp.width), handling
    context.fail("Newton's method has found nothing that is free")


def by_kpiece(context, start, goal):
    """Yield a path of the empty hand by KPIECE."""
    world = context.scene.world
    poses = {name: place.pose.matrix for name, place in standing(context.fluents).items()}
    checker = world.checker(Scene(poses, opening=min(start.opening, goal.opening)), margin=ARM_MARGIN)
    robot, seed = world.robot, int(context.rng.integers(2**31))
    found = plan_motion(
        checker, robot.lower, robot.upper, np.array(start.q), np.array(goal.q),
        seed=seed, timeout=20.0, planner="kpiece", iterations=20000, recheck=0.01,
    )  # fmt: skip
    if found.path is not None:
        yield ArmPath(found.path)
    else:
        context.fail(found.reason, proven=False)


def train():
    """Weights of a linear model: how far from the base things are likely to be within reach."""
    rng = np.random.default_rng(0)
    distance = rng.uniform(0.1, 1.0, 400)
    rows = np.column_stack([np.ones(400), distance, distance**2])
    return np.linalg.lstsq(rows, ((distance > 0.35) & (distance < 0.7)).astype(float), rcond=None)[0]


@with_model(train)
def learned_places(context, weights, obj, region):
    """Yield the grid's placements, those first that the model expects to be within reach."""
    base = np.array(context.scene.world.robot.spec.T_world_base.xyz[:2])

    def expected(place):
        distance = np.linalg.norm(np.array(place.pose.xyz[:2]) - base)
        return weights @ (1.0, distance, distance**2)

    yield from sorted(grid(context, obj, region), key=expected, reverse=True)


def in_millimetres(context, obj):
    """Yield a grasp as somebody gives it who thinks in millimetres: the bad one."""
    yield Grasp(Pose.from_rpy((0.0, 0.0, 20.0), (np.pi, 0.0, 0.0)), width=50.0)
