"""Does a ball that lies on several bodies roll off them, or by itself? It is moved aside, and let down anew."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull

from tamp.task import Box, Sphere
from tamp.task.mesh.parts import parts
from tamp.task.model import TABLE_FRICTION
from tests.checking.oracle.world import World

STEPS = (0.003, 0.006, 0.009)  # aside, of which each must be lower than the last [m]
LOWER = 5e-5  # by so much [m]
GRID = 80  # points along a triangle's edge
NEAR = 0.002  # a ball lies on what is no lower under it [m]
ROLLED = 0.02  # so far aside of where it came down it has rolled [m]
ALONE = 0.1  # what is farther away has not met it [m]
APART = 0.001  # a ball pushes blocks apart by so much each, as it comes down between them [m]
MORE = 1.3  # times the work of all friction it gives then


def rolling(world: World) -> str | None:
    """A ball that comes lower and lower as it goes to some side, or None."""
    for thing in world.task.objects:
        if not isinstance(thing.shape, Sphere):
            continue
        center, radius = world.poses[thing.name][:3, 3], thing.shape.radius
        points = _surfaces(world, thing.name, center, 2 * radius)
        lies = _height(points, center[:2], radius)
        if abs(lies - center[2]) > NEAR:
            continue
        for angle in np.linspace(0.0, 2 * np.pi, 36, endpoint=False):
            way = np.array([np.cos(angle), np.sin(angle)])
            heights = [lies, *(_height(points, center[:2] + far * way, radius) for far in STEPS)]
            if max(np.diff(heights)) < -LOWER:
                return f"{thing.name} rolls off what it lies on"
    return None


def rolled(world: World) -> str | None:
    """A ball over the level table, nothing near it, that starts far aside of where it is written; or None."""
    for thing in world.task.objects:
        if not isinstance(thing.shape, Sphere):
            continue
        written = np.array(thing.pose.xyz)
        aside = world.poses[thing.name][:2, 3] - written[:2]
        if np.linalg.norm(aside) > ROLLED and not len(_surfaces(world, thing.name, written, ALONE)):
            return f"{thing.name} rolls by itself on the table"
    return None


def spreading(world: World) -> str | None:
    """A ball between two boxes on the table, which loses more height than friction costs as they slide apart."""
    for ball in (thing for thing in world.task.objects if isinstance(thing.shape, Sphere)):
        center, radius, under = world.poses[ball.name][:3, 3], ball.shape.radius, list[tuple[float, np.ndarray]]()
        for block in (thing for thing in world.task.objects if isinstance(thing.shape, Box)):
            T, half = world.poses[block.name], np.array(block.shape.size) / 2
            local = T[:3, :3].T @ (center - T[:3, 3])
            nearest = np.clip(local, -half, half)
            if abs(np.linalg.norm(nearest - local) - radius) < NEAR and abs(T[2, 3] - half[2]) < NEAR:
                held = block.friction * TABLE_FRICTION * (ball.mass / 2 + block.mass) * APART
                under.append((held, T[:3, :3] @ (nearest - local)))
        if len(under) != 2 or under[0][1][:2] @ under[1][1][:2] > 0.0:
            continue
        (one, way), (other, _) = under
        half, rubs = float(np.hypot(way[0], way[1])), ball.friction * min(b.friction for b in world.task.objects)
        down = np.sqrt(radius**2 - half**2) - np.sqrt(max(radius**2 - (half + APART) ** 2, 0.0))
        along = rubs * ball.mass * radius / np.sqrt(radius**2 - half**2) * np.hypot(APART, down)
        if ball.mass * down > MORE * (one + other + along):
            return f"{ball.name} pushes apart what it lies on"
    return None


def _height(points: np.ndarray, at: np.ndarray, radius: float) -> float:
    """How high the middle of a ball is that is let down on points, shape (n, 3), or on the table, at a place (2,)."""
    aside = np.linalg.norm(points[:, :2] - at, axis=1)
    under = aside < radius
    return float((points[under, 2] + np.sqrt(radius**2 - aside[under] ** 2)).max(initial=radius))


def _surfaces(world: World, name: str, center: np.ndarray, reach: float) -> np.ndarray:
    """Points, shape (n, 3), of the surfaces of all other objects near a place, densely."""
    share = np.array([(i, j, GRID - i - j) for i in range(GRID + 1) for j in range(GRID + 1 - i)]) / GRID
    found = [np.zeros((0, 3))]
    for other, T in world.others(name, "table").items():
        for part in parts(world.task.object(other).shape):
            cloud = part.vertices @ T[:3, :3].T + T[:3, 3]
            if (cloud.min(axis=0) > center + reach).any() or (cloud.max(axis=0) < center - reach).any():
                continue
            found += [share @ corners for corners in cloud[ConvexHull(cloud).simplices]]
    points = np.concatenate(found)
    return points[np.linalg.norm(points - center, axis=1) < reach]
