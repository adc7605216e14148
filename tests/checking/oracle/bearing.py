"""Do boxes that lean bear what was put on them? By brute force: no forces where they touch balance the weights."""

from __future__ import annotations

import numpy as np
from scipy.optimize import linprog

from tamp.task import Box
from tamp.task.model import TABLE_FRICTION
from tests.checking.oracle.bodies import Body
from tests.checking.oracle.world import World

LEANING = 0.3  # what is further off each of its faces leans [rad]
TOUCHING = 0.0005  # points nearer to another body than this touch it [m]
STICKIER = 1.3  # times the friction that is given
EDGES = 12  # of a cone of friction
LONG = 0.05  # a moment counts as a force so far from the centre [m]
CLEARLY = 0.04  # share of all the weight by which no forces balance it
G = 9.81


def gives_in(world: World, name: str) -> str | None:
    """That a box that was put down, and the boxes that lean which it touches, are not in balance together; or None."""
    if not isinstance(world.task.object(name).shape, Box):
        return None
    slant = [o for o in world.others(name, "table") if leans(world, o) and len(_touching(world, name, o)[0])]
    if not slant:
        return None
    loose, columns = [name, *slant], list[np.ndarray]()
    for index, one in enumerate(loose):
        for other in world.others(one):
            if other not in loose[:index]:
                columns += _pushes(world, one, other, loose)
    weight = np.zeros((len(loose), 6))
    weight[:, 2] = [G * world.task.object(o).mass for o in loose]
    A, total = np.array(columns).T.reshape(weight.size, -1), float(weight.sum())
    rows, count = np.ones((weight.size, 1)), A.shape[1]
    short = linprog(
        np.append(np.zeros(count), 1.0),
        A_ub=np.vstack([np.hstack([A, -rows]), np.hstack([-A, -rows])]),
        b_ub=np.append(weight.ravel(), -weight.ravel()),
    )
    return f"{' and '.join(slant)} cannot bear {name}" if short.fun > CLEARLY * total else None


def leans(world: World, name: str) -> bool:
    upright = float(np.abs(world.poses[name][2, :3]).max())
    return isinstance(world.task.object(name).shape, Box) and upright < np.cos(LEANING)


def _touching(world: World, one: str, other: str) -> tuple[np.ndarray, np.ndarray]:
    """Points where two bodies touch, and the ways out of the other there, shape (n, 3) each, in the world."""
    bodies, poses = world.bodies, world.poses
    mine = _near(bodies[one], poses[one], bodies[other], poses[other])
    points, ways = _near(bodies[other], poses[other], bodies[one], poses[one])
    return np.vstack([mine[0], points]), np.vstack([mine[1], -ways])


def _near(one: Body, T_one: np.ndarray, two: Body, T_two: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Surface points of one body that touch another, and the ways out of that."""
    points = one.points @ T_one[:3, :3].T + T_one[:3, 3]
    local = (points - T_two[:3, 3]) @ T_two[:3, :3]
    heights = [local @ planes[:, :3].T + planes[:, 3] for planes in two.planes]
    far = np.array([height.max(axis=1) for height in heights])
    piece, near = far.argmin(axis=0), far.min(axis=0) < TOUCHING
    ways = [two.planes[p][heights[p][i].argmax(), :3] for i, p in enumerate(piece) if near[i]]
    return points[near], np.array(ways).reshape(-1, 3) @ T_two[:3, :3].T


def _pushes(world: World, one: str, other: str, loose: list[str]) -> list[np.ndarray]:
    """What each edge of each cone of friction between two bodies does to all that is loose: forces and moments."""
    friction = [TABLE_FRICTION if o == "table" else world.task.object(o).friction for o in (one, other)]
    found, angles = [], np.linspace(0.0, 2 * np.pi, EDGES, endpoint=False)
    for point, way in zip(*_touching(world, one, other), strict=True):
        aside = np.linalg.svd(way[None])[2][1:]
        for angle in angles:
            force = way + STICKIER * friction[0] * friction[1] * (np.array([np.cos(angle), np.sin(angle)]) @ aside)
            column = np.zeros((len(loose), 6))
            for body, sign in ((one, 1.0), (other, -1.0)):
                if body in loose:
                    arm = point - world.poses[body][:3, 3]
                    column[loose.index(body)] = sign * np.append(force, np.cross(arm, force) / LONG)
            found.append(column.ravel())
    return found
